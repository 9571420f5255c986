/** One session as it was flown: what the budget told of it, its misses, its frames. */
import { words } from "../../i18n";
import { digits, number, percent } from "../../i18n/forms";
import { type Flights, intervalText } from "./flights";
import { Misses } from "./Misses";

type SessionFlights = Flights["sessions"][number];

export function Session({ session }: { session: SessionFlights }) {
  const text = words.value.simulation;
  const id = `session-${session.session}`;
  const { nominal } = session;
  return (
    <section class="panel" aria-labelledby={id}>
      <h2 id={id}>{text.session(session.session + 1, session.label)}</h2>
      <dl class="figures">
        <dt>{text.told}</dt>
        <dd>{percent(session.budget_probability_in_frame)}</dd>
        <dt>{text.flown}</dt>
        <dd>
          {percent(session.probability_in_frame)} {text.interval(...intervalText(session.in_frame_interval))}
        </dd>
        <dt>{text.sharpFrames}</dt>
        <dd>
          {percent(session.probability_sharp)} {text.interval(...intervalText(session.sharp_interval))}
        </dd>
        <dt>{text.framesHeld}</dt>
        <dd>
          {percent(session.frames_held)}, {text.ofThemSharp(percent(session.frames_sharp))}
        </dd>
        <dt>{text.smear}</dt>
        <dd>{text.fifths(...three(session.smear_px))} px</dd>
        {session.miss_m && (
          <>
            <dt>{text.miss}</dt>
            <dd>{text.fifths(...three(session.miss_m))} m</dd>
          </>
        )}
        {session.gyros && (
          <>
            <dt>{text.steady}</dt>
            <dd>{text.steadyOf(percent(session.gyros.steady, 0), digits(Math.max(...session.gyros.rate_error_deg_s), 2))}</dd>
            <dt>{text.gimbals}</dt>
            <dd>
              {text.gimbalsOf(
                digits(session.gyros.gimbal_rate_max_deg_s),
                digits(session.gyros.momentum_max_n_m_s),
                digits(session.gyros.torque_max_n_m),
              )}
            </dd>
          </>
        )}
        <dt>{text.nominal}</dt>
        <dd>
          {text.frames(nominal.frames, nominal.held, nominal.sharp)}; {text.turn(number(nominal.turn_deg, 3))}
          {movingObjectOf(session)}
        </dd>
      </dl>
      {session.misses && <Misses misses={session.misses} />}
    </section>
  );
}

function three(values: readonly number[] | null): [string, string, string] {
  return [digits(values?.[0]), digits(values?.[1]), digits(values?.[2])];
}

function movingObjectOf({ nominal }: SessionFlights): string {
  const shifts = nominal.moving_object_px?.filter((shift) => shift !== null);
  if (!shifts?.length) return "";
  return `; ${words.value.simulation.movingObject(digits(Math.max(...shifts)))}`;
}
