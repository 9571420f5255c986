/** The estimate: the verdict, the nadir with its ellipse, each camera's overlay. */
import { words } from "../../i18n";
import { digits, fixed, instant, number, percent } from "../../i18n/forms";
import { labelOf } from "../../i18n/labels";
import { Copied } from "../../parts/Copied";
import { Identity } from "../../parts/Identity";
import { NextPlan } from "../../parts/NextPlan";
import { checksum } from "../../parts/paper";
import { isOfBody, type Plan } from "../plan/plan";
import { Ellipse } from "./Ellipse";
import type { Estimate, HorizonRequest } from "./estimate";

interface Props {
  found: Estimate;
  asked: HorizonRequest;
  /** That it is checked against. */
  plan: Plan | null;
}

export function Result({ found, asked, plan }: Props) {
  const text = words.value.horizon;
  // A body steers itself: its next plan takes none.
  const correction = plan && isOfBody(plan) ? null : found.correction;
  const cameras = asked.cameras.map((camera) => camera.name).join(", ");
  return (
    <section class="panel" aria-labelledby="horizon-result">
      <h2 id="horizon-result">{text.result}</h2>
      <Identity
        name={plan ? labelOf({ ...plan.summary, id: plan.id }) : text.of}
        parts={[...(plan ? [text.of] : []), instant(asked.epoch), cameras]}
        proof={[...(plan ? [plan.id] : []), checksum(found.provenance.input_sha256)]}
        made={{ at: found.provenance.planned_at }}
      />
      <p data-testid="horizon-verdict" role="status" class={`verdict verdict-${found.verdict}`}>
        <strong>{text.verdicts[found.verdict]}</strong>
        {found.sigma_deg !== null && ` ${text.sigmaOf(digits(found.sigma_deg))}`}
        {found.check && ` ${text.differs(digits(found.check.angle_deg), percent(found.check.probability))}`}
        {found.explanation && ` ${found.explanation}`}
      </p>
      <div class="horizon">
        {found.covariance_deg2 && (
          <figure>
            <Ellipse covariance_deg2={found.covariance_deg2} check={found.check} />
            <figcaption class="small">{text.ellipse}</figcaption>
          </figure>
        )}
        <dl>
          <Vector name={text.nadir} value={found.nadir_body} />
          <Vector name={text.geodetic} value={found.nadir_geodetic_body} />
          {found.limb_height_km !== null && (
            <>
              <dt>{text.limb}</dt>
              <dd>
                {number(found.limb_height_km)} ± {number(found.limb_height_sigma_km)} km
              </dd>
            </>
          )}
          {found.warnings.length > 0 && (
            <>
              <dt>{text.warnings}</dt>
              {found.warnings.map((warning) => (
                <dd key={warning}>{words.value.service.told(warning)}</dd>
              ))}
            </>
          )}
        </dl>
      </div>
      <div class="overlays">
        {found.cameras.map((camera) => (
          <figure key={camera.name}>
            {camera.overlay_png && <img src={`data:image/png;base64,${camera.overlay_png}`} alt={text.overlayOf(camera.name)} />}
            <figcaption>
              <strong>{camera.name}</strong>:{" "}
              {camera.used
                ? text.used(number(camera.arc_deg), digits(camera.residual_px, 2))
                : `${text.notUsed} ${camera.explanation ?? ""}`}
            </figcaption>
          </figure>
        ))}
      </div>
      {correction && plan && <NextPlan plan={plan.id} learnt={{ corrections: [correction] }} />}
      {correction && <Copied name={text.correction} content={JSON.stringify(correction, null, 2)} />}
    </section>
  );
}

function Vector({ name, value }: { name: string; value: readonly number[] | null }) {
  if (!value) return null;
  return (
    <>
      <dt>{name}</dt>
      <dd class="mono">{value.map((part) => fixed(part, 6)).join(", ")}</dd>
    </>
  );
}
