/** Error and smear of the session's frames, flown as planned. */
import { words } from "../../i18n";
import { digits } from "../../i18n/forms";
import type { Flights } from "./Flown";

interface Props {
  nominal: Flights["sessions"][number]["nominal"];
}

export function Frames({ nominal }: Props) {
  const text = words.value.flights;
  return (
    <>
      <Series name={text.error} unit="″" t_s={nominal.t_s} values={nominal.error_arcsec} />
      <Series name={text.smearOfFrames} unit="px" t_s={nominal.t_s} values={nominal.smear_px} bound={1} />
    </>
  );
}

interface SeriesProps {
  name: string;
  unit: string;
  t_s: readonly number[];
  values: readonly number[];
  /** Drawn as a line. */
  bound?: number;
}

const WIDTH = 420;
const HEIGHT = 150;

function Series({ name, unit, t_s, values, bound }: SeriesProps) {
  const first = t_s[0] ?? 0;
  const last = t_s.at(-1) ?? first + 1;
  const top = Math.max(...values, bound ?? 0) * 1.05 || 1;
  const x = (t: number) => (WIDTH * (t - first)) / (last - first || 1);
  const y = (value: number) => HEIGHT * (1 - value / top);
  const line = values.map((value, index) => `${x(t_s[index] ?? first).toFixed(1)},${y(value).toFixed(1)}`).join(" ");
  const most = `${digits(Math.max(...values))} ${unit}`;
  return (
    <figure>
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT + 18}`} class="series" role="img" aria-label={words.value.flights.seriesOf(name, most)}>
        {bound !== undefined && <line class="bound" x2={WIDTH} y1={y(bound)} y2={y(bound)} />}
        <polyline points={line} />
        <line x2={WIDTH} y1={HEIGHT} y2={HEIGHT} />
        <text y={HEIGHT + 14}>{digits(first, 4)} s</text>
        <text x={WIDTH} y={HEIGHT + 14} text-anchor="end">
          {digits(last, 4)} s
        </text>
      </svg>
      <figcaption class="small">
        {name}: {words.value.flights.atMost(most)}
      </figcaption>
    </figure>
  );
}
