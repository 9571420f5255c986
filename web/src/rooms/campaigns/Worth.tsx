/** The value of the choice, beside the least effort and the bound. */
import { words } from "../../i18n";
import { digits, percent } from "../../i18n/forms";
import type { Campaign, Choice } from "./campaign";

interface Props {
  choice: Choice;
  planned: Campaign["planned"];
  targets: number;
}

export function Worth({ choice, planned, targets }: Props) {
  const text = words.value.campaigns;
  const { value, bound, greedy_value, gap_share, looks, passes, windows } = choice;
  const most = Math.max(bound, value, 1e-12);
  const seen = targets - choice.unseen.length;
  return (
    <section class="panel worth" aria-labelledby="campaign-worth">
      <h2 id="campaign-worth" class="hidden">
        {text.worth}
      </h2>
      <p class="worth-line" data-testid="campaign-verdict">
        <b>{gap_share < 1e-9 ? text.best : text.gap(percent(gap_share))}</b>
        <span>{text.looks(looks, passes)}</span>
        <span>{text.windows(windows, seen, targets)}</span>
        <span>
          {text.planned(planned.done, passes)}
          {planned.open > 0 && ` · ${text.open(planned.open)}`}
          {planned.refused + planned.failed > 0 && ` · ${text.refusedPasses(planned.refused + planned.failed)}`}
        </span>
      </p>
      <dl class="scale">
        <Level name={text.greedy} value={greedy_value} most={most} kind="greedy" />
        <Level name={text.chosenWorth} value={value} most={most} kind="value" />
        <Level name={text.bound} value={bound} most={most} kind="bound" />
      </dl>
      {choice.revision && <p>{text.revised(choice.revision.frozen.length, choice.revision)}</p>}
      <p class="hint">{text.boundHint}</p>
    </section>
  );
}

function Level({ name, value, most, kind }: { name: string; value: number; most: number; kind: string }) {
  return (
    <>
      <dt>{name}</dt>
      <dd>
        <span class="scale-bar" aria-hidden="true">
          <span class={`scale-${kind}`} style={{ width: `${(100 * value) / most}%` }} />
        </span>
        <span class="scale-figure">
          {digits(value, 4)} <span class="small">{percent(value / most)}</span>
        </span>
      </dd>
    </>
  );
}
