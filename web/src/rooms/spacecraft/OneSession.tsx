/** One session: whether it may be flown, what it images, how steady and how near to its limits. */
import { useCallback, useMemo, useRef, useState } from "preact/hooks";

import { useJob, useRequest } from "../../api/request";
import { MomentumSphere } from "../../charts/MomentumSphere";
import { words } from "../../i18n";
import { digits, number, percent, period } from "../../i18n/forms";
import { nameOf } from "../../i18n/labels";
import { AtWork } from "../../parts/AtWork";
import { Identity } from "../../parts/Identity";
import { JobEnded } from "../../parts/JobEnded";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { checksum } from "../../parts/paper";
import { cursor_s } from "../../time/cursor";
import { type Stretch, TimeBar } from "../../time/TimeBar";
import { SessionCharts } from "./SessionCharts";
import { SessionFiles } from "./SessionFiles";
import { SessionMap } from "./SessionMap";
import { LeftOut, Looks, Slews } from "./SessionTables";
import { fetchSession, fetchView, isSession, PATH, type Session, type SessionView } from "./session";
import { stretchesOf } from "./stretches";

export function OneSession({ id }: { id: string }) {
  const { answer, progress, error, ask, cancel } = useJob(PATH, id, fetchSession);
  const text = words.value.spacecraft;
  const session = answer && isSession(answer) ? answer : null;
  return (
    <div class="room">
      <div class="row heading">
        <h1>{session ? nameOf({ ...session.summary, id }) : answer?.name || words.value.shell.rooms.spacecraft}</h1>
        <Link to={`/spacecraft?from=${id}`} class="button">
          {words.value.plan.one.change}
        </Link>
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
  const {
    answer: view,
    error,
    ask,
  } = useRequest(session.id, (until) => {
    cursor_s.value = 0;
    return fetchView(session.id, until);
  });
  return (
    <>
      <Verdict session={session} />
      {session.warnings.length > 0 && (
        <section class="notice notice-warn" aria-label={words.value.plan.one.warnings}>
          <ul>
            {session.warnings.map((warning) => (
              <li key={warning}>{words.value.service.told(warning)}</li>
            ))}
          </ul>
        </section>
      )}
      {session.left_out.length > 0 && <LeftOut session={session} />}
      {error !== null && <ProblemNotice error={error} again={() => void ask()} />}
      {!view && error === null && <p class="loading">{words.value.shell.loading}</p>}
      {view && <Seen session={session} view={view} />}
      <Looks session={session} />
      <Slews session={session} />
      <SessionFiles id={session.id} assumptions={session.assumptions} />
    </>
  );
}

function Seen({ session, view }: { session: Session; view: SessionView }) {
  const text = words.value.spacecraft;
  const box = useRef<HTMLDivElement>(null);
  const [chosen, setChosen] = useState<Stretch | null>(null);
  const stretches = useMemo(() => stretchesOf(session, text), [session, text]);
  const stop_s = view.t_s[view.t_s.length - 1] ?? 0;
  const isOn = useCallback((row: number) => view.window[row] !== null, [view]);
  const looks = stretches.filter((one) => one.kind === "track");
  const closer = looks.findIndex((one) => one.start_s === chosen?.start_s);
  return (
    <div ref={box} role="group" aria-label={text.seen}>
      <div class="seen-beside">
        <div>
          <SessionMap view={view} closer={closer < 0 ? null : closer} />
          <MomentumSphere
            momentum_n_m_s={view.momentum_n_m_s}
            most_n_m_s={view.limits.momentum_sphere_n_m_s}
            step_s={view.step_s}
            isOn={isOn}
          />
        </div>
        <SessionCharts session={session} view={view} chosen={chosen} onWhole={() => setChosen(null)} />
      </div>
      <TimeBar
        epoch_ms={Date.parse(view.epoch)}
        stop_s={stop_s}
        stretches={stretches}
        within={() => box.current}
        onStretch={setChosen}
      />
    </div>
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
