/** The windows of the next days: all at once as bars over time, and one by one. */
import { words } from "../../i18n";
import { clock, instant, number, percent } from "../../i18n/forms";
import { mayHelpAgain, ProblemNotice } from "../../parts/ProblemNotice";
import * as draft from "./draft";
import { Profile } from "./Profile";
import { SessionBar } from "./SessionBar";
import { SpanFields } from "./SpanFields";
import {
  found,
  isSearching,
  lightOf,
  quality,
  sample_m,
  searchAgain,
  searchError,
  sessionIn,
  type Window,
  windowNear,
  windowOf,
} from "./windows";
import { Problem } from "../../api/problem";

const DAY_MS = 86_400_000;

export function WindowsPanel() {
  const text = words.value.plan.windows;
  const now = found.value;
  const taken = now && windowOf(now.windows, draft.session.value);
  const near = now && windowNear(now.windows, draft.session.value);
  const error = searchError.value;
  const isTargets = error instanceof Problem && error.field?.startsWith("targets.0.target");
  return (
    <section class="panel" aria-label={text.title}>
      <div class="row heading">
        <h2>{text.title}</h2>
        <span role="status" class="soft">
          {isSearching.value ? text.searching : now ? text.count(now.windows.length) : ""}
        </span>
      </div>
      <SpanFields />
      {error !== null && !isTargets && (
        <ProblemNotice error={error} again={mayHelpAgain(error) ? searchAgain : undefined} />
      )}
      {now && now.windows.length === 0 && <p>{text.none}</p>}
      {now && now.windows.length > 0 && (
        <>
          <Overview windows={now.windows} taken={taken} />
          {near && <SessionBar window={near} />}
          <List windows={now.windows} taken={taken} />
        </>
      )}
      {now?.warnings.map((warning) => (
        <p key={warning} class="hint">
          {warning}
        </p>
      ))}
    </section>
  );
}

function take(window: Window): void {
  const times = sessionIn(window);
  if (times) draft.setTimes(times.start, times.stop);
}

/** Height is the greatest elevation, colour the light. */
function Overview({ windows, taken }: { windows: readonly Window[]; taken: Window | null }) {
  const text = words.value.plan.windows;
  const from = draft.from_ms.value;
  const span = draft.to_ms.value - from;
  const place = (ms: number) => `${(100 * (ms - from)) / span}%`;
  const firstMidnight = Math.ceil(from / DAY_MS) * DAY_MS;
  const count = Math.max(0, Math.ceil((from + span - firstMidnight) / DAY_MS));
  const midnights = Array.from({ length: count }, (_, day) => firstMidnight + day * DAY_MS);
  return (
    <div class="overview" aria-hidden="true">
      <div class="overview-bars">
        {midnights.map((at) => (
          <span key={at} class="midnight" style={{ left: place(at) }}>
            {instant(at).slice(5, 10)}
          </span>
        ))}
        {windows.map((window) => (
          <button
            key={window.rise + window.branch}
            type="button"
            tabIndex={-1}
            class={`overview-bar light-${lightOf(window.closest.sun_elevation_deg) ?? "space"} ${window === taken ? "taken" : ""}`}
            style={{
              left: place(Date.parse(window.rise)),
              width: `max(5px, ${(100 * Date.parse(window.set) - 100 * Date.parse(window.rise)) / span}%)`,
              height: `${Math.max(6, (100 * Math.min(window.highest_deg, 90)) / 90)}%`,
            }}
            title={`${instant(window.rise)} · ${number(window.highest_deg, 0)}°`}
            onClick={() => take(window)}
          />
        ))}
      </div>
      <div class="legend">
        {(["day", "low", "twilight", "night"] as const).map((light) => (
          <span key={light}>
            <i class={`swatch light-${light}`} /> {text.lights[light]}
          </span>
        ))}
      </div>
    </div>
  );
}

function List({ windows, taken }: { windows: readonly Window[]; taken: Window | null }) {
  const text = words.value.plan.windows;
  return (
    <ul class="window-list" aria-label={text.list} tabIndex={0}>
      {windows.map((window) => {
        const light = lightOf(window.closest.sun_elevation_deg);
        const sample = sample_m(window);
        const share = quality(window);
        return (
          <li key={window.rise + window.branch}>
            <button
              type="button"
              class="window"
              aria-pressed={window === taken}
              disabled={!window.session}
              onClick={() => take(window)}
            >
              <span class="window-when">
                <b>{instant(window.rise).slice(5, 10)}</b> {clock(window.rise)}–{clock(window.set)}
              </span>
              <Profile window={window} />
              <span class="number">{number(window.highest_deg, 0)}°</span>
              <span class={`light light-text-${light ?? "space"}`}>{light ? text.lights[light] : text.space}</span>
              {share !== null ? (
                <span class="quality" title={text.quality(percent(share, 0))}>
                  <span class="meter">
                    <i style={{ width: `${share * 100}%` }} />
                  </span>
                  {number(sample, 2)} {text.metres}
                </span>
              ) : (
                <span class="quality">{text.seconds(number(window.duration_s, 0))}</span>
              )}
            </button>
          </li>
        );
      })}
    </ul>
  );
}
