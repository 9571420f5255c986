/** Cesium's engine over files of our own service: a chunk that is loaded after the rest. */
import {
  BoundingSphere,
  buildModuleUrl,
  Cartesian3,
  CesiumWidget,
  Color,
  Credit,
  CreditDisplay,
  CzmlDataSource,
  DirectionalLight,
  Ellipsoid,
  HeadingPitchRange,
  ImageryLayer,
  Ion,
  JulianDate,
  Material,
  Matrix4,
  PolylineCollection,
  TileMapServiceImageryProvider,
  Transforms,
} from "@cesium/engine";

import { boundaries } from "../map/outlines";
import type { GlobeView, Place } from "./globe";

// Neither is told of in the engine's types.
const untold = { buildModuleUrl, Transforms } as unknown as {
  buildModuleUrl: { setBaseUrl: (url: string) => void };
  Transforms: { iau2006XysData: { computeXysRadians: () => undefined } };
};
untold.buildModuleUrl.setBaseUrl(new URL(/* @vite-ignore */ "./cesium/", import.meta.url).href);
Ion.defaultAccessToken = "";
CreditDisplay.cesiumCredit = new Credit("CesiumJS");
// Cesium's own Sun isn't drawn and our light comes from the plan; without these tables, 2 MB that
// it would fetch, it takes the sidereal time.
untold.Transforms.iau2006XysData = { computeXysRadians: () => undefined };

const SPACE = "#0a111b";
const LINES = Color.fromBytes(235, 240, 246, 140);
const TRACE = Color.fromBytes(255, 190, 90, 200);
const SWATH = Color.fromBytes(0, 220, 90, 220);
const NEAREST_M = 100e3; // a pixel of the picture is 20 km wide

type Line = readonly (readonly [number, number])[];

export interface Opened extends GlobeView {
  close: () => void;
}

/** What is drawn beside the document, as lines of longitude and latitude, deg. */
export interface OnGround {
  /** Where the boresight meets the ground. */
  trace: readonly Line[];
  /** Outlines of the camera's frame. */
  swath: readonly Line[];
}

interface Kept {
  widget: CesiumWidget;
  stage: HTMLElement;
  light: DirectionalLight;
  onBroken: (error: unknown) => void;
}

/** The one there is: each that is made and destroyed leaves its canvas with listeners behind. */
let kept: Kept | null = null;

function globe(): Kept {
  if (kept) return kept;
  const stage = document.createElement("div");
  stage.style.height = "100%"; // of what it is put in
  const widget = new CesiumWidget(stage, {
    baseLayer: ImageryLayer.fromProviderAsync(
      TileMapServiceImageryProvider.fromUrl(buildModuleUrl("Assets/Textures/NaturalEarthII")),
      { saturation: 0.55, brightness: 0.95 },
    ),
    skyBox: false,
    skyAtmosphere: false,
    scene3DOnly: true,
    automaticallyTrackDataSourceClocks: false,
    requestRenderMode: true,
    maximumRenderTimeChange: Infinity,
    showRenderLoopErrors: false,
    creditContainer: document.createElement("div"), // the page's own line names the sources
    creditViewport: document.createElement("div"),
  });
  const { scene, clock } = widget;
  scene.backgroundColor = Color.fromCssColorString(SPACE);
  scene.fog.enabled = false;
  scene.screenSpaceCameraController.minimumZoomDistance = NEAREST_M;
  scene.globe.showGroundAtmosphere = false;
  scene.globe.enableLighting = true;
  scene.globe.dynamicAtmosphereLighting = false;
  [scene.globe.lightingFadeOutDistance, scene.globe.lightingFadeInDistance] = [0, 1]; // at any distance
  const light = new DirectionalLight({ direction: new Cartesian3(1, 0, 0) });
  scene.light = light;
  clock.shouldAnimate = false;
  const made: Kept = { widget, stage, light, onBroken: () => undefined };
  scene.renderError.addEventListener((_: unknown, error: unknown) => {
    if (kept === made) kept = null; // to be destroyed once it is closed
    made.onBroken(error);
  });
  // The picture's pixels are 20 km wide.
  void boundaries().then(
    (lines) => void draw(scene, lines, LINES, 1),
    (error: unknown) => made.onBroken(error),
  );
  updateOnceAtATime(widget);
  kept = made;
  return made;
}

