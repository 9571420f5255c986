/** One strip of lines over the plan's time; strips share their stretch of time and the cursor. */
import { effect, type Signal, signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";

import { isDark } from "../shell/theme";
import { cursor_s, isPlaying } from "../time/cursor";
import "./charts.css";
import { colour } from "./colours";
import { labels } from "./levels";

export type Values = readonly (number | null)[];

export interface Line {
  label: string;
  /** As long as the time. */
  values: Values;
  /** Of theme.css. */
  colour: string;
  dashed?: boolean;
  width?: number;
  /** Behind the others: seen as far as their scale allows. */
  isBehind?: boolean;
}

export interface Shade {
  start_s: number;
  stop_s: number;
  /** Of theme.css. */
  colour: string;
}

export interface TimeRange {
  from_s: number;
  to_s: number;
}

interface Props {
  /** For who doesn't see it. */
  label: string;
  epoch_ms: number;
  t_s: readonly number[];
  lines: readonly Line[];
  /** Drawn as dashed levels where they are in sight. */
  limits?: readonly number[];
  /** Whether the limits are to be in sight. */
  withLimits?: boolean;
  shades?: readonly Shade[];
  isLogarithmic?: boolean;
  hasTimes?: boolean;
  height: number;
  range: Signal<TimeRange>;
}

const TICK_STEPS_S = [0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 43200];
const LEFT_PX = 62;
const RIGHT_PX = 28; // half of a time's text
const LEAST_RANGE_S = 2;

export function TimeChart(props: Props) {
  const box = useRef<HTMLDivElement>(null);
  const dark = isDark();
  useEffect(() => {
    const element = box.current;
    if (!element) return;
    const plot = new uPlot(options(props, element.clientWidth), aligned(props), element);
    const undo = [follow(plot, props), handle(plot, props), resize(plot, element, props.height)];
    return () => {
      for (const one of undo) one();
      plot.destroy();
    };
  }, [props.t_s, props.lines, props.limits, props.withLimits, props.isLogarithmic, props.hasTimes, props.height, dark]);
  return <div class="chart" ref={box} role="img" aria-label={props.label} />;
}

function aligned({ t_s, epoch_ms, lines }: Props): uPlot.AlignedData {
  const epoch_s = epoch_ms / 1000;
  return [t_s.map((t) => epoch_s + t), ...lines.map((line) => line.values)] as uPlot.AlignedData;
}

function options(props: Props, width: number): uPlot.Options {
  const { lines, limits = [], withLimits, isLogarithmic, hasTimes, height, range, epoch_ms } = props;
  const shades = (props.shades ?? []).map((one) => ({ ...one, colour: colour(one.colour) }));
  const epoch_s = epoch_ms / 1000;
  const [text, line, strong] = [colour("text-soft"), colour("line"), colour("line-strong")];
  const font = `11px ${colour("font")}`;
  const grid = { stroke: line, width: 1 };
  const ticks = { stroke: line, width: 1, size: 4 };
  return {
    width: Math.max(width, 120),
    height,
    padding: [6, RIGHT_PX, hasTimes ? 0 : 6, 0],
    cursor: { show: false },
    legend: { show: false },
    select: { show: false, left: 0, top: 0, width: 0, height: 0 },
    scales: {
      x: {
        time: false,
        range: () => [epoch_s + range.peek().from_s, epoch_s + range.peek().to_s],
      },
      y: isLogarithmic
        ? { distr: 3, range: (_, low, high) => decades(low, high) }
        : { range: (_, low, high) => spread(low, high, withLimits ? limits : behind(lines, low, high)) },
    },
    axes: [
      {
        show: hasTimes ?? false,
        stroke: text,
        font,
        grid,
        ticks,
        size: 26,
        gap: 3,
        space: 78,
        incrs: TICK_STEPS_S,
        values: (_, splits, _axis, _space, step) =>
          splits.map((split) => new Date(Math.round(split * 1000)).toISOString().slice(11, step < 1 ? 21 : 19)),
      },
      {
        stroke: text,
        font,
        grid,
        ticks,
        size: LEFT_PX,
        gap: 4,
        space: 26,
        values: (_: uPlot, splits: number[]) => labels(splits),
        ...(isLogarithmic && {
          splits: (_: uPlot, _axis: number, low: number, high: number) => powers(low, high),
          filter: (_: uPlot, splits: number[]) => splits,
          values: (_: uPlot, splits: number[]) => splits.map(String),
        }),
      },
    ],
    series: [
      {},
      ...lines.map((one) => ({
        label: one.label,
        auto: !one.isBehind,
        alpha: one.isBehind ? 0.6 : 1,
        stroke: colour(one.colour),
        width: one.width ?? 1.5,
        dash: one.dashed ? [5, 4] : undefined,
        points: { show: false },
        spanGaps: false,
      })),
    ],
    hooks: {
      drawClear: [(plot) => shade(plot, shades, epoch_s)],
      draw: [(plot) => levels(plot, limits, strong)],
    },
  };
}

/** Lines with air around them; a line that doesn't move still has a scale. */
function spread(low: number | null, high: number | null, also: readonly number[]): [number, number] {
  const all = [low, high, ...also].filter((one): one is number => one !== null && Number.isFinite(one));
  if (all.length === 0) return [0, 1];
  const [least, most] = [Math.min(...all), Math.max(...all)];
  const air = 0.08 * (most - least) || Math.max(0.1 * Math.abs(most), 1e-6);
  return [least - air, most + air];
}

/** How far the lines behind reach, up to three times as far as those before them. */
function behind(lines: readonly Line[], low: number | null, high: number | null): number[] {
  if (low === null || high === null) return [];
  const air = high - low;
  return lines.flatMap((line) => {
    if (!line.isBehind) return [];
    let [least, most] = [low, high];
    for (const value of line.values) {
      if (value === null) continue;
      least = Math.min(least, value);
      most = Math.max(most, value);
    }
    return [Math.max(least, low - air), Math.min(most, high + air)];
  });
}

function decades(low: number | null, high: number | null): [number, number] {
  if (low === null || high === null || low <= 0) return [0.1, 10];
  return [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high * 1.0001))];
}

