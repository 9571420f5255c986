/** The request to fly a plan many times, and the list of earlier flights. */
import { get } from "../../api/client";
import { sendOffFlights } from "../../api/job";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { instant, percent } from "../../i18n/forms";
import { labelOf } from "../../i18n/labels";
import { Field } from "../../parts/Field";
import { useKept } from "../../parts/kept";
import { Link } from "../../parts/Link";
import { PlanField, useKeptPlan } from "../../parts/PlanField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { go, place } from "../../router";

const RUNS = 400;

export function AskSimulation() {
  const text = words.value.simulation;
  const before = useRequest("flights", (signal) => get("/v1/flights", { query: { limit: 20 }, signal }));
  const sending = useRequest<void>(null);
  const asked = place.value.query.get("plan");
  const [plan, setPlan] = useKept("/flights plan", asked ?? "", asked);
  const [runs, setRuns] = useKept("/flights runs", RUNS);
  const [seed, setSeed] = useKept("/flights seed", 0);
  const flown = before.answer?.flights ?? [];
  const kept = useKeptPlan(plan);
  const error = sending.error ?? before.error;
  const fly = (event: Event) => {
    event.preventDefault();
    void sending.ask(async (until) =>
      go(`/flights/${(await sendOffFlights(plan, { runs, seed, name: kept.plan?.summary.name ?? "" }, until)).id}`),
    );
  };
  return (
    <>
      <p>{text.what}</p>
      <form class="panel fly" onSubmit={fly}>
        <PlanField id={plan} onId={setPlan} kept={kept} />
        <Field label={text.runs} hint={text.runsHint}>
          {(control) => (
            <input
              {...control}
              type="number"
              min={2}
              max={20000}
              value={runs}
              onInput={(event) => setRuns(event.currentTarget.valueAsNumber)}
            />
          )}
        </Field>
        <Field label={text.seed} hint={text.seedHint}>
          {(control) => (
            <input
              {...control}
              type="number"
              min={0}
              max={4294967295}
              value={seed}
              onInput={(event) => setSeed(event.currentTarget.valueAsNumber)}
            />
          )}
        </Field>
        <button type="submit" class="primary" disabled={!plan}>
          {text.fly}
        </button>
      </form>
      {error !== null && <ProblemNotice error={error} />}
      {flown.length > 0 && (
        <section aria-labelledby="flown-before">
          <h2 id="flown-before">{text.before}</h2>
          <ul>
            {flown.map((one) => (
              <li key={one.id}>
                <Link to={`/flights/${one.id}`}>{labelOf(one)}</Link>, {text.asked(instant(one.created))},{" "}
                {words.value.shell.states[one.state]}
                {one.probability_in_frame !== null && `, ${percent(one.probability_in_frame)}`}
              </li>
            ))}
          </ul>
        </section>
      )}
    </>
  );
}
