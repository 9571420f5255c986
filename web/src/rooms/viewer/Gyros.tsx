/** The gyros of a body: their gimbals over time, and the momentum that they hold. */
import { useCallback, useMemo } from "preact/hooks";

import { MomentumSphere } from "../../charts/MomentumSphere";
import { Strip } from "../../charts/Strip";
import { type Line, TimeChart } from "../../charts/TimeChart";
import { words } from "../../i18n";
import { digits } from "../../i18n/forms";
import type { View } from "./view";

const HEIGHT = 118;
const GIMBALS = ["1", "2", "3", "4"];

type Gyros = NonNullable<View["gyros"]>;

export function Sphere({ view, gyros }: { view: View; gyros: Gyros }) {
  const isOn = useCallback((row: number) => view.activity[row] === "track", [view]);
  const { momentum_n_m_s, momentum_max_n_m_s } = gyros;
  return <MomentumSphere momentum_n_m_s={momentum_n_m_s} most_n_m_s={momentum_max_n_m_s} step_s={view.step_s} isOn={isOn} />;
}

interface Props {
  gyros: Gyros;
  common: Pick<Parameters<typeof TimeChart>[0], "epoch_ms" | "t_s" | "shades" | "range">;
  withLimits: boolean;
}

export function GyroCharts({ gyros, common, withLimits }: Props) {
  const text = words.value.viewer;
  const { gimbal_rate_max_deg_s: fastest, momentum_max_n_m_s: most } = gyros;
  const lines = useMemo(() => {
    const sizes = gyros.momentum_n_m_s.map((h) => Math.hypot(...h));
    const momentum: Line[] = [{ label: "|H|", values: sizes, colour: "series-1" }];
    return { angles: linesOf(gyros.gimbal_deg), rates: linesOf(gyros.gimbal_rate_deg_s), momentum, largest: Math.max(...sizes) };
  }, [gyros]);
  // The same lists from one drawing to the next: a chart is made anew for others.
  const levels = useMemo(() => ({ rates: [-fastest, fastest], momentum: [most] }), [fastest, most]);
  const rate_deg_s = Math.max(...gyros.gimbal_rate_deg_s.flat().map(Math.abs));
  return (
    <>
      <Strip name={text.gyros.gimbals} unit="°" keys={GIMBALS} fact="">
        <TimeChart {...common} label={text.charts.told(text.gyros.gimbals, "°")} lines={lines.angles} height={HEIGHT} />
      </Strip>
      <Strip name={text.gyros.gimbalRates} unit="°/s" keys={GIMBALS} fact={text.gyros.most(digits(rate_deg_s), digits(fastest))}>
        <TimeChart
          {...common}
          label={text.charts.told(text.gyros.gimbalRates, "°/s")}
          lines={lines.rates}
          limits={levels.rates}
          withLimits={withLimits}
          height={HEIGHT}
        />
      </Strip>
      <Strip name={text.gyros.momentum} unit="N·m·s" keys={[]} fact={text.gyros.most(digits(lines.largest), digits(most))}>
        <TimeChart
          {...common}
          label={text.charts.told(text.gyros.momentum, "N·m·s")}
          lines={lines.momentum}
          limits={levels.momentum}
          withLimits={withLimits}
          height={HEIGHT}
        />
      </Strip>
    </>
  );
}

function linesOf(rows: readonly (readonly number[])[]): Line[] {
  return GIMBALS.map((label, k) => ({
    label,
    values: rows.map((row) => row[k] ?? null),
    colour: `series-${k + 1}`,
  }));
}
