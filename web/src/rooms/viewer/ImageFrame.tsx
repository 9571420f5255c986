/** The target's place in the camera's frame: the ellipses of the pointing budget. */
import { Plane, type Scale } from "../../charts/Plane";
import { words } from "../../i18n";
import { digits, percent, rowClock } from "../../i18n/forms";
import { cursor_s } from "../../time/cursor";
import type { Plan } from "../plan/plan";
import { frameRowAt, rowAt, type View } from "./view";

const HEIGHT = 270;
const SIGMAS = [1, 2, 3];
const HALF_ARCSEC_PER_DEG = 1800;

export function ImageFrame({ view, plan }: { view: View; plan: Plan }) {
  const text = words.value.viewer.frame;
  const [first = 1, second = 1] = view.frame_deg.map((side) => side * HALF_ARCSEC_PER_DEG);
  return (
    <section class="panel look-panel">
      <div class="look-head">
        <h2>{text.title}</h2>
      </div>
      <Plane
        label={text.told}
        xLabel={text.first}
        yLabel={text.second}
        x={[-1.12 * first, 1.12 * first]}
        y={[-1.12 * second, 1.12 * second]}
        height={HEIGHT}
        isEqual
      >
        {(scale) => (
          <>
            <rect
              class="frame-edge"
              x={scale.x(-first)}
              y={scale.y(second)}
              width={scale.x(first) - scale.x(-first)}
              height={scale.y(-second) - scale.y(second)}
            />
            <Ellipses view={view} scale={scale} />
            <path class="frame-cross" d={`M${scale.x(0) - 7},${scale.y(0)}h14M${scale.x(0)},${scale.y(0) - 7}v14`} />
          </>
        )}
      </Plane>
      <Told view={view} plan={plan} />
    </section>
  );
}

function Ellipses({ view, scale }: { view: View; scale: Scale }) {
  const row = frameRowAt(view, cursor_s.value);
  if (row === null) return null;
  const { sigma_major_arcsec, sigma_minor_arcsec, major_turn_deg } = view.pointing;
  const [major, minor, turn_deg] = [sigma_major_arcsec[row], sigma_minor_arcsec[row], major_turn_deg[row]];
  if (major == null || minor == null) return null;
  const px = Math.abs(scale.x(1) - scale.x(0));
  return (
    <g transform={`translate(${scale.x(0)},${scale.y(0)}) rotate(${-(turn_deg ?? 0)})`}>
      {SIGMAS.map((sigma) => (
        <ellipse key={sigma} class={`frame-sigma frame-sigma-${sigma}`} rx={sigma * major * px} ry={sigma * minor * px} />
      ))}
    </g>
  );
}

function Told({ view, plan }: { view: View; plan: Plan }) {
  const text = words.value.viewer.frame;
  const row = frameRowAt(view, cursor_s.value);
  if (row === null) return <p class="look-legend">{text.outside}</p>;
  const session = view.session[row];
  const budget = plan.uncertainty.find((one) => one.session === session);
  const [major, minor] = [view.pointing.sigma_major_arcsec[row], view.pointing.sigma_minor_arcsec[row]];
  if (major == null || minor == null) return null;
  return (
    <p class="look-legend">
      <span>{text.sigma(digits(major), digits(minor))}</span>
      {budget && <span>{text.inFrame(percent(budget.probability_in_frame))}</span>}
      {row !== rowAt(view, cursor_s.value) && (
        <span>{text.ofSession((session ?? 0) + 1, `${rowClock(Date.parse(view.epoch) + 1000 * (view.t_s[row] ?? 0))} UTC`)}</span>
      )}
    </p>
  );
}
