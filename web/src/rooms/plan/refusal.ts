/** Why the request isn't flown, tied to the session it is about, and the ways out it offers. */
import { computed, signal } from "@preact/signals";

import { Problem } from "../../api/problem";

/** What came of the last try to plan; null while nothing is wrong. */
export const failure = signal<unknown>(null);

export interface Refused {
  problem: Problem;
  /** Number of the session that the service names, from 0. */
  session: number;
  at: string | null;
  /** A session that works instead. */
  offered: { start: string; stop: string } | null;
}

export const refused = computed<Refused | null>(() => {
  const problem = failure.value;
  if (!(problem instanceof Problem)) return null;
  const session = Number(/^sessions\.(\d+)/.exec(problem.field ?? "")?.[1] ?? NaN);
  if (!Number.isInteger(session)) return null;
  const { at, earliest_feasible_start: start, feasible_stop: stop } = problem.document;
  return { problem, session, at: at ?? null, offered: start && stop ? { start, stop } : null };
});

export function refusalOf(session: number): Refused | null {
  return refused.value?.session === session ? refused.value : null;
}
