/** The weight of each quality of a view in the value of an observation. */
import { words } from "../../i18n";
import { NumberField } from "../../parts/NumberField";
import type { CampaignRequest } from "./campaign";

type View = NonNullable<CampaignRequest["view"]>;

const WEIGHTS = ["ground_sample", "off_nadir", "sun", "probability"] as const;
const UNLESS_GIVEN = { ground_sample: 1, off_nadir: 0, sun: 0, probability: 0 };

export function Weights({ view, onView }: { view: View; onView: (view: View) => void }) {
  const text = words.value.campaigns;
  return (
    <section class="panel" aria-labelledby="campaign-weights">
      <h2 id="campaign-weights">{text.weights}</h2>
      <div class="weights">
        {WEIGHTS.map((name) => (
          <NumberField
            key={name}
            label={text.weight[name]}
            least={0}
            most={10}
            step={0.1}
            value={view[name] ?? UNLESS_GIVEN[name]}
            onValue={(weight) => onView({ ...view, [name]: weight })}
          />
        ))}
      </div>
      <p class="hint">{text.weightsHint}</p>
    </section>
  );
}
