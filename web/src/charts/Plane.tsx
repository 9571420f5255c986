/** Two axes of degrees or arcseconds at right angles, and what is drawn between them. */
import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef, useState } from "preact/hooks";

import "./charts.css";
import { ticks } from "./levels";

export type Span = readonly [number, number];

export interface Scale {
  x: (value: number) => number;
  y: (value: number) => number;
}

interface Props {
  label: string;
  xLabel: string;
  yLabel: string;
  x: Span;
  y: Span;
  height: number;
  /** Whether a unit is as long on both axes; the spans then grow as the box asks. */
  isEqual?: boolean;
  children: (scale: Scale) => ComponentChildren;
}

const [LEFT, RIGHT, TOP, BOTTOM] = [46, 8, 8, 34];

export function Plane({ label, xLabel, yLabel, x, y, height, isEqual, children }: Props) {
  const clip = useId();
  const box = useRef<HTMLDivElement>(null);
  const [width, setWidth] = useState(320);
  useEffect(() => {
    const element = box.current;
    if (!element) return;
    const watch = new ResizeObserver(() => setWidth(Math.max(element.clientWidth, 160)));
    watch.observe(element);
    return () => watch.disconnect();
  }, []);
  const [wide, high] = [width - LEFT - RIGHT, height - TOP - BOTTOM];
  const [xs, ys] = isEqual ? equal(x, y, wide / high) : [x, y];
  const scale: Scale = {
    x: (value) => LEFT + ((value - xs[0]) / (xs[1] - xs[0])) * wide,
    y: (value) => TOP + ((ys[1] - value) / (ys[1] - ys[0])) * high,
  };
  return (
    <div class="plane" ref={box}>
      <svg width={width} height={height} viewBox={`0 0 ${width} ${height}`} role="img" aria-label={label}>
        <clipPath id={clip}>
          <rect x={LEFT} y={TOP} width={wide} height={high} />
        </clipPath>
        <g class="plane-grid">
          {ticks(xs, wide / 64).map((one) => (
            <g key={`x${one}`}>
              <line x1={scale.x(one)} x2={scale.x(one)} y1={TOP} y2={TOP + high} />
              <text x={scale.x(one)} y={TOP + high + 14} text-anchor="middle">
                {told(one)}
              </text>
            </g>
          ))}
          {ticks(ys, high / 34).map((one) => (
            <g key={`y${one}`}>
              <line x1={LEFT} x2={LEFT + wide} y1={scale.y(one)} y2={scale.y(one)} />
              <text x={LEFT - 5} y={scale.y(one) + 4} text-anchor="end">
                {told(one)}
              </text>
            </g>
          ))}
        </g>
        <g class="plane-names">
          <text x={LEFT + wide / 2} y={height - 4} text-anchor="middle">
            {xLabel}
          </text>
          <text transform={`translate(10,${TOP + high / 2}) rotate(-90)`} text-anchor="middle">
            {yLabel}
          </text>
        </g>
        <g clip-path={`url(#${clip})`}>{children(scale)}</g>
        <rect class="plane-box" x={LEFT} y={TOP} width={wide} height={high} />
      </svg>
    </div>
  );
}

/** The spans, one of them grown until a unit is as long on both. */
function equal(x: Span, y: Span, aspect: number): [Span, Span] {
  const [wide, high] = [x[1] - x[0], y[1] - y[0]];
  return wide / high < aspect ? [grown(x, high * aspect), y] : [x, grown(y, wide / aspect)];
}

function grown([low, high]: Span, length: number): Span {
  const middle = (low + high) / 2;
  return [middle - length / 2, middle + length / 2];
}

function told(value: number): string {
  return String(value).replace("-", "−");
}

/** Points as a path, broken where one of them isn't known and where it jumps by more than so much. */
export function pathOf(xs: readonly (number | null)[], ys: readonly (number | null)[], { x, y }: Scale, jump = Infinity): string {
  let path = "";
  let isDown = false;
  for (let k = 0; k < xs.length; k++) {
    const [across, up] = [xs[k], ys[k]];
    if (across == null || up == null) isDown = false;
    else {
      if (Math.abs(across - (xs[k - 1] ?? across)) > jump || Math.abs(up - (ys[k - 1] ?? up)) > jump) isDown = false;
      path += `${isDown ? "L" : "M"}${x(across).toFixed(1)},${y(up).toFixed(1)}`;
      isDown = true;
    }
  }
  return path;
}

/** Low and high with air around, at least so wide. */
export function span(values: Iterable<number | null>, least: number, air = 0.12): Span {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value === null) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (low > high) return [-least / 2, least / 2];
  return grown([low, high], Math.max((high - low) * (1 + 2 * air), least));
}
