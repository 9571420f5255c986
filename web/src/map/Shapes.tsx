/** Shapes of imaging modes on a map: those asked for, and the one that is being drawn. */
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
