/** Conditions of a look beside its time: elevation, Sun and off-nadir angle. */
import { words } from "../../i18n";
import { number, rfc3339 } from "../../i18n/forms";
import { NumberField } from "../../parts/NumberField";
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
        <NumberField
          label={text.days}
          least={0.001}
          step="any"
          value={Number.isFinite(days) ? Number(days.toFixed(3)) : null}
          onValue={(days) => onChange({ stop: rfc3339(Date.parse(start) + days * DAY_MS) })}
        />
        {ANGLES.map(({ name, least, most }) => (
          <NumberField
            key={name}
            label={text.conditions[name]}
            least={least}
            most={most}
            step="any"
            placeholder={text.any}
            value={conditions[name] ?? null}
            onValue={(angle_deg) => onChange({ conditions: { ...conditions, [name]: angle_deg } })}
            onClear={() => {
              const { [name]: _, ...others } = conditions;
              onChange({ conditions: others as Conditions });
            }}
          />
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
