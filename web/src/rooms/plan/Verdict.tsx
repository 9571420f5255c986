import { words } from "../../i18n";
import { digits, marginTold, number, percent, rowClock } from "../../i18n/forms";
import { axisTold, exclusionTold, limitTold, resourceTold, resourceUnit } from "../../i18n/labels";
import type { Plan } from "./plan";
import { gradeOf, isAtLimit, type LeastMargin, leastExclusion, leastMargin } from "./verdict";

/** Whether it passed, and the figures one asks for first. */
export function Verdict({ plan }: { plan: Plan }) {
  const text = words.value.plan.one;
  const grade = gradeOf(plan);
  const least = leastMargin(plan);
  const kept = leastExclusion(plan);
  const highest = Math.max(...plan.summary.sessions.map((one) => one.best_elevation_deg ?? -Infinity));
  const samples = plan.summary.sessions.map((one) => one.ground_sample_m ?? Infinity);
  const clear = Math.min(...plan.summary.sessions.map((one) => one.clear_probability ?? Infinity));
  const sample = Math.min(...samples);
  const facts = [
    least &&
      (isAtLimit(least)
        ? text.atLimit(nameOf(least), `${rowClock(least.at)} UTC`)
        : text.least(nameOf(least), marginTold(least.share), `${rowClock(least.at)} UTC`)),
    kept && text.exclusion(exclusionTold(kept.name), number(kept.margin_deg), `${rowClock(kept.at)} UTC`),
    ...plan.resources.map(({ name, margin, unit, at }) =>
      text.reserve(resourceTold(name), `${digits(margin)} ${resourceUnit(unit)}`, `${rowClock(at)} UTC`),
    ),
    plan.summary.probability_in_frame !== null && text.inFrame(percent(plan.summary.probability_in_frame)),
    Number.isFinite(clear) && text.clear(percent(clear)),
    Number.isFinite(sample) && text.sample(number(sample, 2)),
    Number.isFinite(highest) && text.elevation(number(highest, 0)),
  ].filter((fact) => typeof fact === "string");
  return (
    <p class={`verdict verdict-${grade}`} data-testid="verdict">
      <b>{{ good: text.passed, warn: text.doubtful, bad: text.failed }[grade]}</b>
      {facts.map((fact) => (
        <span key={fact}>{fact}</span>
      ))}
    </p>
  );
}

function nameOf(least: LeastMargin): string {
  const text = words.value.plan.one;
  if (least.kind === "keepOut") return text.keepOut(least.limit);
  if (least.kind === "mask") return text.mask(least.limit);
  return text.limitOf(axisTold(least.axis), limitTold(least.limit));
}
