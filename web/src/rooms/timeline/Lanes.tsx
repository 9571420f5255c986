/** The timeline itself: lanes of plans over time, windows, shadow and conflicts; moved and zoomed by hand and by keys. */
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { words } from "../../i18n";
import { named, number, percent, period } from "../../i18n/forms";
import type { Track } from "../../map/track";
import { Link } from "../../parts/Link";
import {
  type Block,
  type Conflict,
  carrierOf,
  DAY_MS,
  type Lane,
  moved,
  replacedBy,
  rowsOf,
  type Seen,
  type Span,
  type Stretch,
  ticksOf,
  zoomed,
} from "./lanes";

interface Props {
  span: Span;
  lanes: readonly Lane[];
  windows: readonly Seen[];
  conflicts: readonly Conflict[];
  /** Of a lane's satellite. */
  trackOf: (lane: Lane) => Track | null;
  /** What other pictures show is of this instant. */
  now_ms: number;
  onNow: (at_ms: number) => void;
  onSpan: (span: Span) => void;
  /** To all that is kept. */
  onAll: () => void;
}

const TICK_PX = 92;
const LETTER_PX = 7.2;
const LEAST_PX = 8;
const ROW_PX = 24;
const WINDOW_ROWS = 5; // of windows with their names; more stand without
const SHADOW_MOST_MS = 8 * DAY_MS; // of more, bands would be a grey

export function Lanes({ span, lanes, windows, conflicts, trackOf, now_ms, onNow, onSpan, onAll }: Props) {
  const text = words.value.timeline;
  const box = useRef<HTMLDivElement>(null);
  const [wide_px, setWide] = useState(0);
  const held = useRef<{ x: number; span: Span; hasMoved: boolean } | null>(null);
  const latest = useRef(span);
  latest.current = span;
  const [from_ms, to_ms] = span;
  const timeAt = (clientX: number) => {
    const area = box.current?.getBoundingClientRect();
    const [from, to] = latest.current;
    return area ? from + ((clientX - area.left) / area.width) * (to - from) : from;
  };
  useEffect(() => {
    const element = box.current;
    if (!element) return;
    const watch = new ResizeObserver(() => setWide(element.clientWidth));
    watch.observe(element);
    const wheel = (event: WheelEvent) => {
      const isSideways = Math.abs(event.deltaX) > Math.abs(event.deltaY);
      if (!isSideways && !event.ctrlKey && !event.metaKey && !element.contains(document.activeElement)) return;
      event.preventDefault();
      if (isSideways) onSpan(moved(latest.current, event.deltaX / element.clientWidth));
      else onSpan(zoomed(latest.current, timeAt(event.clientX), event.deltaY < 0 ? 1.25 : 0.8));
    };
    element.addEventListener("wheel", wheel, { passive: false });
    return () => {
      watch.disconnect();
      element.removeEventListener("wheel", wheel);
    };
  }, []);
  const key = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const middle = (from_ms + to_ms) / 2;
    if (event.key === "ArrowLeft") onSpan(moved(span, event.shiftKey ? -1 : -0.1));
    else if (event.key === "ArrowRight") onSpan(moved(span, event.shiftKey ? 1 : 0.1));
    else if (event.key === "+" || event.key === "=") onSpan(zoomed(span, middle, 1.6));
    else if (event.key === "-") onSpan(zoomed(span, middle, 1 / 1.6));
    else if (event.key === "Home") onAll();
    else return;
    event.preventDefault();
  };
  const isDragged = () => held.current?.hasMoved === true;
  const at: Place = { span, wide_px, per_ms: wide_px / (to_ms - from_ms), isDragged };
  const named_ = period(new Date(from_ms).toISOString(), new Date(to_ms).toISOString());
  const [fromTold, toTold] = [named_.split("–")[0] ?? "", named_.split("–")[1] ?? ""];
  return (
    <section
      class="lanes"
      ref={box}
      role="group"
      tabIndex={0}
      aria-label={text.label(fromTold, toTold)}
      data-from={from_ms}
      data-to={to_ms}
      onKeyDown={key}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        held.current = { x: event.clientX, span, hasMoved: false };
      }}
      onPointerMove={(event) => {
        const from = held.current;
        if (!from || event.buttons === 0) {
          held.current = null;
          return onNow(timeAt(event.clientX));
        }
        const dx = event.clientX - from.x;
        if (Math.abs(dx) < 5 && !from.hasMoved) return;
        if (!from.hasMoved) event.currentTarget.setPointerCapture(event.pointerId);
        from.hasMoved = true;
        onSpan(moved(from.span, -dx / (box.current?.clientWidth ?? 1)));
      }}
      onPointerUp={() => {
        // After the click that may come of it.
        setTimeout(() => {
          held.current = null;
        });
      }}
    >
      <Ticks at={at} />
      {lanes.map((lane) => (
        <PlanLane key={lane.name} lane={lane} at={at} track={trackOf(lane)} conflicts={conflicts} />
      ))}
      <WindowLanes windows={windows} at={at} />
      <div class="lanes-now" style={{ left: `${100 * share(at, now_ms)}%` }} aria-hidden="true" />
    </section>
  );
}

