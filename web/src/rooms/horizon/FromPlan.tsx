/** Position and predicted attitude as a kept plan has them at the frames' epoch. */
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { Field } from "../../parts/Field";
import { useKept } from "../../parts/kept";
import { PlanField, type useKeptPlan } from "../../parts/PlanField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { isOfBody } from "../plan/plan";
import { filledFromPlan, type HorizonRequest, rowNearest, spanOf } from "./estimate";

interface Props {
  /** Of the plan. */
  id: string;
  onId: (id: string) => void;
  kept: ReturnType<typeof useKeptPlan>;
  request: HorizonRequest | null;
  onRequest: (request: HorizonRequest) => void;
}

const SIGMA_DEG = 0.5;

export function FromPlan({ id, onId, kept, request, onRequest }: Props) {
  const text = words.value.horizon;
  const [sigma_deg, setSigma] = useKept("/horizon sigma", SIGMA_DEG);
  const { answer: isFilled, error, ask } = useRequest<true>(null);
  const { plan } = kept;
  const isOutside = plan !== null && request !== null && isOfBody(plan) && rowNearest(plan.table, request.epoch) === null;
  const fill = (event: Event) => {
    event.preventDefault();
    if (!request || !plan) return;
    void ask(async () => {
      onRequest(await filledFromPlan(plan, request, sigma_deg));
      return true;
    });
  };
  return (
    <form onSubmit={fill}>
      <div class="from-plan">
        <PlanField id={id} onId={onId} kept={kept} />
        <Field label={text.sigma}>
          {(control) => (
            <input
              {...control}
              type="number"
              min={0.001}
              max={180}
              step="any"
              value={sigma_deg}
              onInput={(event) => setSigma(event.currentTarget.valueAsNumber)}
            />
          )}
        </Field>
        <button type="submit" disabled={!request || !plan || isOutside || !(sigma_deg > 0)}>
          {text.fill}
        </button>
      </div>
      {plan && isOutside ? (
        <p class="notice notice-warn">{text.outside(spanOf(plan.table))}</p>
      ) : (
        <p class="hint">{text.planHint}</p>
      )}
      <p role="status" class="small">
        {isFilled && !isOutside && text.filled}
      </p>
      {error !== null && <ProblemNotice error={error} />}
    </form>
  );
}
