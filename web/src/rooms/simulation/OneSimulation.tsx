/** The flights of a plan: probabilities, contributors, sessions, and progress while they are flown. */
import { get } from "../../api/client";
import { Cancelled } from "../../api/job";
import { useJob } from "../../api/request";
import { words } from "../../i18n";
import { percent, period } from "../../i18n/forms";
import { nameOf } from "../../i18n/labels";
import { Bar } from "../../parts/Bar";
import { Identity } from "../../parts/Identity";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { checksum } from "../../parts/paper";
import { Contributors } from "./Contributors";
import { type Flights, intervalText } from "./flights";
import { OverTime } from "./OverTime";
import { Session } from "./Session";

function fetchFlights(id: string, signal: AbortSignal): Promise<Flights> {
  return get("/v1/flights/{id}", { id, signal });
}

export function OneSimulation({ id }: { id: string }) {
  const text = words.value;
  const { answer: flights, progress, error, ask, cancel } = useJob("/v1/flights/{id}", id, fetchFlights);
  const isCancelled = error instanceof Cancelled;
  const problem = error !== null && !isCancelled && (
    <ProblemNotice error={error} again={() => void ask()}>
      {flights && (
        <p>
          <Link to={`/flights?plan=${flights.plan}`} class="button">
            {text.plan.one.change}
          </Link>
        </p>
      )}
    </ProblemNotice>
  );
  if (!flights) return problem || <p class="loading">{text.shell.loading}</p>;
  const { platform, start, stop } = flights;
  const name = nameOf(flights);
  return (
    <>
      <Identity
        name={name}
        parts={[start && stop && period(start, stop), platform].filter((part) => part !== null)}
        proof={[flights.id, checksum(flights.input_sha256)]}
        made={{ at: flights.created, by: flights.requested_by }}
      />
      <p>
        <strong>{name}: </strong>
        {text.simulation.of(flights.flown, flights.runs, flights.seed)}{" "}
        <Link to={`/plans/${flights.plan}`}>{text.simulation.toPlan}</Link>
      </p>
      {(progress || flights.state === "queued" || flights.state === "running") && error === null && (
        <div class="row" role="status">
          <Bar label={progress?.stage ?? text.shell.states.running} percent={progress?.percent ?? null} />
          <button type="button" onClick={cancel}>
            {text.shell.cancel}
          </button>
        </div>
      )}
      {problem}
      {isCancelled && <p class="notice notice-warn">{text.simulation.cancelled}</p>}
      {flights.probability_in_frame !== null && flights.flown > 0 && (
        <p data-testid="flights-verdict" class="panel" role="status">
          <strong>{text.simulation.inFrame(percent(flights.probability_in_frame))}</strong>{" "}
          {text.simulation.interval(...intervalText(flights.in_frame_interval))}{" "}
          <strong>{text.simulation.sharp(percent(flights.probability_sharp))}</strong>{" "}
          {text.simulation.interval(...intervalText(flights.sharp_interval))}
        </p>
      )}
      {flights.warnings.map((warning) => (
        <p key={warning} class="notice notice-warn">
          {words.value.service.told(warning)}
        </p>
      ))}
      {flights.contributors.length > 0 && (
        <section class="panel" aria-labelledby="to-blame">
          <h2 id="to-blame">{text.simulation.contributors}</h2>
          <Contributors contributors={flights.contributors} />
        </section>
      )}
      {flights.epoch !== null && flights.sessions.length > 0 && <OverTime flights={flights} epoch={flights.epoch} />}
      {flights.sessions.map((session) => (
        <Session key={session.session} session={session} />
      ))}
    </>
  );
}
