/** Points in the order in which they are passed: each changed, moved and removed in its row. */
import { words } from "../../i18n";
import { NumberInput } from "../../parts/fields/Fields";
import type { Point } from "./target";

const STEPS = [-1, 1] as const;

export function PointList({ points, onPoints }: { points: readonly Point[]; onPoints: (points: Point[]) => void }) {
  const text = words.value.plan.path;
  const change = (number: number, name: keyof Point, value: unknown) =>
    onPoints(points.map((point, at) => (at === number ? { ...point, [name]: value } : point)) as Point[]);
  const move = (from: number, by: number) => {
    const next = [...points];
    next.splice(from + by, 0, ...next.splice(from, 1));
    onPoints(next);
  };
  if (points.length === 0) return null;
  return (
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
            onClick={() => onPoints([...points.slice(0, at), ...points.slice(at + 1)])}
          >
            ×
          </button>
        </li>
      ))}
    </ol>
  );
}
