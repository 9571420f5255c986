/** A path's points: clicked on the map or added by name, in the order in which they are passed. */
import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import { Field } from "../../parts/Field";
import { NumberInput } from "../../parts/fields/Fields";
import * as draft from "./draft";
import { PointEntry } from "./PointEntry";
import { durationOf, lengthOf, type Path, type Point, withPoints } from "./target";

/** At the end of the path that is there, or as the first of one. */
export function addPoint(point: Point): void {
  const now = draft.target.peek();
  if (now?.mode === "ground_path") take(withPoints(now, [...now.points, point]));
  else draft.setTarget(withPoints(null, [point]));
}

function take(path: Path): void {
  draft.refineTarget(path, { isMoved: true });
}

const STEPS = [-1, 1] as const;

export function PathEntry({ path }: { path: Path | null }) {
  const text = words.value.plan.path;
  const points = path?.points ?? [];
  const change = (number: number, name: keyof Point, value: unknown) => {
    if (path) take(withPoints(path, points.map((point, at) => (at === number ? { ...point, [name]: value } : point)) as Point[]));
  };
  const move = (from: number, by: number) => {
    const next = [...points];
    next.splice(from + by, 0, ...next.splice(from, 1));
    if (path) take(withPoints(path, next));
  };
  return (
    <>
      <PointEntry label={text.next} button={text.add} hint={text.hint} onPoint={addPoint} />
      {points.length > 0 && (
        <ol class="path-points" aria-label={text.points}>
          {points.map((point, at) => (
            <li key={at}>
              {(["latitude_deg", "longitude_deg"] as const).map((name) => (
                <NumberInput
                  key={name}
                  control={{ "aria-label": text[name](at + 1) }}
                  value={point[name]}
                  onValue={(value) => change(at, name, value ?? "")}
                />
              ))}
              {STEPS.map((by) => (
                <button
                  key={by}
                  type="button"
                  class="plain"
                  aria-label={by < 0 ? text.earlier(at + 1) : text.later(at + 1)}
                  disabled={at + by < 0 || at + by >= points.length}
                  onClick={() => move(at, by)}
                >
                  {by < 0 ? "↑" : "↓"}
                </button>
              ))}
              <button
                type="button"
                class="plain"
                aria-label={text.remove(at + 1)}
                onClick={() => path && take(withPoints(path, [...points.slice(0, at), ...points.slice(at + 1)]))}
              >
                ×
              </button>
            </li>
          ))}
        </ol>
      )}
      {path && points.length > 1 && (
        <>
          <Field label={text.seconds} hint={text.told(number(lengthOf(points) / 1000, 1), number(path.speed_m_s, 1))}>
            {(control) => (
              <NumberInput
                control={control}
                value={Number(durationOf(path).toFixed(1))}
                onValue={(seconds) => {
                  if (typeof seconds !== "number" || seconds <= 0) return;
                  take({ ...path, speed_m_s: Number((lengthOf(points) / seconds).toPrecision(6)) });
                }}
              />
            )}
          </Field>
          <p class="hint">{text.windows}</p>
        </>
      )}
    </>
  );
}
