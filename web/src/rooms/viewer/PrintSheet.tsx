/** A look on paper: the map and how the axes move; drawn only while the browser prints. */
import { useEffect, useState } from "preact/hooks";

import { Plane, pathOf, span } from "../../charts/Plane";
import { words } from "../../i18n";
import { clock } from "../../i18n/forms";
import { wantOutlines } from "../../map/outlines";
import type { Stretch } from "../../time/TimeBar";
import { MapPicture } from "./FlatMap";
import { hasAngles, hasPlaces, lastOf, type View } from "./view";

const MAP_PX = { width: 700, height: 195 };
const CHART_PX = 118;
const MOST_POINTS = 700;
const MOTION = [
  { key: "angle", column: "angle_deg", unit: "°" },
  { key: "rate", column: "rate_deg_s", unit: "°/s" },
  { key: "acceleration", column: "acceleration_deg_s2", unit: "°/s²" },
] as const;

type Values = readonly (number | null)[];

interface Props {
  view: View;
  stretches: readonly Stretch[];
}

export function PrintSheet(props: Props) {
  const [isPrinting, setIsPrinting] = useState(false);
  useEffect(() => {
    const begin = () => setIsPrinting(true);
    const end = () => setIsPrinting(false);
    void wantOutlines().catch(() => undefined); // a map without coasts is still one
    window.addEventListener("beforeprint", begin);
    window.addEventListener("afterprint", end);
    return () => {
      window.removeEventListener("beforeprint", begin);
      window.removeEventListener("afterprint", end);
    };
  }, []);
  return isPrinting ? <Sheet {...props} /> : null;
}

function Sheet({ view, stretches }: Props) {
  const text = words.value.viewer.charts;
  const sight = [...view.targets.map((target) => target.elevation_deg), view.boresight.off_nadir_deg];
  return (
    <div class="sheet">
      <MapPicture view={view} reach="pass" closer={1} {...MAP_PX} />
      <div class="sheet-charts">
        {(hasAngles(view) ? MOTION : MOTION.slice(1)).map(({ key, column, unit }) => (
          <Chart
            key={key}
            view={view}
            stretches={stretches}
            name={`${text[key]}, ${unit}`}
            keys={Object.keys(view.axes)}
            lines={Object.values(view.axes).map((axis) => axis[column])}
          />
        ))}
        <Chart
          view={view}
          stretches={stretches}
          name={`${text.sight}, °`}
          keys={[hasPlaces(view) ? text.elevation : text.aboveLimb, text.offNadir]}
          lines={sight}
          colours={[...view.targets.map(() => 0), 1]}
        />
      </div>
    </div>
  );
}

interface ChartProps extends Props {
  name: string;
  /** What the colours are of. */
  keys: readonly string[];
  lines: readonly Values[];
  /** Of each line; as they come unless said. */
  colours?: readonly number[];
}

function Chart({ view, stretches, name, keys, lines, colours }: ChartProps) {
  const every = Math.ceil(view.t_s.length / MOST_POINTS);
  const isShown = (_: unknown, row: number) => row % every === 0;
  const t_s = view.t_s.filter(isShown);
  const y = span(lines.flat(), 1e-6);
  return (
    <figure>
      <figcaption>
        {name}
        {keys.map((key, index) => (
          <span key={key} class={`key key-axis-${index}`}>
            {key}
          </span>
        ))}
      </figcaption>
      <Plane
        label={name}
        xLabel={words.value.viewer.charts.since(clock(view.epoch))}
        yLabel=""
        x={[0, lastOf(view.t_s)]}
        y={y}
        height={CHART_PX}
      >
        {(scale) => (
          <>
            {stretches
              .filter((one) => one.kind === "track")
              .map(({ start_s, stop_s }) => (
                <rect
                  key={start_s}
                  class="sheet-session"
                  x={scale.x(start_s)}
                  y={scale.y(y[1])}
                  width={scale.x(stop_s) - scale.x(start_s)}
                  height={scale.y(y[0]) - scale.y(y[1])}
                />
              ))}
            {lines.map((values, index) => (
              <path
                key={index}
                class={`sheet-line sheet-line-${colours?.[index] ?? index}`}
                d={pathOf(t_s, values.filter(isShown), scale)}
              />
            ))}
          </>
        )}
      </Plane>
    </figure>
  );
}
