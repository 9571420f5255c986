/** An imaging mode's positions: clicked on the map or added by name, as they are scanned. */
import { words } from "../../i18n";
import { geometryOf, isMode, type Mode, POSITIONS, positionsOf } from "../../map/modes";
import * as draft from "./draft";
import { PointEntry } from "./PointEntry";
import { PointList } from "./PointList";
import { geometryIn, type Point, type Target } from "./target";

/** At the end of the positions that are there; once there are as many as the mode takes, as the first of others. */
export function addPosition(mode: Mode, point: Point): void {
  const now = draft.target.peek();
  const points = now?.mode === mode ? pointsIn(now) : [];
  take(mode, points.length < POSITIONS[mode].most ? [...points, point] : [point]);
}

function take(mode: Mode, points: readonly Point[]): void {
  const now = draft.target.peek();
  const geometry = geometryOf(
    mode,
    points.map(({ longitude_deg, latitude_deg }) => [longitude_deg, latitude_deg]),
  );
  if (now?.mode === mode) draft.refineTarget({ ...now, geometry } as Target, { isMoved: true });
  else draft.setTarget({ mode, geometry } as Target);
}

function pointsIn(target: Target): Point[] {
  return positionsOf(geometryIn(target)).map(([longitude_deg, latitude_deg]) => ({ longitude_deg, latitude_deg }));
}

export function ModeEntry({ mode, target }: { mode: Mode; target: Target | undefined }) {
  const text = words.value.plan;
  const points = target && isMode(target.mode) ? pointsIn(target) : [];
  const parts = target ? (geometryIn(target)?.coordinates.length ?? 0) : 0;
  return (
    <>
      <PointEntry
        label={text.path.next}
        button={text.path.add}
        hint={text.drawing.howTo[mode]}
        onPoint={(point) => addPosition(mode, point)}
      />
      <PointList points={points} onPoints={(next) => take(mode, next)} />
      {points.length === 0 && parts > 0 && <p class="hint">{text.drawing.whole(parts)}</p>}
    </>
  );
}
