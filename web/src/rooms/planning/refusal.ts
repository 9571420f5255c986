/** The refusal of a request, tied to the session it is about, and the ways out it offers. */
import { computed, signal } from "@preact/signals";

import { type Offer, offerOf, sessionOf } from "../../api/offer";
import { Problem } from "../../api/problem";

/** What came of the last try to plan; null while nothing is wrong. */
export const failure = signal<unknown>(null);

export interface Refused {
  problem: Problem;
  /** Number of the session that the service names, from 0. */
  session: number;
  at: string | null;
  /** A session that works instead. */
  offered: Offer | null;
}

export const refused = computed<Refused | null>(() => {
  const problem = failure.value;
  if (!(problem instanceof Problem)) return null;
  const session = sessionOf(problem);
  if (session === null) return null;
  return { problem, session, at: problem.document.at ?? null, offered: offerOf(problem) };
});

export function refusalOf(session: number): Refused | null {
  return refused.value?.session === session ? refused.value : null;
}
