/** The path of the axes: one against the other, with what it must not touch. */
import { computed } from "@preact/signals";
import { useMemo, useState } from "preact/hooks";

import { Plane, pathOf, type Scale, type Span, span } from "../../charts/Plane";
import { words } from "../../i18n";
import { cursor_s } from "../../time/cursor";
import type { Stretch } from "../../time/TimeBar";
import { rowAt, type View, valueAt } from "./view";

const HEIGHT = 270;
const LEAST_SPAN_DEG = 20;
const TURN_DEG = 360;

interface Props {
  view: View;
  stretches: readonly Stretch[];
}

export function AxisSpace({ view, stretches }: Props) {
  const text = words.value.viewer.axisSpace;
  const [isWhole, setIsWhole] = useState(false);
  const [outer = "alpha", inner = "beta"] = Object.keys(view.axes);
  const [across, up] = [view.axes[outer], view.axes[inner]];
  const [acrossMay, upMay] = [view.limits[outer], view.limits[inner]];
  if (!across || !up || !acrossMay || !upMay) return null;
  const ends: (number | null)[] = [acrossMay, upMay].flatMap((one) => [one.angle_min_deg, one.angle_max_deg]);
  const [left, right, low, high] = ends;
  // A spacecraft that turns as a whole has no angles of axes.
  if (left == null || right == null || low == null || high == null) return null;
  const stops: [Span, Span] = [
    [left, right],
    [low, high],
  ];
  const x = span(isWhole ? stops[0] : across.angle_deg, LEAST_SPAN_DEG);
  const y = span(isWhole ? stops[1] : up.angle_deg, LEAST_SPAN_DEG);
  return (
    <section class="panel look-panel">
      <div class="look-head">
        <h2>{text.title}</h2>
        <label class="look-check">
          <input type="checkbox" checked={isWhole} onChange={(event) => setIsWhole(event.currentTarget.checked)} />
          {text.whole}
        </label>
      </div>
      <Plane label={text.told(outer, inner)} xLabel={`${outer}, °`} yLabel={`${inner}, °`} x={x} y={y} height={HEIGHT}>
        {(scale) => (
          <>
            <Stops x={stops[0]} y={stops[1]} scale={scale} />
            <Keyholes view={view} x={x} scale={scale} />
            {view.masks.flatMap((mask) =>
              (mask.outline_deg[outer] ?? []).map((line, way) => (
                <path
                  key={`${mask.number}-${way}`}
                  class={isOpen(line) ? "axis-mask axis-open" : "axis-mask"}
                  d={pathOf(line, mask.outline_deg[inner]?.[way] ?? [], scale, TURN_DEG / 2)}
                />
              )),
            )}
            <Cones view={view} outer={outer} inner={inner} scale={scale} />
            {stretches.map((one) => {
              const rows: [number, number] = [rowAt(view, one.start_s), rowAt(view, one.stop_s) + 1];
              const d = pathOf(across.angle_deg.slice(...rows), up.angle_deg.slice(...rows), scale);
              return <path key={one.start_s} class={`axis-path axis-${one.kind}`} d={d} />;
            })}
            <Here view={view} outer={outer} inner={inner} scale={scale} />
          </>
        )}
      </Plane>
      <p class="look-legend">
        <span class="key key-slew">{text.slew}</span>
        <span class="key key-track">{text.track}</span>
        <span class="key key-stop">{text.stops}</span>
        {view.keyholes_deg.length > 0 && <span class="key key-hole">{text.keyholes}</span>}
        {view.keep_out.length > 0 && <span class="key key-cone">{view.keep_out.map((cone) => cone.about).join(", ")}</span>}
        {view.masks.length > 0 && <span class="key key-mask">{view.masks.map((mask) => mask.name).join(", ")}</span>}
      </p>
    </section>
  );
}

function Stops({ x, y, scale }: { x: Span; y: Span; scale: Scale }) {
  const [left, right, top, bottom] = [scale.x(x[0]), scale.x(x[1]), scale.y(y[1]), scale.y(y[0])];
  return <rect class="axis-stops" x={left} y={top} width={right - left} height={bottom - top} />;
}

function Keyholes({ view, x, scale }: { view: View; x: Span; scale: Scale }) {
  return (
    <>
      {view.keyholes_deg.map((at) => (
        <line key={at} class="axis-keyhole" x1={scale.x(x[0])} x2={scale.x(x[1])} y1={scale.y(at)} y2={scale.y(at)} />
      ))}
    </>
  );
}

/** Where they lie at the cursor, drawn thin where they aren't in force. */
function Cones({ view, outer, inner, scale }: { view: View; outer: string; inner: string; scale: Scale }) {
  return (
    <>
      {view.keep_out.map((cone) => (
        <Cone key={cone.number} view={view} cone={cone} outer={outer} inner={inner} scale={scale} />
      ))}
    </>
  );
}

interface ConeProps {
  view: View;
  cone: View["keep_out"][number];
  outer: string;
  inner: string;
  scale: Scale;
}

function Cone({ view, cone, outer, inner, scale }: ConeProps) {
  const at = useMemo(() => computed(() => nearest(cone.outline_t_s, cursor_s.value)), [cone]);
  const now = at.value;
  const counts = cone.counts[rowAt(view, cone.outline_t_s[now] ?? 0)] ?? false;
  const ways = cone.outline_deg[outer]?.[now] ?? [];
  return (
    <>
      {ways.map((line, way) => (
        <path
          key={way}
          class={`axis-cone ${counts ? "" : "axis-cone-lapsed"} ${isOpen(line) ? "axis-open" : ""}`}
          d={pathOf(line, cone.outline_deg[inner]?.[now]?.[way] ?? [], scale, TURN_DEG / 2)}
        />
      ))}
    </>
  );
}

function Here({ view, outer, inner, scale }: { view: View; outer: string; inner: string; scale: Scale }) {
  const t_s = cursor_s.value;
  const x = valueAt(view, view.axes[outer]?.angle_deg ?? [], t_s);
  const y = valueAt(view, view.axes[inner]?.angle_deg ?? [], t_s);
  if (x === null || y === null) return null;
  return <circle class="look-here" cx={scale.x(x)} cy={scale.y(y)} r={5} />;
}

/** Whether an outline has an inside in this picture: not where it goes on a turn away. */
function isOpen(line: readonly (number | null)[]): boolean {
  return line.some((at, k) => at === null || Math.abs(at - (line[k - 1] ?? at)) > TURN_DEG / 2);
}

function nearest(all_s: readonly number[], t_s: number): number {
  let best = 0;
  for (const [index, one_s] of all_s.entries()) {
    if (Math.abs(one_s - t_s) < Math.abs((all_s[best] ?? 0) - t_s)) best = index;
  }
  return best;
}
