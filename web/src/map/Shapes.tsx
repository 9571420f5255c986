/** Shapes on a map: of imaging modes those asked for and the one that is being drawn, and many marks at once. */
import type { Drawing } from "./EarthMap";
import { type Geometry, type Mode, shapeOf } from "./modes";
import type { LonLat } from "./places";

export function Shape({ mode, geometry, drawing }: { mode: Mode; geometry: Geometry; drawing: Drawing }) {
  return (
    <g class={`asked-shape mode-${mode}`}>
      <path d={drawing.path(shapeOf(geometry)) ?? ""} />
    </g>
  );
}

export function Drafted({ mode, positions, drawing }: { mode: Mode; positions: readonly LonLat[]; drawing: Drawing }) {
  return (
    <g class={`asked-shape draft mode-${mode}`}>
      <path d={drawing.path({ type: "LineString", coordinates: [...positions] }) ?? ""} />
      {positions.map((one, number) => {
        const point = drawing.projection(one);
        return point && <circle key={number} cx={point[0]} cy={point[1]} r={4} />;
      })}
    </g>
  );
}

type Point = readonly [number, number];

interface DotsProps {
  /** Its class, which says the colours of rim and dot. */
  kind: string;
  colour?: string;
  points: readonly (Point | null)[];
  /** A click on one, by its number. */
  onDot?: (number: number) => void;
}

/** So many marks are too slow as elements of their own. */
export const MANY = 300;

/** Marks that are one element. */
export function Dots({ kind, colour, points, onDot }: DotsProps) {
  // Squares: to find the bounds of as many round marks takes the browser seconds.
  const squares = (half: number) =>
    points
      .map((one) => one && `M${(one[0] - half).toFixed(1)},${(one[1] - half).toFixed(1)}h${2 * half}v${2 * half}h${-2 * half}z`)
      .join("");
  const clicked = (event: MouseEvent) => {
    const { left = 0, top = 0 } = (event.currentTarget as SVGElement).ownerSVGElement?.getBoundingClientRect() ?? {};
    const away = points.map((point) =>
      point ? Math.hypot(point[0] + left - event.clientX, point[1] + top - event.clientY) : Infinity,
    );
    onDot?.(away.indexOf(away.reduce((least, one) => Math.min(least, one))));
  };
  const takes = onDot && { onPointerDown: (event: Event) => event.stopPropagation(), onClick: clicked };
  return (
    <g class={kind} style={colour && { "--dot": colour }} {...takes}>
      <path class="rim" d={squares(3)} />
      <path class="dot" d={squares(2)} />
    </g>
  );
}
