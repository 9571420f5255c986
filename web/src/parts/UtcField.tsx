import type { ComponentChildren } from "preact";

import { rfc3339 } from "../i18n/forms";
import { Field } from "./Field";

interface Props {
  label: ComponentChildren;
  /** RFC 3339. */
  value: string | null | undefined;
  onValue: (value: string) => void;
}

/** A date and time of day in UTC, to the second. */
export function UtcField({ label, value, onValue }: Props) {
  const given_ms = Date.parse(value ?? "");
  return (
    <Field label={label}>
      {(control) => (
        <input
          {...control}
          type="datetime-local"
          step={1}
          value={Number.isFinite(given_ms) ? new Date(given_ms).toISOString().slice(0, 19) : ""}
          onChange={(event) => {
            const chosen_ms = Date.parse(`${event.currentTarget.value}Z`);
            if (Number.isFinite(chosen_ms)) onValue(rfc3339(chosen_ms));
          }}
        />
      )}
    </Field>
  );
}
