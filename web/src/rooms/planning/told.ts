/** Targets in the page's words. */
import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import { valueLabel } from "../../parts/fields/labels";
import { lengthOf, type Target, textOf } from "./target";

export function targetTold(target: Target): string {
  const { bodies, ofPath } = words.value.plan.target;
  if (target.mode === "body") return (bodies as Record<string, string>)[target.name.toLowerCase()] ?? target.name;
  if (target.mode === "ground_path") return ofPath(String(target.points.length), number(lengthOf(target.points) / 1000, 1));
  if (target.mode === "ground_moving" || target.mode === "station") return `${valueLabel(target.mode)}, ${textOf(target)}`;
  return ["ground", "place", "star"].includes(target.mode) ? textOf(target) : valueLabel(target.mode);
}
