/** The passes of the next days over what is asked for; a click takes one for the session's times. */
import { useState } from "preact/hooks";

import { post, remove, type Schemas } from "../../api/client";
import { reachOf, searchStart } from "../../api/orbit";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { number, rfc3339 } from "../../i18n/forms";
import { useKept } from "../../parts/kept";
import { NumberField } from "../../parts/NumberField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { UtcField } from "../../parts/UtcField";
import { WindowList } from "../../windows/WindowList";
import "../planning/planning.css";
import { GRID_MS, passesOf, spanOf, type Window } from "../planning/scans";
import { type Asked, askedOf, type SessionRequest } from "./session";

const DAY_MS = 86_400_000;
const MOST_DAYS = 14;
const SAMPLES = 21;
const ASKED = { include: "view", limit: 1000 };
// From orbital orientation to the farthest look, or back: 54 deg at 1.58 deg/s about each axis, and settling.
const TURN_MS = 60_000;

/** What one session can image, told by the window in which it is highest. */
type Pass = ReturnType<typeof sessionOf>;

export function PassesPanel({ request, onTimes }: { request: SessionRequest; onTimes: (times: Pass["session"]) => void }) {
  const text = words.value.spacecraft.passes;
  const { span, windows } = words.value.plan;
  const { orbit, spacecraft, settings, start, stop } = request;
  const [from, setFrom] = useKept<string | null>("/spacecraft passes from", null);
  const [days, setDays] = useKept("/spacecraft passes days", 3);
  const from_ms = Date.parse(from ?? new Date(searchStart(orbit, Date.now())).toISOString());
  const last_ms = reachOf(orbit)?.to_ms ?? 0;
  const to_ms = Math.min(from_ms + days * DAY_MS, last_ms > from_ms ? last_ms : Infinity);
  const limits = [settings?.along_max_deg, settings?.across_max_deg].filter((one) => one != null);
  const search = {
    platform: spacecraft,
    orbit,
    targets: askedOf(request).map((one) => ({ id: one.name, target: modeOf(one) })),
    conditions: limits.length ? { max_off_nadir_deg: Math.max(...limits) } : {},
    start: rfc3339(from_ms),
    stop: rfc3339(to_ms),
    samples: SAMPLES,
  };
  const [asked, setAsked] = useState("");
  // Of another search nothing is told.
  const key = JSON.stringify(search);
  const passes = useRequest(asked === key ? key : null, (until) => findPasses(search, until));
  const { answer: found, error, isAsking } = passes;
  return (
    <section class="panel" aria-labelledby="session-passes">
      <div class="row heading">
        <h2 id="session-passes">{text.title}</h2>
        <span role="status" class="small">
          {isAsking ? text.searching : found ? windows.count(found.passes.length) : ""}
        </span>
      </div>
      <div class="span-fields">
        <UtcField label={span.from} value={search.start} onValue={setFrom} />
        <NumberField label={span.days} least={1} most={MOST_DAYS} value={days} onValue={setDays} />
        <button type="button" disabled={search.targets.length === 0 || isAsking} onClick={() => setAsked(key)}>
          {text.find}
        </button>
      </div>
      {error !== null && <ProblemNotice error={error} again={() => void passes.ask()} />}
      {found && found.unseen.length > 0 && <p class="notice notice-warn">{text.unseen(found.unseen.join(", "))}</p>}
      {found && (
        <WindowList
          windows={found.passes}
          taken={found.passes.find(({ session }) => session.start === start && session.stop === stop) ?? null}
          from_ms={from_ms}
          to_ms={to_ms}
          label={text.list}
          onTake={({ session }) => onTimes(session)}
          more={(pass) => <span class="small pass-seen">{told(pass, search.targets.length)}</span>}
          warnings={found.warnings}
        />
      )}
    </section>
  );
}

/** Passes in order of time, each as much as one session may hold, and names of what none shows whole. */
async function findPasses(search: object, until: AbortSignal) {
  const { id, windows, unseen, warnings } = await post("/v1/opportunities", search, { query: ASKED, signal: until });
  // Kept by the service for who wants it; ours is seen once.
  void remove("/v1/opportunities/{id}", { id }).catch(() => undefined);
  return { passes: passesOf((windows as Window[]).filter((one) => one.session)).map(sessionOf), unseen, warnings };
}

/** A request of a session as the imaging mode it is. */
function modeOf({ name: _, priority: __, scan_speed_m_s, start, window_start, window_stop, ...mode }: Asked) {
  return { ...mode, line: "plane", speed_m_s: scan_speed_m_s } as Schemas["StripMode"];
}

function sessionOf(seen: readonly Window[]) {
  const { rise_ms, set_ms, highest } = spanOf(seen);
  const onRow = (ms: number, round: (count: number) => number) => rfc3339(round(ms / GRID_MS) * GRID_MS);
  return { ...highest, session: { start: onRow(rise_ms - TURN_MS, Math.floor), stop: onRow(set_ms + TURN_MS, Math.ceil) }, seen };
}

/** What a session in the pass can image, and from how far aside. */
function told({ seen }: Pass, count: number): string {
  const text = words.value.spacecraft.passes;
  const across = new Map(seen.map((one) => [one.target, one.closest.angles_deg.across_track]));
  const names = [...across].map(([name, deg]) => (deg == null ? name : text.aside(name, number(Math.abs(deg), 0))));
  return `${text.sees(across.size, count)}: ${names.join(", ")}`;
}
