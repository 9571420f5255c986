/** The windows of the next days: all at once as bars over time, and one by one. */
import { Problem } from "../../api/problem";
import { words } from "../../i18n";
import { number, percent } from "../../i18n/forms";
import { isMode } from "../../map/modes";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { WindowList } from "../../windows/WindowList";
import * as draft from "./draft";
import { SessionBar } from "./SessionBar";
import { SpanFields } from "./SpanFields";
import {
  found,
  GOOD,
  isSearching,
  searchAgain,
  searchError,
  searchedOf,
  sessionIn,
  type Window,
  windowNear,
  windowOf,
} from "./windows";

export function WindowsPanel() {
  const text = words.value.plan.windows;
  const now = found.value;
  const target = draft.target.value;
  const taken = now && windowOf(now.windows, draft.session.value);
  const near = now && windowNear(now.windows, draft.session.value);
  const error = searchError.value;
  // Entries of these kinds tell it themselves.
  const isTold = ["ground", "star"].includes(draft.kind.value);
  const isTargets = isTold && error instanceof Problem && error.field?.startsWith("targets.0.target");
  return (
    <section class="panel" aria-label={text.title}>
      <div class="row heading">
        <h2>{text.title}</h2>
        <span role="status" class="soft">
          {isSearching.value ? text.searching : now ? text.count(now.windows.length) : ""}
        </span>
      </div>
      <SpanFields />
      {error !== null && !isTargets && <ProblemNotice error={error} again={searchAgain} />}
      {target && searchedOf(target) === null && (
        <p class="hint">
          {isMode(target.mode)
            ? words.value.plan.drawing.howTo[target.mode]
            : target.mode === "ground_path"
              ? text.onePoint
              : text.untimed}
        </p>
      )}
      {now?.unseen && <p>{text.none(now.unseen.closed_by, now.unseen.because, number(now.unseen.best_elevation_deg, 1))}</p>}
      {now && (
        <WindowList
          windows={now.windows}
          taken={taken}
          from_ms={draft.from_ms.value}
          to_ms={draft.to_ms.value}
          label={text.list}
          onTake={take}
          more={Chances}
          warnings={now.warnings}
        >
          {near && <SessionBar window={near} />}
          <Heads isInSpace={now.windows.every((window) => window.place === null)} />
        </WindowList>
      )}
    </section>
  );
}

function take(window: Window): void {
  const times = sessionIn(window);
  if (times) draft.setTimes(times.start, times.stop);
}

/** What the figures of the list are; the list's items tell it to those who hear them. */
function Heads({ isInSpace }: { isInSpace: boolean }) {
  const { heads } = words.value.plan.windows;
  const all = [heads.when, isInSpace ? heads.aboveLimb : heads.elevation, heads.light, isInSpace ? heads.length : heads.sample];
  return (
    <div class="window-heads" aria-hidden="true">
      {all.map((one, index) => (
        <span key={index}>{one}</span>
      ))}
    </div>
  );
}

function Chances({ probability_in_frame: inFrame, clear_probability: clear }: Window) {
  const text = words.value.plan.windows;
  return (
    <>
      {inFrame !== null && (
        <span class={`in-frame ${inFrame < GOOD ? "unlikely" : ""}`}>{text.inFrame(percent(inFrame, 0))}</span>
      )}
      {clear != null && <span>{text.clear(percent(clear, 0))}</span>}
    </>
  );
}
