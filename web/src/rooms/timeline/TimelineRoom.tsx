/** The days of everybody's work: plans, windows, shadow and conflicts over time, and their ground track. */
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { save } from "../../api/download";
import { covered, type Orbit } from "../../api/orbit";
import { Problem } from "../../api/problem";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { fetchTrack, type Track } from "../../map/track";
import { ChoiceField } from "../../parts/ChoiceField";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { UtcField } from "../../parts/UtcField";
import type { RoomProps } from "../../room";
import { place } from "../../router";
import { calendarOf, type Event, sessionsOf } from "./calendar";
import { DaysMap } from "./DaysMap";
import { fetchKept, type Kept, latest, nearest } from "./kept";
import { Lanes, told } from "./Lanes";
import {
  around,
  type By,
  type Conflict,
  carrierOf,
  conflictsOf,
  DAY_MS,
  type Lane,
  lanesOf,
  moved,
  type Span,
  wholeDays,
  zoomed,
} from "./lanes";
import "./timeline.css";

const QUIET_MS = 250; // a drag isn't yet a wish
const CONFLICTS_SHOWN = 30;

/** As the address has it. */
function spanAsked(): Span | null {
  const [from, to] = ["from", "to"].map((name) => Date.parse(place.value.query.get(name) ?? ""));
  return from !== undefined && to !== undefined && to > from ? [from, to] : null;
}

export default function TimelineRoom(_: RoomProps) {
  const text = words.value;
  const [span, setSpan] = useState(spanAsked);
  const first = useRequest(span ? null : "first", async (until) => {
    const found = await latest(until);
    const day = around(found.slice(0, 1));
    setSpan((before) => before ?? (day ? wholeDays(day) : wholeDays([Date.now(), Date.now() + DAY_MS])));
    return found.length;
  });
  return (
    <div class="room">
      <h1>{text.shell.rooms.timeline}</h1>
      {first.error !== null && <ProblemNotice error={first.error} again={() => void first.ask()} />}
      {span === null && first.error === null && <p class="loading">{text.shell.loading}</p>}
      {span && <Timeline span={span} onSpan={setSpan} />}
    </div>
  );
}

