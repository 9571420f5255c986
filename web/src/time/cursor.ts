/** The instant that globe, charts and map show together. */
import { signal } from "@preact/signals";

/** Seconds since the plan's epoch. */
export const cursor_s = signal(0);
export const isPlaying = signal(false);
/** Seconds of the plan per second. */
export const speed = signal(1);
