/** The choice of a kept plan: by its name, its target or its id. */
import { useRef, useState } from "preact/hooks";

import { get, type Schemas } from "../api/client";
import { useRequest } from "../api/request";
import { words } from "../i18n";
import { labelOf, targetTold } from "../i18n/labels";
import { fetchPlan, isPlan, type Plan } from "../rooms/plan/plan";
import { Combobox, type Offer } from "./Combobox";
import { Field } from "./Field";

type Job = Schemas["JobResponse"];

const OFFERED = 20;
const ID = /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/;

/** The plan of an id, once it is read; nothing is asked for what is no id. */
export function useKeptPlan(id: string) {
  const { answer, error } = useRequest<Plan | Job>(ID.test(id) ? id : null, (until) => fetchPlan(id, until));
  return { plan: answer && isPlan(answer) ? answer : null, error };
}

interface Props {
  id: string;
  onId: (id: string) => void;
  /** What is read of it. */
  kept: ReturnType<typeof useKeptPlan>;
}

export function PlanField({ id, onId, kept: { plan, error } }: Props) {
  const text = words.value.shell.keptPlan;
  const [typed, setTyped] = useState<string | null>(null);
  const idOf = useRef(new Map<string, string>());
  const offers = (begun: string) =>
    get("/v1/plans", { query: { state: "done", limit: OFFERED, text: begun.trim() || undefined } }).then(({ plans }) =>
      plans.map((one): Offer => {
        const label = labelOf(one);
        const known = idOf.current.get(label);
        const value = known === undefined || known === one.id ? label : `${label} · ${one.id.slice(-8)}`;
        idOf.current.set(value, one.id);
        return { value, told: one.name ? one.targets.map(targetTold).join(", ") : "" };
      }),
    );
  const take = (value: string) => {
    setTyped(value);
    onId(idOf.current.get(value) ?? value.trim());
  };
  return (
    <Field
      label={text.label}
      hint={text.hint}
      error={error instanceof Error ? words.value.service.told(error.message) : undefined}
    >
      {(control) => (
        <Combobox
          control={control}
          value={typed ?? (plan ? labelOf({ ...plan.summary, id }) : id)}
          onValue={take}
          onTake={take}
          onLeave={() => undefined}
          offered={text.offered}
          offers={offers}
        />
      )}
    </Field>
  );
}