function Timeline({ span, onSpan }: { span: Span; onSpan: (span: Span) => void }) {
  const text = words.value.timeline;
  const [from_ms, to_ms] = span;
  const [by, setBy] = useState<By>("carrier");
  const [now_ms, setNow] = useState<number | null>(null);
  const [chosen, setChosen] = useState("");
  const days = useQuietly(wholeDays(span), QUIET_MS);
  const kept = useRequest<Kept>("kept", (until, show) => fetchKept(days, until, (answer) => show({ answer })), days.join());
  const blocks = kept.answer?.blocks ?? [];
  const lanes = useMemo(() => lanesOf(blocks, by, text.nobody), [kept.answer, by, text]);
  const carriers = useMemo(() => lanesOf(blocks, "carrier", ""), [kept.answer]);
  const conflicts = useMemo(() => conflictsOf(blocks), [kept.answer]);
  const orbits = orbitsOf(carriers, kept.answer, days);
  const tracks = useTracks(orbits, days);
  useEffect(() => {
    const query = new URLSearchParams(
      ["from", "to"].map((name, k) => [name, `${new Date(span[k] ?? 0).toISOString().slice(0, 19)}Z`]),
    );
    history.replaceState(null, "", `${location.pathname}?${query}`);
  }, [span]);
  const everything = useRequest<void>(null, async (until) => {
    const whole = around(await latest(until));
    if (whole) onSpan(whole);
  });
  const trackOf = (lane: Lane): Track | null => {
    const names = new Set(lane.blocks.map(carrierOf));
    const track = names.size === 1 ? tracks.get([...names][0] ?? "") : null;
    return track && !(track instanceof Problem) ? track : null;
  };
  const shownNow_ms = now_ms === null || now_ms < from_ms || now_ms > to_ms ? (from_ms + to_ms) / 2 : now_ms;
  const count = (lane: Lane) => lane.blocks.filter((one) => one.stop_ms > from_ms && one.start_ms < to_ms).length;
  const fullest = [...carriers].sort((one, other) => count(other) - count(one))[0] ?? null;
  const mapped = carriers.find((lane) => lane.name === chosen) ?? fullest;
  const refusals = [...tracks].flatMap(([name, track]) =>
    track instanceof Problem ? [{ name, why: words.value.service.told(track.document.detail) }] : [],
  );
  const middle_ms = (from_ms + to_ms) / 2;
  const about = (length_ms: number) => onSpan([middle_ms - length_ms / 2, middle_ms + length_ms / 2]);
  const showAll = () => void everything.ask();
  const shown = blocks.filter((one) => one.stop_ms > from_ms && one.start_ms < to_ms);
  const windows = (kept.answer?.windows ?? []).filter((one) => one.stop_ms > from_ms && one.start_ms < to_ms);
  return (
    <>
      <div class="panel timeline-tools">
        <div class="row">
          <button type="button" aria-label={text.earlier} onClick={() => onSpan(moved(span, -0.5))}>
            ‹
          </button>
          <button type="button" aria-label={text.later} onClick={() => onSpan(moved(span, 0.5))}>
            ›
          </button>
          <button type="button" aria-label={text.closer} onClick={() => onSpan(zoomed(span, middle_ms, 2))}>
            +
          </button>
          <button type="button" aria-label={text.farther} onClick={() => onSpan(zoomed(span, middle_ms, 0.5))}>
            −
          </button>
          <button type="button" onClick={() => about(DAY_MS)}>
            {text.day}
          </button>
          <button type="button" onClick={() => about(7 * DAY_MS)}>
            {text.week}
          </button>
          <button type="button" onClick={showAll}>
            {text.all}
          </button>
        </div>
        <UtcField
          label={text.from}
          value={new Date(from_ms).toISOString()}
          onValue={(value) => Date.parse(value) < to_ms && onSpan([Date.parse(value), to_ms])}
        />
        <UtcField
          label={text.to}
          value={new Date(to_ms).toISOString()}
          onValue={(value) => Date.parse(value) > from_ms && onSpan([from_ms, Date.parse(value)])}
        />
        <ChoiceField label={text.by} value={by} choices={["carrier", "owner"]} told={(one) => text.lanes[one]} onValue={setBy} />
        <Calendar kept={kept.answer} span={span} tracks={tracks} />
      </div>
      {kept.error !== null && <ProblemNotice error={kept.error} again={() => void kept.ask()} />}
      {everything.error !== null && <ProblemNotice error={everything.error} again={showAll} />}
      {kept.answer?.isCut && <p class="notice">{text.cut}</p>}
      <div class="panel lanes-panel" aria-busy={kept.isAsking}>
        <Lanes
          span={span}
          lanes={lanes}
          windows={windows}
          conflicts={conflicts}
          trackOf={trackOf}
          now_ms={shownNow_ms}
          onNow={setNow}
          onSpan={onSpan}
          onAll={showAll}
        />
        {kept.answer && !kept.isAsking && shown.length === 0 && windows.length === 0 && (
          <p class="lanes-empty">
            {text.nothing}{" "}
            <button type="button" class="small-button" onClick={showAll}>
              {text.all}
            </button>
          </p>
        )}
        <Legend />
        <p class="hint lanes-hint">{text.hint}</p>
      </div>
      {refusals.map(({ name, why }) => (
        <p key={name} class="small">
          {text.noTrack(name, why)}
        </p>
      ))}
      {orbits
        .filter(({ span: has }) => has === null || has[0] > from_ms || has[1] < to_ms)
        .map(({ name, span: has }) => (
          <p key={name} class="small">
            {has ? text.covers(name, told({ start_ms: has[0], stop_ms: has[1] })) : text.coversNothing(name)}
          </p>
        ))}
      {kept.answer && <Conflicts conflicts={conflicts.filter((one) => one.stop_ms > from_ms && one.start_ms < to_ms)} />}
      <DaysMap
        span={span}
        now_ms={shownNow_ms}
        lanes={carriers}
        lane={mapped}
        onLane={setChosen}
        track={mapped && trackOf(mapped)}
      />
    </>
  );
}

/** Once it has stayed the same for a while. */
function useQuietly(value: Span, quiet_ms: number): Span {
  const [settled, setSettled] = useState(value);
  useEffect(
    () => {
      const timer = setTimeout(() => setSettled(value), quiet_ms);
      return () => clearTimeout(timer);
    },
    value as unknown as number[],
  );
  return settled;
}

interface Known {
  name: string;
  orbit: Orbit;
  /** What the orbit covers of the days; null for nothing of them. */
  span: Span | null;
}

/** Of each satellite the orbit of its plans that is nearest in time. */
function orbitsOf(carriers: readonly Lane[], kept: Kept | null, days: Span): Known[] {
  const middle_ms = (days[0] + days[1]) / 2;
  return carriers.flatMap((lane) => {
    const known = lane.blocks.flatMap((one) => kept?.orbits.get(one.id) ?? []);
    const orbit = nearest(known, middle_ms);
    return orbit ? [{ name: lane.name, orbit, span: covered(orbit, days) }] : [];
  });
}

