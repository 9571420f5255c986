/** The API key, in the memory of this tab only, and the question for it. */
import { signal } from "@preact/signals";

let secret: string | null = null;

export interface Wanted {
  /** Whether the last one was refused. */
  refused: boolean;
  answer: (key: string | null) => void;
}

/** Set while the service waits for a key; the shell shows the dialog. */
export const keyWanted = signal<Wanted | null>(null);
let asking: Promise<string | null> | null = null;

export function authorization(): Record<string, string> {
  return secret === null ? {} : { Authorization: `Bearer ${secret}` };
}

/** Ask the person once, however many answers wait for it; null when they don't want to say. */
export async function askForKey(): Promise<string | null> {
  asking ??= new Promise<string | null>((resolve) => {
    keyWanted.value = {
      refused: secret !== null,
      answer: (key) => {
        keyWanted.value = null;
        asking = null;
        if (key !== null) secret = key;
        resolve(key);
      },
    };
  });
  return asking;
}
