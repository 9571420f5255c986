/** A target as a person types it. */
import type { Schemas } from "../../api/client";

export type Target = Schemas["Session"]["target"];
export type Kind = "ground" | "star" | "body";

export const BODIES = ["sun", "moon", "mercury", "venus", "mars", "jupiter", "saturn"] as const;

export function kindOf(target: Target): Kind | "other" {
  if (target.mode === "place" || target.mode === "ground") return "ground";
  return target.mode === "star" || target.mode === "body" ? target.mode : "other";
}

/** Coordinates or a place's name; null for nothing. */
export function groundOf(text: string): Target | null {
  const point = pointOf(text);
  if (point) return { mode: "ground", ...point };
  const name = text.trim();
  return name ? { mode: "place", name } : null;
}

/** "36.11, -115.17", "36.11 N 115.17 W", with the height in metres as a third number. */
function pointOf(text: string) {
  const form =
    /^\s*([+-]?\d+(?:\.\d+)?)\s*°?\s*([NS]?)\s*[,;\s]\s*([+-]?\d+(?:\.\d+)?)\s*°?\s*([EW]?)(?:\s*[,;\s]\s*([+-]?\d+(?:\.\d+)?)\s*m?)?\s*$/i;
  const found = form.exec(text);
  if (!found) return null;
  const sign = (letter: string | undefined) => (/[SW]/i.test(letter ?? "") ? -1 : 1);
  return {
    latitude_deg: sign(found[2]) * Number(found[1]),
    longitude_deg: sign(found[4]) * Number(found[3]),
    height_m: Number(found[5] ?? 0),
  };
}

/** A name or a Hipparcos number. */
export function starOf(text: string): Target | null {
  const name = text.trim();
  const hip = /^(?:HIP\s*)?(\d{1,6})$/i.exec(name);
  if (hip) return { mode: "star", hip: Number(hip[1]) };
  return name ? { mode: "star", name } : null;
}

/** What stands in the text field for a target. */
export function textOf(target: Target): string {
  if (target.mode === "ground") {
    const height = target.height_m ? `, ${target.height_m}` : "";
    return `${target.latitude_deg}, ${target.longitude_deg}${height}`;
  }
  if (target.mode === "place") return target.name;
  if (target.mode === "star") return target.name ?? (target.hip ? `HIP ${target.hip}` : `${target.ra_deg}, ${target.dec_deg}`);
  if (target.mode === "body") return target.name;
  return target.mode;
}
