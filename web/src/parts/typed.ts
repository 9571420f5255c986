/** The text being typed into a field, kept until the field is left. */
import type { TargetedEvent } from "preact";
import { useState } from "preact/hooks";

/** given: what is shown else; drawn anew, as while a slow machine loads, it doesn't undo what is typed. */
export function useTyped(given: string | number) {
  const [typed, setTyped] = useState<string | null>(null);
  return {
    value: typed ?? given,
    onInput: (event: TargetedEvent<HTMLInputElement>) => setTyped(event.currentTarget.value),
    onBlur: () => setTyped(null),
  };
}
