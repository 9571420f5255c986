/** A plan's figures by name, as two plans are compared by. */
import type { Schemas } from "../../api/client";
import { words } from "../../i18n";
import { digits, instant, number, percent } from "../../i18n/forms";
import { targetTold } from "../../i18n/labels";

export type Plan = Schemas["PlanResponse"];

export interface Figure {
  name: string;
  value: string;
}

export function figures(plan: Plan): Figure[] {
  const text = words.value.library.figures;
  const rows = plan.table.t_s.length;
  return [
    { name: text.verdict, value: plan.verification.passed ? text.passed : text.rejected },
    { name: text.platform, value: plan.platform },
    { name: text.epoch, value: instant(plan.table.epoch) },
    { name: text.rows, value: text.rowsOver(rows, number((rows - 1) * plan.table.step_s)) },
    ...plan.summary.sessions.flatMap((session) => ofSession(plan, session)),
    ...plan.solver.slews.flatMap((slew) => {
      const name = slew.session === null ? text.finalSlew : text.slew(slew.session + 1);
      return [
        { name: `${name}, ${text.duration}`, value: `${number(slew.duration_s)} s` },
        { name: `${name}, ${text.cost}`, value: slew.cost == null ? "–" : `${digits(slew.cost, 4)} deg²/s⁵` },
        { name: `${name}, ${text.gap}`, value: slew.gap == null ? "–" : digits(slew.gap, 2) },
      ];
    }),
    ...Object.entries(plan.margins).flatMap(([axis, limits]) =>
      Object.entries(limits).map(([limit, { margin, unit }]) => ({
        name: `${axis}, ${text.margin(limit)}`,
        value: `${digits(margin, 4)} ${unit}`,
      })),
    ),
    { name: text.warnings, value: plan.warnings.map(words.value.service.told).join("; ") || text.none },
  ];
}

function ofSession(plan: Plan, session: Plan["summary"]["sessions"][number]): Figure[] {
  const text = words.value.library.figures;
  const name = text.session(session.session + 1);
  const pointing = plan.pointing.find((one) => one.session === session.session);
  const budget = plan.uncertainty.find((one) => one.session === session.session);
  return [
    { name: `${name}, ${text.target}`, value: targetTold(session.target) },
    { name: `${name}, ${text.start}`, value: instant(session.start) },
    { name: `${name}, ${text.stop}`, value: instant(session.stop) },
    { name: `${name}, ${text.elevation}`, value: `${number(session.best_elevation_deg, 2)}°` },
    { name: `${name}, ${text.probability}`, value: percent(session.probability_in_frame) },
    { name: `${name}, ${text.sigma}`, value: `${number(budget?.sigma_arcsec)}″` },
    {
      name: `${name}, ${text.error}`,
      value: pointing && pointing.max_arcsec < 0.001 ? "< 0.001″" : `${digits(pointing?.max_arcsec)}″`,
    },
  ];
}
