/** Work that may take longer: sent off, followed by its events, fetched when it is done. */
import { type Given, postForAnswer, send, url } from "./client";
import { follow } from "./events";
import { Problem, type ProblemDocument } from "./problem";
import type { paths } from "./schema";

export interface Progress {
  state: "queued" | "running";
  stage: string | null;
  percent: number | null;
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
    const { state, stage, percent, problem } = event.data;
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
      };
    }
    tell(now);
  }
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
