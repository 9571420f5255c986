/** Moves the cursor on while the plan plays. */
import { batch, effect } from "@preact/signals";

import { cursor_s, isPlaying, speed } from "./cursor";

export const SPEEDS = [1, 2, 5, 10, 20, 60] as const;

/** Until the returned function is called; at the plan's end it stops by itself. */
export function keepTime(stop_s: number): () => void {
  return effect(() => {
    if (!isPlaying.value) return;
    let last_ms = performance.now();
    let frame = requestAnimationFrame(step);
    function step(now_ms: number) {
      const next_s = cursor_s.peek() + ((now_ms - last_ms) / 1000) * speed.peek();
      last_ms = now_ms;
      if (next_s < stop_s) {
        cursor_s.value = next_s;
        frame = requestAnimationFrame(step);
      } else {
        batch(() => {
          cursor_s.value = stop_s;
          isPlaying.value = false;
        });
      }
    }
    return () => cancelAnimationFrame(frame);
  });
}

/** Plays or pauses; from the start again once it has come to the end. */
export function playOrPause(stop_s: number): void {
  if (!isPlaying.value && cursor_s.value >= stop_s) cursor_s.value = 0;
  isPlaying.value = !isPlaying.value;
}

export function moveTo(t_s: number, stop_s: number): void {
  cursor_s.value = Math.min(Math.max(t_s, 0), stop_s);
}
