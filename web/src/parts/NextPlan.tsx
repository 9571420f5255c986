/** The button that takes what was learnt of a flight into the request of the next plan. */
import { correctedRequest, type Learnt } from "../api/correct";
import { useRequest } from "../api/request";
import { words } from "../i18n";
import { load } from "../rooms/planning/draft";
import { go } from "../router";
import { ProblemNotice } from "./ProblemNotice";

export function NextPlan({ plan, learnt }: { plan: string; learnt: Learnt }) {
  const taking = useRequest<void>(null, async () => {
    load(await correctedRequest(plan, learnt), null);
    go("/");
  });
  return (
    <>
      <button type="button" class="primary" disabled={taking.isAsking} onClick={() => void taking.ask()}>
        {words.value.shell.nextPlan(learnt.corrections.length)}
      </button>
      {taking.error !== null && <ProblemNotice error={taking.error} />}
    </>
  );
}
