/** Lanes of a timeline: who or what each is of, which plans get in each other's way, rows and ticks. */
export type Span = readonly [from_ms: number, to_ms: number];
export type By = "carrier" | "owner";

/** What a table does for a while. */
export interface Stretch {
  kind: string;
  /** The target it is of; empty for none. */
  target: string;
  start_ms: number;
  stop_ms: number;
}

/** A plan, kept or in the making. */
export interface Block {
  id: string;
  kind: "plan" | "pass" | "spacecraft";
  /** Its address on the page. */
  to: string;
  name: string;
  owner: string | null;
  platform: string;
  /** The satellite, as its orbit names it; empty until that is known. */
  carrier: string;
  state: string;
  /** The plan that it takes the place of. */
  revises: string | null;
  probability: number | null;
  start_ms: number;
  stop_ms: number;
  stretches: readonly Stretch[];
}

/** A stretch in which a target of a kept search can be seen. */
export interface Seen {
  search: string;
  /** Where the page plans it; null where no session fits into it. */
  to: string | null;
  platform: string;
  target: string;
  highest_deg: number;
  inSpace: boolean;
  start_ms: number;
  stop_ms: number;
}

export interface Lane {
  name: string;
  blocks: Block[];
}

export interface Conflict {
  one: Block;
  other: Block;
  start_ms: number;
  stop_ms: number;
}

/** By time, then the older plan first: ids of later ones sort after earlier ones. */
function before(one: Block, other: Block): number {
  return one.start_ms - other.start_ms || one.id.localeCompare(other.id);
}

const OPEN = new Set(["queued", "running"]);

/** Refused, failed and cancelled ones command nothing. */
export function commands(block: Block): boolean {
  return block.state === "done" || OPEN.has(block.state);
}

/** "iss-hrc, NORAD 25544". */
export function carrierOf({ platform, carrier }: Block): string {
  return [platform, carrier].filter(Boolean).join(", ");
}

/** Ids of plans whose place another one, made or in the making, has taken. */
export function replacedBy(blocks: readonly Block[]): ReadonlySet<string> {
  return new Set(blocks.flatMap((one) => (one.revises && one.state === "done" ? [one.revises] : [])));
}

export function lanesOf(blocks: readonly Block[], by: By, nobody: string): Lane[] {
  const lanes = new Map<string, Block[]>();
  for (const block of [...blocks].sort(before)) {
    const name = by === "carrier" ? carrierOf(block) : (block.owner ?? nobody);
    lanes.set(name, [...(lanes.get(name) ?? []), block]);
  }
  return [...lanes].map(([name, of]) => ({ name, blocks: of })).sort((a, b) => a.name.localeCompare(b.name));
}

/** Pairs of plans that command one platform at the same time; a revision takes the place of the one before. */
export function conflictsOf(blocks: readonly Block[]): Conflict[] {
  const replaced = replacedBy(blocks);
  const counted = blocks.filter((one) => commands(one) && !replaced.has(one.id)).sort(before);
  const found: Conflict[] = [];
  for (const [number, one] of counted.entries()) {
    for (const other of counted.slice(number + 1)) {
      if (other.start_ms >= one.stop_ms) break;
      if (carrierOf(one) !== carrierOf(other) || other.revises === one.id || one.revises === other.id) continue;
      found.push({ one, other, start_ms: other.start_ms, stop_ms: Math.min(one.stop_ms, other.stop_ms) });
    }
  }
  return found;
}

/** The row of each, so that none lies over another; wide_ms: what each needs at least, with its name. */
export function rowsOf(blocks: readonly { start_ms: number; stop_ms: number }[], wide_ms: readonly number[]): number[] {
  const ends: number[] = [];
  return blocks.map(({ start_ms, stop_ms }, number) => {
    const end_ms = Math.max(stop_ms, start_ms + (wide_ms[number] ?? 0));
    const free = ends.findIndex((end) => end <= start_ms);
    const row = free < 0 ? ends.length : free;
    ends[row] = end_ms;
    return row;
  });
}

const MINUTE_MS = 60_000;
const HOUR_MS = 60 * MINUTE_MS;
export const DAY_MS = 24 * HOUR_MS;
const STEPS_MS = [
  ...[1, 5, 10, 30].map((one) => 1000 * one),
  ...[1, 5, 10, 30].map((one) => MINUTE_MS * one),
  ...[1, 3, 6, 12].map((one) => HOUR_MS * one),
  ...[1, 2, 7, 28, 91, 365, 1826, 7305].map((one) => DAY_MS * one),
];

/** Whole times of day in a span, at most so many. */
export function ticksOf([from_ms, to_ms]: Span, most: number): { at_ms: number; step_ms: number }[] {
  const step_ms = STEPS_MS.find((one) => (to_ms - from_ms) / one <= most) ?? 36_525 * DAY_MS;
  const first = Math.ceil(from_ms / step_ms) * step_ms;
  const count = Math.max(0, Math.floor((to_ms - first) / step_ms) + 1);
  return Array.from({ length: count }, (_, k) => ({ at_ms: first + k * step_ms, step_ms }));
}

const SHORTEST_MS = 20_000;
const LONGEST_MS = 366 * DAY_MS;

/** Closer or further about an instant that stays where it is. */
export function zoomed([from_ms, to_ms]: Span, about_ms: number, factor: number): Span {
  const length_ms = Math.min(LONGEST_MS, Math.max(SHORTEST_MS, (to_ms - from_ms) / factor));
  const share = (about_ms - from_ms) / (to_ms - from_ms);
  return [about_ms - share * length_ms, about_ms + (1 - share) * length_ms];
}

export function moved([from_ms, to_ms]: Span, share: number): Span {
  const by_ms = share * (to_ms - from_ms);
  return [from_ms + by_ms, to_ms + by_ms];
}

/** Around all of them, with air; null without any. */
export function around(blocks: readonly { start_ms: number; stop_ms: number }[]): Span | null {
  if (blocks.length === 0) return null;
  const from_ms = Math.min(...blocks.map((one) => one.start_ms));
  const to_ms = Math.max(...blocks.map((one) => one.stop_ms));
  const air_ms = Math.max(0.05 * (to_ms - from_ms), 60_000);
  return [from_ms - air_ms, to_ms + air_ms];
}

/** Whole days around a span: what is asked of the service at a time. */
export function wholeDays([from_ms, to_ms]: Span): Span {
  return [Math.floor(from_ms / DAY_MS) * DAY_MS, Math.ceil(to_ms / DAY_MS) * DAY_MS];
}
