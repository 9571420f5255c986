/** All sessions on one line of time; where they conflict, what each way out would give up. */
import { batch } from "@preact/signals";

import type { Schemas } from "../../api/client";
import { CONFLICTS } from "../../api/lists";
import { words } from "../../i18n";
import { named, number, period, rfc3339 } from "../../i18n/forms";
import { ChoiceField } from "../../parts/ChoiceField";
import { Fields } from "../../parts/fields/Fields";
import type { Members } from "../../parts/fields/shape";
import { UtcField } from "../../parts/UtcField";
import * as draft from "./draft";
import { failure, refused } from "./refusal";
import { targetTold } from "./told";
import { searchedOf } from "./windows";

type Relaxation = Schemas["Relaxation"];

const ROW_S = 0.2; // of the command table

export function SequencePanel({ plan }: { plan: () => void }) {
  const text = words.value.plan.sequence;
  const all = draft.sessions.value;
  return (
    <section class="panel" aria-label={text.title}>
      <div class="row heading">
        <h2>{text.title}</h2>
        <button type="button" onClick={draft.addSession}>
          {text.add}
        </button>
      </div>
      <ol class="sessions">
        {all.map((one, number) => (
          <li key={`${number}-${one.start ?? ""}`}>
            <button
              type="button"
              class="session"
              aria-pressed={number === draft.chosen.value}
              onClick={() => {
                draft.chosen.value = number;
              }}
            >
              <b>{number + 1}</b> {one.target ? (one.name ?? targetTold(one.target)) : text.noTarget}
              <span class="soft">{one.start && one.stop ? period(one.start, one.stop) : text.noTimes}</span>
            </button>
            {all.length > 1 && (
              <button
                type="button"
                class="plain"
                aria-label={text.remove(number + 1)}
                onClick={() => draft.removeSession(number)}
              >
                ×
              </button>
            )}
          </li>
        ))}
      </ol>
      {all.length > 1 && (
        <>
          <Timeline />
          <ChoiceField
            label={text.conflict}
            value={draft.onConflict.value}
            choices={CONFLICTS}
            told={(one) => named(text.conflicts, one)}
            onValue={(on_conflict) => draft.change({ on_conflict })}
          />
        </>
      )}
      <Exactly />
      <Clashes />
      <WaysOut plan={plan} />
    </section>
  );
}

/** Times to the row of the table, names, and how a keyhole is met. */
function Exactly() {
  const text = words.value.plan.sequence;
  const one = draft.session.value;
  const number = draft.chosen.value;
  if (!one.target) return null;
  const take = (start: string | undefined, stop: string | undefined) => {
    if (start && stop) draft.setTimes(start, stop);
    else draft.changeSession({ ...one, start, stop });
  };
  const isBackwards = one.start && one.stop && Date.parse(one.start) >= Date.parse(one.stop);
  return (
    <details class="fields-group" open={!one.start && draft.target.value !== undefined && searchedOf(one.target) === null}>
      <summary>
        <b>{text.exactly(number + 1)}</b>
        <span class="small">{one.name ?? ""}</span>
      </summary>
      <div class="pair">
        <UtcField
          label={text.start}
          value={one.start}
          step_s={ROW_S}
          error={isBackwards ? text.backwards : undefined}
          onValue={(start) => take(start, one.stop)}
        />
        <UtcField label={text.stop} value={one.stop} step_s={ROW_S} onValue={(stop) => take(one.start, stop)} />
      </div>
      <Fields
        schema="Session"
        value={one as Members}
        path={`sessions.${number}`}
        omit={["target", "start", "stop"]}
        onValue={(next) => draft.changeSession(next as draft.DraftSession)}
      />
    </details>
  );
}

interface Span {
  start: number;
  stop: number;
}

function spans(): (Span | null)[] {
  return draft.sessions.value.map((one) =>
    one.start && one.stop ? { start: Date.parse(one.start), stop: Date.parse(one.stop) } : null,
  );
}

function scale(all: (Span | null)[]): (ms: number) => number {
  const known = all.filter((one) => one !== null);
  const first = Math.min(...known.map((one) => one.start));
  const last = Math.max(...known.map((one) => one.stop));
  const room = Math.max(1000, 0.04 * (last - first));
  return (ms) => (100 * (ms - first + room)) / (last - first + 2 * room);
}

