/** Names of kept work, the same in every list. */
import { period } from "./forms";
import { words } from "./index";

interface Named {
  id: string;
  name: string;
  targets: readonly string[];
  start: string | null;
  stop: string | null;
}

/** A target in the service's few words, told in the page's language. */
export function targetTold(target: string): string {
  return words.value.service.told(target);
}

/** What a person called it, or else what it looks at. */
export function nameOf({ id, name, targets }: Pick<Named, "id" | "name" | "targets">): string {
  return name || targets.map(targetTold).join(", ") || id;
}

/** "Las Vegas, 27 Feb 2015 17:36:20–17:37:50 UTC". */
export function labelOf(one: Named): string {
  return one.start && one.stop ? `${nameOf(one)}, ${period(one.start, one.stop)}` : nameOf(one);
}

/** A limit that a margin or a refusal names: "off_nadir"; what has no words of the page's own as it is. */
export function limitTold(limit: string): string {
  const { limits } = words.value.plan.one;
  return limits[limit as keyof typeof limits] ?? limit;
}

/** An exclusion by the name it was given; a body's star trackers count together. */
export function exclusionTold(name: string): string {
  return name === "star_trackers" ? words.value.plan.one.starTrackers : name;
}

export function resourceTold(name: keyof typeof words.value.plan.one.resources): string {
  return words.value.plan.one.resources[name];
}

/** Of a resource: "Wh" or "Gbit". */
export function resourceUnit(unit: string): string {
  const { resourceUnits } = words.value.plan.one;
  return resourceUnits[unit as keyof typeof resourceUnits] ?? unit;
}

/** An axis by its name; a spacecraft that turns as a whole is "body". */
export function axisTold(axis: string): string {
  return axis === "body" ? words.value.plan.one.wholeBody : axis;
}
