/** Work that may take longer: sent off, followed by its events, fetched when it is done. */
import { type Given, postForAnswer, send } from "./client";
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

/** Sends a request off; raises Problem at once where the service refuses to take it. */
export function sendOff(
  path: JobPaths & keyof paths,
  request: object,
  query: Record<string, string> = {},
  until?: AbortSignal,
): Promise<Sent> {
  return sentTo(path, path, request, { query, signal: until });
}

/** Has a plan flown. */
export function sendOffFlights(plan: string, request: object): Promise<Sent> {
  return sentTo("/v1/plans/{id}/flights", "/v1/flights", request, { id: plan });
}

/** where: the address of what such jobs make. */
async function sentTo(path: JobPaths | "/v1/plans/{id}/flights", where: string, request: object, given: Given): Promise<Sent> {
  const headers = { Prefer: "respond-async", "Idempotency-Key": crypto.randomUUID() };
  const id = made(await postForAnswer(path, request, { ...given, headers }));
  return { path: `${where}/${id}`, id };
}

/** The id of what an answer made. */
function made(answer: Response): string {
  const { pathname } = new URL(answer.headers.get("Location") ?? "", answer.url);
  return pathname.slice(pathname.lastIndexOf("/") + 1);
}

/** Until it is done; raises Problem for a refusal or failure. */
export async function untilDone(
  sent: Sent,
  tell: (now: Progress) => void,
  until?: AbortSignal,
): Promise<void> {
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
