/** The chosen session's target: a place, a path, something that moves, a station, a star, a body or a test motion. */

import { batch } from "@preact/signals";
import { FIELDS } from "../../api/fields";

import { Problem } from "../../api/problem";
import { words } from "../../i18n";
import { rfc3339 } from "../../i18n/forms";
import { isMode, MODES } from "../../map/modes";
import { Combobox } from "../../parts/Combobox";
import { Field } from "../../parts/Field";
import { FoldedFields } from "../../parts/fields/FoldedFields";
import { valueLabel } from "../../parts/fields/labels";
import { begin, beginUnion, type Members } from "../../parts/fields/shape";
import { useStateOf } from "../../parts/stateOf";
import * as draft from "./draft";
import { ModeEntry } from "./ModeEntry";
import { places, stars } from "./names";
import { PathEntry } from "./PathEntry";
import { PointEntry } from "./PointEntry";
import { axes, others } from "./platforms";
import { BODIES, groundOf, KINDS, kindOf, type Point, schemaOfMode, starOf, type Target, textOf } from "./target";
import { found, searchError, searchedOf } from "./windows";

/** Fields that each kind's own entry makes; the rest stand below it. */
const ENTERED: Readonly<Record<string, readonly string[]>> = {
  ground: ["latitude_deg", "longitude_deg", "height_m"],
  place: ["name"],
  ground_path: ["points"],
  station: ["latitude_deg", "longitude_deg", "height_m"],
  ...Object.fromEntries(MODES.map((mode) => [mode, ["geometry"]])),
  star: ["name", "hip"],
  body: ["name"],
};

export function TargetPanel() {
  const text = words.value.plan.target;
  const target = draft.target.value;
  const kind = draft.kind.value;
  const count = draft.sessions.value.length;
  const own = target && kindOf(target) === kind ? target : undefined;
  return (
    <section class="panel" aria-label={text.title}>
      <h2>
        {text.title}
        {count > 1 && <span class="soft"> · {text.ofSession(draft.chosen.value + 1, count)}</span>}
      </h2>
      <fieldset class="choice choice-wraps">
        <legend class="hidden">{text.kind}</legend>
        {KINDS.filter((one) => one === kind || !others.value.includes(`Session.target.${one}`)).map((one) => (
          <label key={one}>
            <input type="radio" name="kind" checked={kind === one} onChange={() => draft.setKind(one)} />
            <span>{valueLabel(one)}</span>
          </label>
        ))}
      </fieldset>
      <Entry key={kind} kind={kind} target={own} />
      {own && <More target={own} />}
      {found.value?.assumed && <p class="hint">{text.taken(words.value.service.told(found.value.assumed))}</p>}
    </section>
  );
}

function Entry({ kind, target }: { kind: string; target: Target | undefined }) {
  const text = words.value.plan.target;
  if (kind === "ground" || kind === "star") return <TextField kind={kind} target={target} />;
  if (kind === "body") return <BodyField target={target} />;
  if (kind === "ground_path") return <PathEntry path={target?.mode === "ground_path" ? target : null} />;
  if (kind === "ground_moving") {
    return <PointEntry label={text.whereMoving} button={text.find} hint={text.hints.moving} onPoint={takeMoving} />;
  }
  if (kind === "station") {
    return (
      <>
        <PointEntry label={text.whereMoving} button={text.find} hint={text.hints.station} onPoint={takeStation} />
        {target && <p>{textOf(target)}</p>}
      </>
    );
  }
  if (isMode(kind)) return <ModeEntry mode={kind} target={target} />;
  if (target) return null;
  const shape = FIELDS.Session?.target?.shape;
  return (
    <button
      type="button"
      onClick={() => {
        if (shape?.kind === "union") beginTarget(asMotion(beginUnion(FIELDS, shape, kind)) as unknown as Target);
      }}
    >
      {text.begin(valueLabel(kind))}
    </button>
  );
}

const [LATER_MS, LASTS_MS] = [900_000, 60_000];

/** It has no window that would give it times. */
function beginTarget(target: Target): void {
  batch(() => {
    draft.setTarget(target);
    const start_ms = Math.max(draft.from_ms.peek(), ...lastStops()) + LATER_MS;
    if (searchedOf(target) === null) draft.setTimes(rfc3339(start_ms), rfc3339(start_ms + LASTS_MS));
  });
}

function lastStops(): number[] {
  return draft.sessions.peek().flatMap((one) => (one.stop ? [Date.parse(one.stop)] : []));
}

