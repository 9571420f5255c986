/** The times that a refusal offers in place of the request's. */
import { Problem } from "./problem";

export interface Offer {
  start: string;
  stop: string;
  /** Number of the session it is for, from 0; null where the request has only one. */
  session: number | null;
  /** Numbers of the sessions that can't be flown as asked with it. */
  without: readonly number[];
}

export function sessionOf(problem: Problem): number | null {
  const number = /^sessions\.(\d+)/.exec(problem.field ?? "")?.[1];
  return number === undefined ? null : Number(number);
}

export function offerOf(error: unknown): Offer | null {
  if (!(error instanceof Problem)) return null;
  const { earliest_feasible_start: start, feasible_stop: stop, costs_sessions: without = [] } = error.document;
  return start && stop ? { start, stop, session: sessionOf(error), without } : null;
}
