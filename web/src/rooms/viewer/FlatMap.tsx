/** The plan on a flat map: track, boresight, footprint, targets, day and night. */
import { computed } from "@preact/signals";
import { type GeoProjection, geoCircle, geoEquirectangular, geoGraticule10, geoPath } from "d3-geo";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { words } from "../../i18n";
import { readable } from "../../map/labels";
import { outlines, wantDetail, wantOutlines } from "../../map/outlines";
import { cursor_s } from "../../time/cursor";
import { footprintAt, footprintRows, type LonLat, linesOf, type Trace } from "./ground";
import { longitudeAt, rowAt, type View, valueAt } from "./view";

const HEIGHT = 380;
const LEAST_DEG = 24;
const NAME_PX = 130;
const NIGHT_STEP_S = 20;

export function FlatMap({ view, isWhole }: { view: View; isWhole: boolean }) {
  const box = useRef<HTMLDivElement>(null);
  const [width, setWidth] = useState(0);
  useEffect(() => {
    void wantOutlines().then(wantDetail);
    const element = box.current;
    if (!element) return;
    const watch = new ResizeObserver(() => setWidth(element.clientWidth));
    watch.observe(element);
    return () => watch.disconnect();
  }, []);
  return (
    <div class="look-map" ref={box}>
      <MapPicture view={view} isWhole={isWhole} width={width} height={HEIGHT} />
    </div>
  );
}

interface Props {
  view: View;
  isWhole: boolean;
  width: number;
  height: number;
}

export function MapPicture({ view, isWhole, width, height }: Props) {
  const text = words.value.viewer.map;
  const track = useMemo(() => linesOf(view.carrier), [view]);
  const trace = useMemo(() => linesOf(view.boresight), [view]);
  const projection = useMemo(() => {
    if (width === 0) return null;
    const made = geoEquirectangular().clipExtent([
      [-2, -2],
      [width + 2, height + 2],
    ]);
    return isWhole || track.length === 0
      ? made.fitSize([width, height], { type: "Sphere" })
      : fit(made, [...track.flat(), ...trace.flat()], width, height);
  }, [width, height, isWhole, track, trace]);
  const shapes = outlines.value;
  const drawn = useMemo(() => {
    if (!projection) return null;
    const path = geoPath(projection);
    return {
      path,
      land: (shapes && path(shapes.land)) ?? "",
      borders: (shapes && path(shapes.borders)) ?? "",
      graticule: path(geoGraticule10()) ?? "",
      track: path({ type: "MultiLineString", coordinates: track }) ?? "",
      trace: path({ type: "MultiLineString", coordinates: trace }) ?? "",
      footprints: footprintRows(view)
        .map((row) => path({ type: "LineString", coordinates: footprintAt(view, row) }) ?? "")
        .join(""),
    };
  }, [projection, shapes, track, trace, view]);
  return (
    <svg width={width} height={height} viewBox={`0 0 ${width} ${height}`} role="img" aria-label={text.told}>
      <rect class="lm-sea" width={width} height={height} />
      {drawn && projection && (
        <>
          <path class="lm-land" d={drawn.land} />
          <path class="lm-borders" d={drawn.borders} />
          <path class="lm-graticule" d={drawn.graticule} />
          <Night view={view} projection={projection} />
          <path class="lm-track" d={drawn.track} />
          <path class="lm-trace" d={drawn.trace} />
          <path class="lm-footprints" d={drawn.footprints} />
          <Targets view={view} projection={projection} width={width} />
          <Now view={view} projection={projection} />
        </>
      )}
    </svg>
  );
}

/** The hemisphere away from the Sun. */
function Night({ view, projection }: { view: View; projection: GeoProjection }) {
  const step = useMemo(() => computed(() => NIGHT_STEP_S * Math.round(cursor_s.value / NIGHT_STEP_S)), []);
  const t_s = step.value;
  const [longitude, latitude] = [longitudeAt(view, view.sun.longitude_deg, t_s), valueAt(view, view.sun.latitude_deg, t_s)];
  if (longitude === null || latitude === null) return null;
  const night = geoCircle()
    .center([longitude + 180, -latitude])
    .radius(90)();
  return <path class="lm-night" d={geoPath(projection)(night) ?? ""} />;
}

