/** One axis: its errors phase by phase, its oscillations, where it stuck, what it exceeded. */
import type { ComponentChildren } from "preact";

import { words } from "../../i18n";
import { digits, fixed, number, period } from "../../i18n/forms";
import type { Comparison } from "./compare";

type AxisComparison = Comparison["axes"][string];

export function Axis({ name, axis, hasDrive }: { name: string; axis: AxisComparison; hasDrive: boolean }) {
  const text = words.value.telemetry;
  return (
    <section class="panel" aria-labelledby={`axis-${name}`}>
      <h2 id={`axis-${name}`}>{name}</h2>
      <p>
        {text.errors(digits(axis.rms_arcsec), digits(axis.max_arcsec), text.bases[axis.basis])}{" "}
        {axis.lag_s === null || axis.lag_sigma_s === null
          ? text.noLag
          : text.lag(fixed(axis.lag_s, 4), fixed(axis.lag_sigma_s, 4))}{" "}
        {axis.gain && text.gain(fixed(axis.gain.value, 6), fixed(axis.gain.sigma, 6))}{" "}
        {axis.bias && text.bias(fixed(axis.bias.value, 2), fixed(axis.bias.sigma, 2), axis.bias_unit)}
      </p>
      {axis.rate_gain && axis.rate_bias_arcsec_s && (
        <p>
          {text.rates} {text.gain(fixed(axis.rate_gain.value, 6), fixed(axis.rate_gain.sigma, 6))}{" "}
          {text.bias(fixed(axis.rate_bias_arcsec_s.value, 3), fixed(axis.rate_bias_arcsec_s.sigma, 3), "arcsec/s")}
        </p>
      )}
      {axis.noise_arcsec && (
        <p>
          {text.noise(fixed(axis.noise_arcsec.value, 2), fixed(axis.noise_arcsec.sigma, 2))}{" "}
          {axis.wander_arcsec && axis.wander_half_life_s
            ? text.wander(
                fixed(axis.wander_arcsec.value, 2),
                fixed(axis.wander_arcsec.sigma, 2),
                fixed(axis.wander_half_life_s.value, 1),
                fixed(axis.wander_half_life_s.sigma, 1),
              )
            : text.noWander}
        </p>
      )}
      <Stretches
        axis={name}
        title={text.phases}
        columns={[text.phase, text.samples, "rms ″", "max ″"]}
        rows={axis.phases.map((phase) => ({
          ...phase,
          values: [
            phase.session === null ? text.kinds[phase.kind] : `${text.kinds[phase.kind]} ${phase.session + 1}`,
            number(phase.samples),
            digits(phase.rms_arcsec),
            digits(phase.max_arcsec),
          ],
        }))}
      />
      <Stretches
        axis={name}
        title={text.oscillations}
        columns={["Hz", text.amplitude]}
        rows={axis.oscillations.map((one) => ({
          ...one,
          values: [digits(one.frequency_hz), digits(one.amplitude_arcsec)],
        }))}
      />
      {hasDrive && (
        <Stretches
          axis={name}
          title={text.stickSlip}
          columns={[text.slips, text.stuck, text.slip]}
          rows={axis.stick_slip.map((one) => ({
            ...one,
            values: [number(one.slips), `${number(100 * one.stuck_share)} %`, digits(one.slip_arcsec)],
          }))}
        />
      )}
      <Stretches
        axis={name}
        title={text.exceeded}
        columns={[text.limit, text.value, text.bound]}
        rows={axis.limits_exceeded.map((one) => ({
          ...one,
          values: [one.limit, `${digits(one.value)} ${one.unit}`, `${digits(one.bound)} ${one.unit}`],
        }))}
      />
      <p class="small">{text.checked(axis.limits_checked.join(", ") || "–")}</p>
    </section>
  );
}

interface Props {
  axis: string;
  title: string;
  columns: ComponentChildren[];
  rows: { start: string; stop: string; values: string[] }[];
}

function Stretches({ axis, title, columns, rows }: Props) {
  const text = words.value.telemetry;
  if (rows.length === 0) {
    return (
      <p class="small">
        {title}: {text.none}
      </p>
    );
  }
  return (
    <div class="scroll-x" tabIndex={0} role="region" aria-label={`${axis}: ${title}`}>
      <table>
        <caption>{title}</caption>
        <thead>
          <tr>
            <th scope="col">{text.fromTo}</th>
            {columns.map((column, index) => (
              <th key={index} scope="col">
                {column}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map(({ start, stop, values }) => (
            <tr key={start + stop}>
              <td class="mono">{period(start, stop).replace(" UTC", "")}</td>
              {values.map((value, index) => (
                <td key={index}>{value}</td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
