/** Work kept over some days: plans, passes of campaigns, imaging sessions, windows of searches. */
import { get, type Schemas, send } from "../../api/client";
import { type Orbit, reachOf, textOf } from "../../api/orbit";
import { isAbort, Problem } from "../../api/problem";
import { rfc3339 } from "../../i18n/forms";
import { targetTold } from "../../i18n/labels";
import type { Block, Seen, Span } from "./lanes";

type Job = Schemas["JobResponse"];

const PAGE = 200;
const PAGES = 3;
const WINDOWS = 1000;
const AT_A_TIME = 4;

export interface Kept {
  blocks: Block[];
  windows: Seen[];
  /** By the blocks' ids. */
  orbits: Map<string, Orbit>;
  /** There is more than was listed. */
  isCut: boolean;
}

/** Plans never change once they are made: each is asked for once. */
const known = new Map<string, { block: Partial<Block>; orbit: Orbit | null }>();

export async function fetchKept([from_ms, to_ms]: Span, until: AbortSignal, show: (kept: Kept) => void): Promise<Kept> {
  const query = { after: rfc3339(from_ms), before: rfc3339(to_ms), limit: PAGE };
  const [plans, sessions, campaigns, searches] = await Promise.all([
    all(async (cursor) => pageOf(await get("/v1/plans", { query: { ...query, cursor }, signal: until }), "plans")),
    all(async (cursor) => pageOf(await get("/v1/spacecraft/plans", { query: { ...query, cursor }, signal: until }), "plans")),
    all(async (cursor) => pageOf(await get("/v1/campaigns", { query: { ...query, cursor }, signal: until }), "campaigns")),
    all(async (cursor) =>
      pageOf(await get("/v1/opportunities", { query: { ...query, cursor }, signal: until }), "opportunities"),
    ),
  ]);
  const kept: Kept = {
    blocks: [...plans.jobs.map((job) => blockOf(job, "plan")), ...sessions.jobs.map((job) => blockOf(job, "spacecraft"))],
    windows: [],
    orbits: new Map(),
    isCut: [plans, sessions, campaigns, searches].some((one) => one.isCut),
  };
  show(kept);
  await inTurn(campaigns.jobs, async (job) => {
    kept.blocks.push(...(await passesOf(job, until)));
  });
  await inTurn(searches.jobs.filter(isAsked), async (job) => {
    kept.windows.push(...(await windowsOf(job, until)));
  });
  await inTurn(kept.blocks, async (block) => {
    const more = await detailsOf(block, until);
    if (!more) return;
    Object.assign(block, more.block);
    if (more.orbit) kept.orbits.set(block.id, more.orbit);
  });
  return { ...kept, blocks: kept.blocks.filter((one) => one.stop_ms > from_ms && one.start_ms < to_ms) };
}

/** Plans and imaging sessions of any time, the latest made first. */
export async function latest(until: AbortSignal): Promise<Block[]> {
  const query = { limit: PAGE, state: "done" } as const;
  const [{ plans }, { plans: sessions }] = await Promise.all([
    get("/v1/plans", { query, signal: until }),
    get("/v1/spacecraft/plans", { query, signal: until }),
  ]);
  return [...plans.map((job) => blockOf(job, "plan")), ...sessions.map((job) => blockOf(job, "spacecraft"))];
}

function pageOf<N extends string>(answer: Record<N, Job[]> & { next: string | null }, name: N) {
  return { jobs: answer[name], next: answer.next };
}

/** The pages of a list one after the other, up to so many. */
async function all(page: (cursor?: string) => Promise<{ jobs: Job[]; next: string | null }>) {
  const jobs: Job[] = [];
  let cursor: string | undefined;
  for (let number = 0; number < PAGES; number++) {
    const { jobs: some, next } = await page(cursor);
    jobs.push(...some);
    if (next === null) return { jobs, isCut: false };
    cursor = next;
  }
  return { jobs, isCut: true };
}

function blockOf(job: Job, kind: Block["kind"]): Block {
  return {
    id: job.id,
    kind,
    to: `${kind === "spacecraft" ? "/spacecraft" : ""}/plans/${job.id}`,
    name: job.name || job.targets.slice(0, 3).join(", "),
    owner: job.requested_by,
    platform: job.platform ?? "",
    carrier: "",
    state: job.state,
    revises: job.revises,
    probability: job.probability_in_frame,
    start_ms: Date.parse(job.start ?? job.created),
    stop_ms: Date.parse(job.stop ?? job.created),
    stretches: [],
  };
}

async function passesOf(job: Job, until: AbortSignal): Promise<Block[]> {
  const campaign = await orGone(get("/v1/campaigns/{id}", { id: job.id, signal: until }));
  if (!campaign) return [];
  const made = campaign.passes.filter((pass) => pass.state !== "refused" && pass.state !== "failed");
  return made.map((pass) => ({
    ...blockOf(job, "pass"),
    id: pass.plan,
    to: `/plans/${pass.plan}`,
    name: `${job.name || pass.looks.map((look) => look.target).join(", ")}`,
    state: pass.state,
    revises: null,
    start_ms: Date.parse(pass.start),
    stop_ms: Date.parse(pass.stop),
  }));
}

