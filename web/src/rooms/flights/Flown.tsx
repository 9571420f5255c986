/** What the flights tell, and how far they have come. */
import { useEffect, useState } from "preact/hooks";

import { get, remove, type Schemas } from "../../api/client";
import { Cancelled, type Progress, untilDone } from "../../api/job";
import { isAbort, NoAnswer, Problem } from "../../api/problem";
import { words } from "../../i18n";
import { percent } from "../../i18n/forms";
import { Bar } from "../../parts/Bar";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { Contributors } from "./Contributors";
import { Session } from "./Session";

export type Flights = Schemas["FlightsResponse"];

export function Flown({ id }: { id: string }) {
  const text = words.value;
  const [flights, setFlights] = useState<Flights | null>(null);
  const [progress, setProgress] = useState<Progress | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [asked, setAsked] = useState(0);

  useEffect(() => {
    const until = new AbortController();
    const given = { id, signal: until.signal };
    const fetchAndFollow = async () => {
      const first = await get("/v1/flights/{id}", given);
      setFlights(first);
      if (first.state !== "queued" && first.state !== "running") return;
      try {
        await untilDone({ path: `/v1/flights/${id}`, id }, setProgress, until.signal);
      } catch (caught) {
        // However the job ended, its own address tells it best.
        if (!(caught instanceof Cancelled) && !(caught instanceof Problem)) throw caught;
      }
      setProgress(null);
      setFlights(await get("/v1/flights/{id}", given));
    };
    setError(null);
    fetchAndFollow().catch((caught: unknown) => !isAbort(caught) && setError(caught));
    return () => until.abort();
  }, [id, asked]);

  if (error !== null) {
    const again = error instanceof NoAnswer ? () => setAsked((times) => times + 1) : undefined;
    return <ProblemNotice error={error} again={again} />;
  }
  if (!flights) return <p class="loading">{text.shell.loading}</p>;
  const isAtWork = flights.state === "queued" || flights.state === "running";
  return (
    <>
      <p>
        {flights.name && <strong>{flights.name}: </strong>}
        {text.flights.of(flights.flown, flights.runs, flights.seed)}{" "}
        <Link to={`/plans/${flights.plan}`}>{text.flights.toPlan}</Link>
      </p>
      {isAtWork && (
        <div class="row" role="status">
          <Bar label={progress?.stage ?? text.shell.states.running} percent={progress?.percent ?? null} />
          <button type="button" onClick={() => void remove("/v1/flights/{id}", { id }).catch(setError)}>
            {text.shell.cancel}
          </button>
        </div>
      )}
      {flights.problem && (
        <ProblemNotice error={new Problem(flights.problem)}>
          <p>
            <Link to={`/flights?plan=${flights.plan}`} class="button">
              {text.plan.one.change}
            </Link>
          </p>
        </ProblemNotice>
      )}
      {flights.state === "cancelled" && <p class="notice notice-warn">{text.flights.cancelled}</p>}
      {flights.probability_in_frame !== null && flights.flown > 0 && (
        <p data-testid="flights-verdict" class="panel" role="status">
          <strong>{text.flights.inFrame(percent(flights.probability_in_frame))}</strong>{" "}
          {text.flights.interval(...between(flights.in_frame_interval))}{" "}
          <strong>{text.flights.sharp(percent(flights.probability_sharp))}</strong>{" "}
          {text.flights.interval(...between(flights.sharp_interval))}
        </p>
      )}
      {flights.warnings.map((warning) => (
        <p key={warning} class="notice notice-warn">
          {warning}
        </p>
      ))}
      {flights.contributors.length > 0 && (
        <section class="panel" aria-labelledby="to-blame">
          <h2 id="to-blame">{text.flights.contributors}</h2>
          <Contributors contributors={flights.contributors} />
        </section>
      )}
      {flights.sessions.map((session) => (
        <Session key={session.session} session={session} />
      ))}
    </>
  );
}

/** An interval's ends as they are written. */
export function between(interval: readonly number[] | null): [string, string] {
  return [percent(interval?.[0]), percent(interval?.[1])];
}
