/** One plan: its verdict, what it looks like, what can be taken away; or why there is none. */
import type { ComponentType } from "preact";
import { useMemo, useRef } from "preact/hooks";

import { send } from "../../api/client";
import { Cancelled } from "../../api/job";
import { offerOf } from "../../api/offer";
import { brokeOff, Problem } from "../../api/problem";
import { useJob, useRequest } from "../../api/request";
import { stageText } from "../../api/stage";
import { words } from "../../i18n";
import { instant } from "../../i18n/forms";
import { Bar } from "../../parts/Bar";
import { Identity } from "../../parts/Identity";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { checksum } from "../../parts/paper";
import { TakeOffer } from "../../parts/TakeOffer";
import type { RoomProps } from "../../room";
import { go } from "../../router";
import { useViewer } from "../viewer/load";
import { Figures } from "./Figures";
import { identityOf, nameOf } from "./identity";
import { fetchPlan, isPlan, type Plan, type PlanRequest } from "./plan";
import "../planning/planning.css";
import "./plan.css";
import { TakeAway } from "./TakeAway";
import { Verdict } from "./Verdict";

export default function PlanRoom({ params }: RoomProps) {
  const id = params.id ?? "";
  const text = words.value;
  const job = useJob("/v1/plans/{id}", id, fetchPlan);
  const viewer = useViewer();
  const plan = job.answer && isPlan(job.answer) ? job.answer : null;
  const { progress } = job;
  const error = job.error ?? viewer.error;
  const again = () => {
    if (job.error !== null) void job.ask();
    if (viewer.error !== null) void viewer.ask();
  };
  if (error !== null) {
    return (
      <div class="room">
        <h1>{text.shell.rooms.onePlan}</h1>
        <Why id={id} error={error} again={again} />
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
  return <Shown plan={plan} Viewer={viewer.answer} />;
}

function Shown({ plan, Viewer }: { plan: Plan; Viewer: ComponentType<{ plan: Plan }> | null }) {
  const text = words.value;
  const { id } = plan;
  const request = useRequest(id, async (until) => (await send("GET", "/v1/plans/{id}/request", { id, signal: until })).text());
  const asked = useMemo(() => (request.answer === null ? null : (JSON.parse(request.answer) as PlanRequest)), [request.answer]);
  const name = nameOf(plan);
  const takeAway = useRef<HTMLDivElement>(null);
  return (
    <div class="room one">
      <div class="row heading">
        <h1>{name}</h1>
        <nav class="row lead-on no-print" aria-label={text.plan.one.leadOn}>
          <Link to={`/?from=${id}&revises=yes`} class="button">
            {text.plan.one.change}
          </Link>
          <Link to={`/flights?plan=${id}`} class="button">
            {text.plan.one.fly}
          </Link>
          <Link to={`/telemetry?plan=${id}`} class="button">
            {text.plan.one.telemetry}
          </Link>
          <Link to={`/horizon?plan=${id}`} class="button">
            {text.plan.one.horizon}
          </Link>
          <button type="button" onClick={() => takeAway.current?.scrollIntoView({ block: "start" })}>
            {text.plan.one.take}
          </button>
        </nav>
      </div>
      <Identity
        name={name}
        parts={identityOf(plan, asked)}
        proof={[id, checksum(plan.provenance.input_sha256)]}
        made={{ at: plan.provenance.planned_at, by: plan.requested_by }}
      />
      <Verdict plan={plan} />
      {Viewer ? <Viewer plan={plan} /> : <p class="loading no-print">{text.shell.loading}</p>}
      <div class="one-below">
        <div>
          <Figures plan={plan} />
        </div>
        <div ref={takeAway}>
          <TakeAway plan={plan} request={request.answer} unread={request.error} />
        </div>
      </div>
      <p class="signed">
        <span>{text.plan.one.identity.planned(instant(plan.provenance.planned_at), plan.requested_by)}</span>
        <span>{text.plan.one.identity.approved}</span>
      </p>
    </div>
  );
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
