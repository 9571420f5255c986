/** Play, pause, speed and the slider over a plan's time, its stretches drawn on it. */
import { computed } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";

import { words } from "../i18n";
import { number } from "../i18n/forms";
import { cursor_s, isPlaying, speed } from "./cursor";
import { keepTime, moveTo, playOrPause, SPEEDS } from "./playback";
import "./time.css";

export interface Stretch {
  kind: string;
  /** Said and shown of it. */
  label: string;
  start_s: number;
  stop_s: number;
}

interface Props {
  epoch_ms: number;
  stop_s: number;
  stretches: readonly Stretch[];
  /** Keys are listened to in it, and where nothing has the focus. */
  within: () => HTMLElement | null;
  /** The cursor goes to its start; another object each time, so that the same may be taken again. */
  onStretch: (stretch: Stretch) => void;
}

const STEP_S = 0.2; // of the command table

export function TimeBar({ epoch_ms, stop_s, stretches, within, onStretch }: Props) {
  const text = words.value.viewer.time;
  useEffect(() => {
    const stopKeeping = keepTime(stop_s);
    return () => {
      isPlaying.value = false;
      stopKeeping();
    };
  }, [stop_s]);
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
      const at = event.target as HTMLElement;
      const isSlider = at instanceof HTMLInputElement && at.type === "range";
      const isOurs = at === document.body || at.tagName === "MAIN" || within()?.contains(at);
      if (!isOurs || (!isSlider && at.closest("input, select, textarea, button, a, summary, canvas"))) return;
      if (event.key === " ") playOrPause(stop_s);
      else if (event.key === "ArrowLeft") moveTo(cursor_s.value - (event.shiftKey ? 10 : 1), stop_s);
      else if (event.key === "ArrowRight") moveTo(cursor_s.value + (event.shiftKey ? 10 : 1), stop_s);
      else if (event.key === "Home") moveTo(0, stop_s);
      else if (event.key === "End") moveTo(stop_s, stop_s);
      else return;
      event.preventDefault();
    };
    document.addEventListener("keydown", onKey);
    return () => document.removeEventListener("keydown", onKey);
  }, [stop_s, within]);
  return (
    <div class="timebar" role="group" aria-label={text.bar}>
      <button
        type="button"
        class="timebar-play"
        aria-label={isPlaying.value ? text.pause : text.play}
        onClick={() => playOrPause(stop_s)}
      >
        <svg viewBox="0 0 16 16" width={16} height={16} aria-hidden="true">
          <path d={isPlaying.value ? "M3 2h3.6v12H3zM9.4 2H13v12H9.4z" : "M3.5 1.5 14 8 3.5 14.5z"} fill="currentColor" />
        </svg>
      </button>
      <select
        aria-label={text.speed}
        value={String(speed.value)}
        onChange={(event) => {
          speed.value = Number(event.currentTarget.value);
        }}
      >
        {SPEEDS.map((one) => (
          <option key={one} value={String(one)}>
            {one}×
          </option>
        ))}
      </select>
      <Now epoch_ms={epoch_ms} />
      <div class="timebar-track">
        <Stretches stretches={stretches} stop_s={stop_s} onStretch={onStretch} />
        <Slider epoch_ms={epoch_ms} stop_s={stop_s} stretches={stretches} />
      </div>
    </div>
  );
}

function Now({ epoch_ms }: { epoch_ms: number }) {
  const now = useMemo(
    () => ({
      clock: computed(() => new Date(epoch_ms + 1000 * cursor_s.value).toISOString().slice(11, 21)),
      since: computed(() => `+${number(cursor_s.value, 1)} s`),
    }),
    [epoch_ms],
  );
  return (
    <span class="timebar-now">
      <b>{now.clock}</b> UTC <span class="timebar-since">{now.since}</span>
    </span>
  );
}

function Slider({ epoch_ms, stop_s, stretches }: Omit<Props, "within" | "onStretch">) {
  const text = words.value.viewer.time;
  const now_s = cursor_s.value;
  const here = stretches.find((one) => now_s < one.stop_s) ?? stretches[stretches.length - 1];
  const clock = new Date(epoch_ms + 1000 * now_s).toISOString().slice(11, 19);
  return (
    <input
      type="range"
      aria-label={text.slider}
      aria-valuetext={`${clock} UTC, ${here?.label ?? ""}`}
      min={0}
      max={stop_s}
      step={STEP_S}
      value={now_s}
      onInput={(event) => moveTo(event.currentTarget.valueAsNumber, stop_s)}
    />
  );
}

function Stretches({ stretches, stop_s, onStretch }: Pick<Props, "stretches" | "stop_s" | "onStretch">) {
  const text = words.value.viewer.time;
  return (
    <div class="timebar-stretches">
      {stretches.map((one) => (
        <button
          key={one.start_s}
          type="button"
          class={`stretch stretch-${one.kind}`}
          title={text.zoomTo(one.label)}
          aria-label={text.zoomTo(one.label)}
          style={{ flexGrow: String((one.stop_s - one.start_s) / stop_s) }}
          onClick={() => {
            onStretch({ ...one });
            moveTo(one.start_s, stop_s);
          }}
        >
          <span aria-hidden="true">{one.label}</span>
        </button>
      ))}
    </div>
  );
}
