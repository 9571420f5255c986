import type { ComponentChildren } from "preact";

import { rfc3339 } from "../i18n/forms";
import { Field } from "./Field";
import { useTyped } from "./typed";

interface Props {
  label: ComponentChildren;
  hint?: ComponentChildren;
  error?: ComponentChildren;
  /** RFC 3339. */
  value: string | null | undefined;
  /** Between two values; 1 unless given. */
  step_s?: number;
  onValue: (value: string) => void;
  /** Of what may be left out. */
  onClear?: () => void;
}

/** A date and time of day in UTC, to the second or finer. */
export function UtcField({ label, hint, error, value, step_s = 1, onValue, onClear }: Props) {
  const given_ms = Date.parse(value ?? "");
  const isFine = step_s < 1 || given_ms % 1000 !== 0;
  const given = Number.isFinite(given_ms) ? new Date(given_ms).toISOString().slice(0, isFine ? 23 : 19) : "";
  const typed = useTyped(given);
  return (
    <Field label={label} hint={hint} error={error}>
      {(control) => (
        <input
          {...control}
          {...typed}
          type="datetime-local"
          step={isFine ? 0.001 : step_s}
          onChange={(event) => {
            const chosen_ms = Date.parse(`${event.currentTarget.value}Z`);
            if (Number.isFinite(chosen_ms)) onValue(rfc3339(chosen_ms));
            else if (event.currentTarget.value === "") onClear?.();
          }}
        />
      )}
    </Field>
  );
}
