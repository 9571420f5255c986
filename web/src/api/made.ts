/** What a job makes, followed until it is made. */
import { useEffect, useState } from "preact/hooks";

import { remove } from "./client";
import { Cancelled, type Progress, untilDone } from "./job";
import { Problem, type ProblemDocument } from "./problem";

interface Job {
  state: string;
  problem?: ProblemDocument | null;
}

export interface Made<A> {
  /** As far as it is; null before the first answer. */
  answer: A | null;
  /** While it is at work. */
  progress: Progress | null;
  error: unknown;
  again: () => void;
  cancel: () => void;
}

const REFRESH_MS = 1500;

/** path: of the service, with the braces of the id; fetch: the answer as it stands now. */
export function useMade<A extends object>(
  path: string,
  id: string,
  fetch: (id: string, signal: AbortSignal) => Promise<A>,
): Made<A> {
  const [answer, setAnswer] = useState<A | null>(null);
  const [progress, setProgress] = useState<Progress | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [tries, setTries] = useState(0);
  useEffect(() => {
    const until = new AbortController();
    setAnswer(null);
    setProgress(null);
    setError(null);
    const follow = async () => {
      const first = await fetch(id, until.signal);
      if (!isAtWork(first)) return first;
      setAnswer(first);
      let asked_ms = Date.now();
      const tell = (now: Progress) => {
        setProgress(now);
        if (Date.now() - asked_ms < REFRESH_MS) return;
        asked_ms = Date.now();
        // Only to show how far it is: the end is told by the events.
        fetch(id, until.signal).then(setAnswer, () => {});
      };
      try {
        await untilDone({ path: path.replace("{id}", id), id }, tell, until.signal);
      } catch (caught) {
        // However the job ended, its own address tells it best, with what was made until then.
        if (!(caught instanceof Cancelled) && !(caught instanceof Problem)) throw caught;
      }
      return fetch(id, until.signal);
    };
    follow()
      .then((made) => {
        if (until.signal.aborted) return;
        const { state, problem } = made as Partial<Job>;
        setAnswer(made);
        setProgress(null);
        if (problem) setError(new Problem(problem));
        else if (state === "cancelled") setError(new Cancelled());
      })
      .catch((caught: unknown) => {
        if (until.signal.aborted) return;
        setProgress(null);
        setError(caught);
      });
    return () => until.abort();
  }, [path, id, tries]);
  return {
    answer,
    progress,
    error,
    again: () => setTries(tries + 1),
    cancel: () => void remove(path as "/v1/plans/{id}", { id }).catch(setError),
  };
}

function isAtWork(answer: object): boolean {
  const { state } = answer as Partial<Job>;
  return state === "queued" || state === "running";
}
