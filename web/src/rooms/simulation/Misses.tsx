/** Histogram of the greatest distance of the target from the boresight, run by run. */
import { words } from "../../i18n";
import { digits } from "../../i18n/forms";
import type { Flights } from "./flights";

type Histogram = NonNullable<Flights["sessions"][number]["misses"]>;

const WIDTH = 420;
const HEIGHT = 150;

export function Misses({ misses }: { misses: Histogram }) {
  const text = words.value.simulation;
  const { edges_arcsec, counts, beyond } = misses;
  const most = Math.max(...counts, 1);
  const bar = WIDTH / counts.length;
  const last = edges_arcsec.at(-1) ?? 0;
  return (
    <figure>
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT + 18}`} class="histogram" role="img" aria-label={text.histogramOf(digits(last))}>
        {counts.map((count, index) => (
          <rect
            key={edges_arcsec[index]}
            x={index * bar + 0.5}
            width={bar - 1}
            y={HEIGHT * (1 - count / most)}
            height={(HEIGHT * count) / most}
          >
            <title>{`${digits(edges_arcsec[index])}″ – ${digits(edges_arcsec[index + 1])}″: ${count}`}</title>
          </rect>
        ))}
        <line x2={WIDTH} y1={HEIGHT} y2={HEIGHT} />
        <text y={HEIGHT + 14}>0″</text>
        <text x={WIDTH} y={HEIGHT + 14} text-anchor="end">
          {digits(last)}″
        </text>
      </svg>
      <figcaption class="small">
        {text.histogram} {beyond > 0 && text.beyond(beyond)}
      </figcaption>
    </figure>
  );
}
