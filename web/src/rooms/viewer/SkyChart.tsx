/** The sky around a target in space, by right ascension and declination: boresight, Sun, Moon, Earth, cones. */
import { type GeoProjection, geoAzimuthalEquidistant, geoCircle, geoGraticule, geoPath } from "d3-geo";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { words } from "../../i18n";
import { fixed } from "../../i18n/forms";
import { targetTold } from "../../i18n/labels";
import { placeNames } from "../../map/labels";
import type { LonLat } from "../../map/places";
import { cursor_s } from "../../time/cursor";
import { rowAt, type View } from "./view";

const HEIGHT = 380;
const WHOLE_DEG = 180;
const AIR_PX = 14;
const LINES_DEG: [number, number] = [30, 30];
const EARTH_RADIUS_M = 6_371_000;

type Sky = NonNullable<View["sky"]>;
type Direction = Sky["boresight"];

interface Props {
  view: View;
  sky: Sky;
  /** How much closer than the whole sky. */
  closer: number;
}

export function SkyChart({ view, sky, closer }: Props) {
  const text = words.value.viewer.sky;
  const box = useRef<HTMLDivElement>(null);
  const [width, setWidth] = useState(0);
  useEffect(() => {
    const element = box.current;
    if (!element) return;
    const watch = new ResizeObserver(() => setWidth(element.clientWidth));
    watch.observe(element);
    return () => watch.disconnect();
  }, []);
  const row = rowAt(view, cursor_s.value);
  const shown = shownTarget(view, sky, row);
  const middle = useMemo(() => (shown ? firstKnown(shown.direction) : null), [shown?.direction]);
  const projection = useMemo(() => (middle && width > 0 ? chart(middle, width, closer) : null), [middle?.join(), width, closer]);
  const path = useMemo(() => projection && geoPath(projection), [projection]);
  return (
    <>
      <div class="look-map look-sky" ref={box}>
        <svg width={width} height={HEIGHT} viewBox={`0 0 ${width} ${HEIGHT}`} role="img" aria-label={text.told}>
          {projection && path && (
            <>
              <path class="sky-ground" d={path({ type: "Sphere" }) ?? ""} />
              <Earth view={view} sky={sky} row={row} projection={projection} />
              <path
                class="lm-graticule"
                d={
                  path(
                    geoGraticule()
                      .step(LINES_DEG)
                      .extent([
                        [-180, -89.9],
                        [180, 89.9],
                      ])(),
                  ) ?? ""
                }
              />
              <Cones view={view} sky={sky} row={row} projection={projection} />
              <Path view={view} sky={sky} projection={projection} />
              <Marks view={view} sky={sky} row={row} projection={projection} width={width} />
            </>
          )}
        </svg>
      </div>
      <p class="look-legend look-map-legend">
        <span class="key key-slew">{text.slew}</span>
        <span class="key key-track">{text.track}</span>
        <span class="key key-earth">{text.earth}</span>
        {sky.keep_out.length > 0 && <span class="key key-cone">{text.cones}</span>}
        {shown && <span>{text.height(shown.name, fixed(shown.height_deg, 1))}</span>}
      </p>
    </>
  );
}

/** Of the session the row belongs or leads to, else the first in space. */
function shownTarget(view: View, sky: Sky, row: number) {
  const numbers = sky.targets.flatMap((one, number) => (firstKnown(one) ? [number] : []));
  const number = numbers.find((one) => one === view.session[row]) ?? numbers[0];
  const [direction, target] = [sky.targets[number ?? -1], view.targets.find((one) => one.session === number)];
  return direction && target ? { direction, name: targetTold(target.name), height_deg: target.elevation_deg[row] ?? null } : null;
}

function placeAt({ right_ascension_deg, declination_deg }: Direction, row: number): LonLat | null {
  const [ra, dec] = [right_ascension_deg[row], declination_deg[row]];
  return ra == null || dec == null ? null : [ra, dec];
}

function firstKnown(direction: Direction): LonLat | null {
  const row = direction.declination_deg.findIndex((one) => one !== null);
  return row < 0 ? null : placeAt(direction, row);
}

