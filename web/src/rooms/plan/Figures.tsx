/** The figures behind the verdict: sessions, margins, the pointing budget, warnings. */
import { words } from "../../i18n";
import { arcsecTold, digits, marginTold, number, percent, period, rowClock } from "../../i18n/forms";
import { axisTold, exclusionTold, limitTold, resourceTold, resourceUnit, targetTold } from "../../i18n/labels";
import { labelOf } from "../../parts/fields/labels";
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
  const { units } = words.value.viewer;
  return (
    <section class="panel scroll-x" tabIndex={0} aria-label={text.sessions}>
      <h2>{text.sessions}</h2>
      <table>
        <thead>
          <tr>
            <th scope="col">{columns.target}</th>
            <th scope="col">{columns.times}</th>
            <th scope="col" class="number">
              {columns.elevation}
            </th>
            <th scope="col" class="number">
              {columns.range}
            </th>
            <th scope="col" class="number">
              {columns.error}
            </th>
            <th scope="col" class="number">
              {columns.probability}
            </th>
          </tr>
        </thead>
        <tbody>
          {plan.summary.sessions.map((one) => {
            const pointing = plan.pointing.find((held) => held.session === one.session);
            return (
              <tr key={one.session}>
                <td>{one.name ?? targetTold(one.target)}</td>
                <td>{period(one.start, one.stop).replace(" UTC", "")}</td>
                <td class="number">{one.best_elevation_deg == null ? "–" : `${number(one.best_elevation_deg)}°`}</td>
                <td class="number">{pointing?.range_min_km == null ? "–" : `${number(pointing.range_min_km, 0)} ${units.km}`}</td>
                <td class="number">{pointing == null ? "–" : `${arcsecTold(pointing.max_arcsec)}″`}</td>
                <td class="number">{percent(one.probability_in_frame)}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </section>
  );
}

function Margins({ plan }: { plan: Plan }) {
  const text = words.value.plan.one;
  const { columns } = text;
  return (
    <section class="panel scroll-x" tabIndex={0} aria-label={text.margins}>
      <h2>{text.margins}</h2>
      <table>
        <thead>
          <tr>
            <th scope="col">{columns.axis}</th>
            <th scope="col">{columns.limit}</th>
            <th scope="col" class="number">
              {columns.reached}
            </th>
            <th scope="col" class="number">
              {columns.margin}
            </th>
            <th scope="col" class="number">
              {columns.at}
            </th>
          </tr>
        </thead>
        <tbody>
          {Object.entries(plan.margins).flatMap(([axis, limits]) =>
            Object.entries(limits).map(
              ([limit, one]) =>
                one && (
                  <tr key={axis + limit}>
                    <td>{axisTold(axis)}</td>
                    <td>
                      {limitTold(limit)} {digits(one.limit)} {unitOf(one.unit)}
                    </td>
                    <td class="number">{digits(one.extreme)}</td>
                    <td class="number">
                      {isAtLimit({ kind: "axis", limit, share: shareOf(one) ?? 1 })
                        ? text.limitReached
                        : marginTold(shareOf(one))}
                    </td>
                    <td class="number">{rowClock(one.at)}</td>
                  </tr>
                ),
            ),
          )}
          {plan.exclusions.map(({ name, margin_deg, at }) => (
            <tr key={`exclusion ${name}`}>
              <td>{text.limits.exclusion}</td>
              <td>{exclusionTold(name)}</td>
              <td class="number">–</td>
              <td class="number">{margin_deg === null ? text.neverCounts : `${number(margin_deg)}°`}</td>
              <td class="number">{at === null ? "–" : rowClock(at)}</td>
            </tr>
          ))}
          {plan.pointing.flatMap(({ session, conditions }) =>
            conditions.map(({ name, unit, limit, extreme, margin, at }) => (
              <tr key={`condition ${session} ${name}`}>
                <td>
                  {session + 1}. {targetTold(plan.summary.sessions[session]?.target ?? "")}
                </td>
                <td>
                  {labelOf("Conditions", name)} {digits(limit)} {unitOf(unit)}
                </td>
                <td class="number">{digits(extreme)}</td>
                <td class="number">
                  {digits(margin)} {unitOf(unit)}
                </td>
                <td class="number">{rowClock(at)}</td>
              </tr>
            )),
          )}
          {plan.resources.map((one) => (
            <Reserve key={`resource ${one.name}`} of={resourceTold(one.name)} limit="" one={one} />
          ))}
          {plan.gyros.map((one) => (
            <Reserve key={`gyros ${one.name}`} of={text.gyros} limit={limitTold(one.name)} one={one} />
          ))}
        </tbody>
      </table>
    </section>
  );
}

interface ReserveProps {
  of: string;
  limit: string;
  one: Plan["resources"][number] | Plan["gyros"][number];
}

function Reserve({ of, limit, one }: ReserveProps) {
  const unit = unitOf(resourceUnit(one.unit));
  return (
    <tr>
      <td>{of}</td>
      <td>
        {limit} {digits(one.limit)} {unit}
      </td>
      <td class="number">{digits(one.extreme)}</td>
      <td class="number">
        {digits(one.margin)} {unit}
      </td>
      <td class="number">{rowClock(one.at)}</td>
    </tr>
  );
}

function Budget({ plan }: { plan: Plan }) {
  const text = words.value.plan.one;
  const { columns } = text;
  const { units } = words.value.viewer;
  const budgets = plan.uncertainty.filter((one) => one !== null);
  if (budgets.length === 0) return null;
  return (
    <section class="panel scroll-x budget" tabIndex={0} aria-label={text.budget}>
      <h2>{text.budget}</h2>
      <table>
        <thead>
          <tr>
            <th scope="col">{columns.cause}</th>
            <th scope="col" class="number">
              {columns.sigma}
            </th>
            <th scope="col" class="number">
              {columns.ground}
            </th>
            <th scope="col">{columns.better}</th>
          </tr>
        </thead>
        <tbody>
          {budgets.flatMap((budget) =>
            budget.contributions.map((one) => {
              const cause = words.value.service.told(one.cause);
              return (
                <tr key={`${budget.session}-${one.cause}`}>
                  <td>{budgets.length > 1 ? `${budget.session + 1}: ${cause}` : cause}</td>
                  <td class="number">{digits(one.sigma_arcsec)}″</td>
                  <td class="number">{one.ground_m == null ? "–" : `${digits(one.ground_m)} ${units.m}`}</td>
                  <td>{words.value.service.told(one.better)}</td>
                </tr>
              );
            }),
          )}
        </tbody>
      </table>
    </section>
  );
}

/** "°/s²" of "deg/s2", as the charts have it. */
function unitOf(unit: string): string {
  return unit.replace("deg", "°").replace("2", "²").replace("3", "³");
}