/** Ground track and shadow of each satellite, for as long as its orbit is known. */
function useTracks(orbits: readonly Known[], days: Span): Map<string, Track | Problem> {
  const found = useRequest<Map<string, Track | Problem>>(
    "tracks",
    async (until) => {
      const made = new Map<string, Track | Problem>();
      for (const { name, orbit, span } of orbits) {
        const track = span && (await fetchTrack(orbit, span, 60, until));
        if (track) made.set(name, track);
      }
      return made;
    },
    JSON.stringify([orbits, days]),
  );
  return found.answer ?? new Map();
}

function Legend() {
  const { key, eclipse } = words.value.timeline;
  return (
    <p class="lanes-legend">
      {(["slew", "session", "wait", "spacecraft", "window", "conflict", "open"] as const).map((one) => (
        <span key={one}>
          <i class={`lanes-key lanes-key-${one}`} /> {key[one]}
        </span>
      ))}
      <span>
        <i class="lanes-key lanes-key-shadow" /> {eclipse}
      </span>
    </p>
  );
}

function Conflicts({ conflicts }: { conflicts: readonly Conflict[] }) {
  const text = words.value.timeline;
  if (conflicts.length === 0) return <p class="small">{text.noConflicts}</p>;
  const name = (one: Conflict["one"]) =>
    [one.name || text.unnamed, one.owner && `(${text.ownedBy(one.owner)})`].filter(Boolean).join(" ");
  return (
    <section class="panel conflicts" aria-label={text.conflicts(conflicts.length)}>
      <h2>{text.conflicts(conflicts.length)}</h2>
      <ul>
        {conflicts.slice(0, CONFLICTS_SHOWN).map((one) => (
          <li key={one.one.id + one.other.id}>
            <Link to={one.one.to}>{name(one.one)}</Link> {text.and} <Link to={one.other.to}>{name(one.other)}</Link>:{" "}
            {text.conflictTold(carrierOf(one.one), told(one))}
          </li>
        ))}
        {conflicts.length > CONFLICTS_SHOWN && <li>{text.furtherConflicts(conflicts.length - CONFLICTS_SHOWN)}</li>}
      </ul>
    </section>
  );
}

interface CalendarProps {
  kept: Kept | null;
  span: Span;
  tracks: ReadonlyMap<string, Track | Problem>;
}

/** Saves all that is shown as one calendar. */
function Calendar({ kept, span: [from_ms, to_ms], tracks }: CalendarProps) {
  const text = words.value.timeline;
  const stamp = useRef(Date.now());
  const isIn = (one: { start_ms: number; stop_ms: number }) => one.stop_ms > from_ms && one.start_ms < to_ms;
  const saving = useRequest<void>(null, async (until) => {
    const blocks = (kept?.blocks ?? []).filter((one) => isIn(one) && one.state === "done");
    const sessions = await sessionsOf(
      blocks.filter((one) => one.kind !== "spacecraft"),
      until,
    );
    const others: Event[] = [
      ...blocks
        .filter((one) => one.kind === "spacecraft")
        .map((one) => ({ uid: one.id, ...one, summary: `${one.name || text.unnamed}, ${one.platform}`, description: told(one) })),
      ...(kept?.windows ?? []).filter(isIn).map((one) => ({
        uid: `window-${one.start_ms}-${one.target.replace(/[^\w.-]/g, "_")}`,
        ...one,
        summary: `${text.key.window}: ${one.target}`,
        description: told(one),
      })),
      ...[...tracks].flatMap(([name, track]) =>
        track instanceof Problem
          ? []
          : track.eclipses
              .map(({ start, stop }) => ({ start_ms: Date.parse(start), stop_ms: Date.parse(stop) }))
              .filter(isIn)
              .map((one) => ({
                uid: `shadow-${one.start_ms}-${name.replace(/[^\w.-]/g, "_")}`,
                ...one,
                summary: `${text.eclipse}: ${name}`,
                description: told(one),
              })),
      ),
    ];
    const content = calendarOf([...sessions, ...others], stamp.current);
    const days = [from_ms, to_ms].map((one) => new Date(one).toISOString().slice(0, 10)).join("_");
    save(new Blob([content], { type: "text/calendar" }), `slewtrack_${days}.ics`);
  });
  return (
    <>
      <button type="button" disabled={!kept || saving.isAsking} onClick={() => void saving.ask()}>
        {text.calendar}
      </button>
      {saving.error !== null && <ProblemNotice error={saving.error} />}
    </>
  );
}
