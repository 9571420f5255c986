/** Charts over the plan's time: motion of the axes, pointing, sight. */
import { useMemo, useState } from "preact/hooks";

import { RangeButtons, useTimeRange } from "../../charts/range";
import { type Line, type Shade, TimeChart } from "../../charts/TimeChart";
import { words } from "../../i18n";
import { arcsecTold, digits, marginTold } from "../../i18n/forms";
import { targetTold } from "../../i18n/labels";
import type { Stretch } from "../../time/TimeBar";
import type { Plan } from "../plan/plan";
import { isAtLimit, shareOf } from "../plan/verdict";
import { hasPlaces, lastOf, onRows, type View } from "./view";

const HEIGHT = 118;
const TIMES_HEIGHT = 26;
const COLOURS = ["series-1", "series-2"];
const ORDERS = [
  { key: "angle", column: "angle_deg", unit: "°" },
  { key: "rate", column: "rate_deg_s", unit: "°/s" },
  { key: "acceleration", column: "acceleration_deg_s2", unit: "°/s²" },
  { key: "jerk", column: "jerk_deg_s3", unit: "°/s³" },
] as const;

interface Props {
  view: View;
  plan: Plan;
  stretches: readonly Stretch[];
  /** The stretch to come closer to; null for the whole plan. */
  chosen: Stretch | null;
  onWhole: () => void;
}

export function Charts({ view, plan, stretches, chosen, onWhole }: Props) {
  const text = words.value.viewer.charts;
  const stop_s = lastOf(view.t_s);
  const epoch_ms = Date.parse(view.epoch);
  const range = useTimeRange(stop_s, chosen);
  const [withLimits, setWithLimits] = useState(false);
  const [withSpline, setWithSpline] = useState(true);
  const shades = useMemo<Shade[]>(
    () =>
      stretches
        .filter((one) => one.kind === "track")
        .map(({ start_s, stop_s: end_s }) => ({ start_s, stop_s: end_s, colour: "good-soft" })),
    [stretches],
  );
  const names = Object.keys(view.axes);
  const motion = useMemo(() => ORDERS.map(({ column }) => motionLines(view, column, withSpline)), [view, withSpline]);
  const limits = useMemo(() => ORDERS.map(({ key }) => limitsOf(view, key)), [view]);
  const common = { epoch_ms, t_s: view.t_s, shades, range };
  return (
    <section class="panel look-charts" aria-label={text.title}>
      <div class="look-head">
        <h2>{text.title}</h2>
        <div class="row">
          <label class="look-check">
            <input type="checkbox" checked={withLimits} onChange={(event) => setWithLimits(event.currentTarget.checked)} />
            {text.withLimits}
          </label>
          {view.baseline.length > 0 && (
            <label class="look-check">
              <input type="checkbox" checked={withSpline} onChange={(event) => setWithSpline(event.currentTarget.checked)} />
              {text.withSpline}
            </label>
          )}
          <RangeButtons range={range} stop_s={stop_s} onWhole={onWhole} />
        </div>
      </div>
      <p class="look-legend">
        {names.map((name, axis) => (
          <span key={name} class={`key key-axis-${axis}`}>
            {name}
          </span>
        ))}
        {withSpline && view.baseline.length > 0 && <span class="key key-spline">{text.spline}</span>}
        <span class="key key-stop">{text.limit}</span>
        <span class="key key-session">{text.session}</span>
      </p>
      {ORDERS.map(({ key, unit }, order) => (
        <div key={key} class="look-strip">
          <h3>
            {text[key]}, {unit} <small>{marginsTold(plan, key, unit)}</small>
          </h3>
          <TimeChart
            {...common}
            label={text.told(text[key], unit)}
            lines={motion[order] ?? []}
            limits={limits[order]}
            withLimits={withLimits}
            hasTimes={order === ORDERS.length - 1}
            height={HEIGHT + (order === ORDERS.length - 1 ? TIMES_HEIGHT : 0)}
          />
        </div>
      ))}
      <Pointing view={view} plan={plan} common={common} />
      <Sight view={view} common={common} />
    </section>
  );
}

type Common = Pick<Parameters<typeof TimeChart>[0], "epoch_ms" | "t_s" | "shades" | "range">;

