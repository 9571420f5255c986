/** Plan and flight over time, axis by axis: the angles, and the error. */
import { useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

import { RangeButtons, useTimeRange } from "../../charts/range";
import { Strip } from "../../charts/Strip";
import { type Line, type Shade, TimeChart } from "../../charts/TimeChart";
import { words } from "../../i18n";
import { digits, fixed } from "../../i18n/forms";
import { cursor_s } from "../../time/cursor";
import { moveTo } from "../../time/playback";
import { type Stretch, TimeBar } from "../../time/TimeBar";
import type { Comparison, Flown } from "./compare";

const HEIGHT = 150;
const TIMES_HEIGHT = 26;
const ANGLE_DECIMALS = 4;
const ZERO = [0];

interface Props {
  comparison: Comparison;
  flown: ReadonlyMap<string, Flown>;
}

export function Flight({ comparison, flown }: Props) {
  const text = words.value.telemetry;
  const box = useRef<HTMLElement>(null);
  const epoch_ms = Date.parse(comparison.epoch);
  const stop_s = Math.max(...[...flown.values()].map((one) => one.t_s.at(-1) ?? 0));
  const start_s = Math.max(0, Math.min(...[...flown.values()].map((one) => one.t_s[0] ?? 0)));
  const stretches = useMemo(() => stretchesOf(comparison, epoch_ms, text), [comparison, text]);
  const shades = useMemo<Shade[]>(
    () => stretches.filter((one) => one.kind === "track").map((one) => ({ ...one, colour: "good-soft" })),
    [stretches],
  );
  const [chosen, setChosen] = useState<Stretch | null>(null);
  const range = useTimeRange(stop_s, chosen);
  // Before it is painted, so that no move by hand is undone.
  useLayoutEffect(() => moveTo(start_s, stop_s), [comparison]);
  const last = [...flown.keys()].at(-1);
  return (
    <section class="panel" aria-labelledby="flight" ref={box}>
      <div class="row heading">
        <h2 id="flight">{text.picture}</h2>
        <RangeButtons range={range} stop_s={stop_s} onWhole={() => setChosen(null)} />
      </div>
      {[...flown].map(([name, one]) => (
        <Strips
          key={name}
          name={name}
          flown={one}
          rms={`${digits(comparison.axes[name]?.rms_arcsec)}″`}
          common={{ epoch_ms, t_s: one.t_s, shades, range }}
          hasTimes={name === last}
        />
      ))}
      <ul class="plain-list" data-testid="flight-now">
        {[...flown].map(([name, one]) => (
          <Now key={name} name={name} flown={one} />
        ))}
      </ul>
      <TimeBar epoch_ms={epoch_ms} stop_s={stop_s} stretches={stretches} within={() => box.current} onStretch={setChosen} />
    </section>
  );
}

interface StripsProps {
  name: string;
  flown: Flown;
  rms: string;
  common: Pick<Parameters<typeof TimeChart>[0], "epoch_ms" | "t_s" | "shades" | "range">;
  hasTimes: boolean;
}

function Strips({ name, flown, rms, common, hasTimes }: StripsProps) {
  const text = words.value.telemetry;
  const angles = useMemo<Line[]>(
    () => [
      { label: text.flown, values: flown.flown_deg, colour: "series-1", width: 1.8 },
      { label: text.planned, values: flown.planned_deg, colour: "series-2", dashed: true },
    ],
    [flown, text],
  );
  const errors = useMemo<Line[]>(() => [{ label: text.error, values: flown.error_arcsec, colour: "series-1" }], [flown, text]);
  const fact = text.rms(rms);
  return (
    <>
      <Strip name={name} unit="°" keys={angles.map((one) => one.label)} fact="">
        <TimeChart {...common} label={text.anglesOf(name)} lines={angles} height={HEIGHT} />
      </Strip>
      <Strip name={text.errorOf(name)} unit="″" keys={[]} fact={fact}>
        <TimeChart
          {...common}
          label={`${text.errorOf(name)}, ${fact}`}
          lines={errors}
          limits={ZERO}
          withLimits
          hasTimes={hasTimes}
          height={HEIGHT + (hasTimes ? TIMES_HEIGHT : 0)}
        />
      </Strip>
    </>
  );
}

/** The sample that was taken last at the cursor. */
function Now({ name, flown }: { name: string; flown: Flown }) {
  const text = words.value.telemetry;
  const after = flown.t_s.findIndex((t) => t > cursor_s.value + 1e-6);
  const row = (after < 0 ? flown.t_s.length : after) - 1;
  const error = flown.error_arcsec[row];
  if (error === undefined) return <li>{text.noSample(name)}</li>;
  const [now, planned] = [flown.flown_deg[row], flown.planned_deg[row]].map((deg) => fixed(deg, ANGLE_DECIMALS));
  return <li>{text.sampleNow(name, now ?? "", planned ?? "", digits(error))}</li>;
}

/** The plan's slews and sessions, as the phases of any axis have them. */
function stretchesOf({ axes }: Comparison, epoch_ms: number, text: { kinds: Record<string, string> }): Stretch[] {
  const [axis] = Object.values(axes);
  const second = (utc: string) => Math.max(0, (Date.parse(utc) - epoch_ms) / 1000);
  return (axis?.phases ?? []).map(({ kind, session, start, stop }) => ({
    kind,
    label: session === null ? (text.kinds[kind] ?? kind) : `${text.kinds[kind] ?? kind} ${session + 1}`,
    start_s: second(start),
    stop_s: second(stop),
  }));
}
