/** Asks the service: typed by its own schema, patient where it is busy or can't be reached. */
import { signal } from "@preact/signals";

import { address } from "../router";
import { askForKey, authorization } from "./key";
import { NoAnswer, Problem } from "./problem";
import type { components, paths } from "./schema";

export type Schemas = components["schemas"];

type Ok = 200 | 201 | 202;
type Operation<P extends keyof paths, M extends string> = paths[P] extends Record<M, infer O> ? O : never;
type JsonOf<A> = A extends { content: infer C } ? (C extends { "application/json": infer T } ? T : never) : never;
/** What an operation answers as JSON when all is well. */
export type Answered<P extends keyof paths, M extends "get" | "post"> =
  Operation<P, M> extends { responses: infer R } ? JsonOf<R[keyof R & Ok]> : never;

type PathsWith<M extends "get" | "post" | "delete"> = {
  [P in keyof paths]: paths[P] extends Record<M, { responses: unknown }> ? P : never;
}[keyof paths];

export interface Given {
  /** For the braces of the path. */
  id?: string;
  query?: Record<string, string | number | boolean | undefined>;
  headers?: Record<string, string>;
  signal?: AbortSignal;
  /** How often a busy service is asked, at most. */
  tries?: number;
}

export interface Waiting {
  left_s: number;
  /** What the service said; null where no answer came. */
  problem: Problem | null;
}

/** For the next try; null while nothing is waited for. */
export const waiting = signal<Waiting | null>(null);

const TRIES = 4;
const STORE_TRIES = 2; // a lock may end by itself, a full disk doesn't
const LONGEST_WAIT_S = 30;
export const BUSY = new Set([429, 503]);

export async function get<P extends PathsWith<"get">>(path: P, given: Given = {}): Promise<Answered<P, "get">> {
  return (await send("GET", path, given)).json() as Promise<Answered<P, "get">>;
}

/** body: an object, or a JSON text that goes out as it is. */
export async function post<P extends PathsWith<"post">>(
  path: P,
  body: object | string,
  given: Given = {},
): Promise<Answered<P, "post">> {
  return (await postForAnswer(path, body, given)).json() as Promise<Answered<P, "post">>;
}

/** The whole answer, for who needs its status or headers. */
export async function postForAnswer<P extends PathsWith<"post">>(
  path: P,
  body: object | string | FormData,
  given: Given = {},
): Promise<Response> {
  if (body instanceof FormData) return send("POST", path, given, body);
  const headers = { "Content-Type": "application/json", ...given.headers };
  const text = typeof body === "string" ? body : JSON.stringify(body);
  return send("POST", path, { ...given, headers }, text);
}

export async function remove<P extends PathsWith<"delete">>(path: P, given: Given = {}): Promise<Response> {
  return send("DELETE", path, given);
}

/** A path of the service by its template, ready for fetch or a link. */
export function url(path: string, { id, query }: Given = {}): string {
  const filled = path.replace(/\{\w+\}/g, () => encodeURIComponent(id ?? ""));
  const pairs = Object.entries(query ?? {}).filter(([, value]) => value !== undefined);
  const text = new URLSearchParams(pairs.map(([name, value]) => [name, String(value)])).toString();
  return address(filled) + (text && `?${text}`);
}

/** Any request; raises Problem for a refusal and NoAnswer where none came. */
export async function send(
  method: "GET" | "POST" | "DELETE",
  path: string,
  given: Given = {},
  body?: string | FormData,
): Promise<Response> {
  // Asked again only where that can't do anything twice.
  const mayRepeat = method === "GET" || "Idempotency-Key" in (given.headers ?? {});
  for (let attempt = 1; ; attempt++) {
    const answer = await once(method, url(path, given), given, body, mayRepeat && attempt < TRIES);
    if (answer?.ok) return answer;
    if (answer?.status === 401 && (await askForKey()) !== null) {
      attempt--;
      continue;
    }
    const problem = answer && (await Problem.of(answer));
    const tries = given.tries ?? (problem?.kind === "store-unavailable" ? STORE_TRIES : TRIES);
    if (problem && (!BUSY.has(problem.status) || problem.retryAfter_s === null || attempt >= tries)) {
      throw problem;
    }
    const wait_s = problem?.retryAfter_s ?? 2 ** (attempt - 1);
    if (problem && wait_s > LONGEST_WAIT_S) throw problem;
    await pause(wait_s, problem, given.signal);
  }
}

/** null: no answer, and it may be asked again. */
async function once(
  method: string,
  target: string,
  given: Given,
  body: string | FormData | undefined,
  mayRepeat: boolean,
): Promise<Response | null> {
  try {
    return await fetch(target, {
      method,
      headers: { Accept: "application/json, */*;q=0.5", ...authorization(), ...given.headers },
      body,
      signal: given.signal,
      cache: "no-cache",
    });
  } catch (error) {
    if (given.signal?.aborted) throw error;
    if (mayRepeat) return null;
    throw new NoAnswer(String(error));
  }
}

async function pause(wait_s: number, problem: Problem | null, until?: AbortSignal): Promise<void> {
  try {
    for (let left_s = Math.ceil(wait_s); left_s > 0; left_s--) {
      waiting.value = { left_s, problem };
      await new Promise<void>((resolve, reject) => {
        const timer = setTimeout(resolve, 1000);
        until?.addEventListener("abort", () => {
          clearTimeout(timer);
          reject(new DOMException("no longer wanted", "AbortError"));
        });
      });
    }
  } finally {
    waiting.value = null;
  }
}
