/** From when on, for how long and under which conditions windows are looked for. */
import { EARTH_FIXED_MODES, SEARCHED_MODES } from "../../api/lists";
import { words } from "../../i18n";
import { rfc3339 } from "../../i18n/forms";
import { Field } from "../../parts/Field";
import { FoldedFields } from "../../parts/fields/FoldedFields";
import type { Members } from "../../parts/fields/shape";
import { NumberField } from "../../parts/NumberField";
import { useTyped } from "../../parts/typed";
import * as draft from "./draft";

export function SpanFields() {
  const text = words.value.plan.span;
  const mode = draft.target.value?.mode;
  const isInSpace = SEARCHED_MODES.some((one) => one === mode) && !EARTH_FIXED_MODES.some((one) => one === mode);
  const from = useTyped(rfc3339(draft.from_ms.value).slice(0, 16));
  return (
    <div class="span-fields">
      <Field label={text.from}>
        {(props) => (
          <input
            {...props}
            {...from}
            type="datetime-local"
            onChange={(event) => {
              const given = Date.parse(`${event.currentTarget.value}Z`);
              if (Number.isFinite(given)) draft.from_ms.value = given;
            }}
          />
        )}
      </Field>
      <NumberField
        label={text.days}
        least={1}
        most={14}
        value={draft.days.value}
        onValue={(days) => {
          draft.days.value = days;
        }}
      />
      {!isInSpace && (
        <NumberField
          label={text.elevation}
          least={0}
          most={85}
          value={draft.leastElevation_deg.value}
          onValue={(min_elevation_deg) => {
            draft.conditions.value = { ...draft.conditions.peek(), min_elevation_deg };
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
