/** What a plan looks like: globe, charts and cameras by one time cursor. */
import type { Plan } from "../plan/plan";

export default function Look(_: { plan: Plan }) {
  return null;
}