/** Not the one that the form leaves behind, of whatever it was last asked for. */
function isAsked({ name, targets }: Job): boolean {
  return name !== "" || targets.join() !== "target";
}

async function windowsOf(job: Job, until: AbortSignal): Promise<Seen[]> {
  const given = { id: job.id, query: { limit: WINDOWS, include: "view" }, signal: until };
  const found = await orGone(get("/v1/opportunities/{id}", given));
  return ((found?.windows ?? []) as Required<Schemas["WindowOut"]>[]).map((one) => ({
    search: job.name || job.targets.slice(0, 3).join(", "),
    platform: job.platform ?? "",
    target: one.target,
    highest_deg: one.highest_deg,
    to:
      one.session &&
      `/?${new URLSearchParams({ search: job.id, target: one.target, start: one.session.start, stop: one.session.stop })}`,
    inSpace: one.place === null,
    start_ms: Date.parse(one.rise),
    stop_ms: Date.parse(one.set),
  }));
}

/** Times of its table and the orbit it was planned with; null where it isn't made. */
async function detailsOf(block: Block, until: AbortSignal) {
  const before = known.get(block.id);
  if (before || block.state !== "done") return before ?? null;
  const path = block.kind === "spacecraft" ? "/v1/spacecraft/plans/{id}/request" : "/v1/plans/{id}/request";
  const given = { id: block.id, signal: until };
  const asked = (await orGone(send("GET", path, given).then((answer) => answer.json()))) as { orbit?: Orbit } | null;
  const orbit = asked?.orbit ?? null;
  const carrier = orbit ? nameOfCarrier(orbit) : "";
  const plan = block.kind === "spacecraft" ? null : await orGone(get("/v1/plans/{id}", given));
  const details = { block: plan && "table" in plan ? { carrier, ...timesOf(plan) } : { carrier }, orbit };
  known.set(block.id, details);
  return details;
}

function timesOf({ segments, summary }: Schemas["PlanResponse"]): Partial<Block> {
  const stretches = segments.map(({ kind, session, start, stop }) => {
    const of = summary.sessions.find((one) => one.session === session);
    const target = kind === "track" && of ? (of.name ?? of.id ?? targetTold(of.target)) : "";
    return { kind, target, start_ms: Date.parse(start), stop_ms: Date.parse(stop) };
  });
  const [first, last] = [stretches[0], stretches[stretches.length - 1]];
  return first && last ? { stretches, start_ms: first.start_ms, stop_ms: last.stop_ms } : { stretches };
}

/** "NORAD 25544", or as a message names it; plans of one satellite by several sources belong together. */
export function nameOfCarrier(orbit: Orbit): string {
  const text = textOf(orbit);
  const number = /^1 ([0-9A-Z]{5})/m.exec(text)?.[1] ?? /NORAD_CAT_ID\W+(\d+)/.exec(text)?.[1];
  if (number) return `NORAD ${number.replace(/^0+/, "")}`;
  return /OBJECT_NAME\W+([^\r\n<"]+)/.exec(text)?.[1]?.trim() ?? "";
}

/** Of these orbits the one made nearest to an instant. */
export function nearest(orbits: readonly Orbit[], at_ms: number): Orbit | null {
  const away = (orbit: Orbit) => Math.abs((reachOf(orbit)?.from_ms ?? Number.POSITIVE_INFINITY) - at_ms);
  return orbits.reduce<Orbit | null>((best, one) => (!best || away(one) < away(best) ? one : best), null);
}

/** Swaths and targets of a plan, as the service's GeoJSON has them. */
const maps = new Map<string, GeoJSON.FeatureCollection>();

export async function fetchMap(id: string, until: AbortSignal): Promise<GeoJSON.FeatureCollection | null> {
  const found = maps.get(id);
  if (found) return found;
  const given = { id, query: { format: "geojson" }, headers: { Accept: "*/*" }, signal: until };
  const map = (await orGone(
    send("GET", "/v1/plans/{id}/view", given).then((answer) => answer.json()),
  )) as GeoJSON.FeatureCollection | null;
  if (map) maps.set(id, map);
  return map;
}

/** null for what the service refuses by now: deleted in the meantime, say. */
async function orGone<T>(asked: Promise<T>): Promise<T | null> {
  try {
    return await asked;
  } catch (error) {
    if (!isAbort(error) && error instanceof Problem) return null;
    throw error;
  }
}

/** A few at a time, so that others who ask get their turn. */
export async function inTurn<T>(items: readonly T[], work: (item: T) => Promise<void>): Promise<void> {
  const left = [...items];
  const one = async () => {
    for (let item = left.shift(); item !== undefined; item = left.shift()) await work(item);
  };
  await Promise.all(Array.from({ length: AT_A_TIME }, one));
}
