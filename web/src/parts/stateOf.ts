/** State that begins anew when its source changes. */
import { useState } from "preact/hooks";

/**
 * next: the state for a source, from the state before.  It is taken while rendering: an effect comes
 * after the paint, late on a loaded machine, and would undo what was typed in between.
 */
export function useStateOf<T>(source: unknown, next: (before?: T) => T) {
  const [state, setState] = useState<T>(() => next());
  const [seen, setSeen] = useState(source);
  if (seen !== source) {
    setSeen(() => source);
    setState(next);
  }
  return [state, setState] as const;
}
