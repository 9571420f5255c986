/** A path's points: clicked on the map or added by name, in the order in which they are passed. */
import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import { Field } from "../../parts/Field";
import { NumberInput } from "../../parts/fields/Fields";
import * as draft from "./draft";
import { PointEntry } from "./PointEntry";
import { PointList } from "./PointList";
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

export function PathEntry({ path }: { path: Path | null }) {
  const text = words.value.plan.path;
  const points = path?.points ?? [];
  return (
    <>
      <PointEntry label={text.next} button={text.add} hint={text.hint} onPoint={addPoint} />
      <PointList points={points} onPoints={(next) => path && take(withPoints(path, next))} />
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
