/** One window drawn large, and the session dragged along it. */
import type { TargetedKeyboardEvent, TargetedPointerEvent } from "preact";
import { useRef } from "preact/hooks";

import { words } from "../../i18n";
import { number, period, rfc3339, rowClock } from "../../i18n/forms";
import { Profile } from "../../windows/Profile";
import { lightOf } from "../../windows/sight";
import * as draft from "./draft";
import { refusalOf } from "./refusal";
import type { Window } from "./windows";

type Edge = "start" | "stop" | "both";

const LEAST_MS = 2000;
const ROW_MS = 200;

export function SessionBar({ window }: { window: Window }) {
  const text = words.value.plan.session;
  const bar = useRef<HTMLDivElement>(null);
  const dragged = useRef<{ edge: Edge; grabbed_ms: number; start: number; stop: number } | null>(null);
  const { start, stop } = draft.session.value;
  if (!start || !stop || !window.session) return null;
  const [first, last] = [Date.parse(start), Date.parse(stop)];
  const [rise, set] = [Date.parse(window.rise), Date.parse(window.set)];
  // A session beside its window is drawn there, too.
  const left = Math.min(rise, first);
  const span = Math.max(set, last) - left;
  const least = Math.min(Date.parse(window.session.start), first);
  const most = Math.max(Date.parse(window.session.stop), last);
  const place = (ms: number) => `${Math.min(100, Math.max(0, (100 * (ms - left)) / span))}%`;

  const move = (edge: Edge, by_ms: number, from = { start: first, stop: last }) => {
    let [next, end] = [from.start, from.stop];
    if (edge !== "stop") next += by_ms;
    if (edge !== "start") end += by_ms;
    if (edge === "both") {
      const back = Math.min(0, most - end) + Math.max(0, least - next);
      [next, end] = [next + back, end + back];
    }
    const onRow = (ms: number) => Math.round(ms / ROW_MS) * ROW_MS;
    next = Math.max(least, Math.min(onRow(next), edge === "start" ? end - LEAST_MS : most));
    end = Math.min(most, Math.max(onRow(end), edge === "stop" ? next + LEAST_MS : least));
    if (next !== first || end !== last) draft.setTimes(rfc3339(next), rfc3339(end));
  };
  const grab = (edge: Edge) => (event: TargetedPointerEvent<HTMLElement>) => {
    event.currentTarget.setPointerCapture(event.pointerId);
    dragged.current = { edge, grabbed_ms: at(event.clientX), start: first, stop: last };
  };
  const at = (clientX: number) => {
    const box = bar.current?.getBoundingClientRect();
    return box ? left + (span * (clientX - box.left)) / box.width : left;
  };
  const drag = (event: TargetedPointerEvent<HTMLElement>) => {
    const held = dragged.current;
    if (!held) return;
    const by = Math.round((at(event.clientX) - held.grabbed_ms) / 1000) * 1000;
    move(held.edge, by, held);
  };
  const release = () => {
    dragged.current = null;
  };
  const key = (edge: Edge) => (event: TargetedKeyboardEvent<HTMLElement>) => {
    const step = event.shiftKey ? 10_000 : event.altKey ? ROW_MS : 1000;
    const moves: Record<string, number> = {
      ArrowLeft: -step,
      ArrowDown: -step,
      ArrowRight: step,
      ArrowUp: step,
      PageUp: 30_000,
      PageDown: -30_000,
      Home: -span,
      End: span,
    };
    const by = moves[event.key];
    if (by === undefined) return;
    event.preventDefault();
    move(edge, by);
  };
  const slider = (edge: Edge, now: number, label: string) => (
    <div
      role="slider"
      tabIndex={0}
      class={`grip grip-${edge}`}
      aria-label={label}
      aria-valuemin={0}
      aria-valuemax={Math.round((most - least) / 1000)}
      aria-valuenow={Math.round((now - least) / 1000)}
      aria-valuetext={`${rowClock(now)} UTC`}
      style={edge === "both" ? { left: place(first), right: `calc(100% - ${place(last)})` } : { left: place(now) }}
      onPointerDown={grab(edge)}
      onPointerMove={drag}
      onPointerUp={release}
      onPointerCancel={release}
      onKeyDown={key(edge)}
    />
  );
  const refusal = refusalOf(draft.chosen.value);
  const seen = within(window, first, last);
  return (
    <div class="session-bar">
      <div class="session-window" ref={bar}>
        <div class="session-profile" style={{ left: place(rise), right: `calc(100% - ${place(set)})` }}>
          <Profile pass={window} />
        </div>
        <div class="session-out" style={{ left: 0, width: place(first) }} />
        <div class="session-out" style={{ right: 0, width: `calc(100% - ${place(last)})` }} />
        {refusal?.offered && (
          <div
            class="offered"
            style={{
              left: place(Date.parse(refusal.offered.start)),
              right: `calc(100% - ${place(Date.parse(refusal.offered.stop))})`,
            }}
          />
        )}
        {refusal?.at && <div class="refused-at" style={{ left: place(Date.parse(refusal.at)) }} />}
        {slider("both", first, text.whole)}
        {slider("start", first, text.start)}
        {slider("stop", last, text.stop)}
      </div>
      <div class="session-scale" aria-hidden="true">
        <span>{rowClock(left)}</span>
        <span>{rowClock(left + span)}</span>
      </div>
      <p class="session-told">
        <b>{period(start, stop)}</b>
        {` · ${words.value.plan.windows.seconds(number((last - first) / 1000, 1))} · ${(window.place ? text.elevation : text.aboveLimb)(number(seen.least, 0), number(seen.most, 0))}`}
        {seen.light && ` · ${words.value.plan.windows.lights[seen.light]}`}
        {seen.sample !== null && ` · ${text.sample(number(seen.sample, 2))}`}
      </p>
      <p class="hint">{text.keys}</p>
    </div>
  );
}

/** What a session in the window sees, by the window's samples. */
function within(window: Window, first: number, last: number) {
  const { at, elevation_deg, ground_sample_along_m: along, ground_sample_across_m: across, sun_elevation_deg } = window.through;
  const times = at.map((instant) => Date.parse(instant));
  const inside = times.flatMap((ms, index) => (ms >= first && ms <= last ? [index] : []));
  const middle = (first + last) / 2;
  const nearest = times.reduce(
    (best, ms, index) => (Math.abs(ms - middle) < Math.abs((times[best] ?? 0) - middle) ? index : best),
    0,
  );
  const seen = inside.length ? inside : [nearest];
  const angles = seen.map((index) => elevation_deg[index] ?? 0);
  const samples = seen.map((index) => Math.max(along[index] ?? Infinity, across[index] ?? Infinity));
  const finest = Math.min(...samples);
  return {
    least: Math.min(...angles),
    most: Math.max(...angles),
    sample: window.place && Number.isFinite(finest) ? finest : null,
    light: lightOf(sun_elevation_deg[nearest]),
  };
}
