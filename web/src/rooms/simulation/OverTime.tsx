/** The frames over the plan's time: what the plan's table promises and what is flown, and the smear. */
import { useLayoutEffect, useMemo, useRef } from "preact/hooks";

import { get } from "../../api/client";
import { useRequest } from "../../api/request";
import { RangeButtons, useTimeRange } from "../../charts/range";
import { Strip } from "../../charts/Strip";
import { type Line, type Shade, TimeChart } from "../../charts/TimeChart";
import { words } from "../../i18n";
import { digits } from "../../i18n/forms";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { useStateOf } from "../../parts/stateOf";
import { cursor_s } from "../../time/cursor";
import { moveTo } from "../../time/playback";
import { type Stretch, TimeBar } from "../../time/TimeBar";
import type { Flights } from "./flights";
import { framesOf, type Planned, plannedAt, positive, stretchesOf } from "./frames";

const HEIGHT = 150;
const TIMES_HEIGHT = 26;
const SHARP_PX = [1];
const BODY = ["X", "Y", "Z"];
const STEADY_DEG_S = [-0.001, 0.001];

export function OverTime({ flights, epoch }: { flights: Flights; epoch: string }) {
  const text = words.value.simulation;
  const box = useRef<HTMLElement>(null);
  const {
    answer: view,
    error,
    ask,
  } = useRequest(flights.plan, (signal) => get("/v1/plans/{id}/view", { id: flights.plan, signal }));
  // They don't change while more is flown.
  const known = flights.sessions.map((one) => one.nominal.t_s.length).join();
  const frames = useMemo(() => framesOf(flights.sessions), [flights.id, known]);
  const stretches = useMemo(() => stretchesOf(flights.sessions, text.pause), [flights.id, known, text]);
  const planned = useMemo(() => view && plannedAt(view, frames.t_s), [view, frames]);
  const first = stretches.find((one) => one.kind === "track");
  const [chosen, setChosen] = useStateOf<Stretch | null>(`${flights.id} ${known}`, () => first ?? null);
  const stop_s = stretches[stretches.length - 1]?.stop_s ?? 0;
  // Before it is painted, so that no move by hand is undone.
  useLayoutEffect(() => moveTo(first?.start_s ?? 0, stop_s), [flights.id, known]);
  const range = useTimeRange(stop_s, chosen);
  const shades = useMemo<Shade[]>(
    () => stretches.filter((one) => one.kind === "track").map((one) => ({ ...one, colour: "good-soft" })),
    [stretches],
  );
  const errors = useMemo<Line[]>(
    () => [
      { label: text.flownLine, values: positive(frames.error_arcsec), colour: "series-1", width: 1.8 },
      { label: text.sigmaLine, values: positive(planned?.sigma_arcsec ?? frames.nothing), colour: "series-2", dashed: true },
      // A table that holds its target to nothing has no place on this scale.
      ...(planned?.error_arcsec.some(Boolean)
        ? [{ label: text.plannedLine, values: positive(planned.error_arcsec), colour: "series-3" }]
        : []),
    ],
    [frames, planned, text],
  );
  const smears = useMemo<Line[]>(
    () => [{ label: text.smearOfFrames, values: frames.smear_px, colour: "series-1", width: 1.8 }],
    [frames, text],
  );
  const rates = useMemo<Line[]>(
    () =>
      BODY.map((label, axis) => ({
        label,
        values: frames.rate_error_deg_s.map((error) => error?.[axis] ?? null),
        colour: `series-${axis + 1}`,
      })),
    [frames],
  );
  const common = { epoch_ms: Date.parse(epoch), t_s: frames.t_s, shades, range };
  const worst_arcsec = `${mostOf(frames.error_arcsec)}″`;
  const worst_px = `${mostOf(frames.smear_px)} px`;
  return (
    <section class="panel" aria-labelledby="over-time" ref={box}>
      <div class="row heading">
        <h2 id="over-time">{text.overTime}</h2>
        <RangeButtons range={range} stop_s={stop_s} onWhole={() => setChosen(null)} />
      </div>
      {error !== null && <ProblemNotice error={error} again={() => void ask()} />}
      <Strip name={text.error} unit="″" keys={errors.map((one) => one.label)} fact={text.atMost(worst_arcsec)}>
        <TimeChart {...common} label={text.seriesOf(text.error, worst_arcsec)} lines={errors} isLogarithmic height={HEIGHT} />
      </Strip>
      <Strip name={text.smearOfFrames} unit="px" keys={[]} fact={text.atMost(worst_px)}>
        <TimeChart
          {...common}
          label={text.seriesOf(text.smearOfFrames, worst_px)}
          lines={smears}
          limits={SHARP_PX}
          withLimits
          hasTimes
          height={HEIGHT + TIMES_HEIGHT}
        />
      </Strip>
      {frames.rate_error_deg_s.some(Boolean) && (
        <Strip name={text.rateError} unit="°/s" keys={BODY} fact={text.atMost(worstRate(flights))}>
          <TimeChart
            {...common}
            label={text.seriesOf(text.rateError, worstRate(flights))}
            lines={rates}
            limits={STEADY_DEG_S}
            withLimits
            hasTimes
            height={HEIGHT + TIMES_HEIGHT}
          />
        </Strip>
      )}
      <Now frames={frames} planned={planned} />
      <TimeBar
        epoch_ms={Date.parse(epoch)}
        stop_s={stop_s}
        stretches={stretches}
        within={() => box.current}
        onStretch={setChosen}
      />
      <p class="hint">{text.overTimeHint}</p>
    </section>
  );
}

function worstRate({ sessions }: Flights): string {
  return `${digits(Math.max(...sessions.flatMap(({ nominal }) => nominal.gyros?.rate_error_deg_s ?? [])), 2)}°/s`;
}

function mostOf(values: readonly (number | null)[]): string {
  return digits(values.reduce<number>((most, one) => Math.max(most, one ?? 0), 0));
}

/** The frame that is taken at the cursor. */
function Now({ frames, planned }: { frames: ReturnType<typeof framesOf>; planned: Planned | null }) {
  const text = words.value.simulation;
  const now_s = cursor_s.value;
  let row = frames.t_s.findIndex((t) => t > now_s + 1e-6) - 1;
  if (row === -2) row = frames.t_s.length - 1;
  const error = frames.error_arcsec[row];
  if (error == null) return <p data-testid="frame-now">{text.noFrame}</p>;
  return (
    <p data-testid="frame-now">
      {text.frameNow(frames.number[row] ?? 0, digits(error), digits(planned?.error_arcsec[row]), digits(frames.smear_px[row]))}{" "}
      <b class={frames.holds[row] ? "is-good" : "is-bad"}>{frames.holds[row] ? text.holds : text.misses}</b>
    </p>
  );
}
