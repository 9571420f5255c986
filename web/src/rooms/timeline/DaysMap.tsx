/** The Earth over the time shown: ground track, swaths, targets, night side. */
import { useMemo } from "preact/hooks";

import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { instant } from "../../i18n/forms";
import { EarthMap } from "../../map/EarthMap";
import { placeNames } from "../../map/labels";
import { Night } from "../../map/Night";
import { type LonLat, ringOf } from "../../map/places";
import { linesIn, rowAt, type Track } from "../../map/track";
import { fetchMap, inTurn } from "./kept";
import { type Block, DAY_MS, type Lane, type Span } from "./lanes";

const MOST_MS = 3 * DAY_MS; // of the track: more days cover the map
const PLANS = 24; // whose swaths are drawn

interface Props {
  span: Span;
  now_ms: number;
  lanes: readonly Lane[];
  lane: Lane | null;
  onLane: (name: string) => void;
  track: Track | null;
}

interface Named {
  at: LonLat;
  name: string;
}

export function DaysMap({ span: [from_ms, to_ms], now_ms, lanes, lane, onLane, track }: Props) {
  const text = words.value.timeline.map;
  const shown = (lane?.blocks ?? [])
    .filter((one) => one.state === "done" && one.kind !== "spacecraft" && one.stop_ms > from_ms && one.start_ms < to_ms)
    .slice(0, PLANS);
  const features = useFeatures(shown);
  const swaths = useMemo(() => features.flatMap(ringsIn), [features]);
  const targets = useMemo(() => placesIn(features), [features]);
  const lines = useMemo(
    () => (track ? linesIn(track, from_ms, Math.min(to_ms, from_ms + MOST_MS)) : []),
    [track, from_ms, to_ms],
  );
  const now = track && rowAt(track, now_ms);
  return (
    <section class="panel days-map" aria-label={text.title}>
      <div class="row heading">
        <h2>{text.title}</h2>
        {lanes.length > 1 && (
          <select aria-label={text.title} value={lane?.name} onChange={(event) => onLane(event.currentTarget.value)}>
            {lanes.map(({ name }) => (
              <option key={name} value={name}>
                {name}
              </option>
            ))}
          </select>
        )}
        <span class="small">
          {text.at}: {instant(now_ms).slice(0, 16)}
        </span>
      </div>
      <EarthMap
        label={text.label}
        hint={text.hint}
        around={targets.map((one) => one.at)}
        aroundLabel={text.toTargets}
        height={380}
      >
        {({ projection, path, wide }) => {
          const points = targets.map((one) => projection(one.at));
          const placings = placeNames(
            points,
            targets.map((one) => one.name),
            wide,
          );
          const carrier = now && projection(now.carrier);
          return (
            <>
              {now && <Night sun={now.sun} path={path} class="map-night" />}
              <path class="dm-track" d={path({ type: "MultiLineString", coordinates: lines }) ?? ""} />
              <path class="dm-swath" d={path({ type: "MultiPolygon", coordinates: swaths }) ?? ""} />
              {carrier && <circle class="dm-carrier" cx={carrier[0]} cy={carrier[1]} r={5} />}
              {targets.map((one, k) => {
                const point = points[k];
                const placing = placings[k];
                return (
                  point && (
                    <g key={`${one.name} ${one.at.join()}`} class="dm-target" transform={`translate(${point[0]},${point[1]})`}>
                      <circle r={4.5} />
                      {placing ? <text {...placing}>{one.name}</text> : <title>{one.name}</title>}
                    </g>
                  )
                );
              })}
            </>
          );
        }}
      </EarthMap>
      <p class="lanes-legend">
        <span>
          <i class="lanes-key lanes-key-track" /> {text.track}
        </span>
        <span>
          <i class="lanes-key lanes-key-swath" /> {text.swath}
        </span>
        <span>◯ {text.target}</span>
        <span>● {text.carrier}</span>
        <span>
          <i class="lanes-key lanes-key-shadow" /> {text.night}
        </span>
      </p>
      {track && to_ms - from_ms > MOST_MS && <p class="hint">{text.cut}</p>}
    </section>
  );
}

/** Of the plans' own maps, as they come. */
function useFeatures(blocks: readonly Block[]): GeoJSON.Feature[] {
  const found = useRequest<GeoJSON.Feature[]>(
    "maps",
    async (until) => {
      const features: GeoJSON.Feature[] = [];
      await inTurn(blocks, async ({ id, name, kind }) => {
        const found = (await fetchMap(id, until))?.features ?? [];
        const isOne = kind === "plan" && found.filter((one) => one.properties?.kind === "target").length === 1;
        // Coordinates are no name where the plan has one.
        for (const one of found) features.push(isOne && name ? { ...one, properties: { ...one.properties, name } } : one);
      });
      return features;
    },
    blocks.map((one) => one.id).join(),
  );
  return found.answer ?? [];
}

/** Outlines of a swath, so wound that d3 takes their insides. */
function ringsIn({ properties, geometry }: GeoJSON.Feature): LonLat[][][] {
  if (properties?.kind !== "swath") return [];
  const areas =
    geometry.type === "MultiPolygon" ? geometry.coordinates : geometry.type === "Polygon" ? [geometry.coordinates] : [];
  return areas.map((rings) => rings.map((ring) => ringOf(ring as LonLat[])));
}

function placesIn(features: readonly GeoJSON.Feature[]): Named[] {
  const places = new Map<string, Named>();
  for (const { properties, geometry } of features) {
    if (properties?.kind !== "target" || geometry.type !== "Point") continue;
    const [longitude = 0, latitude = 0] = geometry.coordinates;
    const name = String(properties.name ?? "");
    places.set(`${name} ${longitude} ${latitude}`, { at: [longitude, latitude], name });
  }
  return [...places.values()];
}
