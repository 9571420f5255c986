/** Everything else that a plan takes: where the platform begins and ends, how it slews, cones, cameras. */
import { useState } from "preact/hooks";
import { get } from "../../api/client";
import { FIELDS } from "../../api/fields";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { period } from "../../i18n/forms";
import { Field } from "../../parts/Field";
import { Fields, withMember } from "../../parts/fields/Fields";
import { briefOf, labelOf } from "../../parts/fields/labels";
import { isMembers, type Members } from "../../parts/fields/shape";
import { ProblemNotice } from "../../parts/ProblemNotice";
import * as draft from "./draft";

const SCHEMA = "PlanRequest";
/** Members that have panels of their own. */
const ELSEWHERE = ["name", "platform", "orbit", "attitude", "sessions", "on_conflict"];
const SHOWN = Object.keys(FIELDS[SCHEMA] ?? {}).filter((name) => !ELSEWHERE.includes(name));

export function OptionsPanel() {
  const text = words.value.plan.options;
  const [isOpen, setIsOpen] = useState(false);
  const request = draft.made.value as unknown as Members;
  const set = SHOWN.filter((name) => request[name] !== undefined && request[name] !== null);
  return (
    <section class="panel" aria-label={text.title}>
      <details onToggle={(event) => setIsOpen(event.currentTarget.open)}>
        <summary>
          <h2>{text.title}</h2>
          <span class="soft">{set.map((name) => toldOf(name, request[name])).join(" · ") || text.none}</span>
        </summary>
        {isOpen && <AfterPlan />}
        <Fields
          schema={SCHEMA}
          value={request}
          path=""
          omit={ELSEWHERE}
          onValue={(next) => draft.change(withLeftOut(next) as unknown as Partial<draft.DraftRequest>)}
        />
      </details>
    </section>
  );
}

/** A member that was taken out must be taken out of the draft. */
function withLeftOut(next: Members): Members {
  return { ...Object.fromEntries(SHOWN.map((name) => [name, undefined])), ...next };
}

function toldOf(name: string, value: unknown): string {
  const shape = FIELDS[SCHEMA]?.[name]?.shape;
  const brief = shape ? briefOf(shape, value) : "";
  return brief ? `${labelOf(SCHEMA, name)}: ${brief}` : labelOf(SCHEMA, name);
}

const LISTED = 50;

/** A plan that is kept, at whose end this one begins. */
function AfterPlan() {
  const text = words.value.plan.options;
  const { answer, error } = useRequest("plans", (until) =>
    get("/v1/plans", { query: { state: "done", limit: LISTED }, signal: until }),
  );
  const state = draft.made.value.initial_state;
  const after = isMembers(state) ? String(state.after ?? "") : "";
  const plans = answer?.plans ?? [];
  const take = (id: string) => {
    // That plan's end says all the rest.
    const next: Members = id ? { after: id } : withMember<Members>(state ?? {}, "after", undefined);
    draft.change({ initial_state: Object.keys(next).length ? next : undefined });
  };
  return (
    <>
      <Field label={text.after} hint={text.afterHint}>
        {(control) => (
          <select {...control} value={after} onChange={(event) => take(event.currentTarget.value)}>
            <option value="">{text.afterNone}</option>
            {after && !plans.some((plan) => plan.id === after) && <option value={after}>{after}</option>}
            {plans.map((plan) => (
              <option key={plan.id} value={plan.id}>
                {plan.name || plan.id}
                {plan.start && plan.stop ? `, ${period(plan.start, plan.stop)}` : ""}
              </option>
            ))}
          </select>
        )}
      </Field>
      {error !== null && <ProblemNotice error={error} />}
    </>
  );
}
