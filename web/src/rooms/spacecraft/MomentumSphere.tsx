/** The gyros' momentum in the sphere they can take in every direction; turned by hand or keys. */
import { useMemo, useRef, useState } from "preact/hooks";

import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import { cursor_s } from "../../time/cursor";
import type { SessionView } from "./session";

type Vector = readonly number[];

const SIZE = 260;
const REACH = 112; // of the sphere, in the picture
const STEP_DEG = 10;
const AXES: { name: string; of: Vector }[] = [
  { name: "X", of: [1, 0, 0] },
  { name: "Y", of: [0, 1, 0] },
  { name: "Z", of: [0, 0, 1] },
];

export function MomentumSphere({ view }: { view: SessionView }) {
  const text = words.value.spacecraft;
  const [turn, setTurn] = useState({ east_deg: 35, up_deg: 22 });
  const held = useRef<{ x: number; y: number } | null>(null);
  const radius_n_m_s = view.limits.momentum_sphere_n_m_s;
  const seen = useMemo(() => turned(turn.east_deg, turn.up_deg), [turn]);
  const { off, on } = useMemo(() => pathsOf(view, (h) => spot(h, radius_n_m_s, seen)), [view, seen]);
  const row = Math.min(Math.round(cursor_s.value / (view.step_s || 1)), view.t_s.length - 1);
  const now = view.momentum_n_m_s[row] ?? [0, 0, 0];
  const [x, y] = spot(now, radius_n_m_s, seen);
  const key = (event: KeyboardEvent) => {
    const moves: Record<string, [number, number]> = {
      ArrowLeft: [-1, 0],
      ArrowRight: [1, 0],
      ArrowUp: [0, 1],
      ArrowDown: [0, -1],
    };
    const by = moves[event.key];
    if (!by) return;
    event.preventDefault();
    event.stopPropagation();
    setTurn(({ east_deg, up_deg }) => ({ east_deg: east_deg + STEP_DEG * by[0], up_deg: tilt(up_deg + STEP_DEG * by[1]) }));
  };
  return (
    <section class="panel sphere" aria-labelledby="session-momentum">
      <svg
        viewBox={`${-SIZE / 2} ${-SIZE / 2} ${SIZE} ${SIZE}`}
        role="application"
        tabindex={0}
        aria-label={text.sphereLabel}
        onKeyDown={key}
        onPointerDown={(event) => {
          held.current = { x: event.clientX, y: event.clientY };
          event.currentTarget.setPointerCapture(event.pointerId);
        }}
        onPointerMove={(event) => {
          const from = held.current;
          if (!from) return;
          held.current = { x: event.clientX, y: event.clientY };
          setTurn(({ east_deg, up_deg }) => ({
            east_deg: east_deg + (event.clientX - from.x) / 2,
            up_deg: tilt(up_deg + (event.clientY - from.y) / 2),
          }));
        }}
        onPointerUp={() => {
          held.current = null;
        }}
      >
        <circle r={REACH} class="sphere-edge" />
        {AXES.map(({ of }, k) => (
          <path key={k} class="sphere-ring" d={ringAcross(of, seen)} />
        ))}
        {AXES.map(({ name, of }) => {
          const [endX, endY] = spot(of, 1, seen);
          return (
            <g key={name} class="sphere-axis">
              <line x2={endX} y2={endY} />
              <text x={endX * 1.08} y={endY * 1.08 + 4} text-anchor="middle">
                {name}
              </text>
            </g>
          );
        })}
        <path class="sphere-off" d={off} />
        <path class="sphere-on" d={on} />
        <line class="sphere-now" x2={x} y2={y} />
        <circle class="sphere-end" cx={x} cy={y} r={4.5} />
      </svg>
      <div>
        <h2 id="session-momentum">{text.sphere}</h2>
        <p class="sphere-figure">
          <b>{number(Math.hypot(...now))}</b> / {number(radius_n_m_s, 0)} N·m·s
        </p>
        <p class="mono">{now.map((part, k) => `${AXES[k]?.name} ${number(Number(part.toFixed(1)) + 0)}`).join("  ")}</p>
        <ul class="map-legend">
          <li class="key-line key-sphere-on">{text.legend.on}</li>
          <li class="key-line key-sphere-off">{text.legend.off}</li>
        </ul>
        <p class="hint">{text.sphereHint}</p>
      </div>
    </section>
  );
}

/** Rows: the picture's right and up, seen from this side. */
function turned(east_deg: number, up_deg: number): [Vector, Vector] {
  const [east, up] = [(east_deg * Math.PI) / 180, (up_deg * Math.PI) / 180];
  return [
    [-Math.sin(east), Math.cos(east), 0],
    [-Math.sin(up) * Math.cos(east), -Math.sin(up) * Math.sin(east), Math.cos(up)],
  ];
}

function spot(vector: Vector, whole: number, [right, up]: readonly [Vector, Vector]): [number, number] {
  const scale = REACH / whole;
  return [scale * dot(vector, right), -scale * dot(vector, up)];
}

/** The great circle at right angles to an axis. */
function ringAcross(axis: Vector, seen: [Vector, Vector]): string {
  const [a, b] = AXES.map((one) => one.of).filter((one) => dot(one, axis) === 0);
  if (!a || !b) return "";
  const points = Array.from({ length: 73 }, (_, k) => {
    const angle = (k * Math.PI) / 36;
    const on = [0, 1, 2].map((part) => (a[part] ?? 0) * Math.cos(angle) + (b[part] ?? 0) * Math.sin(angle));
    return spot(on, 1, seen)
      .map((one) => one.toFixed(1))
      .join();
  });
  return `M${points.join("L")}`;
}

/** The momentum's way, in the imaging intervals and between them. */
function pathsOf(view: SessionView, draw: (h: Vector) => [number, number]): { off: string; on: string } {
  const paths = { off: "", on: "" };
  let before = "";
  for (const [row, h] of view.momentum_n_m_s.entries()) {
    const point = draw(h)
      .map((one) => one.toFixed(1))
      .join();
    if (before) paths[view.window[row] === null ? "off" : "on"] += `M${before}L${point}`;
    before = point;
  }
  return paths;
}

function tilt(up_deg: number): number {
  return Math.max(-90, Math.min(90, up_deg));
}

function dot(a: Vector, b: Vector): number {
  return a.reduce((sum, part, k) => sum + part * (b[k] ?? 0), 0);
}
