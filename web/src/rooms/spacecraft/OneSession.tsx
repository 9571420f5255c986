/** One session: whether it may be flown, what it images, how steady and how near to its limits. */
import { send } from "../../api/client";
import { useJob, useRequest } from "../../api/request";
import { words } from "../../i18n";
import { digits, number, percent, period } from "../../i18n/forms";
import { nameOf } from "../../i18n/labels";
import { AtWork } from "../../parts/AtWork";
import { Identity } from "../../parts/Identity";
import { JobEnded } from "../../parts/JobEnded";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { checksum } from "../../parts/paper";
import { fetchPlan, isPlan } from "../plan/plan";
import { TakeAway } from "../plan/TakeAway";
import { useViewer } from "../viewer/load";
import "../plan/plan.css";
import { RateErrors } from "./RateErrors";
import { LeftOut, Looks, Slews } from "./SessionTables";
import { fetchSession, isSession, PATH, type Session } from "./session";

const ASKED = { path: "v1/spacecraft/plans", call: "spacecraft.plan", room: "/spacecraft/plans" };

export function OneSession({ id }: { id: string }) {
  const { answer, progress, error, ask, cancel } = useJob(PATH, id, fetchSession);
  const text = words.value.spacecraft;
  const session = answer && isSession(answer) ? answer : null;
  return (
    <div class="room">
      <div class="row heading">
        <h1>{session ? nameOf({ ...session.summary, id }) : answer?.name || words.value.shell.rooms.spacecraft}</h1>
        <nav class="row lead-on no-print" aria-label={words.value.plan.one.leadOn}>
          <Link to={`/spacecraft?from=${id}`} class="button">
            {words.value.plan.one.change}
          </Link>
          {session && (
            <>
              <Link to={`/flights?plan=${id}`} class="button">
                {words.value.plan.one.fly}
              </Link>
              <Link to={`/telemetry?plan=${id}`} class="button">
                {words.value.plan.one.telemetry}
              </Link>
            </>
          )}
        </nav>
      </div>
      {session && (
        <Identity
          name={nameOf({ ...session.summary, id })}
          parts={[
            period(session.summary.start, session.summary.stop),
            session.spacecraft,
            words.value.plan.one.identity.revision(session.revision),
          ]}
          proof={[id, checksum(session.provenance.input_sha256)]}
          made={{ at: session.provenance.planned_at, by: session.requested_by }}
        />
      )}
      {error !== null && (
        <JobEnded
          work="/v1/spacecraft/plans"
          room="/spacecraft/plans"
          id={id}
          error={error}
          again={() => void ask()}
          text={{ gone: text.gone, cancelled: words.value.plan.one.cancelled }}
        />
      )}
      {!answer && error === null && <p class="loading">{words.value.shell.loading}</p>}
      {progress && <AtWork progress={progress} stages={text.stages} onCancel={cancel} />}
      {session && <Made session={session} />}
    </div>
  );
}

function Made({ session }: { session: Session }) {
  const { id } = session;
  const text = words.value;
  const plan = useRequest(id, (until) => fetchPlan(id, until));
  const request = useRequest(id, async (until) => (await send("GET", "/v1/plans/{id}/request", { id, signal: until })).text());
  const viewer = useViewer();
  const whole = plan.answer && isPlan(plan.answer) ? plan.answer : null;
  const error = plan.error ?? viewer.error;
  const again = () => {
    if (plan.error !== null) void plan.ask();
    if (viewer.error !== null) void viewer.ask();
  };
  const Viewer = viewer.answer;
  return (
    <>
      <Verdict session={session} />
      {session.warnings.length > 0 && (
        <section class="notice notice-warn" aria-label={text.plan.one.warnings}>
          <ul>
            {session.warnings.map((warning) => (
              <li key={warning}>{text.service.told(warning)}</li>
            ))}
          </ul>
        </section>
      )}
      {session.left_out.length > 0 && <LeftOut session={session} />}
      {error !== null && <ProblemNotice error={error} again={again} />}
      {error === null && !(whole && Viewer) && <p class="loading">{text.shell.loading}</p>}
      {whole && Viewer && <Viewer plan={whole} more={(common) => <RateErrors session={session} common={common} />} />}
      <Looks session={session} />
      <Slews session={session} />
      {whole && <TakeAway plan={whole} request={request.answer} unread={request.error} asked={ASKED} />}
      <details class="copied">
        <summary>
          <h3>{text.spacecraft.assumptions}</h3>
        </summary>
        <ul>
          {session.assumptions.map((one) => (
            <li key={one}>{one}</li>
          ))}
        </ul>
      </details>
    </>
  );
}

function Verdict({ session }: { session: Session }) {
  const text = words.value.spacecraft;
  const { passed, findings, momentum_max_n_m_s, gimbal_margin } = session.verification;
  const { runs, share_steady, worst_deg_s } = session.stabilisation;
  const imaged = session.summary.requests.filter((one) => one.looks > 0).length;
  return (
    <div class={`session-verdict ${passed ? "" : "session-verdict-bad"}`} data-testid="session-verdict">
      <b>{passed ? words.value.plan.one.passed : words.value.plan.one.failed}</b>
      <span>{text.imaged(imaged, session.summary.requests.length)}</span>
      <span>{text.worth(digits(session.choice.value))}</span>
      {runs > 0 && <span>{text.steady(percent(share_steady, 0), digits(worst_deg_s, 2), runs)}</span>}
      <span>{text.momentum(number(momentum_max_n_m_s))}</span>
      <span>{text.gimbalMargin(number(gimbal_margin, 2))}</span>
      {findings.length > 0 && (
        <ul>
          {findings.map((finding) => (
            <li key={finding}>{finding}</li>
          ))}
        </ul>
      )}
    </div>
  );
}
