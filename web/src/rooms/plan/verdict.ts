/** The one line that says whether a plan flies, and how near it comes to what. */
import type { Plan } from "./plan";

/** Below, the picture will probably miss; the service warns of the same. */
const PROBABLE = 0.9;
/** A share of an angle's limit so small that the motion lies on it. */
const ON_A_STOP = 0.01;
/** So near an exclusion that the motion lies on it: the same share of a usual one of 30°. */
const ON_AN_EXCLUSION_DEG = 0.3;

export type Grade = "good" | "warn" | "bad";

/** bad: something breaks; warn: it flies, but will probably miss or lies on a stop, a cone, a mask or an exclusion. */
export function gradeOf(plan: Plan): Grade {
  if (!plan.verification.passed) return "bad";
  const probability = plan.summary.probability_in_frame;
  const kept = leastExclusion(plan);
  const isOnOne = marginsOf(plan).some(isOnAStop) || (kept !== null && kept.margin_deg < ON_AN_EXCLUSION_DEG);
  return isOnOne || (probability !== null && probability < PROBABLE) ? "warn" : "good";
}

/** A slew as fast as it may is meant to be: of rates and above, a limit that is reached is no danger. */
export function isAtLimit(one: Reached): boolean {
  return !isAngle(one) && one.share < ON_A_STOP;
}

function isOnAStop(one: Reached): boolean {
  return isAngle(one) && one.share < ON_A_STOP;
}

function isAngle({ kind, limit }: Reached): boolean {
  return kind !== "axis" || limit.startsWith("angle");
}

/** The one figure of an axis's margin: of the limit; null of a limit at zero. */
export function shareOf({ margin, limit }: { margin: number; limit: number }): number | null {
  return limit === 0 ? null : margin / Math.abs(limit);
}

export interface LeastMargin {
  kind: "axis" | "keepOut" | "mask";
  axis: string;
  limit: string;
  /** Of the limit, or of the cone's half angle: 0 touches it. */
  share: number;
  at: string;
}

type Reached = Pick<LeastMargin, "kind" | "limit" | "share">;

/** The nearest that the motion comes to anything, as a share of it; a stop that it lies on before a limit that it uses up. */
export function leastMargin(plan: Plan): LeastMargin | null {
  const all = marginsOf(plan);
  const onStops = all.filter(isOnAStop);
  return (onStops.length > 0 ? onStops : all).reduce<LeastMargin | null>(
    (least, one) => (!least || one.share < least.share ? one : least),
    null,
  );
}

/** The exclusion that is kept by least, of those that count at any time. */
export function leastExclusion({ exclusions }: Plan): { name: string; margin_deg: number; at: string } | null {
  const counting = exclusions.flatMap(({ name, margin_deg, at }) =>
    margin_deg !== null && at !== null ? [{ name, margin_deg, at }] : [],
  );
  return counting.sort((one, other) => one.margin_deg - other.margin_deg)[0] ?? null;
}

function marginsOf(plan: Plan): LeastMargin[] {
  const all: LeastMargin[] = [];
  for (const [axis, limits] of Object.entries(plan.margins)) {
    for (const [limit, margin] of Object.entries(limits)) {
      const share = margin && shareOf(margin);
      if (margin && share !== null) all.push({ kind: "axis", axis, limit, share, at: margin.at });
    }
  }
  for (const cone of plan.keep_out) {
    if (cone.margin_deg !== null && cone.at !== null) {
      all.push({ kind: "keepOut", axis: "", limit: cone.about, share: cone.margin_deg / cone.half_angle_deg, at: cone.at });
    }
  }
  for (const mask of plan.masks) {
    const share = mask.margin_deg / Math.max(mask.away_min_deg, 1e-9);
    all.push({ kind: "mask", axis: "", limit: mask.name, share, at: mask.at });
  }
  return all;
}
