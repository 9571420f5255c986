/** The plan on a flat map: track, boresight, swath, footprint, 1-sigma ellipse, targets, day and night. */
import { computed } from "@preact/signals";
import { type GeoProjection, geoEquirectangular, geoGraticule10, geoMercator, geoPath } from "d3-geo";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import { targetTold } from "../../i18n/labels";
import { placeNames } from "../../map/labels";
import { Night as NightSide } from "../../map/Night";
import { outlines, wantDetail, wantOutlines } from "../../map/outlines";
import type { LonLat } from "../../map/places";
import { cursor_s } from "../../time/cursor";
import { ellipseAt, footprintAt, footprintRows, linesOf, type Trace } from "./ground";
import { frameRowAt, longitudeAt, rowAt, type View, valueAt } from "./view";

const HEIGHT = 380;
const LEAST_DEG = 24;
const NIGHT_STEP_S = 20;
const NEAR_DEG = 0.05; // on either side of a target
const KM_PER_DEG = 111.2; // of a great circle on the mean sphere
const SCALE_PX = 110; // the scale is no longer

/** Which part of the Earth is shown: all of it, the pass, the surroundings of a target. */
export type Reach = "world" | "pass" | "target";

interface Shown {
  reach: Reach;
  /** How much closer than that. */
  closer: number;
}

export function FlatMap({ view, ...shown }: { view: View } & Shown) {
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
    <>
      <div class="look-map" ref={box}>
        <MapPicture view={view} {...shown} width={width} height={HEIGHT} />
      </div>
      <Legend />
    </>
  );
}

interface Props extends Shown {
  view: View;
  width: number;
  height: number;
}

export function MapPicture({ view, reach, closer, width, height }: Props) {
  const text = words.value.viewer.map;
  const track = useMemo(() => linesOf(view.carrier), [view]);
  const trace = useMemo(() => linesOf(view.boresight), [view]);
  // Of a session at a time: the map stays where it is while a target is tracked.
  const near = useMemo(() => computed(() => (reach === "target" ? sessionRow(view, cursor_s.value) : 0)), [view, reach]);
  const nearRow = near.value;
  const projection = useMemo(() => {
    if (width === 0) return null;
    const clipped = <P extends GeoProjection>(made: P): P =>
      made.clipExtent([
        [-2, -2],
        [width + 2, height + 2],
      ]);
    const close = reach === "target" ? closeUp(view, nearRow, width, height) : null;
    const made =
      close ??
      (reach === "world" || track.length === 0
        ? geoEquirectangular().fitSize([width, height], { type: "Sphere" })
        : fit(geoEquirectangular(), [...track.flat(), ...trace.flat()], width, height));
    return clipped(made.scale(made.scale() * closer));
  }, [width, height, reach, closer, nearRow, view, track, trace]);
  const shapes = outlines.value;
  const drawn = useMemo(() => {
    if (!projection) return null;
    const path = geoPath(projection);
    const frames = footprintRows(view).map((row) => footprintAt(view, row));
    return {
      path,
      land: (shapes && path(shapes.land)) ?? "",
      borders: (shapes && path(shapes.borders)) ?? "",
      graticule: path(geoGraticule10()) ?? "",
      track: path({ type: "MultiLineString", coordinates: track }) ?? "",
      trace: path({ type: "MultiLineString", coordinates: trace }) ?? "",
      swath: frames.filter((ring) => ring.length > 0).map((ring) => path({ type: "Polygon", coordinates: [ring] }) ?? ""),
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
          {drawn.swath.map((d, k) => (
            <path key={k} class="lm-footprints" d={d} />
          ))}
          <path class="lm-track" d={drawn.track} />
          <path class="lm-trace" d={drawn.trace} />
          <Now view={view} projection={projection} />
          <Targets view={view} projection={projection} width={width} />
          <ScaleBar projection={projection} width={width} height={height} />
        </>
      )}
    </svg>
  );
}

function Legend() {
  const text = words.value.viewer.map;
  return (
    <p class="look-legend look-map-legend">
      <span class="key key-axis-0">{text.track}</span>
      <span class="key key-boresight">{text.boresight}</span>
      <span class="key key-error">{text.swath}</span>
      <span class="key key-sigma">{text.ellipse}</span>
      <span class="key key-target">{text.target}</span>
      <span class="key key-night">{text.night}</span>
    </p>
  );
}

function Night({ view, projection }: { view: View; projection: GeoProjection }) {
  const step = useMemo(() => computed(() => NIGHT_STEP_S * Math.round(cursor_s.value / NIGHT_STEP_S)), []);
  const t_s = step.value;
  const [longitude, latitude] = [longitudeAt(view, view.sun.longitude_deg, t_s), valueAt(view, view.sun.latitude_deg, t_s)];
  if (longitude === null || latitude === null) return null;
  return <NightSide sun={[longitude, latitude]} path={geoPath(projection)} class="lm-night" />;
}

