/** Conditions of a look beside its time: elevation, Sun and off-nadir angle. */
import { words } from "../../i18n";
import { number, rfc3339 } from "../../i18n/forms";
import { Field } from "../../parts/Field";
import { UtcField } from "../../parts/UtcField";
import type { AskedCampaign } from "./campaign";

type Conditions = NonNullable<AskedCampaign["conditions"]>;

const DAY_MS = 86_400_000;
const ANGLES = [
  { name: "min_elevation_deg", least: 0, most: 90 },
  { name: "sun_elevation_min_deg", least: -90, most: 90 },
  { name: "max_off_nadir_deg", least: 0, most: 180 },
] as const;

interface Props {
  request: AskedCampaign;
  onChange: (members: Partial<AskedCampaign>) => void;
}

export function WhenAndHow({ request, onChange }: Props) {
  const text = words.value.campaigns;
  const { start, stop, conditions = {} } = request;
  const days = (Date.parse(stop) - Date.parse(start)) / DAY_MS;
  return (
    <>
      <div class="pair">
        <UtcField label={text.start} value={start} onValue={(start) => onChange({ start })} />
        <UtcField label={text.stop} value={stop} onValue={(stop) => onChange({ stop })} />
      </div>
      <div class="weights">
        <Field label={text.days}>
          {(control) => (
            <input
              {...control}
              type="number"
              min={0.01}
              max={31}
              step="any"
              value={Number.isFinite(days) ? Number(days.toFixed(3)) : ""}
              onChange={(event) => {
                const typed = event.currentTarget.valueAsNumber;
                if (typed > 0) onChange({ stop: rfc3339(Date.parse(start) + typed * DAY_MS) });
              }}
            />
          )}
        </Field>
        {ANGLES.map(({ name, least, most }) => (
          <Field key={name} label={text.conditions[name]}>
            {(control) => (
              <input
                {...control}
                type="number"
                min={least}
                max={most}
                step="any"
                placeholder={text.any}
                value={conditions[name] ?? ""}
                onChange={(event) => {
                  const typed = event.currentTarget.valueAsNumber;
                  const { [name]: _, ...others } = conditions;
                  if (Number.isNaN(typed)) onChange({ conditions: others as Conditions });
                  else if (typed >= least && typed <= most) onChange({ conditions: { ...conditions, [name]: typed } });
                }}
              />
            )}
          </Field>
        ))}
      </div>
    </>
  );
}

/** The conditions in words, as they head what was made. */
export function conditionsTold({ conditions }: AskedCampaign): string[] {
  const text = words.value.campaigns;
  return ANGLES.flatMap(({ name }) => {
    const given = conditions?.[name];
    return given == null ? [] : [`${text.conditions[name].replace(/, °$/, "")} ${number(given)}°`];
  });
}
