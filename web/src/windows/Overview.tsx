/** Passes as bars over time: height is the greatest elevation, or height above the limb; colour the light. */
import { words } from "../i18n";
import { dayOfYear, instant, number } from "../i18n/forms";
import { lightOf, type Pass } from "./sight";
import "./windows.css";

const DAY_MS = 86_400_000;
const HALF_TURN_DEG = 180;
const LIGHTS = ["day", "low", "twilight", "night"] as const;

interface Props<P extends Pass> {
  passes: readonly P[];
  /** Whether it is the one that is chosen. */
  taken: (pass: P) => boolean;
  from_ms: number;
  to_ms: number;
  onTake: (pass: P) => void;
}

/** For the mouse alone: the keyboard has the list beside it. */
export function Overview<P extends Pass>({ passes, taken, from_ms, to_ms, onTake }: Props<P>) {
  const span = to_ms - from_ms;
  const place = (ms: number) => `${(100 * (ms - from_ms)) / span}%`;
  const firstMidnight = Math.ceil(from_ms / DAY_MS) * DAY_MS;
  const count = Math.max(0, Math.ceil((to_ms - firstMidnight) / DAY_MS));
  const inSpace = passes.length > 0 && passes.every((pass) => pass.place === null);
  const most_deg = inSpace ? HALF_TURN_DEG : HALF_TURN_DEG / 2;
  const midnights = Array.from({ length: count }, (_, day) => firstMidnight + day * DAY_MS);
  return (
    <div class="overview" aria-hidden="true">
      <div class="overview-bars">
        {midnights.map((at) => (
          <span key={at} class="midnight" style={{ left: place(at) }}>
            {dayOfYear(at)}
          </span>
        ))}
        {passes.map((pass, index) => (
          <button
            key={index}
            type="button"
            tabIndex={-1}
            class={`overview-bar light-${lightOf(pass.closest.sun_elevation_deg) ?? "space"} ${taken(pass) ? "taken" : ""}`}
            style={{
              left: place(Date.parse(pass.rise)),
              width: `max(5px, ${(100 * Date.parse(pass.set) - 100 * Date.parse(pass.rise)) / span}%)`,
              height: `${Math.max(6, (100 * Math.min(pass.highest_deg, most_deg)) / most_deg)}%`,
            }}
            title={`${instant(pass.rise)} · ${number(pass.highest_deg, 0)}°`}
            onClick={() => onTake(pass)}
          />
        ))}
      </div>
      <div class="legend">
        {inSpace && <span>{words.value.plan.windows.space}</span>}
        {(inSpace ? [] : LIGHTS).map((light) => (
          <span key={light}>
            <i class={`swatch light-${light}`} /> {words.value.plan.windows.lights[light]}
          </span>
        ))}
      </div>
    </div>
  );
}
