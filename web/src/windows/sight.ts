/** One pass as it is drawn and told: the light at the target, and how sharp it is seen. */
import type { Schemas } from "../api/client";

export type Pass = Pick<
  Required<Schemas["WindowOut"]>,
  "rise" | "set" | "duration_s" | "highest_deg" | "closest" | "through" | "place"
>;
export type Light = "day" | "low" | "twilight" | "night";

/** Of the Sun at the target; null in space. */
export function lightOf(sunElevation_deg: number | null | undefined): Light | null {
  if (sunElevation_deg == null) return null;
  if (sunElevation_deg >= 15) return "day";
  if (sunElevation_deg >= 0) return "low";
  return sunElevation_deg >= -6 ? "twilight" : "night";
}

/** Of a pixel on the ground at the closest approach, its longer side; null in space. */
export function sample_m(pass: Pass): number | null {
  const { ground_sample_along_m: along, ground_sample_across_m: across } = pass.closest;
  if (pass.place === null || along === null || across === null) return null;
  return Math.max(along, across);
}

/** 1 straight below the carrier, less the more a pixel is stretched; null in space. */
export function quality(pass: Pass): number | null {
  const sample = sample_m(pass);
  const { range_km, ground_sample_across_m: across, off_nadir_deg } = pass.closest;
  if (sample === null || across === null || range_km === null) return null;
  // Straight down from there the range is about its projection on the vertical.
  const below_m = across * Math.cos((off_nadir_deg * Math.PI) / 180);
  return Math.min(1, below_m / sample);
}
