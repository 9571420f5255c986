/** One session: the plan that it is, and what is told of it in the terms of imaging. */
import { useJob } from "../../api/request";
import { words } from "../../i18n";
import { digits, percent } from "../../i18n/forms";
import { JobState } from "../../parts/JobState";
import { Link } from "../../parts/Link";
import { Notices } from "../../parts/Notices";
import type { RoomProps } from "../../room";
import type { Plan } from "../plan/plan";
import { ShownPlan } from "../plan/ShownPlan";
import { RateErrors } from "./RateErrors";
import { Looks, Slews } from "./SessionTables";
import { fetchSession, PATH, type Session } from "./session";

const ASKED = {
  call: "spacecraft.plan",
  room: "/spacecraft/plans",
  change: (id: string) => `/spacecraft?from=${id}`,
};

export default function OneSession({ params }: RoomProps) {
  const id = params.id ?? "";
  const job = useJob(PATH, id, fetchSession);
  const { answer } = job;
  const text = words.value;
  if (answer && "plan" in answer) {
    return (
      <ShownPlan
        plan={answer.plan}
        asked={ASKED}
        more={(common) => <RateErrors session={answer} common={common} />}
        beside={<Imaged session={answer} plan={answer.plan} />}
        below={
          <>
            <Looks session={answer} />
            <Slews session={answer} />
            <details class="copied">
              <summary>
                <h3>{text.spacecraft.assumptions}</h3>
              </summary>
              <ul>
                {answer.assumptions.map((one) => (
                  <li key={one}>{one}</li>
                ))}
              </ul>
            </details>
          </>
        }
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
      <JobState room="/spacecraft/plans" id={id} job={job} text={{ ...text.spacecraft, cancelled: text.plan.one.cancelled }} />
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
    text.worth(digits(session.choice.value), digits(session.choice.bound)),
    ...(runs > 0 ? [text.steady(percent(share_steady, 0), digits(worst_deg_s, 2), runs)] : []),
  ];
  return (
    <>
      <p data-testid="session-imaged">{told.join(" · ")}</p>
      <Notices label={words.value.plan.one.warnings} told={warnings.map(words.value.service.told)} />
      <Notices label={text.leftOut} told={session.left_out.map(({ name, reason }) => `${name}: ${reason}`)} />
    </>
  );
}
