/** One session: the plan that it is, and what is told of it in the terms of imaging. */
import { useJob } from "../../api/request";
import { words } from "../../i18n";
import { digits, percent } from "../../i18n/forms";
import { AtWork } from "../../parts/AtWork";
import { JobEnded } from "../../parts/JobEnded";
import { Link } from "../../parts/Link";
import type { Plan } from "../plan/plan";
import { ShownPlan } from "../plan/ShownPlan";
import { RateErrors } from "./RateErrors";
import { LeftOut, Looks, Slews } from "./SessionTables";
import { fetchSession, PATH, type Session } from "./session";

const ASKED = {
  path: "v1/spacecraft/plans",
  call: "spacecraft.plan",
  room: "/spacecraft/plans",
  change: (id: string) => `/spacecraft?from=${id}`,
};

export function OneSession({ id }: { id: string }) {
  const { answer, error, progress, ask, cancel } = useJob(PATH, id, fetchSession);
  const text = words.value;
  if (answer && "plan" in answer) {
    return (
      <ShownPlan
        plan={answer.plan}
        asked={ASKED}
        more={(common) => <RateErrors session={answer} common={common} />}
        beside={<Imaged session={answer} plan={answer.plan} />}
        below={<Below session={answer} />}
      />
    );
  }
  return (
    <div class="room">
      <div class="row heading">
        <h1>{answer?.name || text.shell.rooms.spacecraft}</h1>
        <Link to={ASKED.change(id)} class="button">
          {text.plan.one.change}
        </Link>
      </div>
      {error !== null && (
        <JobEnded
          work="/v1/spacecraft/plans"
          room="/spacecraft/plans"
          id={id}
          error={error}
          again={() => void ask()}
          text={{ gone: text.spacecraft.gone, cancelled: text.plan.one.cancelled }}
        />
      )}
      {progress && <AtWork progress={progress} stages={text.spacecraft.stages} onCancel={cancel} />}
      {error === null && !progress && <p class="loading">{text.shell.loading}</p>}
    </div>
  );
}

function Imaged({ session, plan }: { session: Session; plan: Plan }) {
  const text = words.value.spacecraft;
  const { runs, share_steady, worst_deg_s } = session.stabilisation;
  const { requests } = session.summary;
  // The plan's figures tell the others.
  const warnings = session.warnings.filter((one) => !plan.warnings.includes(one));
  const told = [
    text.imaged(requests.filter((one) => one.looks > 0).length, requests.length),
    text.worth(digits(session.choice.value)),
    ...(runs > 0 ? [text.steady(percent(share_steady, 0), digits(worst_deg_s, 2), runs)] : []),
  ];
  return (
    <>
      <p data-testid="session-imaged">{told.join(" · ")}</p>
      {warnings.length > 0 && (
        <ul class="notice notice-warn">
          {warnings.map((one) => (
            <li key={one}>{words.value.service.told(one)}</li>
          ))}
        </ul>
      )}
      {session.left_out.length > 0 && <LeftOut session={session} />}
    </>
  );
}

function Below({ session }: { session: Session }) {
  return (
    <>
      <Looks session={session} />
      <Slews session={session} />
      <details class="copied">
        <summary>
          <h3>{words.value.spacecraft.assumptions}</h3>
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
