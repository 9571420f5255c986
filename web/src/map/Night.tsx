/** The hemisphere away from the Sun. */
import { type GeoPath, geoCircle } from "d3-geo";

import type { LonLat } from "./places";

interface Props {
  /** The place that has the Sun overhead. */
  sun: LonLat;
  path: GeoPath;
  class: string;
}

export function Night({ sun: [longitude, latitude], path, class: name }: Props) {
  const night = geoCircle()
    .center([longitude + 180, -latitude])
    .radius(90)();
  return <path class={name} d={path(night) ?? ""} />;
}
