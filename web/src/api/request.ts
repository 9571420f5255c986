/** A request of a part of the page: asked while it is shown or by a button, aborted when it is left. */
import { useEffect, useRef, useState } from "preact/hooks";

import { remove } from "./client";
import { followed, type Progress } from "./job";

interface State<A> {
  /** As far as it is there; null before the first. */
  answer: A | null;
  error: unknown;
  isAsking: boolean;
  /** Of a job that is at work. */
  progress: Progress | null;
}

/** until: aborted when nobody waits any more; show: tells what is known before the end. */
export type How<A> = (until: AbortSignal, show: (part: Partial<State<A>>) => void) => Promise<A>;

export interface Requested<A> extends State<A> {
  /** Asks anew, or for something else that then stands in the answer's place. */
  ask: (how?: How<A>) => Promise<void>;
  /** Puts an error in its place. */
  fail: (error: unknown) => void;
}

/**
 * key: of what is shown, asked for at once and for each other key anew; null where only `ask` asks,
 * and each time forgets the answer before.  variant: asked anew for another, while the answer stands.
 */
export function useRequest<A>(key: string | null, how?: How<A>, variant = ""): Requested<A> {
  const begin = { of: key, answer: null, error: null, isAsking: key !== null, progress: null };
  const [state, setState] = useState<State<A> & { of: string | null }>(begin);
  const asking = useRef<AbortController | null>(null);
  const ask = async (by = how) => {
    asking.current?.abort();
    const wanted = new AbortController();
    asking.current = wanted;
    const show = (part: Partial<State<A>>) => {
      if (!wanted.signal.aborted) setState((before) => ({ ...(before.of === key ? before : begin), ...part }));
    };
    show({ error: null, isAsking: true, ...(key === null && { answer: null }) });
    try {
      if (by) show({ answer: await by(wanted.signal, show) });
    } catch (error) {
      show({ error });
    }
    show({ isAsking: false, progress: null });
  };
  useEffect(() => {
    if (key !== null) void ask();
    return () => asking.current?.abort();
  }, [key, variant]);
  // Until the effect has come, nothing is known of another key.
  return { ...(state.of === key ? state : begin), ask, fail: (error) => setState((before) => ({ ...before, error })) };
}

/** What a job makes, followed until it is made.  path: of the service, with the braces of the id. */
export function useJob<A extends object>(
  path: "/v1/plans/{id}" | "/v1/flights/{id}" | "/v1/campaigns/{id}" | "/v1/spacecraft/plans/{id}",
  id: string,
  fetch: (id: string, until: AbortSignal) => Promise<A>,
): Requested<A> & { cancel: () => void } {
  const job = useRequest<A>(`${path} ${id}`, (until, show) =>
    followed({ path: path.replace("{id}", id), id }, fetch, until, show),
  );
  return { ...job, cancel: () => void remove(path, { id }).catch(job.fail) };
}