/** Shapes that move are made anew by each update, and ask for another picture: without end. */
function updateOnceAtATime({ dataSourceDisplay, dataSources }: CesiumWidget): void {
  const update = dataSourceDisplay.update.bind(dataSourceDisplay);
  let settled: JulianDate | undefined;
  dataSourceDisplay.update = (time) => {
    if (JulianDate.equals(time, settled)) return true;
    const isSettled = update(time);
    settled = isSettled ? JulianDate.clone(time) : undefined;
    return isSettled;
  };
  const begin = () => {
    settled = undefined;
  };
  dataSources.dataSourceAdded.addEventListener(begin);
  dataSources.dataSourceRemoved.addEventListener(begin);
}

function destroy({ widget }: Kept): void {
  const { canvas } = widget.scene;
  const context = canvas.getContext("webgl2") ?? canvas.getContext("webgl");
  widget.destroy();
  context?.getExtension("WEBGL_lose_context")?.loseContext(); // not only when it is collected
}

/** null where nobody waits for it any more: then the globe is another's.

czml: a document of the service, as it is.  onBroken: when it can draw no more. */
export async function openGlobe(
  element: HTMLElement,
  czml: object,
  epoch_ms: number,
  { trace, swath }: OnGround,
  onBroken: (error: unknown) => void,
  until: AbortSignal,
): Promise<Opened | null> {
  const source = await CzmlDataSource.load(czml);
  if (until.aborted) return null;
  const opened = globe();
  const { widget, stage, light } = opened;
  const { scene, clock, camera } = widget;
  opened.onBroken = onBroken;
  element.append(stage);
  widget.useDefaultRenderLoop = true;
  const drawn = [draw(scene, trace, TRACE, 1.5), draw(scene, swath, SWATH, 1)];
  const epoch = JulianDate.fromDate(new Date(epoch_ms));
  await widget.dataSources.add(source);
  return {
    show: (t_s, sun) => {
      JulianDate.addSeconds(epoch, t_s, clock.currentTime);
      if (sun) {
        const overhead = Ellipsoid.WGS84.geodeticSurfaceNormal(cartesian(sun));
        light.direction = Cartesian3.negate(overhead, new Cartesian3());
      }
      scene.requestRender();
    },
    overview: (places) => {
      const sphere = BoundingSphere.fromPoints(places.map(cartesian));
      camera.lookAtTransform(Matrix4.IDENTITY);
      camera.viewBoundingSphere(sphere, new HeadingPitchRange(0, -1.2, Math.max(3.6 * sphere.radius, 3200e3)));
      camera.lookAtTransform(Matrix4.IDENTITY);
      scene.requestRender();
    },
    zoom: (factor) => {
      const height_m = camera.positionCartographic.height;
      if (factor > 1 && height_m / factor < NEAREST_M) return false;
      camera.zoomIn(height_m * (1 - 1 / factor));
      scene.requestRender();
      return true;
    },
    close: () => {
      stage.remove();
      if (kept !== opened) return destroy(opened);
      opened.onBroken = () => undefined;
      for (const lines of drawn) scene.primitives.remove(lines);
      widget.dataSources.remove(source, true);
      widget.useDefaultRenderLoop = false;
    },
  };
}

/** Lines of longitude and latitude on the ground. */
function draw(scene: CesiumWidget["scene"], lines: readonly Line[], color: Color, width: number) {
  if (scene.isDestroyed()) return null;
  const drawn = scene.primitives.add(new PolylineCollection()) as PolylineCollection;
  for (const line of lines) {
    // Its own: a line takes its material with it when it is destroyed.
    const material = Material.fromType("Color", { color });
    drawn.add({ positions: Cartesian3.fromDegreesArray(line.flat()), width, material });
  }
  scene.requestRender();
  return drawn;
}

function cartesian({ longitude_deg, latitude_deg, height_m }: Place): Cartesian3 {
  return Cartesian3.fromDegrees(longitude_deg, latitude_deg, height_m ?? 0);
}
