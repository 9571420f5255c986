/** The one line that says whether a plan flies, and how near it comes to what. */
import type { Plan } from "./plan";

export interface LeastMargin {
  kind: "axis" | "keepOut" | "mask";
  axis: string;
  limit: string;
  /** Of the limit, or of the cone's half angle: 0 touches it. */
  share: number;
  at: string;
}

/** The nearest that the motion comes to anything, as a share of it. */
export function leastMargin(plan: Plan): LeastMargin | null {
  const all: LeastMargin[] = [];
  for (const [axis, limits] of Object.entries(plan.margins)) {
    for (const [limit, margin] of Object.entries(limits)) {
      if (margin && margin.limit !== 0) {
        all.push({ kind: "axis", axis, limit, share: margin.margin / Math.abs(margin.limit), at: margin.at });
      }
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
  return all.reduce<LeastMargin | null>((least, one) => (!least || one.share < least.share ? one : least), null);
}
