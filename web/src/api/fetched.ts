/** What the service answers, fetched while it is shown. */
import { useEffect, useState } from "preact/hooks";

export interface Fetched<A> {
  /** null until it is there. */
  answer: A | null;
  error: unknown;
  again: () => void;
}

/** key: what the answer is of; fetched anew for another. */
export function useFetched<A>(key: string, fetch: (signal: AbortSignal) => Promise<A>): Fetched<A> {
  const [answer, setAnswer] = useState<A | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [tries, setTries] = useState(0);
  useEffect(() => {
    const wanted = new AbortController();
    setAnswer(null);
    setError(null);
    fetch(wanted.signal).then(
      (found) => wanted.signal.aborted || setAnswer(() => found),
      (caught: unknown) => wanted.signal.aborted || setError(caught),
    );
    return () => wanted.abort();
  }, [key, tries]);
  return { answer, error, again: () => setTries(tries + 1) };
}
