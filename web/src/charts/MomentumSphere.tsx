/** The gyros' momentum in the sphere they can take in every direction; turned by hand or keys. */
import { useMemo, useRef, useState } from "preact/hooks";

import { words } from "../i18n";
import { number } from "../i18n/forms";
import { cursor_s } from "../time/cursor";

type Vector = readonly number[];

const SIZE = 260;
const REACH = 112; // of the sphere, in the picture
const STEP_DEG = 10;
const AXES: { name: string; of: Vector }[] = [
  { name: "X", of: [1, 0, 0] },
  { name: "Y", of: [0, 1, 0] },
  { name: "Z", of: [0, 0, 1] },
];

interface Props {
  /** Of the gyros in body axes, by rows. */
  momentum_n_m_s: readonly Vector[];
  /** What they may take in every direction. */
  most_n_m_s: number;
  step_s: number;
  /** Whether the camera is on from a row on. */
  isOn: (row: number) => boolean;
}

export function MomentumSphere({ momentum_n_m_s, most_n_m_s, step_s, isOn }: Props) {
  const text = words.value.viewer.gyros;
  const [turn, setTurn] = useState({ east_deg: 35, up_deg: 22 });
  const held = useRef<{ x: number; y: number } | null>(null);
  const seen = useMemo(() => turned(turn.east_deg, turn.up_deg), [turn]);
  const { off, on } = useMemo(
    () => pathsOf(momentum_n_m_s, isOn, (h) => spot(h, most_n_m_s, seen)),
    [momentum_n_m_s, isOn, seen],
  );
  const row = Math.min(Math.round(cursor_s.value / (step_s || 1)), momentum_n_m_s.length - 1);
  const now = momentum_n_m_s[row] ?? [0, 0, 0];
  const [x, y] = spot(now, most_n_m_s, seen);
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
    <section class="panel sphere" aria-labelledby="gyros-momentum">
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
        <h2 id="gyros-momentum">{text.sphere}</h2>
        <p class="sphere-figure">
          <b>{number(Math.hypot(...now))}</b> / {number(most_n_m_s, 0)} N·m·s
        </p>
        <p class="mono">{now.map((part, k) => `${AXES[k]?.name} ${number(Number(part.toFixed(1)) + 0)}`).join("  ")}</p>
        <ul class="sphere-legend">
          <li class="key-line key-sphere-on">{text.on}</li>
          <li class="key-line key-sphere-off">{text.off}</li>
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
function pathsOf(
  momentum: readonly Vector[],
  isOn: (row: number) => boolean,
  draw: (h: Vector) => [number, number],
): { off: string; on: string } {
  const paths = { off: "", on: "" };
  let before = "";
  for (const [row, h] of momentum.entries()) {
    const point = draw(h)
      .map((one) => one.toFixed(1))
      .join();
    if (before) paths[isOn(row) ? "on" : "off"] += `M${before}L${point}`;
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