/** Levels of a logarithmic scale: of few decades with steps between, of many not each. */
function powers(low: number, high: number): number[] {
  const [first, last] = [Math.round(Math.log10(low)), Math.round(Math.log10(high))];
  const every = Math.ceil((last - first) / 4);
  const found: number[] = [];
  for (let power = first; power <= last; power += every) {
    found.push(Number(`1e${power}`));
    if (last - first <= 1 && power < last) found.push(Number(`2e${power}`), Number(`5e${power}`));
  }
  return found;
}

function shade(plot: uPlot, shades: readonly Shade[], epoch_s: number): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (const one of shades) {
    const left = plot.valToPos(epoch_s + one.start_s, "x", true);
    const right = plot.valToPos(epoch_s + one.stop_s, "x", true);
    ctx.fillStyle = one.colour;
    ctx.fillRect(left, bbox.top, right - left, bbox.height);
  }
  ctx.restore();
}

function levels(plot: uPlot, limits: readonly number[], stroke: string): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.strokeStyle = stroke;
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
  for (const limit of limits) {
    const y = plot.valToPos(limit, "y", true);
    if (!(y >= bbox.top - 1 && y <= bbox.top + bbox.height + 1)) continue;
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
  }
  ctx.restore();
}

/** Keeps the strip's stretch of time and the cursor's line where they are for all. */
function follow(plot: uPlot, { range, epoch_ms }: Props): () => void {
  const line = document.createElement("div");
  line.className = "chart-now";
  plot.over.append(line);
  const isInSight = signal(true);
  const watch = new IntersectionObserver(([entry]) => {
    isInSight.value = entry?.isIntersecting ?? true;
  });
  watch.observe(plot.root);
  const stopRange = effect(() => {
    const { from_s, to_s } = range.value;
    if (isInSight.value) plot.setScale("x", { min: epoch_ms / 1000 + from_s, max: epoch_ms / 1000 + to_s });
  });
  const stopCursor = effect(() => {
    const { from_s, to_s } = range.value;
    const share = (cursor_s.value - from_s) / (to_s - from_s);
    line.hidden = share < 0 || share > 1;
    line.style.transform = `translateX(${share * widthOf(plot)}px)`;
  });
  return () => {
    watch.disconnect();
    stopRange();
    stopCursor();
  };
}