/** A test motion moves each axis of the platform. */
function asMotion(begun: Members): Members {
  const field = FIELDS.BenchMotionTarget?.axes;
  if (begun.mode !== "test_motion" || field?.shape.kind !== "map") return begun;
  const of = field.shape.of;
  return { ...begun, axes: Object.fromEntries(axes.peek().map((axis) => [axis, begin(FIELDS, of)])) };
}

export function takeMoving({ height_m, ...place }: Point): void {
  const point = height_m ? { ...place, height_m } : place; // which no terrain tells of what moves
  const now = draft.target.peek();
  if (now?.mode === "ground_moving") draft.refineTarget({ ...now, ...point }, { isMoved: true });
  else {
    const epoch = rfc3339(draft.from_ms.peek());
    draft.setTarget({ mode: "ground_moving", epoch, ...point, course_deg: 90, speed_m_s: 8 });
  }
}

/** Its least elevation stays where it is moved. */
export function takeStation({ height_m, ...place }: Point): void {
  const now = draft.target.peek();
  draft.setTarget({ ...(now?.mode === "station" && now), mode: "station", ...place, height_m: height_m ?? 0 });
}

/** Fields of the target that have no entry of their own. */
function More({ target }: { target: Target }) {
  const text = words.value.plan.target;
  const schema = schemaOfMode(target.mode);
  if (!schema) return <p class="hint">{text.unknown(target.mode)}</p>;
  return (
    <FoldedFields
      title={text.more}
      isOpen={target.mode === "test_motion" || target.mode === "ground_moving"}
      schema={schema}
      value={target as unknown as Members}
      path={`sessions.${draft.chosen.value}.target`}
      omit={ENTERED[target.mode] ?? []}
      onValue={(next) => draft.refineTarget(next as unknown as Target)}
    />
  );
}

function TextField({ kind, target }: { kind: "ground" | "star"; target: Target | undefined }) {
  const text = words.value.plan.target;
  const own = target ? textOf(target) : "";
  const [typed, setTyped] = useStateOf(own, () => own);
  const take = (entry: string) => {
    const next = kind === "star" ? starOf(entry) : groundOf(entry);
    if (next && entry !== own) draft.setTarget(next);
  };
  const error = searchError.value;
  const isWrong = target && error instanceof Problem && error.field?.startsWith("targets.0.target");
  const offers = isWrong ? offersOf(error.document.detail) : [];
  const why = isWrong ? whyNot(target, error.document.detail) : undefined;
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        take(typed);
      }}
    >
      <Field label={text.labels[kind]} hint={text.hints[kind]} error={why}>
        {(props) => (
          <span class="entry">
            <Combobox
              control={props}
              value={typed}
              onValue={setTyped}
              onTake={take}
              onLeave={() => take(typed)}
              offered={text.offered[kind]}
              offers={kind === "star" ? stars : places}
            />
            <button type="submit">{text.find}</button>
          </span>
        )}
      </Field>
      {offers.length > 0 && (
        <div class="row" role="group" aria-label={text.meant}>
          {offers.map((offer) => (
            <button key={offer} type="button" class="small-button" onClick={() => take(offer)}>
              {offer}
            </button>
          ))}
        </div>
      )}
    </form>
  );
}

/** The service's way out is for those who write JSON. */
function whyNot(target: Target, detail: string): string {
  const text = words.value.plan.target;
  if (target.mode === "place") return / may be /.test(detail) ? text.several : text.noPlace;
  return target.mode === "star" && target.name ? text.noStar : words.value.service.told(detail);
}

/** The names that a refusal offers: 'Springfield, Ohio, US' (39.92, -83.81), or "do you mean Vega?" */
function offersOf(detail: string): string[] {
  const named = [...detail.matchAll(/'([^']+, [A-Z]{2})'/g)].map((match) => match[1] ?? "");
  const star = /do you mean ([^'?]+)\?/.exec(detail)?.[1];
  return named.length ? [...new Set(named)] : (star?.split(" or ") ?? []);
}

function BodyField({ target }: { target: Target | undefined }) {
  const text = words.value.plan.target;
  return (
    <Field label={text.labels.body}>
      {(props) => (
        <select
          {...props}
          value={target?.mode === "body" ? target.name.toLowerCase() : ""}
          onChange={(event) => draft.setTarget({ mode: "body", name: event.currentTarget.value })}
        >
          <option value="" disabled>
            {text.choose}
          </option>
          {BODIES.map((body) => (
            <option key={body} value={body}>
              {text.bodies[body]}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}