function Pointing({ view, plan, common }: { view: View; plan: Plan; common: Common }) {
  const text = words.value.viewer.charts;
  const lines = useMemo<Line[]>(() => {
    const { error_arcsec, sigma_major_arcsec, sigma_minor_arcsec } = view.pointing;
    const shown = error_arcsec.map((one) => (one === null || one <= 0 ? null : one));
    return [
      { label: text.error, values: shown, colour: "series-3" },
      { label: text.sigma, values: sigma_major_arcsec, colour: "series-4" },
      { label: text.sigma, values: sigma_minor_arcsec, colour: "series-4", dashed: true },
    ];
  }, [view, text]);
  if (lines.every((line) => line.values.every((one) => one === null))) return null;
  return (
    <div class="look-strip">
      <h3>
        {text.pointing}, ″ <span class="key key-error">{text.error}</span> <span class="key key-sigma">{text.sigma}</span>{" "}
        <small>{text.most(arcsecTold(Math.max(...plan.pointing.map((one) => one.max_arcsec))))}</small>
      </h3>
      <TimeChart {...common} label={text.told(text.pointing, "″")} lines={lines} isLogarithmic height={HEIGHT} />
    </div>
  );
}

/** Elevation of the carrier in the targets' sky, and the boresight's way from the nadir. */
function Sight({ view, common }: { view: View; common: Common }) {
  const text = words.value.viewer.charts;
  const lines = useMemo<Line[]>(
    () => [
      ...view.targets.map((target) => ({ label: targetTold(target.name), values: target.elevation_deg, colour: "series-1" })),
      { label: text.offNadir, values: view.boresight.off_nadir_deg, colour: "series-2" },
      { label: text.sun, values: view.boresight.sun_separation_deg, colour: "warn", dashed: true },
    ],
    [view, text],
  );
  const heights = [(view.sky === null || hasPlaces(view)) && text.elevation, view.sky && text.aboveLimb]
    .filter(Boolean)
    .join(" / ");
  return (
    <div class="look-strip">
      <h3>
        {text.sight}, ° <span class="key key-axis-0">{heights}</span> <span class="key key-axis-1">{text.offNadir}</span>{" "}
        <span class="key key-sun">{text.sun}</span>
      </h3>
      <TimeChart {...common} label={text.told(text.sight, "°")} lines={lines} hasTimes height={HEIGHT + TIMES_HEIGHT} />
    </div>
  );
}

function motionLines(view: View, column: (typeof ORDERS)[number]["column"], withSpline: boolean): Line[] {
  const names = Object.keys(view.axes);
  const spline: Line[] = withSpline
    ? view.baseline.flatMap((slew) =>
        names.map((name, axis) => ({
          label: `spline ${name}`,
          values: onRows(view.t_s, slew.t_s, (slew.axes[name]?.[column] ?? []) as readonly number[]),
          colour: COLOURS[axis] ?? "text-soft",
          width: 1,
          isBehind: true,
        })),
      )
    : [];
  return [
    ...spline,
    ...names.map((name, axis) => ({
      label: name,
      values: view.axes[name]?.[column] ?? [],
      colour: COLOURS[axis] ?? "text-soft",
    })),
  ];
}

function limitsOf(view: View, key: (typeof ORDERS)[number]["key"]): number[] {
  const all = Object.values(view.limits).flatMap((one): (number | null)[] => {
    if (key === "angle") return [one.angle_min_deg, one.angle_max_deg];
    const most = key === "rate" ? one.rate_max_deg_s : key === "acceleration" ? one.acceleration_max_deg_s2 : one.jerk_max_deg_s3;
    return [-most, most];
  });
  return [...new Set(all.filter((one) => one !== null))];
}

/** "least margin 67 % (alpha, limit 3 °/s)": the nearest that an axis comes to this limit. */
function marginsTold(plan: Plan, key: (typeof ORDERS)[number]["key"], unit: string): string {
  const text = words.value.viewer.charts;
  const limits = key === "angle" ? ["angle_min", "angle_max"] : [key];
  const all = Object.entries(plan.margins).flatMap(([axis, margins]) =>
    limits.flatMap((name) => {
      const margin = (margins as Record<string, { limit: number; margin: number } | null>)[name];
      const share = margin ? shareOf(margin) : null;
      return margin && share !== null ? [{ axis, ...margin, share }] : [];
    }),
  );
  const least = all.reduce<(typeof all)[number] | null>((best, one) => (!best || one.share < best.share ? one : best), null);
  if (!least) return "";
  return isAtLimit({ kind: "axis", limit: key, share: least.share })
    ? text.atLimit(digits(least.limit), least.axis, unit)
    : text.margin(digits(least.limit), marginTold(least.share), least.axis, unit);
}
