/** A layer of the map: the ground track of the days that are searched, and the night at the session. */
import type { GeoPath } from "d3-geo";

import { useRequest } from "../../api/request";
import { Night } from "../../map/Night";
import { fetchTrack, linesIn, rowAt, type Track } from "../../map/track";
import * as draft from "./draft";

const STEP_S = 180; // between rows the map draws great circles, which a low orbit's track keeps to 0.1 deg

export function DaysTrack({ path }: { path: GeoPath }) {
  const [orbit, from_ms, to_ms] = [draft.orbit.value, draft.from_ms.value, draft.to_ms.value];
  const found = useRequest<Track | null>(JSON.stringify([orbit, from_ms, to_ms]), async (until) => {
    const track = await fetchTrack(orbit, [from_ms, to_ms], STEP_S, until);
    return track && "carrier" in track ? track : null; // the form says what is wrong with the orbit
  });
  const track = found.answer;
  if (!track) return null;
  const { start } = draft.session.value;
  const now = rowAt(track, start ? Date.parse(start) : from_ms);
  return (
    <>
      {now && <Night sun={now.sun} path={path} class="map-night" />}
      <path class="days-track" d={path({ type: "MultiLineString", coordinates: linesIn(track, from_ms, to_ms) }) ?? ""} />
    </>
  );
}