function Targets({ view, projection, width }: { view: View; projection: GeoProjection; width: number }) {
  const row = rowAt(view, cursor_s.value);
  const points = view.targets.map((target) => {
    const [longitude, latitude] = [target.longitude_deg[row], target.latitude_deg[row]];
    return longitude == null || latitude == null ? null : projection([longitude, latitude]);
  });
  const names = view.targets.map(({ name }) => targetTold(name));
  const placings = placeNames(points, names, width);
  return (
    <>
      {view.targets.map((target, k) => {
        const [point, placing] = [points[k], placings[k]];
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
            {placing ? <text {...placing}>{names[k]}</text> : <title>{names[k]}</title>}
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
  const ellipse = ellipseAt(view, frameRowAt(view, t_s) ?? row);
  const path = geoPath(projection);
  return (
    <>
      {footprint.length > 0 && <path class="lm-footprint" d={path({ type: "Polygon", coordinates: [footprint] }) ?? ""} />}
      {ellipse.length > 0 && <path class="lm-ellipse" d={path({ type: "LineString", coordinates: ellipse }) ?? ""} />}
      {carrier && end && <path class={`lm-boresight lm-${kind}`} d={`M${carrier.join()}L${end.join()}`} />}
      {end && <circle class={`lm-end lm-${kind}`} cx={end[0]} cy={end[1]} r={2} />}
      {carrier && <circle class="lm-carrier" cx={carrier[0]} cy={carrier[1]} r={5} />}
    </>
  );
}

/** A length on the ground in the middle of the map. */
function ScaleBar({ projection, width, height }: { projection: GeoProjection; width: number; height: number }) {
  const [here, there] = [width / 2 - 20, width / 2 + 20].map((x) => projection.invert?.([x, height / 2]));
  if (!here || !there) return null;
  const east_deg = (((there[0] - here[0] + 540) % 360) - 180) * Math.cos((here[1] * Math.PI) / 180);
  const km_px = (Math.abs(east_deg) * KM_PER_DEG) / 40;
  const most = SCALE_PX * km_px;
  const power = 10 ** Math.floor(Math.log10(most));
  const long_km = ([5, 2, 1].find((one) => one * power <= most) ?? 1) * power;
  const long_px = long_km / km_px;
  if (!Number.isFinite(long_px)) return null;
  return (
    <g class="lm-scale" transform={`translate(10,${height - 10})`}>
      <path d={`M0,-5V0H${long_px}V-5`} />
      <text x={long_px / 2} y={-5} text-anchor="middle">
        {long_km < 1
          ? `${number(1000 * long_km)} ${words.value.viewer.units.m}`
          : `${number(long_km)} ${words.value.viewer.units.km}`}
      </text>
    </g>
  );
}

function pointAt(view: View, trace: Trace, t_s: number, projection: GeoProjection): LonLat | null {
  const [longitude, latitude] = [longitudeAt(view, trace.longitude_deg, t_s), valueAt(view, trace.latitude_deg, t_s)];
  return longitude === null || latitude === null ? null : projection([longitude, latitude]);
}

/** The middle row of the session that the cursor is in, or leads to. */
function sessionRow(view: View, t_s: number): number {
  const session = view.session[frameRowAt(view, t_s) ?? rowAt(view, t_s)];
  const rows = view.session.flatMap((one, row) => (one === session && view.activity[row] === "track" ? [row] : []));
  return rows[Math.floor(rows.length / 2)] ?? rowAt(view, t_s);
}

/** The frame on the ground in the middle of a session, and some ground around; null where there is none. */
function closeUp(view: View, row: number, width: number, height: number): GeoProjection | null {
  const target = view.targets.find((one) => one.session === view.session[row]);
  const place = (trace: Trace): LonLat | null => {
    const [longitude, latitude] = [trace.longitude_deg[row], trace.latitude_deg[row]];
    return longitude == null || latitude == null ? null : [longitude, latitude];
  };
  const middle = (target && place(target)) ?? place(view.boresight);
  if (!middle) return null;
  const [longitude, latitude] = middle;
  const shrink = Math.cos((latitude * Math.PI) / 180);
  const corners = footprintAt(view, row);
  const away = corners.map(([lon, lat]) => [(((lon - longitude + 540) % 360) - 180) * shrink, lat - latitude].map(Math.abs));
  const [wide = NEAR_DEG, high = NEAR_DEG] = [0, 1].map((part) => Math.max(NEAR_DEG, ...away.map((one) => one[part] ?? 0)));
  const px_per_deg = Math.min(width / wide, height / high) / 3.2;
  return geoMercator()
    .rotate([-longitude, 0])
    .center([0, latitude])
    .scale(((px_per_deg * 180) / Math.PI) * shrink)
    .translate([width / 2, height / 2]);
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
