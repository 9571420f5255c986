/** Charts over the plan's time: motion of the axes, pointing, sight. */
import type { ComponentChildren } from "preact";
import { useMemo, useState } from "preact/hooks";

import { RangeButtons, useTimeRange } from "../../charts/range";
import { type Line, type Shade, TimeChart } from "../../charts/TimeChart";
import { words } from "../../i18n";
import { arcsecTold, digits, marginTold } from "../../i18n/forms";
import { axisTold, exclusionTold, resourceUnit, targetTold } from "../../i18n/labels";
import type { Stretch } from "../../time/TimeBar";
import type { Plan } from "../plan/plan";
import { isAtLimit, shareOf } from "../plan/verdict";
import { GyroCharts } from "./Gyros";
import { hasAngles, hasPlaces, lastOf, marginsKept, onRows, type View } from "./view";

const HEIGHT = 118;
const TIMES_HEIGHT = 26;
const COLOURS = ["series-1", "series-2", "series-3", "series-4"];
const EXCLUDED = [0];
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
  /** Charts beside those of every plan. */
  more?: (common: Common) => ComponentChildren;
}

export function Charts({ view, plan, stretches, chosen, onWhole, more }: Props) {
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
  const orders = useMemo(() => (hasAngles(view) ? ORDERS : ORDERS.slice(1)), [view]);
  const motion = useMemo(() => orders.map(({ column }) => motionLines(view, column, withSpline)), [orders, view, withSpline]);
  const limits = useMemo(() => orders.map(({ key }) => limitsOf(view, key)), [orders, view]);
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
      {orders.map(({ key, unit }, order) => (
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
            hasTimes={order === orders.length - 1}
            height={HEIGHT + (order === orders.length - 1 ? TIMES_HEIGHT : 0)}
          />
        </div>
      ))}
      {view.gyros && <GyroCharts gyros={view.gyros} common={common} withLimits={withLimits} />}
      {more?.(common)}
      <Pointing view={view} plan={plan} common={common} />
      <Exclusions view={view} common={common} withLimits={withLimits} />
      {view.resources.map((one) => (
        <Resource key={one.name} one={one} common={common} withLimits={withLimits} />
      ))}
      {orders !== ORDERS && <FromNadir view={view} common={common} />}
      <Sight view={view} common={common} />
    </section>
  );
}

export type Common = Pick<Parameters<typeof TimeChart>[0], "epoch_ms" | "t_s" | "shades" | "range">;

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

/** By how much each of a body's exclusions is kept, while it counts. */
function Exclusions({ view, common, withLimits }: { view: View; common: Common; withLimits: boolean }) {
  const text = words.value.viewer.charts;
  const lines = useMemo<Line[]>(
    () =>
      view.exclusions.map((one, number) => ({
        label: exclusionTold(one.name),
        values: marginsKept(view, one),
        colour: COLOURS[number % COLOURS.length] ?? "text-soft",
        dashed: number >= COLOURS.length,
      })),
    [view, text],
  );
  if (lines.every((line) => line.values.every((one) => one === null))) return null;
  return (
    <div class="look-strip">
      <h3>
        {text.exclusions}, °{" "}
        {lines.map(({ label, dashed }, number) => (
          <span key={label} class={`key key-axis-${number % COLOURS.length} ${dashed ? "key-dashed" : ""}`}>
            {label}
          </span>
        ))}
      </h3>
      <TimeChart
        {...common}
        label={text.told(text.exclusions, "°")}
        lines={lines}
        limits={EXCLUDED}
        withLimits={withLimits}
        height={HEIGHT}
      />
    </div>
  );
}

/** What a battery, a memory or wheels hold, with its limit; wheels hold either way. */
function Resource({ one, common, withLimits }: { one: View["resources"][number]; common: Common; withLimits: boolean }) {
  const text = words.value.viewer.charts;
  const title = text.resources[one.name];
  const unit = resourceUnit(one.unit);
  const lines = useMemo<Line[]>(() => [{ label: title, values: one.level, colour: "series-1" }], [one, title]);
  const limits = useMemo(() => (one.name.startsWith("momentum") ? [-one.limit, one.limit] : [one.limit]), [one]);
  return (
    <div class="look-strip">
      <h3>
        {title}, {unit}
      </h3>
      <TimeChart
        {...common}
        label={text.told(title, unit)}
        lines={lines}
        limits={limits}
        withLimits={withLimits}
        height={HEIGHT}
      />
    </div>
  );
}

/** Where the camera of a body looks, which has no angles of axes to tell it. */
function FromNadir({ view, common }: { view: View; common: Common }) {
  const text = words.value.viewer.charts;
  const { along_track_deg, across_track_deg } = view.boresight;
  const lines = useMemo<Line[]>(
    () => [
      { label: text.alongTrack, values: along_track_deg, colour: "series-1" },
      { label: text.acrossTrack, values: across_track_deg, colour: "series-2" },
    ],
    [along_track_deg, across_track_deg, text],
  );
  return (
    <div class="look-strip">
      <h3>
        {text.fromNadir}, ° <span class="key key-axis-0">{text.alongTrack}</span>{" "}
        <span class="key key-axis-1">{text.acrossTrack}</span>
      </h3>
      <TimeChart {...common} label={text.told(text.fromNadir, "°")} lines={lines} height={HEIGHT} />
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
    ? text.atLimit(digits(least.limit), axisTold(least.axis), unit)
    : text.margin(digits(least.limit), marginTold(least.share), axisTold(least.axis), unit);
}
