/** A refusal in words, with the button that takes the times it offers instead. */
import { words } from "../../i18n";
import { rowClock } from "../../i18n/forms";
import { limitTold } from "../../i18n/labels";
import { pathTold } from "../../parts/fields/labels";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { TakeOffer } from "../../parts/TakeOffer";
import * as draft from "./draft";
import { failure, refused } from "./refusal";
import { takeOffered } from "./SequencePanel";

export function RefusalNotice({ plan }: { plan: () => void }) {
  const text = words.value.plan.refusal;
  const error = failure.value;
  if (error === null) return null;
  const now = refused.value;
  return (
    <ProblemNotice error={error} again={plan} fieldTold={(field) => pathTold("PlanRequest", draft.made.value, field)}>
      {now && (
        <p class="small">
          {text.session(now.session + 1)}
          {now.problem.document.axis && ` · ${text.axis} ${now.problem.document.axis}`}
          {now.problem.document.limit && ` · ${text.limit} ${limitTold(now.problem.document.limit)}`}
          {now.at && ` · ${rowClock(now.at)} UTC`}
        </p>
      )}
      {now?.offered && <TakeOffer offer={now.offered} take={() => takeOffered(plan)} />}
    </ProblemNotice>
  );
}
