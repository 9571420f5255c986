/** The limb in each horizon camera's frame, at a session's start, middle and stop. */
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { clock, number } from "../../i18n/forms";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { moveTo } from "../../time/playback";
import type { Plan } from "../plan/plan";
import { fetchCameras, type HorizonCamera } from "./view";

interface Props {
  plan: Plan;
  epoch_ms: number;
  stop_s: number;
}

export function HorizonViews({ plan, epoch_ms, stop_s }: Props) {
  const text = words.value.viewer.horizon;
  const checks = plan.horizon_checks;
  const { answer, error, ask } = useRequest(checks.length > 0 ? plan.id : null, (until) => fetchCameras(plan.id, until));
  if (checks.length === 0) return null;
  return (
    <section class="panel look-wide">
      <h2>{text.title}</h2>
      {error !== null && <ProblemNotice error={error} again={() => void ask()} />}
      <div class="look-cameras">
        {checks.flatMap((check) => {
          const camera = answer?.find((one) => one.name === check.camera);
          return check.views.map((view) => (
            <figure key={`${check.session}-${check.camera}-${view.at}`}>
              {camera && <Limb camera={camera} limb_px={view.limb_px} label={text.told(view.camera, clock(view.at))} />}
              <figcaption>
                <button type="button" class="plain" onClick={() => moveTo((Date.parse(view.at) - epoch_ms) / 1000, stop_s)}>
                  {view.camera} · {clock(view.at)}
                </button>
                <span class={view.usable ? "look-good" : "look-bad"}>
                  {view.usable ? text.usable(number(view.arc_deg, 0), number(view.sigma_deg, 3)) : view.explanation}
                </span>
              </figcaption>
            </figure>
          ));
        })}
      </div>
    </section>
  );
}

function Limb({ camera, limb_px, label }: { camera: HorizonCamera; limb_px: readonly (readonly number[])[]; label: string }) {
  const { width_px, height_px } = camera;
  const points = limb_px.map(([x = 0, y = 0]) => `${x + 0.5},${y + 0.5}`).join(" ");
  return (
    <svg class="look-limb" viewBox={`0 0 ${width_px} ${height_px}`} role="img" aria-label={label}>
      <rect width={width_px} height={height_px} />
      <polyline points={points} />
    </svg>
  );
}
