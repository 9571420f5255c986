import { words } from "../../i18n";
import { clock, number, percent } from "../../i18n/forms";
import type { Plan } from "./plan";
import { type LeastMargin, leastMargin } from "./verdict";

/** Whether it passed, and the figures one asks for first. */
export function Verdict({ plan }: { plan: Plan }) {
  const text = words.value.plan.one;
  const { passed } = plan.verification;
  const least = leastMargin(plan);
  const highest = Math.max(...plan.summary.sessions.map((one) => one.best_elevation_deg ?? -Infinity));
  const samples = plan.summary.sessions.map((one) => one.ground_sample_m ?? Infinity);
  const sample = Math.min(...samples);
  const facts = [
    least && text.least(nameOf(least), percent(least.share, 0), `${clock(least.at)} UTC`),
    plan.summary.probability_in_frame !== null && text.inFrame(percent(plan.summary.probability_in_frame)),
    Number.isFinite(sample) && text.sample(number(sample, 2)),
    Number.isFinite(highest) && text.elevation(number(highest, 0)),
  ].filter((fact) => typeof fact === "string");
  return (
    <p class={`verdict ${passed ? "verdict-good" : "verdict-bad"}`} data-testid="verdict">
      <b>{passed ? text.passed : text.failed}</b>
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
  return text.limitOf(least.axis, text.limits[least.limit as keyof typeof text.limits] ?? least.limit);
}
