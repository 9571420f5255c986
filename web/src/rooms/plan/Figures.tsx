/** The figures behind the verdict: sessions, margins, the pointing budget, warnings. */
import { words } from "../../i18n";
import { arcsecTold, digits, marginTold, number, percent, rowClock } from "../../i18n/forms";
import { axisTold, exclusionTold, limitTold, resourceTold, resourceUnit, targetTold } from "../../i18n/labels";
import { labelOf } from "../../parts/fields/labels";
import { type Column, TablePanel, timesOf } from "../../parts/TablePanel";
import type { Plan } from "./plan";
import { isAtLimit, shareOf } from "./verdict";

export function Figures({ plan }: { plan: Plan }) {
  const text = words.value.plan.one;
  return (
    <>
      {plan.verification.findings.length > 0 && (
        <section class="notice notice-error">
          <h2>{text.findings}</h2>
          <ul>
            {plan.verification.findings.map((finding) => (
              <li key={finding.detail}>{words.value.service.told(finding.detail)}</li>
            ))}
          </ul>
        </section>
      )}
      {plan.warnings.length > 0 && (
        <section class="notice notice-warn">
          <h2>{text.warnings}</h2>
          <ul>
            {plan.warnings.map((warning) => (
              <li key={warning}>{words.value.service.told(warning)}</li>
            ))}
          </ul>
        </section>
      )}
      <div class={plan.summary.sessions.length > 2 ? "figures figures-many" : "figures"}>
        <Sessions plan={plan} />
        <Margins plan={plan} />
        <Budget plan={plan} />
      </div>
    </>
  );
}

function Sessions({ plan }: { plan: Plan }) {
  const text = words.value.plan.one;
  const { columns } = text;
  const { km } = words.value.viewer.units;
  const rows = plan.summary.sessions.map((one) => ({
    ...one,
    pointing: plan.pointing.find((held) => held.session === one.session),
  }));
  const all: Column<(typeof rows)[number]>[] = [
    [columns.target, (one) => one.name ?? targetTold(one.target)],
    [columns.times, timesOf],
    [columns.elevation, (one) => (one.best_elevation_deg == null ? "–" : `${number(one.best_elevation_deg)}°`), "number"],
    [
      columns.range,
      ({ pointing }) => (pointing?.range_min_km == null ? "–" : `${number(pointing.range_min_km, 0)} ${km}`),
      "number",
    ],
    [columns.error, ({ pointing }) => (pointing ? `${arcsecTold(pointing.max_arcsec)}″` : "–"), "number"],
    [columns.probability, (one) => percent(one.probability_in_frame), "number"],
  ];
  return <TablePanel title={text.sessions} rows={rows} columns={all} />;
}

/** What keeps to which limit, how near it comes, by how much it stays away, and when. */
type Margin = [of: string, limit: string, reached: string, margin: string, at: string];

function Margins({ plan }: { plan: Plan }) {
  const text = words.value.plan.one;
  const { columns } = text;
  const rows: Margin[] = [
    ...Object.entries(plan.margins).flatMap(([axis, limits]) =>
      Object.entries(limits).flatMap(([limit, one]): Margin[] => {
        if (!one) return [];
        const isReached = isAtLimit({ kind: "axis", limit, share: shareOf(one) ?? 1 });
        const margin = isReached ? text.limitReached : marginTold(shareOf(one));
        return [[axisTold(axis), limitIn(limitTold(limit), one), digits(one.extreme), margin, rowClock(one.at)]];
      }),
    ),
    ...plan.exclusions.map(({ name, margin_deg, at }): Margin => {
      const margin = margin_deg === null ? text.neverCounts : `${number(margin_deg)}°`;
      return [text.limits.exclusion, exclusionTold(name), "–", margin, at === null ? "–" : rowClock(at)];
    }),
    ...plan.pointing.flatMap(({ session, conditions }) => {
      const of = `${session + 1}. ${targetTold(plan.summary.sessions[session]?.target ?? "")}`;
      return conditions.map((one) => reserve(of, labelOf("Conditions", one.name), one));
    }),
    ...plan.resources.map((one) => reserve(resourceTold(one.name), "", { ...one, unit: resourceUnit(one.unit) })),
    ...plan.gyros.map((one) => reserve(text.gyros, limitTold(one.name), { ...one, unit: resourceUnit(one.unit) })),
  ];
  const all: Column<Margin>[] = [
    [columns.axis, ([of]) => of],
    [columns.limit, ([, limit]) => limit],
    [columns.reached, ([, , reached]) => reached, "number"],
    [columns.margin, ([, , , margin]) => margin, "number"],
    [columns.at, ([, , , , at]) => at, "number"],
  ];
  return <TablePanel title={text.margins} rows={rows} columns={all} />;
}

interface Limit {
  unit: string;
  limit: number;
}

function limitIn(name: string, { limit, unit }: Limit): string {
  return `${name} ${digits(limit)} ${unitOf(unit)}`;
}

function reserve(of: string, name: string, one: Limit & { extreme: number; margin: number; at: string }): Margin {
  return [of, limitIn(name, one), digits(one.extreme), `${digits(one.margin)} ${unitOf(one.unit)}`, rowClock(one.at)];
}

function Budget({ plan }: { plan: Plan }) {
  const text = words.value.plan.one;
  const { columns } = text;
  const { m } = words.value.viewer.units;
  const budgets = plan.uncertainty.filter((one) => one !== null);
  const rows = budgets.flatMap(({ session, contributions }) => contributions.map((one) => ({ session, ...one })));
  if (rows.length === 0) return null;
  const told = words.value.service.told;
  const all: Column<(typeof rows)[number]>[] = [
    [columns.cause, (one) => (budgets.length > 1 ? `${one.session + 1}: ${told(one.cause)}` : told(one.cause))],
    [columns.sigma, (one) => `${digits(one.sigma_arcsec)}″`, "number"],
    [columns.ground, (one) => (one.ground_m == null ? "–" : `${digits(one.ground_m)} ${m}`), "number"],
    [columns.better, (one) => told(one.better)],
  ];
  return <TablePanel class="budget" title={text.budget} rows={rows} columns={all} />;
}

/** "°/s²" of "deg/s2", as the charts have it. */
function unitOf(unit: string): string {
  return unit.replace("deg", "°").replace("2", "²").replace("3", "³");
}
