/** A session's time as stretches: looks, turns, and what is between them. */

import { number } from "../../i18n/forms";
import type { Words } from "../../i18n/words";
import type { Stretch } from "../../time/TimeBar";
import type { Session } from "./session";

export function stretchesOf(session: Session, text: Words["spacecraft"]): Stretch[] {
  const epoch_ms = Date.parse(session.table.epoch);
  const since = (utc: string) => (Date.parse(utc) - epoch_ms) / 1000;
  const { t_s } = session.table;
  const known: Stretch[] = [
    ...session.windows.map((one) => ({
      kind: "track",
      label: nameOf(session, one),
      start_s: since(one.start),
      stop_s: since(one.stop),
    })),
    ...session.slews.map((one) => ({
      kind: "slew",
      label: text.turn(number(one.angle_deg)),
      start_s: since(one.start),
      stop_s: since(one.stop),
    })),
  ].sort((a, b) => a.start_s - b.start_s);
  const stretches: Stretch[] = [];
  let now_s = 0;
  for (const one of [...known, { kind: "end", label: "", start_s: t_s[t_s.length - 1] ?? 0, stop_s: 0 }]) {
    if (one.start_s > now_s + 0.3) stretches.push({ kind: "wait", label: text.wait, start_s: now_s, stop_s: one.start_s });
    if (one.kind !== "end") stretches.push(one);
    now_s = Math.max(now_s, one.stop_s);
  }
  return stretches;
}

/** "stereo", or "stereo 2" where a request has several looks. */
export function nameOf(session: Session, { request, look }: { request: string; look: number }): string {
  const several = session.windows.filter((one) => one.request === request).length > 1;
  return several ? `${request} ${look + 1}` : request;
}
