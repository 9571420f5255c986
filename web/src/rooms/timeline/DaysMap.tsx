/** The Earth over the time shown: ground track, swaths, targets, night side. */
import { useMemo } from "preact/hooks";

import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { instant } from "../../i18n/forms";
import { EarthMap } from "../../map/EarthMap";
import { arrange } from "../../map/labels";
import { Night } from "../../map/Night";
import type { LonLat } from "../../map/places";
import { fetchMap, inTurn, type Track } from "./kept";
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
  const swaths = features.filter((one) => one.properties?.kind === "swath" || one.properties?.kind === "footprint");
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
        {({ projection, path }) => {
          const points = targets.map((one) => projection(one.at));
          const wide = projection.clipExtent()?.[1][0] ?? 0;
          const names = arrange(
            points.map((point, k) => point && { x: point[0], y: point[1], text: targets[k]?.name ?? "" }),
            wide,
          );
          const carrier = now && projection(now.carrier);
          return (
            <>
              {now && <Night sun={now.sun} path={path} class="dm-night" />}
              <path class="dm-track" d={path({ type: "MultiLineString", coordinates: lines }) ?? ""} />
              <path class="dm-swath" d={swaths.map((one) => path(one) ?? "").join("")} />
              {carrier && <circle class="dm-carrier" cx={carrier[0]} cy={carrier[1]} r={5} />}
              {targets.map((one, k) => {
                const point = points[k];
                const placing = names[k];
                return (
                  point && (
                    <g key={`${one.name} ${one.at.join()}`} class="dm-target" transform={`translate(${point[0]},${point[1]})`}>
                      <title>{one.name}</title>
                      <circle r={4.5} />
                      {placing && <text {...placing}>{one.name}</text>}
                    </g>
                  )
                );
              })}
            </>
          );
        }}
      </EarthMap>
      <p class="lanes-legend">
        <span class="key key-axis-0">{text.track}</span>
        <span class="key key-error">{text.swath}</span>
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
      await inTurn(blocks, async ({ id }) => {
        features.push(...((await fetchMap(id, until))?.features ?? []));
      });
      return features;
    },
    blocks.map((one) => one.id).join(),
  );
  return found.answer ?? [];
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

/** The places below the carrier from one instant to another, in lines. */
function linesIn({ start, t_s, carrier }: Track, from_ms: number, to_ms: number): LonLat[][] {
  const start_ms = Date.parse(start);
  const lines: LonLat[][] = [[]];
  for (const [row, t] of t_s.entries()) {
    const at_ms = start_ms + 1000 * t;
    const [longitude, latitude] = [carrier.longitude_deg[row], carrier.latitude_deg[row]];
    if (at_ms < from_ms || at_ms > to_ms) continue;
    if (longitude == null || latitude == null) lines.push([]);
    else lines[lines.length - 1]?.push([longitude, latitude]);
  }
  return lines.filter((line) => line.length > 1);
}

/** Where carrier and Sun stand at the row nearest to an instant. */
function rowAt({ start, t_s, carrier, sun }: Track, at_ms: number): { carrier: LonLat; sun: LonLat } | null {
  const t = (at_ms - Date.parse(start)) / 1000;
  const after = t_s.findIndex((one) => one >= t);
  const row = after <= 0 ? Math.max(after, 0) : t - (t_s[after - 1] ?? 0) < (t_s[after] ?? 0) - t ? after - 1 : after;
  const place = ({ longitude_deg, latitude_deg }: typeof sun | typeof carrier): LonLat | null => {
    const [longitude, latitude] = [longitude_deg[row], latitude_deg[row]];
    return longitude == null || latitude == null ? null : [longitude, latitude];
  };
  const [below, overhead] = [place(carrier), place(sun)];
  return below && overhead ? { carrier: below, sun: overhead } : null;
}