function Timeline() {
  const all = spans();
  if (!all.some(Boolean)) return null;
  const place = scale(all);
  return (
    <div class="line" aria-hidden="true">
      {all.map((one, number) => one && <Bar key={number} span={one} place={place} name={String(number + 1)} kind="" />)}
      {overlaps().map(({ later, span }) => (
        <Bar key={`overlap-${later}`} span={span} place={place} name="" kind="lost" />
      ))}
    </div>
  );
}

/** Where a session begins before the one before it has ended; later: its number. */
function overlaps(): { later: number; span: Span }[] {
  const all = spans();
  return all.flatMap((one, later) => {
    const before = all[later - 1];
    if (!one || !before || one.start >= before.stop) return [];
    return [{ later, span: { start: one.start, stop: Math.min(one.stop, before.stop) } }];
  });
}

/** Sessions that can't both be as they are, where no other way out is offered. */
function Clashes() {
  const text = words.value.plan.sequence;
  const told = new Map(
    overlaps().map(({ later, span }) => [later, text.overlap(later, later + 1, number((span.stop - span.start) / 1000, 1))]),
  );
  const now = refused.value;
  const { limit, relaxations: offers = [] } = now?.problem.document ?? {};
  if (now && now.session > 0 && limit === "duration" && offers.length === 0 && !told.has(now.session)) {
    told.set(now.session, text.noRoom(now.session, now.session + 1));
  }
  return (
    <>
      {[...told].map(([later, why]) => (
        <div key={later} class="notice notice-warn" role="alert">
          <p>{why}</p>
          <div class="row">
            {[later - 1, later].map((number) => (
              <button
                key={number}
                type="button"
                onClick={() => {
                  failure.value = null;
                  draft.removeSession(number);
                }}
              >
                {text.leaveOut(number + 1)}
              </button>
            ))}
          </div>
        </div>
      ))}
    </>
  );
}

function Bar({ span, place, name, kind }: { span: Span; place: (ms: number) => number; name: string; kind: string }) {
  return (
    <span
      class={`line-bar ${kind}`}
      style={{ left: `${place(span.start)}%`, width: `max(3px, ${place(span.stop) - place(span.start)}%)` }}
    >
      {name}
    </span>
  );
}

/** Each drawn as it would be, with what it costs, and a button that takes it. */
function WaysOut({ plan }: { plan: () => void }) {
  const text = words.value.plan.sequence;
  const now = refused.value;
  if (!now) return null;
  const { relaxations: offers = [] } = now.problem.document;
  const ways = new Map<string, Relaxation[]>();
  for (const offer of offers) ways.set(offer.on_conflict, [...(ways.get(offer.on_conflict) ?? []), offer]);
  if (ways.size === 0) return null;
  const all = spans();
  const place = scale(all);
  return (
    <div class="ways" role="group" aria-label={text.waysOut}>
      <h3>{text.waysOut}</h3>
      {[...ways].map(([way, losses]) => (
        <div key={way} class="way">
          <div class="line" aria-hidden="true">
            {all.map((one, number) => one && <Bar key={number} span={one} place={place} name={String(number + 1)} kind="" />)}
            {losses.flatMap((loss) => {
              const one = all[loss.session];
              if (!one) return [];
              const { start, stop } = one;
              const lost: Span[] = [
                { start, stop: start + 1000 * loss.start_later_s },
                { start: stop - 1000 * loss.stop_earlier_s, stop },
              ];
              return lost
                .filter((span) => span.stop > span.start)
                .map((span) => <Bar key={`${loss.session}-${span.start}`} span={span} place={place} name="" kind="lost" />);
            })}
          </div>
          <button
            type="button"
            onClick={() => {
              draft.change({ on_conflict: way as draft.Conflict });
              plan();
            }}
          >
            {named(text.conflicts, way)}: {losses.map(costs).join("; ")}
          </button>
        </div>
      ))}
    </div>
  );
}

function costs(loss: Relaxation): string {
  return words.value.plan.sequence.loses(loss.session + 1, number(loss.start_later_s + loss.stop_earlier_s, 1));
}

/** Take the times that the refusal offers for the session it names. */
export function takeOffered(plan: () => void): void {
  const now = refused.peek();
  if (!now?.offered) return;
  const { start, stop, without } = now.offered;
  batch(() => {
    const before = without.filter((lost) => lost < now.session).length;
    for (const lost of [...without].sort((one, other) => other - one)) draft.removeSession(lost);
    draft.chosen.value = now.session - before;
    draft.setTimes(rfc3339(Date.parse(start)), rfc3339(Date.parse(stop)));
    failure.value = null;
  });
  plan();
}