interface Place {
  span: Span;
  wide_px: number;
  per_ms: number;
  isDragged: () => boolean;
}

/** What ends a drag is no click on what lies there. */
function endDrag(at: Place, event: Event): void {
  if (!at.isDragged()) return;
  event.preventDefault();
  event.stopPropagation();
}

function share({ span: [from_ms, to_ms] }: Place, at_ms: number): number {
  return (at_ms - from_ms) / (to_ms - from_ms);
}

/** Left and width of what lasts from one instant to another. */
function lie(at: Place, start_ms: number, stop_ms: number, least = "0px") {
  const left = Math.max(share(at, start_ms), -0.01);
  const right = Math.min(share(at, stop_ms), 1.01);
  return { left: `${100 * left}%`, width: `max(${least}, ${100 * Math.max(right - left, 0)}%)` };
}

function isIn({ span: [from_ms, to_ms] }: Place, { start_ms, stop_ms }: { start_ms: number; stop_ms: number }): boolean {
  return stop_ms > from_ms && start_ms < to_ms;
}

export function told({ start_ms, stop_ms }: { start_ms: number; stop_ms: number }): string {
  return period(new Date(start_ms).toISOString(), new Date(stop_ms).toISOString());
}

function Ticks({ at }: { at: Place }) {
  if (at.wide_px === 0) return <div class="lanes-ticks" />;
  const ticks = ticksOf(at.span, Math.max(2, at.wide_px / TICK_PX));
  return (
    <div class="lanes-ticks" aria-hidden="true">
      {ticks.map(({ at_ms, step_ms }, number) => {
        const iso = new Date(at_ms).toISOString();
        const isMidnight = at_ms % DAY_MS === 0;
        const clock = iso.slice(11, step_ms < 60_000 ? 19 : 16);
        return (
          <span key={at_ms} class={isMidnight ? "tick midnight-tick" : "tick"} style={{ left: `${100 * share(at, at_ms)}%` }}>
            {isMidnight || number === 0 ? iso.slice(0, 10) : clock}
            {number === 0 && !isMidnight && ` ${clock}`}
          </span>
        );
      })}
    </div>
  );
}

function Head({ children }: { children: ComponentChildren }) {
  return (
    <h2 class="lane-name">
      <span>{children}</span>
    </h2>
  );
}

interface LaneProps {
  lane: Lane;
  at: Place;
  track: Track | null;
  conflicts: readonly Conflict[];
}

function PlanLane({ lane, at, track, conflicts }: LaneProps) {
  const text = words.value.timeline;
  const blocks = lane.blocks.filter((one) => isIn(at, one));
  const rows = rowsOf(
    blocks,
    blocks.map(({ name }) => (LEAST_PX + 14 + Math.min(name.length, 24) * LETTER_PX) / (at.per_ms || 1)),
  );
  const replaced = replacedBy(lane.blocks);
  const high = Math.max(0, ...rows) + 1;
  const [from_ms, to_ms] = at.span;
  const shadows = track && to_ms - from_ms < SHADOW_MOST_MS ? track.eclipses : [];
  return (
    <div class="lane">
      <Head>{lane.name}</Head>
      <div class="lane-rows" style={{ height: `${high * ROW_PX}px` }}>
        {shadows.map(({ start, stop }) => {
          const shadow = { start_ms: Date.parse(start), stop_ms: Date.parse(stop) };
          if (!isIn(at, shadow)) return null;
          const style = lie(at, shadow.start_ms, shadow.stop_ms);
          return <span key={start} class="shadow" title={text.eclipseTold(told(shadow))} style={style} />;
        })}
        {conflicts
          .filter((one) => isIn(at, one) && lane.blocks.includes(one.one) && lane.blocks.includes(one.other))
          .map((one) => (
            <span
              key={one.one.id + one.other.id}
              class="clash"
              aria-hidden="true"
              style={lie(at, one.start_ms, one.stop_ms, "3px")}
            />
          ))}
        {blocks.map((block, number) => (
          <PlanBlock
            key={block.id}
            block={block}
            row={rows[number] ?? 0}
            at={at}
            isReplaced={replaced.has(block.id)}
            clashes={conflicts.flatMap(({ one, other }) => (one === block ? [other] : other === block ? [one] : []))}
          />
        ))}
      </div>
    </div>
  );
}

