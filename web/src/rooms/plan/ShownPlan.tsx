/** A plan as it is shown: its verdict, viewer and figures, and what can be taken away. */
import type { ComponentChildren } from "preact";
import { useMemo, useRef } from "preact/hooks";

import { send } from "../../api/client";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { instant } from "../../i18n/forms";
import { Identity } from "../../parts/Identity";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { checksum } from "../../parts/paper";
import type { Common } from "../viewer/Charts";
import { useViewer } from "../viewer/load";
import { Figures } from "./Figures";
import { identityOf, nameOf } from "./identity";
import type { Plan, PlanRequest } from "./plan";
import "../planning/planning.css";
import "./plan.css";
import { type Asked, TakeAway } from "./TakeAway";
import { Verdict } from "./Verdict";

const OF_SESSIONS: Asked = { call: "plan", room: "/plans", change: (id) => `/?from=${id}&revises=yes` };

interface Props {
  plan: Plan;
  /** Where it was asked for: of an imaging session elsewhere. */
  asked?: Asked;
  /** Charts of its own, over the viewer's time. */
  more?: (common: Common) => ComponentChildren;
  /** What is told of it beside the verdict, and below the figures. */
  beside?: ComponentChildren;
  below?: ComponentChildren;
}

export function ShownPlan({ plan, asked = OF_SESSIONS, more, beside, below }: Props) {
  const text = words.value;
  const { id } = plan;
  const viewer = useViewer();
  const Viewer = viewer.answer;
  const request = useRequest(id, async (until) => (await send("GET", "/v1/plans/{id}/request", { id, signal: until })).text());
  const sent = useMemo(() => (request.answer === null ? null : (JSON.parse(request.answer) as PlanRequest)), [request.answer]);
  const name = nameOf(plan);
  const takeAway = useRef<HTMLDivElement>(null);
  return (
    <div class="room one">
      <div class="row heading">
        <h1>{name}</h1>
        <nav class="row lead-on no-print" aria-label={text.plan.one.leadOn}>
          <Link to={asked.change(id)} class="button">
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
        parts={identityOf(plan, sent)}
        proof={[id, checksum(plan.provenance.input_sha256)]}
        made={{ at: plan.provenance.planned_at, by: plan.requested_by }}
      />
      <Verdict plan={plan} />
      {beside}
      {viewer.error !== null && <ProblemNotice error={viewer.error} again={() => void viewer.ask()} />}
      {Viewer && <Viewer plan={plan} more={more} />}
      {!Viewer && viewer.error === null && <p class="loading no-print">{text.shell.loading}</p>}
      <div class="one-below">
        <div>
          <Figures plan={plan} />
          {below}
        </div>
        <div ref={takeAway}>
          <TakeAway plan={plan} request={request.answer} unread={request.error} asked={asked} />
        </div>
      </div>
      <p class="signed">
        <span>{text.plan.one.identity.planned(instant(plan.provenance.planned_at), plan.requested_by)}</span>
        <span>{text.plan.one.identity.approved}</span>
      </p>
    </div>
  );
}
