/** One plan: its verdict, what it looks like, what can be taken away; or why there is none. */
import { Cancelled } from "../../api/job";
import { offerOf } from "../../api/offer";
import { brokeOff, Problem } from "../../api/problem";
import { useJob } from "../../api/request";
import { stageText } from "../../api/stage";
import { words } from "../../i18n";
import { Bar } from "../../parts/Bar";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { TakeOffer } from "../../parts/TakeOffer";
import type { RoomProps } from "../../room";
import { go } from "../../router";
import { fetchPlan, isPlan } from "./plan";
import { ShownPlan } from "./ShownPlan";

export default function PlanRoom({ params }: RoomProps) {
  const id = params.id ?? "";
  const text = words.value;
  const job = useJob("/v1/plans/{id}", id, fetchPlan);
  const plan = job.answer && isPlan(job.answer) ? job.answer : null;
  const { progress } = job;
  if (job.error !== null) {
    return (
      <div class="room">
        <h1>{text.shell.rooms.onePlan}</h1>
        <Why id={id} error={job.error} again={() => void job.ask()} />
      </div>
    );
  }
  if (!plan) {
    return (
      <div class="room">
        <h1>{text.plan.one.working}</h1>
        {progress ? (
          <div class="row">
            <Bar label={stageText(progress)} percent={progress.percent} />
            <button type="button" onClick={job.cancel}>
              {text.shell.cancel}
            </button>
          </div>
        ) : (
          <p class="loading">{text.shell.loading}</p>
        )}
      </div>
    );
  }
  return <ShownPlan plan={plan} />;
}

/** Why there is no plan, and the ways on. */
function Why({ id, error, again }: { id: string; error: unknown; again: () => void }) {
  const text = words.value.plan.one;
  if (error instanceof Problem && error.status === 404) {
    return (
      <>
        <p class="notice" role="status">
          {text.gone}
        </p>
        <div class="row">
          <Link to="/" class="button">
            {text.anew}
          </Link>
          <Link to="/plans">{text.others}</Link>
        </div>
      </>
    );
  }
  const offer = offerOf(error);
  const anew = () => go(`/?from=${id}&plan=now`);
  return (
    <>
      {error instanceof Cancelled ? (
        <p class="notice" role="status">
          {text.cancelled}
        </p>
      ) : (
        <ProblemNotice error={error} again={brokeOff(error) ? anew : again}>
          {offer && <TakeOffer offer={offer} take={anew} />}
        </ProblemNotice>
      )}
      <p>
        <Link to={`/?from=${id}`} class="button">
          {text.change}
        </Link>
      </p>
    </>
  );
}
