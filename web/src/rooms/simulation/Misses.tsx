/** Histogram of the greatest distance of the target from the boresight, run by run. */
import { Plane } from "../../charts/Plane";
import { words } from "../../i18n";
import { digits } from "../../i18n/forms";
import type { Flights } from "./flights";

type Histogram = NonNullable<Flights["sessions"][number]["misses"]>;

const HEIGHT = 190;

export function Misses({ misses }: { misses: Histogram }) {
  const text = words.value.simulation;
  const { edges_arcsec, counts, beyond } = misses;
  const most = Math.max(...counts, 1);
  const last = edges_arcsec.at(-1) ?? 0;
  return (
    <figure class="histogram">
      <Plane
        label={text.histogramOf(digits(last))}
        xLabel={text.missAxis}
        yLabel={text.runsAxis}
        x={[0, last || 1]}
        y={[0, 1.05 * most]}
        height={HEIGHT}
      >
        {({ x, y }) =>
          counts.map((count, index) => {
            const [from, to] = [edges_arcsec[index] ?? 0, edges_arcsec[index + 1] ?? 0];
            return (
              <rect key={from} x={x(from) + 0.5} width={Math.max(x(to) - x(from) - 1, 0.5)} y={y(count)} height={y(0) - y(count)}>
                <title>{`${digits(from)}″ – ${digits(to)}″: ${count}`}</title>
              </rect>
            );
          })
        }
      </Plane>
      <figcaption class="small">
        {text.histogram} {beyond > 0 && text.beyond(beyond)}
      </figcaption>
    </figure>
  );
}