/** North up and east to the left, as one looks up; the target in the middle. */
function chart([ra, dec]: LonLat, width: number, closer: number): GeoProjection {
  const radius = (Math.min(width, HEIGHT) / 2 - AIR_PX) * closer;
  return geoAzimuthalEquidistant()
    .rotate([-ra, -dec])
    .reflectX(true)
    .clipAngle(WHOLE_DEG - 1e-3)
    .scale(radius / Math.PI)
    .translate([width / 2, HEIGHT / 2])
    .clipExtent([
      [0, 0],
      [width, HEIGHT],
    ]);
}

interface PartProps {
  view: View;
  sky: Sky;
  row: number;
  projection: GeoProjection;
}

/** As wide as its limb is seen: a target's angle off nadir less its height above the limb. */
function Earth({ view, sky, row, projection }: PartProps) {
  const nadir = placeAt(sky.nadir, row);
  if (!nadir) return null;
  const told = view.targets.find((one, k) => one.elevation_deg[row] != null && placeAt(sky.targets[k] ?? sky.nadir, row));
  const [off, above] = [told?.off_nadir_deg[row], told?.elevation_deg[row]];
  const height_m = view.carrier.height_m[row] ?? 0;
  const limb_deg =
    off != null && above != null ? off - above : (Math.asin(EARTH_RADIUS_M / (EARTH_RADIUS_M + height_m)) * 180) / Math.PI;
  return <path class="sky-earth" d={geoPath(projection)(geoCircle().center(nadir).radius(limb_deg)()) ?? ""} />;
}

function Cones({ view, sky, row, projection }: PartProps) {
  return (
    <>
      {sky.keep_out.map((axis, number) => {
        const [middle, cone] = [placeAt(axis, row), view.keep_out[number]];
        if (!middle || !cone) return null;
        const circle = geoCircle().center(middle).radius(cone.half_angle_deg)();
        const lapsed = cone.counts[row] ? "" : "axis-cone-lapsed";
        return <path key={number} class={`axis-cone ${lapsed}`} d={geoPath(projection)(circle) ?? ""} />;
      })}
    </>
  );
}

/** Where the boresight goes. */
function Path({ view, sky, projection }: Omit<PartProps, "row">) {
  const drawn = useMemo(() => {
    const lines = new Map<string, LonLat[][]>();
    let [kind, line] = ["", [] as LonLat[]];
    for (const [row, does] of view.activity.entries()) {
      const point = placeAt(sky.boresight, row);
      if (!point) continue;
      if (does !== kind) {
        line = line.length > 0 ? [line[line.length - 1] ?? point] : [];
        kind = does;
        lines.set(kind, [...(lines.get(kind) ?? []), line]);
      }
      line.push(point);
    }
    return [...lines].map(([of, coordinates]) => [of, geoPath(projection)({ type: "MultiLineString", coordinates }) ?? ""]);
  }, [view, sky, projection]);
  return (
    <>
      {drawn.map(([kind, d]) => (
        <path key={kind} class={`axis-path axis-${kind}`} d={d} />
      ))}
    </>
  );
}

function Marks({ view, sky, row, projection, width }: PartProps & { width: number }) {
  const text = words.value.viewer.sky;
  const marks = [
    { kind: "boresight", name: "", at: placeAt(sky.boresight, row) },
    ...sky.targets.map((one, k) => ({ kind: "target", name: targetTold(view.targets[k]?.name ?? ""), at: placeAt(one, row) })),
    { kind: "sun", name: text.sun, at: placeAt(sky.sun, row) },
    { kind: "moon", name: text.moon, at: placeAt(sky.moon, row) },
    { kind: "nadir", name: text.earth, at: placeAt(sky.nadir, row) },
  ];
  const points = marks.map(({ at }) => at && projection(at));
  const names = marks.map((one) => one.name);
  const placings = placeNames(points, names, width);
  return (
    <>
      {marks.map(({ kind, name }, k) => {
        const [point, placing] = [points[k], placings[k]];
        if (!point) return null;
        return (
          <g key={`${kind}${k}`} class={`sky-mark sky-${kind}`} transform={`translate(${point[0]},${point[1]})`}>
            {kind === "target" ? <path d="M-8,0H-3M3,0H8M0,-8V-3M0,3V8" /> : <circle r={kind === "nadir" ? 1.5 : 5} />}
            {placing && name && <text {...placing}>{name}</text>}
          </g>
        );
      })}
    </>
  );
}
