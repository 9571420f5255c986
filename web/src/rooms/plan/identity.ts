/** Identity of a plan, in the words that head every view, sheet, file and tab of it. */
import { type Orbit, reachOf } from "../../api/orbit";
import { words } from "../../i18n";
import { day, number, period, rowClock } from "../../i18n/forms";
import { targetTold } from "../../i18n/labels";
import { valueLabel } from "../../parts/fields/labels";
import type { Plan, PlanRequest } from "./plan";

const HOUR_MS = 3_600_000;

export function nameOf({ summary }: Plan): string {
  return summary.name || summary.targets.map(targetTold).join(", ");
}

/** Parts in their order; without the request neither orbit nor attitude is known. */
export function identityOf(plan: Plan, asked: PlanRequest | null): string[] {
  const text = words.value.plan.one.identity;
  const { start, stop, platform } = plan.summary;
  return [
    period(start, stop),
    platform,
    ...(asked ? [orbitTold(asked.orbit, start)] : []),
    ...(asked?.attitude ? [attitudeTold(asked.attitude)] : []),
    text.revision(plan.revision),
  ];
}

/** "Las_Vegas_20150227T173620Z_r1_ab12cd34": what tells a file of it from others'. */
export function fileNameOf(plan: Plan): string {
  const name = nameOf(plan)
    .replace(/[^\p{L}\p{N}.-]+/gu, "_")
    .slice(0, 60);
  const start = new Date(plan.summary.start).toISOString().slice(0, 19).replace(/[-:]/g, "");
  return `${name}_${start}Z_r${plan.revision}_${plan.id.slice(-8)}`;
}

function orbitTold(orbit: Orbit, start: string): string {
  const text = words.value.plan.one.identity;
  const source = orbit.source.toUpperCase();
  const reach = reachOf(orbit);
  if (!reach) return source;
  const from = `${day(reach.from_ms)} ${rowClock(reach.from_ms).slice(0, 5)}`;
  if (reach.to_ms !== null) return `${source} ${from}–${day(reach.to_ms)} ${rowClock(reach.to_ms).slice(0, 5)}`;
  const age_h = (Date.parse(start) - reach.from_ms) / HOUR_MS;
  const told = number(Math.abs(age_h), Math.abs(age_h) < 1 ? 1 : 0);
  return age_h < 0 ? text.later(source, from, told) : text.older(source, from, told);
}

/** "LVLH -4/-2/1, 1 correction". */
export function attitudeTold(attitude: NonNullable<PlanRequest["attitude"]>): string {
  const { law, corrections = [] } = attitude;
  const corrected = corrections.length > 0 ? `, ${words.value.plan.one.identity.corrected(corrections.length)}` : "";
  if (law !== "lvlh") return valueLabel(law) + corrected;
  const { yaw_deg = 0, pitch_deg = 0, roll_deg = 0 } = attitude;
  return `LVLH ${[yaw_deg, pitch_deg, roll_deg].map((one) => number(one, 3)).join("/")}${corrected}`;
}
