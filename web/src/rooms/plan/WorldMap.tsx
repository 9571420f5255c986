/** The Earth, flat: a click is a target; the chosen pass is drawn over it. */
import { geoCircle, geoEquirectangular, geoGraticule10, geoPath } from "d3-geo";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import * as draft from "./draft";
import { outlines, wantDetail } from "../../map/outlines";
import { circleOf, groundTrack, type LonLat } from "./passes";
import { refused } from "./refusal";
import { textOf } from "./target";
import { found, windowOf } from "./windows";

const HIGHEST_ZOOM = 64;
const DETAIL_FROM = 4;

export function WorldMap() {
  const text = words.value.plan.map;
  const box = useRef<HTMLDivElement>(null);
  const [wide, setWide] = useState(0);
  const [zoom, setZoom] = useState(1);
  const [centre, setCentre] = useState<LonLat>([0, 12]);
  const [cross, setCross] = useState<LonLat | null>(null);
  const held = useRef<{ x: number; y: number; centre: LonLat; hasMoved: boolean } | null>(null);
  useEffect(() => {
    const element = box.current;
    if (!element) return;
    const watch = new ResizeObserver(() => setWide(element.clientWidth));
    watch.observe(element);
    const wheel = (event: WheelEvent) => {
      if (!event.ctrlKey && !event.metaKey && document.activeElement !== element.firstElementChild) return;
      event.preventDefault();
      setZoom((now) => clampZoom(now * (event.deltaY < 0 ? 1.25 : 0.8)));
    };
    element.addEventListener("wheel", wheel, { passive: false });
    return () => {
      watch.disconnect();
      element.removeEventListener("wheel", wheel);
    };
  }, []);
  useEffect(() => {
    if (zoom >= DETAIL_FROM) wantDetail();
  }, [zoom]);
  const high = Math.round(Math.min(wide * 0.5, 460));
  const shapes = outlines.value;
  const projection = useMemo(
    () =>
      geoEquirectangular()
        .scale((wide / (2 * Math.PI)) * zoom)
        .center([0, centre[1]])
        .rotate([-centre[0], 0])
        .translate([wide / 2, high / 2])
        .clipExtent([
          [-2, -2],
          [wide + 2, high + 2],
        ]),
    [wide, high, zoom, centre],
  );
  const path = useMemo(() => geoPath(projection), [projection]);
  const ground = useMemo(
    () => ({
      land: shapes ? (path(shapes.land) ?? "") : "",
      borders: shapes ? (path(shapes.borders) ?? "") : "",
      graticule: path(geoGraticule10()) ?? "",
    }),
    [path, shapes],
  );
  const now = found.value;
  const window = now ? windowOf(now.windows, draft.session.value) : null;
  const track = window ? groundTrack(window) : [];
  const radius = window && circleOf(window, draft.leastElevation_deg.value);
  const seen: LonLat | null = window?.place ? [window.place.longitude_deg, window.place.latitude_deg] : placeOf(draft.session.value);

  const pointAt = (event: { clientX: number; clientY: number }): LonLat | null => {
    const corner = box.current?.getBoundingClientRect();
    const point = corner && projection.invert?.([event.clientX - corner.left, event.clientY - corner.top]);
    return point && Math.abs(point[1]) <= 90 ? [wrap(point[0]), point[1]] : null;
  };
  const choose = (point: LonLat | null) => {
    if (!point) return;
    const decimals = zoom > 8 ? 4 : 2;
    draft.setTarget({
      mode: "ground",
      latitude_deg: Number(point[1].toFixed(decimals)),
      longitude_deg: Number(point[0].toFixed(decimals)),
      height_m: 0,
    });
  };
  const key = (event: KeyboardEvent) => {
    const step = 5 / zoom;
    const moves: Record<string, LonLat> = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    const by = moves[event.key];
    const from = cross ?? seen ?? centre;
    if (by) {
      const next: LonLat = [wrap(from[0] + by[0]), Math.max(-90, Math.min(90, from[1] + by[1]))];
      setCross(next);
      if (zoom > 1) setCentre([next[0], Math.max(-80, Math.min(80, next[1]))]);
    } else if (event.key === "Enter") choose(from);
    else if (event.key === "+" || event.key === "=") setZoom(clampZoom(zoom * 1.6));
    else if (event.key === "-") setZoom(clampZoom(zoom / 1.6));
    else return;
    event.preventDefault();
  };
  const mark = (point: LonLat | null) => point && projection(point);
  const refusedAt = refused.value?.session === draft.chosen.value;
  return (
    <div class="map" ref={box}>
      <svg
        role="application"
        tabindex={0}
        aria-label={text.label}
        width={wide}
        height={high}
        onKeyDown={key}
        onPointerDown={(event) => {
          held.current = { x: event.clientX, y: event.clientY, centre, hasMoved: false };
          event.currentTarget.setPointerCapture(event.pointerId);
        }}
        onPointerMove={(event) => {
          const from = held.current;
          if (!from) return setCross(pointAt(event));
          const [dx, dy] = [event.clientX - from.x, event.clientY - from.y];
          if (Math.abs(dx) + Math.abs(dy) < 5 && !from.hasMoved) return;
          from.hasMoved = true;
          const degrees = 360 / (wide * zoom);
          setCentre([wrap(from.centre[0] - dx * degrees), Math.max(-80, Math.min(80, from.centre[1] + dy * degrees))]);
        }}
        onPointerUp={(event) => {
          if (held.current && !held.current.hasMoved) choose(pointAt(event));
          held.current = null;
        }}
        onPointerLeave={() => setCross(null)}
      >
        <rect class="sea" width={wide} height={high} />
        <path class="graticule" d={ground.graticule} />
        <path class="land" d={ground.land} />
        <path class="borders" d={ground.borders} />
        {seen && radius && <path class="circle" d={path(geoCircle().center(seen).radius(radius)()) ?? ""} />}
        {track.length > 1 && <path class={`track ${refusedAt ? "track-refused" : ""}`} d={path({ type: "LineString", coordinates: track }) ?? ""} />}
        {track.length > 1 && <Arrow from={mark(track[track.length - 2] ?? null)} to={mark(track[track.length - 1] ?? null)} />}
        {draft.sessions.value.map((one, index) => {
          const point = index === draft.chosen.value ? mark(seen) : mark(placeOf(one));
          return (
            point && (
              <g key={index} class={index === draft.chosen.value ? "mark mark-chosen" : "mark"} transform={`translate(${point[0]},${point[1]})`}>
                <circle r={5} />
                <text x={9} y={4}>
                  {one.name ?? (one.target ? textOf(one.target) : "")}
                </text>
              </g>
            )
          );
        })}
        <Cross point={mark(cross)} />
      </svg>
      <div class="map-tools">
        <button type="button" aria-label={text.closer} onClick={() => setZoom(clampZoom(zoom * 1.6))}>
          +
        </button>
        <button type="button" aria-label={text.further} onClick={() => setZoom(clampZoom(zoom / 1.6))}>
          −
        </button>
        <button
          type="button"
          aria-label={text.toTarget}
          disabled={!seen}
          onClick={() => {
            if (!seen) return;
            setCentre(seen);
            setZoom(Math.max(zoom, 6));
          }}
        >
          ◎
        </button>
        <button
          type="button"
          aria-label={text.whole}
          onClick={() => {
            setZoom(1);
            setCentre([0, 12]);
          }}
        >
          ⤢
        </button>
      </div>
      <p class="map-told" aria-live="off">
        {cross ? `${number(cross[1], 2)}, ${number(cross[0], 2)}` : text.hint}
      </p>
    </div>
  );
}

function Cross({ point }: { point: [number, number] | null }) {
  if (!point) return null;
  return <path class="cross" d={`M${point[0] - 8},${point[1]}h16M${point[0]},${point[1] - 8}v16`} />;
}

function Arrow({ from, to }: { from: [number, number] | null; to: [number, number] | null }) {
  if (!from || !to) return null;
  const turn = (Math.atan2(to[1] - from[1], to[0] - from[0]) * 180) / Math.PI;
  return <path class="arrow" d="M-8,-5L2,0L-8,5Z" transform={`translate(${to[0]},${to[1]}) rotate(${turn})`} />;
}

function placeOf(one: draft.DraftSession): LonLat | null {
  return one.target?.mode === "ground" ? [one.target.longitude_deg, one.target.latitude_deg] : null;
}

function clampZoom(zoom: number): number {
  return Math.max(1, Math.min(HIGHEST_ZOOM, zoom));
}

function wrap(longitude_deg: number): number {
  return ((((longitude_deg + 180) % 360) + 360) % 360) - 180;
}
