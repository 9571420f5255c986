/** The stretch of time that charts show together, and the buttons that change it. */
import { type Signal, useSignal } from "@preact/signals";
import { useLayoutEffect } from "preact/hooks";

import { words } from "../i18n";
import { cursor_s } from "../time/cursor";
import type { Stretch } from "../time/TimeBar";
import { type TimeRange, within, zoom } from "./TimeChart";

const AIR = 0.06; // of a stretch that is looked at closer, on either side
const LEAST_S = 2;
const CLOSER = 0.6;

/** All of the time, or a stretch of it; it goes along with the cursor. */
export function useTimeRange(stop_s: number, chosen: Stretch | null): Signal<TimeRange> {
  const range = useSignal<TimeRange>({ from_s: 0, to_s: stop_s });
  // Before it is painted: a zoom by hand comes after it.
  useLayoutEffect(() => {
    if (!chosen) range.value = { from_s: 0, to_s: stop_s };
    else {
      const length_s = chosen.stop_s - chosen.start_s;
      range.value = within(chosen.start_s - AIR * length_s, Math.max(length_s * (1 + 2 * AIR), LEAST_S), stop_s);
    }
  }, [chosen, stop_s]);
  useLayoutEffect(
    () =>
      cursor_s.subscribe((now_s) => {
        const { from_s, to_s } = range.peek();
        if (now_s < from_s || now_s > to_s) range.value = within(now_s - 0.1 * (to_s - from_s), to_s - from_s, stop_s);
      }),
    [stop_s],
  );
  return range;
}

interface Props {
  range: Signal<TimeRange>;
  stop_s: number;
  onWhole: () => void;
}

export function RangeButtons({ range, stop_s, onWhole }: Props) {
  const text = words.value.viewer.charts;
  return (
    <span class="range-buttons">
      <button type="button" aria-label={text.closer} onClick={() => zoom(range, cursor_s.peek(), CLOSER, stop_s)}>
        +
      </button>
      <button type="button" aria-label={text.farther} onClick={() => zoom(range, cursor_s.peek(), 1 / CLOSER, stop_s)}>
        −
      </button>
      <button
        type="button"
        onClick={() => {
          range.value = { from_s: 0, to_s: stop_s };
          onWhole();
        }}
      >
        {text.whole}
      </button>
    </span>
  );
}
