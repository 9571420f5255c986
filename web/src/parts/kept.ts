/** Forms in the making, kept while the tab is open: a reload finds them as they were. */
import { signal } from "@preact/signals";
import { useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

const PREFIX = "slewtrack.";
const QUIET_MS = 100;

/** Whether a reload will find all that was typed. */
export const isKept = signal(true);

/** By name; not stored yet. */
const waiting = new Map<string, unknown>();
let pending = 0;

/** Stores a value once nothing more is typed for a moment, at the latest when the page is left. */
export function keep(name: string, value: unknown): void {
  waiting.set(name, value);
  clearTimeout(pending);
  pending = setTimeout(store, QUIET_MS) as unknown as number;
}

/** The value of a name; null for none. */
export function readKept(name: string): unknown {
  if (waiting.has(name)) return waiting.get(name);
  const text = sessionStorage.getItem(PREFIX + name);
  return text === null ? null : JSON.parse(text);
}

function store(): void {
  for (const [name, value] of waiting) {
    try {
      sessionStorage.setItem(PREFIX + name, JSON.stringify(value));
      isKept.value = true;
    } catch {
      isKept.value = false; // which the rooms say
    }
  }
  waiting.clear();
}

window.addEventListener("pagehide", store);

interface Begun {
  /** What the address wanted then; null for nothing. */
  from: string | null;
  value: unknown;
}

/** What was made of the same beginning, or of any where the address wants none; null for nothing. */
export function useBegun<T>(name: string, from: string | null): [T | null, (value: T) => void] {
  const found = useMemo(() => {
    const read = readKept(name) as Begun | null;
    return read && (from === null || read.from === from) ? (read.value as T | null) : null;
  }, [name, from]);
  return [found, (value) => keep(name, { from, value } satisfies Begun)];
}

/** State of a form's field: as it was left, unless the address wants another; else the first. */
export function useKept<T>(name: string, first: T, from: string | null = null) {
  const [found, keepIt] = useBegun<T>(name, from);
  const [value, setValue] = useState<T>(found ?? first);
  const shown = useRef(value);
  // As soon as it is shown, before a reload can come: what a room can't show is not kept.
  useLayoutEffect(() => {
    if (value !== shown.current) keepIt(value);
    shown.current = value;
  }, [value]);
  return [value, setValue] as const;
}
