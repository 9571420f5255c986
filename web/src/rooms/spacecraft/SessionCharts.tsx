/** Charts over a session: body rates, gyros, and the camera's steadiness. */
import { useMemo } from "preact/hooks";

import { RangeButtons, useTimeRange } from "../../charts/range";
import { Strip } from "../../charts/Strip";
import { type Line, type Shade, TimeChart } from "../../charts/TimeChart";
import { words } from "../../i18n";
import { digits, number } from "../../i18n/forms";
import type { Stretch } from "../../time/TimeBar";
import type { Session, SessionView } from "./session";

const HEIGHT = 112;
const TIMES_HEIGHT = 26;
const COLOURS = ["series-1", "series-2", "series-3", "series-4"];
const BODY = ["X", "Y", "Z"];
const GIMBALS = ["1", "2", "3", "4"];

interface Props {
  session: Session;
  view: SessionView;
  /** The stretch to come closer to; null for all of it. */
  chosen: Stretch | null;
  onWhole: () => void;
}

export function SessionCharts({ session, view, chosen, onWhole }: Props) {
  const text = words.value.spacecraft.charts;
  const stop_s = view.t_s[view.t_s.length - 1] ?? 0;
  const range = useTimeRange(stop_s, chosen);
  const shades = useMemo<Shade[]>(() => {
    const epoch_ms = Date.parse(view.epoch);
    return session.windows.map(({ start, stop }) => ({
      start_s: (Date.parse(start) - epoch_ms) / 1000,
      stop_s: (Date.parse(stop) - epoch_ms) / 1000,
      colour: "good-soft",
    }));
  }, [session, view]);
  const { limits } = view;
  const rates = useMemo(() => linesOf(view.omega_body_deg_s, BODY), [view]);
  const gimbals = useMemo(() => linesOf(view.gimbal_deg, GIMBALS), [view]);
  const gimbalRates = useMemo(() => linesOf(view.gimbal_rate_deg_s, GIMBALS), [view]);
  const errors = useMemo(() => errorLines(session, view, shades), [session, view, shades]);
  const momentum = useMemo<Line[]>(
    () => [{ label: "|H|", values: view.momentum_n_m_s.map((h) => Math.hypot(...h)), colour: "series-1", width: 1.8 }],
    [view],
  );
  // The same lists from one drawing to the next: a chart is made anew for others.
  const levels = useMemo(
    () => ({
      rate: [-limits.rate_axis_max_deg_s, limits.rate_axis_max_deg_s],
      error: [0, 1],
      momentum: [limits.momentum_sphere_n_m_s],
    }),
    [limits],
  );
  const common = { epoch_ms: Date.parse(view.epoch), t_s: view.t_s, shades, range };
  const { verification, stabilisation } = session;
  return (
    <section class="panel session-charts" aria-label={text.title}>
      <div class="row heading">
        <h2>{text.title}</h2>
        <RangeButtons range={range} stop_s={stop_s} onWhole={onWhole} />
      </div>
      <Strip
        name={text.rates}
        unit="°/s"
        keys={BODY}
        fact={text.most(digits(Math.max(...verification.rate_max_deg_s)), digits(limits.rate_axis_max_deg_s))}
      >
        <TimeChart {...common} label={text.told(text.rates)} lines={rates} limits={levels.rate} withLimits height={HEIGHT} />
      </Strip>
      {stabilisation.runs > 0 && (
        <Strip
          name={text.errors}
          unit={`${digits(limits.rate_error_max_deg_s)} °/s`}
          keys={BODY}
          fact={text.worst(digits(stabilisation.worst_deg_s, 2), digits(limits.rate_error_max_deg_s), stabilisation.runs)}
        >
          <TimeChart {...common} label={text.told(text.errors)} lines={errors} limits={levels.error} withLimits height={HEIGHT} />
        </Strip>
      )}
      <Strip name={text.gimbals} unit="°" keys={GIMBALS} fact={text.margin(number(verification.gimbal_margin, 2))}>
        <TimeChart {...common} label={text.told(text.gimbals)} lines={gimbals} height={HEIGHT} />
      </Strip>
      <Strip
        name={text.gimbalRates}
        unit="°/s"
        keys={GIMBALS}
        fact={text.most(digits(verification.gimbal_rate_max_deg_s), digits(limits.gimbal_rate_max_deg_s))}
      >
        <TimeChart {...common} label={text.told(text.gimbalRates)} lines={gimbalRates} height={HEIGHT} />
      </Strip>
      <Strip
        name={text.momentum}
        unit="N·m·s"
        keys={[]}
        fact={text.most(digits(verification.momentum_max_n_m_s), digits(limits.momentum_sphere_n_m_s))}
      >
        <TimeChart
          {...common}
          label={text.told(text.momentum)}
          lines={momentum}
          limits={levels.momentum}
          withLimits
          hasTimes
          height={HEIGHT + TIMES_HEIGHT}
        />
      </Strip>
      <p class="hint">{text.hint}</p>
    </section>
  );
}

function linesOf(rows: readonly (readonly number[])[], names: readonly string[]): Line[] {
  return names.map((label, k) => ({
    label,
    values: rows.map((row) => row[k] ?? null),
    colour: COLOURS[k] ?? "text",
  }));
}

/** The worst of all runs stands over the whole of each imaging interval, as a share of the limit. */
function errorLines({ stabilisation }: Session, view: SessionView, shades: readonly Shade[]): Line[] {
  return BODY.map((label, axis) => ({
    label,
    values: view.t_s.map((t_s) => {
      const number = shades.findIndex((one) => t_s >= one.start_s - 0.1 && t_s <= one.stop_s + 0.1);
      const error_deg_s = stabilisation.windows[number]?.rate_error_deg_s[axis];
      return error_deg_s === undefined ? null : error_deg_s / view.limits.rate_error_max_deg_s;
    }),
    colour: COLOURS[axis] ?? "text",
    width: 2,
  }));
}