interface BlockProps {
  block: Block;
  row: number;
  at: Place;
  isReplaced: boolean;
  clashes: readonly Block[];
}

function PlanBlock({ block, row, at, isReplaced, clashes }: BlockProps) {
  const all = words.value;
  const text = all.timeline;
  const parts = [
    text.blockTold(block.name || text.unnamed, carrierOf(block), told(block), named(all.shell.states, block.state)),
    block.owner && text.ownedBy(block.owner),
    block.probability !== null && text.inFrame(percent(block.probability)),
    isReplaced && text.replaced,
    clashes.length > 0 && text.conflictsWith(clashes.map((one) => one.name || text.unnamed).join(", ")),
  ];
  const said = parts.filter(Boolean).join("; ");
  const wide_px = (Math.min(block.stop_ms, at.span[1]) - Math.max(block.start_ms, at.span[0])) * at.per_ms;
  const state = [
    wide_px < (block.name.length + 3) * LETTER_PX && "block-narrow",
    block.state !== "done" && "block-undone",
    block.state === "refused" || block.state === "failed" || block.state === "cancelled" ? "block-void" : "",
    isReplaced && "block-replaced",
    clashes.length > 0 && "block-clash",
  ];
  return (
    <div
      class={["block", `block-${block.kind}`, ...state].filter(Boolean).join(" ")}
      style={{ ...lie(at, block.start_ms, block.stop_ms, `${LEAST_PX}px`), top: `${row * ROW_PX + 2}px` }}
      onClickCapture={(event) => endDrag(at, event)}
      onDragStart={(event) => event.preventDefault()}
      title={said}
    >
      <Link to={block.to}>
        <span class="block-bar" aria-hidden="true">
          {block.stretches.map((one) => (
            <Part key={one.start_ms} of={block} part={one} />
          ))}
        </span>
        <span class="block-name" aria-hidden="true">
          {clashes.length > 0 && "⚠ "}
          {block.name || text.unnamed}
        </span>
        <span class="hidden">{said}</span>
      </Link>
    </div>
  );
}

function Part({ of, part }: { of: Block; part: Stretch }) {
  const length = of.stop_ms - of.start_ms || 1;
  const [left, wide] = [(part.start_ms - of.start_ms) / length, (part.stop_ms - part.start_ms) / length];
  return <i class={`part part-${part.kind}`} style={{ left: `${100 * left}%`, width: `${100 * wide}%` }} />;
}

function WindowLanes({ windows, at }: { windows: readonly Seen[]; at: Place }) {
  const text = words.value.timeline;
  const searches = [...new Set(windows.map((one) => one.search))];
  return (
    <>
      {searches.map((search) => {
        const shown = windows.filter((one) => one.search === search && isIn(at, one)).sort((a, b) => a.start_ms - b.start_ms);
        const name_ms = shown.map(({ target }) => (LEAST_PX + 10 + Math.min(target.length, 18) * LETTER_PX) / (at.per_ms || 1));
        const withNames = rowsOf(shown, name_ms);
        const isNamed = Math.max(0, ...withNames) < WINDOW_ROWS;
        const rows = isNamed ? withNames : rowsOf(shown, []);
        return (
          <div key={search} class="lane">
            <Head>{text.windowsOf(search || text.unnamed)}</Head>
            <ul class="lane-rows" style={{ height: `${(Math.max(0, ...rows) + 1) * ROW_PX}px` }}>
              {shown.map((one, k) => {
                const height = (one.inSpace ? text.aboveLimb : text.elevation)(number(one.highest_deg, 0));
                const about = text.windowTold(one.target, told(one), height);
                const said = one.to === null ? about : `${about}: ${text.planIt}`;
                const shownAs = (
                  <>
                    {isNamed && (
                      <span class="block-name" aria-hidden="true">
                        {one.target}
                      </span>
                    )}
                    <span class="hidden">{said}</span>
                  </>
                );
                return (
                  <li
                    key={`${one.target} ${one.start_ms}`}
                    class="seen block-narrow"
                    title={said}
                    style={{ ...lie(at, one.start_ms, one.stop_ms, "4px"), top: `${(rows[k] ?? 0) * ROW_PX + 2}px` }}
                    onClickCapture={(event) => endDrag(at, event)}
                    onDragStart={(event) => event.preventDefault()}
                  >
                    {one.to === null ? shownAs : <Link to={one.to}>{shownAs}</Link>}
                  </li>
                );
              })}
            </ul>
          </div>
        );
      })}
    </>
  );
}
