/** Work that may take longer: sent off, followed by its events, fetched when it is done. */
import { type Given, postForAnswer, send, url } from "./client";
import { follow } from "./events";
import { Problem, type ProblemDocument } from "./problem";
import type { paths } from "./schema";

export interface Progress {
  state: "queued" | "running";
  stage: string | null;
  percent: number | null;
  /** Of a campaign's choice so far: its worth, and what none is worth more than, once that is proven. */
  value?: number;
  bound?: number;
}

export interface Sent {
  /** Address of the job and of what it makes, from the service's root: "/v1/plans/01J..." */
  path: string;
  id: string;
}

export type JobPaths = "/v1/plans" | "/v1/campaigns" | "/v1/spacecraft/plans";

/** What was asked when no answer came: with the same key it isn't made twice. */
let unanswered: { asked: string; key: string } | null = null;

/** Sends a request off; raises Problem at once where the service refuses to take it. */
export async function sendOff(
  path: JobPaths & keyof paths,
  request: object,
  query: Record<string, string> = {},
  until?: AbortSignal,
): Promise<Sent> {
  const id = await made(path, request, { query, signal: until });
  return { path: `${path}/${id}`, id };
}

/** What was asked with, as it was sent. */
export async function requestOf<R>(path: JobPaths & keyof paths, id: string, until: AbortSignal): Promise<R> {
  return (await send("GET", `${path}/{id}/request`, { id, signal: until })).json() as Promise<R>;
}

/** Has a plan flown. */
export async function sendOffFlights(plan: string, request: object, until?: AbortSignal): Promise<Sent> {
  const id = await made("/v1/plans/{id}/flights", request, { id: plan, signal: until });
  return { path: `/v1/flights/${id}`, id };
}

/** The id of what was made. */
async function made(path: JobPaths | "/v1/plans/{id}/flights", request: object, given: Given): Promise<string> {
  const asked = JSON.stringify([url(path, given), request]);
  const key = unanswered?.asked === asked ? unanswered.key : crypto.randomUUID();
  unanswered = { asked, key };
  const headers = { Prefer: "respond-async", "Idempotency-Key": key };
  let answer: Response;
  try {
    answer = await postForAnswer(path, request, { ...given, headers });
  } catch (error) {
    if (error instanceof Problem && error.status < 500) unanswered = null;
    throw error;
  }
  unanswered = null;
  const { pathname } = new URL(answer.headers.get("Location") ?? "", answer.url);
  return pathname.slice(pathname.lastIndexOf("/") + 1);
}

/** Until it is done; raises Problem for a refusal or failure. */
export async function untilDone(sent: Sent, tell: (now: Progress) => void, until?: AbortSignal): Promise<void> {
  let now: Progress = { state: "queued", stage: null, percent: null };
  for await (const event of follow(`${sent.path}/events`, until)) {
    const { state, stage, percent, problem, value, bound } = event.data;
    if (problem) throw new Problem(problem as ProblemDocument);
    if (state === "done") return;
    if (state === "cancelled") throw new Cancelled();
    if (state === "refused" || state === "failed") throw await endOf(sent);
    if (state === "queued" || state === "running") now = { ...now, state };
    if (event.kind === "progress") {
      now = {
        ...now,
        stage: typeof stage === "string" ? stage : now.stage,
        percent: typeof percent === "number" ? percent : now.percent,
        ...(typeof value === "number" && { value }),
        ...(typeof bound === "number" && { bound }),
      };
    }
    tell(now);
  }
}

const REFRESH_MS = 1500;

interface Job {
  state: string;
  problem?: ProblemDocument | null;
}

function isAtWork({ state }: Partial<Job>): boolean {
  return state === "queued" || state === "running";
}

/** What a job has made at its end, shown as far as it is until then; raises Problem or Cancelled where it came to nothing. */
export async function followed<A extends object>(
  sent: Sent,
  fetch: (id: string, until: AbortSignal) => Promise<A>,
  until: AbortSignal,
  show: (part: { answer?: A; progress?: Progress }) => void,
): Promise<A> {
  let answer = await fetch(sent.id, until);
  if (isAtWork(answer)) {
    show({ answer });
    let asked_ms = Date.now();
    const tell = (progress: Progress) => {
      show({ progress });
      if (Date.now() - asked_ms < REFRESH_MS) return;
      asked_ms = Date.now();
      // Only to show how far it is: the end is told by the events.
      fetch(sent.id, until).then(
        (answer) => show({ answer }),
        () => {},
      );
    };
    try {
      await untilDone(sent, tell, until);
    } catch (caught) {
      // However the job ended, its own address tells it best, with what was made until then.
      if (!(caught instanceof Cancelled) && !(caught instanceof Problem)) throw caught;
    }
    answer = await fetch(sent.id, until);
  }
  const { state, problem } = answer as Partial<Job>;
  if (problem || state === "cancelled") {
    show({ answer });
    throw problem ? new Problem(problem) : new Cancelled();
  }
  return answer;
}

export class Cancelled extends Error {}

/** Why a job came to nothing, as its own address tells. */
async function endOf(sent: Sent): Promise<Problem> {
  try {
    const answer = await send("GET", sent.path);
    const job = (await answer.json()) as { problem?: ProblemDocument };
    if (job.problem) return new Problem(job.problem);
  } catch (error) {
    if (error instanceof Problem) return error;
    throw error;
  }
  return new Problem({ type: "about:blank", title: "failed", status: 500, detail: sent.path, instance: "" });
}
