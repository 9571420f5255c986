/** The frames of all sessions in one row of time, beside what the plan says of them. */
import type { Values } from "../../charts/TimeChart";
import type { Stretch } from "../../time/TimeBar";
import { rowAt, type View } from "../viewer/view";
import type { Flights } from "./flights";

type Sessions = Flights["sessions"];

const GAP_S = 1e-3; // after a session's last frame, so that no line joins it to the next

export interface Planned {
  /** Of the table itself. */
  error_arcsec: Values;
  /** Of the pointing budget, one sigma along its longer axis. */
  sigma_arcsec: Values;
}

/** As long as the time: null between sessions. */
export function framesOf(sessions: Sessions) {
  const t_s: number[] = [];
  const number: (number | null)[] = [];
  const error_arcsec: (number | null)[] = [];
  const smear_px: (number | null)[] = [];
  const holds: (boolean | null)[] = [];
  const rate_error_deg_s: (readonly number[] | null)[] = [];
  for (const { nominal } of sessions) {
    t_s.push(...nominal.t_s, (nominal.t_s.at(-1) ?? 0) + GAP_S);
    number.push(...nominal.t_s.map((_, k) => k + 1), null);
    error_arcsec.push(...nominal.error_arcsec, null);
    smear_px.push(...nominal.smear_px, null);
    holds.push(...nominal.holds, null);
    rate_error_deg_s.push(...(nominal.rate_error_deg_s ?? nominal.t_s.map(() => null)), null);
  }
  return { t_s, number, error_arcsec, smear_px, holds, rate_error_deg_s, nothing: t_s.map(() => null) as Values };
}

/** By the rows of the view: a session may begin between two of them. */
export function plannedAt(view: View, t_s: readonly number[]): Planned {
  const { error_arcsec, sigma_major_arcsec } = view.pointing;
  const rows = t_s.map((t) => rowAt(view, t));
  const of = (values: Values) => rows.map((row) => values[row] ?? values[row + 1] ?? null);
  return { error_arcsec: of(error_arcsec), sigma_arcsec: of(sigma_major_arcsec) };
}

/** As a logarithmic scale takes it, which has no zero. */
export function positive(values: Values): Values {
  return values.map((one) => (one !== null && one > 0 ? one : null));
}

export function stretchesOf(sessions: Sessions, pause: string): Stretch[] {
  const stretches: Stretch[] = [];
  let now_s = 0;
  for (const { label, nominal } of sessions) {
    const [start_s, stop_s] = [nominal.t_s[0] ?? now_s, nominal.t_s.at(-1) ?? now_s];
    if (start_s > now_s) stretches.push({ kind: "wait", label: pause, start_s: now_s, stop_s: start_s });
    stretches.push({ kind: "track", label, start_s, stop_s });
    now_s = stop_s;
  }
  return stretches;
}
