/** A point on the ground by a place's name or coordinates. */
import { useState } from "preact/hooks";

import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { Combobox } from "../../parts/Combobox";
import { Field } from "../../parts/Field";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { places, resolvePoint } from "./names";
import type { Point } from "./target";

interface Props {
  label: string;
  button: string;
  hint: string;
  onPoint: (point: Point) => void;
}

export function PointEntry({ label, button, hint, onPoint }: Props) {
  const text = words.value.plan.target;
  const [typed, setTyped] = useState("");
  const [isUnknown, setIsUnknown] = useState(false);
  const asking = useRequest<void>(null);
  const take = (entry: string) => {
    if (entry.trim() === "") return;
    void asking.ask(async (until) => {
      const point = await resolvePoint(entry, until);
      if (until.aborted) return;
      setIsUnknown(point === null);
      if (!point) return;
      setTyped("");
      onPoint(point);
    });
  };
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        take(typed);
      }}
    >
      <Field label={label} hint={hint} error={isUnknown ? text.noPlace : undefined}>
        {(control) => (
          <span class="entry">
            <Combobox
              control={control}
              value={typed}
              onValue={setTyped}
              onTake={take}
              onLeave={() => undefined}
              offered={text.offered.ground}
              offers={places}
            />
            <button type="submit">{button}</button>
          </span>
        )}
      </Field>
      {asking.error !== null && <ProblemNotice error={asking.error} />}
    </form>
  );
}
