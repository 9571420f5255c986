/** The ground: track, what was asked, what is imaged, and the scanned line now. */
import { useMemo } from "preact/hooks";

import { words } from "../../i18n";
import { type Drawing, EarthMap } from "../../map/EarthMap";
import { placeNames } from "../../map/labels";
import { type LonLat, ringOf } from "../../map/places";
import { cursor_s } from "../../time/cursor";
import type { SessionView } from "./session";

interface Places {
  latitude_deg: readonly (number | null)[];
  longitude_deg: readonly (number | null)[];
}

interface Props {
  view: SessionView;
  /** Number of the swath to come closer to; null for all. */
  closer: number | null;
}

export function SessionMap({ view, closer }: Props) {
  const text = words.value.spacecraft;
  const around = useMemo(() => {
    const swath = closer === null ? undefined : view.swaths[closer];
    return swath ? placesOf(swath) : [...view.requests, ...view.swaths].flatMap(placesOf);
  }, [view, closer]);
  const track = useMemo(() => placesOf(view.carrier), [view]);
  return (
    <section aria-label={text.map}>
      <EarthMap label={text.mapLabel} hint={text.moveHint} around={around} aroundLabel={text.toAsked} fits height={560}>
        {(drawing) => (
          <>
            <path class="track" d={drawing.path({ type: "LineString", coordinates: track }) ?? ""} />
            {view.swaths.map((swath, number) => (
              <path
                key={number}
                class="swath"
                d={drawing.path({ type: "Polygon", coordinates: [ringOf(placesOf(swath))] }) ?? ""}
              />
            ))}
            <Asked view={view} drawing={drawing} />
            <Now view={view} drawing={drawing} />
          </>
        )}
      </EarthMap>
      <ul class="map-legend">
        <li class="key-line key-track">{text.legend.track}</li>
        <li class="key-line key-swath">{text.legend.swath}</li>
        <li class="key-line key-imaged">{text.legend.imaged}</li>
        {view.requests.some((one) => !one.imaged) && <li class="key-line key-left-out">{text.legend.leftOut}</li>}
      </ul>
    </section>
  );
}

function Asked({ view, drawing: { path, projection, wide } }: { view: SessionView; drawing: Drawing }) {
  const starts = view.requests.map((one) => {
    const [first] = placesOf(one);
    return first ? projection(first) : null;
  });
  const names = view.requests.map((one) => one.name);
  const placings = placeNames(starts, names, wide);
  return (
    <>
      {view.requests.map((one, number) => {
        const places = placesOf(one);
        const shape: GeoJSON.Geometry =
          one.mode === "area" ? { type: "Polygon", coordinates: [ringOf(places)] } : { type: "LineString", coordinates: places };
        const [at, placing] = [starts[number], placings[number]];
        return (
          <g key={one.name} class={`asked-shape ${one.imaged ? "asked-imaged" : "asked-left-out"}`}>
            <path d={path(shape) ?? ""} />
            {at && placing && (
              <text {...placing} x={at[0] + placing.x} y={at[1] + placing.y}>
                {one.name}
              </text>
            )}
          </g>
        );
      })}
    </>
  );
}

function Now({ view, drawing: { projection } }: { view: SessionView; drawing: Drawing }) {
  const row = Math.min(Math.round(cursor_s.value / (view.step_s || 1)), view.t_s.length - 1);
  const { carrier, line } = view;
  const below = at(carrier.longitude_deg[row], carrier.latitude_deg[row]);
  const left = at(line.left_longitude_deg[row], line.left_latitude_deg[row]);
  const right = at(line.right_longitude_deg[row], line.right_latitude_deg[row]);
  const middle = at(line.longitude_deg[row], line.latitude_deg[row]);
  const isOn = view.window[row] !== null;
  return (
    <g class={isOn ? "now now-on" : "now"}>
      {below && middle && <path class="sight" d={`M${below.join()}L${middle.join()}`} />}
      {left && right && <path class="scanned" d={`M${left.join()}L${right.join()}`} />}
      {below && <circle cx={below[0]} cy={below[1]} r={4.5} />}
    </g>
  );

  function at(lon: number | null | undefined, lat: number | null | undefined): [number, number] | null {
    return lon == null || lat == null ? null : projection([lon, lat]);
  }
}

function placesOf({ latitude_deg, longitude_deg }: Places): LonLat[] {
  return latitude_deg.flatMap((lat, k): LonLat[] => {
    const lon = longitude_deg[k];
    return lat === null || lon == null ? [] : [[lon, lat]];
  });
}
