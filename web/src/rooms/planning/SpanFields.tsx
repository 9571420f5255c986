/** From when on, for how long and under which conditions windows are looked for. */
import { EARTH_FIXED_MODES, SEARCHED_MODES } from "../../api/lists";
import { words } from "../../i18n";
import { rfc3339 } from "../../i18n/forms";
import { Field } from "../../parts/Field";
import { FoldedFields } from "../../parts/fields/FoldedFields";
import type { Members } from "../../parts/fields/shape";
import * as draft from "./draft";

export function SpanFields() {
  const text = words.value.plan.span;
  const mode = draft.target.value?.mode;
  const isInSpace = SEARCHED_MODES.some((one) => one === mode) && !EARTH_FIXED_MODES.some((one) => one === mode);
  const local = rfc3339(draft.from_ms.value).slice(0, 16);
  return (
    <div class="span-fields">
      <Field label={text.from}>
        {(props) => (
          <input
            {...props}
            type="datetime-local"
            value={local}
            onChange={(event) => {
              const given = Date.parse(`${event.currentTarget.value}Z`);
              if (Number.isFinite(given)) draft.from_ms.value = given;
            }}
          />
        )}
      </Field>
      <NumberField label={text.days} least={1} most={14} of={draft.days} />
      {!isInSpace && (
        <NumberField
          label={text.elevation}
          least={0}
          most={85}
          of={{
            get value() {
              return draft.leastElevation_deg.value;
            },
            set value(min_elevation_deg) {
              draft.conditions.value = { ...draft.conditions.peek(), min_elevation_deg };
            },
          }}
        />
      )}
      <FoldedFields
        title={text.conditions}
        schema="OpportunityConditions"
        value={draft.conditions.value as Members}
        path="conditions"
        omit={["min_elevation_deg"]}
        onValue={(next) => {
          draft.conditions.value = next as draft.Conditions;
        }}
      />
    </div>
  );
}

interface NumberProps {
  label: string;
  least: number;
  most: number;
  of: { value: number };
}

function NumberField({ label, least, most, of }: NumberProps) {
  return (
    <Field label={label}>
      {(props) => (
        <input
          {...props}
          type="number"
          min={least}
          max={most}
          value={of.value}
          onChange={(event) => {
            const given = event.currentTarget.valueAsNumber;
            if (given >= least && given <= most) of.value = given;
          }}
        />
      )}
    </Field>
  );
}