/** Between the axes, CSS pixels: as uPlot keeps it, since asking the element would lay the page out. */
function widthOf(plot: uPlot): number {
  return plot.bbox.width / devicePixelRatio;
}

/** Drag: the cursor.  Shift and drag: the stretch of time.  Ctrl and wheel: closer or farther. */
function handle(plot: uPlot, { range, t_s }: Props): () => void {
  const stop_s = t_s[t_s.length - 1] ?? 0;
  const { over } = plot;
  let held: { x: number; from: TimeRange; isPan: boolean } | null = null;
  const secondAt = (event: PointerEvent | WheelEvent) => {
    const corner = over.getBoundingClientRect();
    const { from_s, to_s } = range.peek();
    return from_s + ((event.clientX - corner.left) / corner.width) * (to_s - from_s);
  };
  const scrub = (event: PointerEvent) => {
    cursor_s.value = Math.min(Math.max(secondAt(event), 0), stop_s);
  };
  const down = (event: PointerEvent) => {
    if (event.button !== 0) return;
    over.setPointerCapture(event.pointerId);
    held = { x: event.clientX, from: range.peek(), isPan: event.shiftKey };
    isPlaying.value = false;
    if (!held.isPan) scrub(event);
  };
  const move = (event: PointerEvent) => {
    if (!held) return;
    if (!held.isPan) return scrub(event);
    const { from_s, to_s } = held.from;
    const by_s = ((held.x - event.clientX) / widthOf(plot)) * (to_s - from_s);
    range.value = within(from_s + by_s, to_s - from_s, stop_s);
  };
  const up = () => {
    held = null;
  };
  const wheel = (event: WheelEvent) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoom(range, secondAt(event), event.deltaY < 0 ? 0.8 : 1.25, stop_s);
  };
  over.addEventListener("pointerdown", down);
  over.addEventListener("pointermove", move);
  over.addEventListener("pointerup", up);
  over.addEventListener("pointercancel", up);
  over.addEventListener("wheel", wheel, { passive: false });
  return () => {
    over.removeEventListener("pointerdown", down);
    over.removeEventListener("pointermove", move);
    over.removeEventListener("pointerup", up);
    over.removeEventListener("pointercancel", up);
    over.removeEventListener("wheel", wheel);
  };
}

function resize(plot: uPlot, element: HTMLElement, height: number): () => void {
  const watch = new ResizeObserver(() => {
    const width = element.clientWidth;
    if (width > 0 && width !== plot.width) plot.setSize({ width, height });
  });
  watch.observe(element);
  return () => watch.disconnect();
}

/** factor: below 1 comes closer; the instant about_s stays where it is. */
export function zoom(range: Signal<TimeRange>, about_s: number, factor: number, stop_s: number): void {
  const { from_s, to_s } = range.peek();
  const length_s = Math.min(Math.max((to_s - from_s) * factor, LEAST_RANGE_S), stop_s);
  const share = (about_s - from_s) / (to_s - from_s);
  range.value = within(about_s - share * length_s, length_s, stop_s);
}

/** So long a stretch, moved to where there is time. */
export function within(from_s: number, length_s: number, stop_s: number): TimeRange {
  const start_s = Math.min(Math.max(from_s, 0), Math.max(stop_s - length_s, 0));
  return { from_s: start_s, to_s: start_s + length_s };
}
