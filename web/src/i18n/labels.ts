/** Names of kept work, the same in every list. */
import { period } from "./forms";

interface Named {
  id: string;
  name: string;
  targets: readonly string[];
  start: string | null;
  stop: string | null;
}

/** What a person called it, or else what it looks at. */
export function nameOf({ id, name, targets }: Pick<Named, "id" | "name" | "targets">): string {
  return name || targets.join(", ") || id;
}

/** "Las Vegas, 27 Feb 2015 17:36:20–17:37:50 UTC". */
export function labelOf(one: Named): string {
  return one.start && one.stop ? `${nameOf(one)}, ${period(one.start, one.stop)}` : nameOf(one);
}
