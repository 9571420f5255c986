/** The Earth, flat: moved by hand or keys, closer and further; what is on it is drawn by others. */
import { type GeoPath, type GeoProjection, geoEquirectangular, geoGraticule10, geoPath } from "d3-geo";
import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

import { words } from "../i18n";
import { number } from "../i18n/forms";
import "./map.css";
import { outlines, wantDetail, wantOutlines } from "./outlines";
import { clampLatitude, type LonLat, middleOf, wrap } from "./places";

export interface Drawing {
  projection: GeoProjection;
  path: GeoPath;
  /** Of the map, in pixels. */
  wide: number;
}

interface Props {
  /** What it is and what its keys do. */
  label: string;
  hint: string;
  /** Come to by the button ◎; one place, or several that then fill the map. */
  around: readonly LonLat[];
  aroundLabel: string;
  /** Whether they fill the map from the first, and whenever they become others. */
  fits?: boolean;
  /** A click, or Enter at the cross; rounded to what the hand can tell. */
  onPick?: (point: LonLat) => void;
  height?: number;
  children: (drawing: Drawing) => ComponentChildren;
}

const HIGHEST_ZOOM = 256;
const NEAR_ZOOM = 6;
const DETAIL_FROM = 4;
const WHOLE: LonLat = [0, 12];

export function EarthMap({ label, hint, around, aroundLabel, fits, onPick, height = 460, children }: Props) {
  const text = words.value.plan.map;
  const box = useRef<HTMLDivElement>(null);
  const [wide, setWide] = useState(0);
  const [zoom, setZoom] = useState(1);
  const [centre, setCentre] = useState<LonLat>(WHOLE);
  const [cross, setCross] = useState<LonLat | null>(null);
  const held = useRef<{ x: number; y: number; centre: LonLat; hasMoved: boolean } | null>(null);
  const high = Math.round(Math.min(wide * (fits ? 0.75 : 0.5), height));
  const fit = () => {
    const middle = middleOf(around);
    if (!middle || wide === 0) return;
    const { at, wide_deg, high_deg } = middle;
    const degrees = Math.max(wide_deg, (high_deg * wide) / high) * 1.2;
    setCentre([at[0], clampLatitude(at[1])]);
    setZoom(degrees === 0 ? Math.max(zoom, NEAR_ZOOM) : clampZoom(360 / degrees));
  };
  useEffect(() => {
    void wantOutlines().catch(() => undefined); // a map without coasts is still one
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
  const fitted = fits ? JSON.stringify(around) : "";
  // Before it is painted: a move by hand comes after it.
  useLayoutEffect(() => {
    if (fits) fit();
  }, [fitted, wide === 0]);
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
  // A cross that moves draws nothing else anew, however much there is.
  const drawn = useMemo(() => wide > 0 && children({ projection, path, wide }), [children, projection, path, wide]);
  const pointAt = (event: { clientX: number; clientY: number }): LonLat | null => {
    const corner = box.current?.getBoundingClientRect();
    const point = corner && projection.invert?.([event.clientX - corner.left, event.clientY - corner.top]);
    return point && Math.abs(point[1]) <= 90 ? [wrap(point[0]), point[1]] : null;
  };
  const pick = (point: LonLat | null) => {
    const decimals = zoom > 8 ? 4 : 2;
    if (point) onPick?.([Number(point[0].toFixed(decimals)), Number(point[1].toFixed(decimals))]);
  };
  const key = (event: KeyboardEvent) => {
    const step = 5 / zoom;
    const moves: Record<string, LonLat> = {
      ArrowLeft: [-step, 0],
      ArrowRight: [step, 0],
      ArrowUp: [0, step],
      ArrowDown: [0, -step],
    };
    const by = moves[event.key];
    const from = onPick ? (cross ?? (around.length === 1 ? around[0] : undefined) ?? centre) : centre;
    if (by) {
      const next: LonLat = [wrap(from[0] + by[0]), Math.max(-90, Math.min(90, from[1] + by[1]))];
      if (onPick) setCross(next);
      if (zoom > 1 || !onPick) setCentre([next[0], clampLatitude(next[1])]);
    } else if (event.key === "Enter" && onPick) pick(from);
    else if (event.key === "+" || event.key === "=") setZoom(clampZoom(zoom * 1.6));
    else if (event.key === "-") setZoom(clampZoom(zoom / 1.6));
    else return;
    event.preventDefault();
  };
  return (
    <div class="map" ref={box}>
      <svg
        role="application"
        tabindex={0}
        aria-label={label}
        width={wide}
        height={high}
        class={onPick ? "map-picks" : "map-moves"}
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
          setCentre([wrap(from.centre[0] - dx * degrees), clampLatitude(from.centre[1] + dy * degrees)]);
        }}
        onPointerUp={(event) => {
          if (held.current && !held.current.hasMoved) pick(pointAt(event));
          held.current = null;
        }}
        onPointerLeave={() => setCross(null)}
      >
        <rect class="sea" width={wide} height={high} />
        <path class="graticule" d={ground.graticule} />
        <path class="land" d={ground.land} />
        <path class="borders" d={ground.borders} />
        {drawn}
        {onPick && <Cross point={cross && projection(cross)} />}
      </svg>
      <div class="map-tools">
        <button type="button" aria-label={text.closer} onClick={() => setZoom(clampZoom(zoom * 1.6))}>
          +
        </button>
        <button type="button" aria-label={text.further} onClick={() => setZoom(clampZoom(zoom / 1.6))}>
          −
        </button>
        <button type="button" aria-label={aroundLabel} disabled={around.length === 0} onClick={fit}>
          ◎
        </button>
        <button
          type="button"
          aria-label={text.whole}
          onClick={() => {
            setZoom(1);
            setCentre(WHOLE);
          }}
        >
          ⤢
        </button>
      </div>
      <p class="map-told" aria-live="off">
        {cross ? `${number(cross[1], 2)}, ${number(cross[0], 2)}` : hint}
      </p>
    </div>
  );
}

function Cross({ point }: { point: [number, number] | null }) {
  if (!point) return null;
  return <path class="cross" d={`M${point[0] - 8},${point[1]}h16M${point[0]},${point[1] - 8}v16`} />;
}

function clampZoom(zoom: number): number {
  return Math.max(1, Math.min(HIGHEST_ZOOM, zoom));
}
