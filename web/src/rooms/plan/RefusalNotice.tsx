/** Why not: in words, with the button that takes what is offered instead. */
import { words } from "../../i18n";
import { clock } from "../../i18n/forms";
import { mayHelpAgain, ProblemNotice } from "../../parts/ProblemNotice";
import { failure, refused } from "./refusal";
import { takeOffered } from "./SequencePanel";

export function RefusalNotice({ plan }: { plan: () => void }) {
  const text = words.value.plan.refusal;
  const error = failure.value;
  if (error === null) return null;
  const now = refused.value;
  return (
    <ProblemNotice error={error} again={mayHelpAgain(error) ? plan : undefined}>
      {now && (
        <p class="small">
          {text.session(now.session + 1)}
          {now.problem.document.axis && ` · ${text.axis} ${now.problem.document.axis}`}
          {now.problem.document.limit && ` · ${text.limit} ${now.problem.document.limit}`}
          {now.at && ` · ${clock(now.at)} UTC`}
        </p>
      )}
      {now?.offered && (
        <p>
          <button type="button" class="primary" onClick={() => takeOffered(plan)}>
            {text.take(clock(now.offered.start), clock(now.offered.stop))}
          </button>
          {(now.problem.document.costs_sessions?.length ?? 0) > 0 && (
            <span class="small"> {text.without((now.problem.document.costs_sessions ?? []).map((one) => one + 1).join(", "))}</span>
          )}
        </p>
      )}
    </ProblemNotice>
  );
}