function Targets({ view, projection, width }: { view: View; projection: GeoProjection; width: number }) {
  const isNearEdge = (x: number) => x > width - NAME_PX;
  const row = rowAt(view, cursor_s.value);
  const points = view.targets.map((target) => {
    const [longitude, latitude] = [target.longitude_deg[row], target.latitude_deg[row]];
    return longitude == null || latitude == null ? null : projection([longitude, latitude]);
  });
  const named = readable(points.map((point, k) => point && { x: point[0], y: point[1], text: view.targets[k]?.name ?? "" }));
  return (
    <>
      {view.targets.map((target, k) => {
        const point = points[k];
        if (!point) return null;
        const isNow = view.session[row] === target.session;
        return (
          <g
            key={target.session}
            class={isNow ? "lm-target lm-target-now" : "lm-target"}
            transform={`translate(${point[0]},${point[1]})`}
          >
            <path d="M-6,0H-2M2,0H6M0,-6V-2M0,2V6" />
            <circle r={4.5} />
            {(named[k] || isNow) && (
              <text x={isNearEdge(point[0]) ? -9 : 9} y={-6} text-anchor={isNearEdge(point[0]) ? "end" : "start"}>
                {target.name}
              </text>
            )}
          </g>
        );
      })}
    </>
  );
}

function Now({ view, projection }: { view: View; projection: GeoProjection }) {
  const t_s = cursor_s.value;
  const carrier = pointAt(view, view.carrier, t_s, projection);
  const end = pointAt(view, view.boresight, t_s, projection);
  const row = rowAt(view, t_s);
  const kind = view.activity[row] ?? "wait";
  const footprint = footprintAt(view, row);
  return (
    <>
      {footprint.length > 0 && (
        <path class="lm-footprint" d={geoPath(projection)({ type: "Polygon", coordinates: [footprint] }) ?? ""} />
      )}
      {carrier && end && <path class={`lm-boresight lm-${kind}`} d={`M${carrier.join()}L${end.join()}`} />}
      {end && <circle class={`lm-end lm-${kind}`} cx={end[0]} cy={end[1]} r={3} />}
      {carrier && <circle class="lm-carrier" cx={carrier[0]} cy={carrier[1]} r={5} />}
    </>
  );
}

function pointAt(view: View, trace: Trace, t_s: number, projection: GeoProjection): LonLat | null {
  const [longitude, latitude] = [longitudeAt(view, trace.longitude_deg, t_s), valueAt(view, trace.latitude_deg, t_s)];
  return longitude === null || latitude === null ? null : projection([longitude, latitude]);
}

/** The points in the middle of the map, with air around them. */
function fit(projection: GeoProjection, points: LonLat[], width: number, height: number): GeoProjection {
  const [x, y] = points.reduce(
    ([east, north], [longitude]) => [east + Math.cos((longitude * Math.PI) / 180), north + Math.sin((longitude * Math.PI) / 180)],
    [0, 0],
  );
  const middle = (Math.atan2(y, x) * 180) / Math.PI;
  const away = points.map(([longitude]) => ((longitude - middle + 540) % 360) - 180);
  const latitudes = points.map(([, latitude]) => latitude);
  const [left, right, low, high] = [Math.min(...away), Math.max(...away), Math.min(...latitudes), Math.max(...latitudes)];
  const wide = Math.max((right - left) * 1.25, LEAST_DEG, (width / height) * Math.max((high - low) * 1.25, LEAST_DEG * 0.6));
  return projection
    .rotate([-(middle + (left + right) / 2), 0])
    .center([0, (low + high) / 2])
    .scale((width * 180) / Math.PI / Math.min(wide, 360))
    .translate([width / 2, height / 2]);
}
