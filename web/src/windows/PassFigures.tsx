/** One pass in a line: when, how high, in what light and how sharp. */
import { words } from "../i18n";
import { day, number, percent, rowClock } from "../i18n/forms";
import { Profile } from "./Profile";
import { lightOf, type Pass, quality, sample_m } from "./sight";
import "./windows.css";

export function PassFigures({ pass }: { pass: Pass }) {
  const text = words.value.plan.windows;
  const light = lightOf(pass.closest.sun_elevation_deg);
  const share = quality(pass);
  return (
    <>
      <span class="window-when">
        <b>{day(pass.rise)}</b> {rowClock(pass.rise)}–{rowClock(pass.set)}
      </span>
      <Profile pass={pass} />
      <span class="number">{number(pass.highest_deg, 0)}°</span>
      <span class={`light light-text-${light ?? "space"}`}>{light ? text.lights[light] : text.space}</span>
      {share !== null ? (
        <span class="quality" title={text.quality(percent(share, 0))}>
          <span class="meter">
            <i style={{ width: `${share * 100}%` }} />
          </span>
          {number(sample_m(pass), 2)} {text.metres}
        </span>
      ) : (
        <span class="quality">{text.seconds(number(pass.duration_s, 0))}</span>
      )}
    </>
  );
}
