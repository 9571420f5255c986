/** The Earth, flat: a click is a target; the chosen pass is drawn over it. */
import { geoCircle } from "d3-geo";

import { words } from "../../i18n";
import { EarthMap } from "../../map/EarthMap";
import type { LonLat } from "../../map/places";
import { DaysTrack } from "./DaysTrack";
import * as draft from "./draft";
import { circleOf, groundTrack } from "./passes";
import { refused } from "./refusal";
import { textOf } from "./target";
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
  const refusedAt = refused.value?.session === draft.chosen.value;
  return (
    <EarthMap
      label={text.label}
      hint={text.hint}
      around={seen ? [seen] : []}
      aroundLabel={text.toTarget}
      onPick={([longitude_deg, latitude_deg]) => draft.setTarget({ mode: "ground", latitude_deg, longitude_deg, height_m: 0 })}
    >
      {({ projection, path }) => (
        <>
          <DaysTrack path={path} />
          {seen && radius && <path class="circle" d={path(geoCircle().center(seen).radius(radius)()) ?? ""} />}
          {track.length > 1 && (
            <path
              class={`track ${refusedAt ? "track-refused" : ""}`}
              d={path({ type: "LineString", coordinates: track }) ?? ""}
            />
          )}
          {track.length > 1 && (
            <Arrow from={projection(track[track.length - 2] ?? [0, 0])} to={projection(track[track.length - 1] ?? [0, 0])} />
          )}
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
                    {one.name ?? (one.target ? textOf(one.target) : "")}
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

function placeOf(one: draft.DraftSession): LonLat | null {
  return one.target?.mode === "ground" ? [one.target.longitude_deg, one.target.latitude_deg] : null;
}
