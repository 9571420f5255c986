/** A window's elevation over time, on the light there is at the target. */
import { lightOf, type Pass } from "./sight";
import "./windows.css";

const WIDE = 1000;
const HIGH = 100;
const QUARTER_DEG = 90;

/** Stretched to whatever it stands in; decoration, its figures are told beside it. */
export function Profile({ pass }: { pass: Pass }) {
  const { at, elevation_deg, sun_elevation_deg } = pass.through;
  const rise = Date.parse(pass.rise);
  const span = Math.max(1, Date.parse(pass.set) - rise);
  const x = at.map((instant) => (WIDE * (Date.parse(instant) - rise)) / span);
  const line = elevation_deg.map((angle, index) => {
    const most = pass.place === null ? 2 * QUARTER_DEG : QUARTER_DEG;
    const height = (HIGH * Math.min(Math.max(angle, 0), most)) / most;
    return `${(x[index] ?? 0).toFixed(1)},${(HIGH - height).toFixed(1)}`;
  });
  return (
    <svg class="profile" viewBox={`0 0 ${WIDE} ${HIGH}`} preserveAspectRatio="none" aria-hidden="true">
      {x.slice(1).map((right, index) => (
        <rect
          key={right}
          class={`light-${lightOf(sun_elevation_deg[index]) ?? "space"} ground`}
          x={x[index]}
          y={0}
          width={right - (x[index] ?? 0) + 1}
          height={HIGH}
        />
      ))}
      <path class="elevation" d={`M0,${HIGH} L${line.join(" L")} L${WIDE},${HIGH} Z`} />
    </svg>
  );
}
