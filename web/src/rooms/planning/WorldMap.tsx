/** The Earth, flat: a click is a target; the chosen pass is drawn over it. */
import { geoCircle } from "d3-geo";

import { words } from "../../i18n";
import { EarthMap } from "../../map/EarthMap";
import { isMode, pointsOf, positionsOf } from "../../map/modes";
import type { LonLat } from "../../map/places";
import { Drafted, Shape } from "../../map/Shapes";
import { DaysTrack } from "./DaysTrack";
import * as draft from "./draft";
import { addPosition } from "./ModeEntry";
import { addPoint } from "./PathEntry";
import { circleOf, groundTrack } from "./passes";
import { refused } from "./refusal";
import { takeMoving, takeStation } from "./TargetPanel";
import { geometryIn, isDrawn } from "./target";
import { targetTold } from "./told";
import { found, windowNear } from "./windows";

export function WorldMap() {
  const text = words.value.plan.map;
  const now = found.value;
  const window = now ? windowNear(now.windows, draft.session.value) : null;
  const track = window ? groundTrack(window) : [];
  const radius = window && circleOf(window, draft.leastElevation_deg.value);
  const seen: LonLat | null = window?.place
    ? [window.place.longitude_deg, window.place.latitude_deg]
    : placeOf(draft.session.value);
  const kind = draft.kind.value;
  const path = pathOf(draft.session.value);
  const refusedAt = refused.value?.session === draft.chosen.value;
  return (
    <EarthMap
      label={text.label}
      hint={isMode(kind) ? words.value.plan.drawing.howTo[kind] : kind === "ground_path" ? text.hintPath : text.hint}
      around={path.length > 1 ? path : seen ? [seen] : []}
      aroundLabel={text.toTarget}
      onPick={pick}
    >
      {({ projection, path: drawn, wide }) => (
        <>
          <DaysTrack path={drawn} />
          {seen && radius && <path class="circle" d={drawn(geoCircle().center(seen).radius(radius)()) ?? ""} />}
          {track.length > 1 && (
            <path
              class={`track ${refusedAt ? "track-refused" : ""}`}
              d={drawn({ type: "LineString", coordinates: track }) ?? ""}
            />
          )}
          {track.length > 1 && (
            <Arrow from={projection(track[track.length - 2] ?? [0, 0])} to={projection(track[track.length - 1] ?? [0, 0])} />
          )}
          {draft.sessions.value.map((one, index) => {
            const points = pathOf(one);
            return (
              points.length > 0 && (
                <g key={`path-${index}`} class={index === draft.chosen.value ? "path path-chosen" : "path"}>
                  <path d={drawn({ type: "LineString", coordinates: points }) ?? ""} />
                  {points.map((point, at) => {
                    const [x, y] = projection(point) ?? [0, 0];
                    return <circle key={at} cx={x} cy={y} r={3} />;
                  })}
                </g>
              )
            );
          })}
          {draft.sessions.value.map(({ target }, index) => {
            const geometry = geometryIn(target);
            if (!target || !geometry || !isMode(target.mode)) return null;
            const drawing = { projection, path: drawn, wide };
            return isDrawn(target) ? (
              <Shape key={`shape-${index}`} mode={target.mode} geometry={geometry} drawing={drawing} />
            ) : (
              <Drafted key={`shape-${index}`} mode={target.mode} positions={positionsOf(geometry)} drawing={drawing} />
            );
          })}
          {draft.sessions.value.map((one, index) => {
            const place = index === draft.chosen.value ? seen : placeOf(one);
            const point = place && projection(place);
            return (
              point && (
                <g
                  key={index}
                  class={index === draft.chosen.value ? "mark mark-chosen" : "mark"}
                  transform={`translate(${point[0]},${point[1]})`}
                >
                  <circle r={5} />
                  <text x={9} y={4}>
                    {one.name ?? (one.target ? targetTold(one.target) : "")}
                  </text>
                </g>
              )
            );
          })}
        </>
      )}
    </EarthMap>
  );
}

function Arrow({ from, to }: { from: [number, number] | null; to: [number, number] | null }) {
  if (!from || !to) return null;
  const turn = (Math.atan2(to[1] - from[1], to[0] - from[0]) * 180) / Math.PI;
  return <path class="arrow" d="M-8,-5L2,0L-8,5Z" transform={`translate(${to[0]},${to[1]}) rotate(${turn})`} />;
}

/** A click, or Enter at the cross, as the kind of target takes it. */
function pick([longitude_deg, latitude_deg]: LonLat): void {
  const point = { latitude_deg, longitude_deg, height_m: 0 };
  const kind = draft.kind.peek();
  if (kind === "ground_path") addPoint(point);
  else if (isMode(kind)) addPosition(kind, point);
  else if (kind === "ground_moving") takeMoving(point);
  else if (kind === "station") takeStation(point);
  else draft.setTarget({ mode: "ground", ...point });
}

function pathOf({ target }: draft.DraftSession): LonLat[] {
  if (target?.mode !== "ground_path") return [];
  return target.points.map(({ longitude_deg, latitude_deg }): LonLat => [Number(longitude_deg), Number(latitude_deg)]);
}

function placeOf({ target }: draft.DraftSession): LonLat | null {
  const isPoint = target?.mode === "ground" || target?.mode === "ground_moving" || target?.mode === "station";
  if (isPoint) return [target.longitude_deg, target.latitude_deg];
  const geometry = geometryIn(target);
  if (geometry) return pointsOf(geometry.coordinates)[0] ?? null;
  return target?.mode === "ground_path" && target.points[0]
    ? [target.points[0].longitude_deg, target.points[0].latitude_deg]
    : null;
}
