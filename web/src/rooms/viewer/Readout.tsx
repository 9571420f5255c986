/** The values at the cursor, in figures; said aloud when it comes to rest. */
import { useEffect, useState } from "preact/hooks";

import { words } from "../../i18n";
import { clock, digits, fixed, number } from "../../i18n/forms";
import { targetTold } from "../../i18n/labels";
import { cursor_s, isPlaying } from "../../time/cursor";
import { hasAngles, longitudeAt, rowAt, type View, valueAt } from "./view";

const QUIET_MS = 600;

export function Readout({ view }: { view: View }) {
  const text = words.value.viewer.values;
  const t_s = cursor_s.value;
  const row = rowAt(view, t_s);
  const at = (values: readonly (number | null)[]) => valueAt(view, values, t_s);
  const { carrier, boresight, pointing, sun } = view;
  const target = targetAt(view, row);
  const isLit = carrier.sunlit_share[row];
  const withAngles = hasAngles(view);
  return (
    <section class="panel look-panel look-values">
      <h2>{text.title}</h2>
      <table class="look-axes">
        <thead>
          <tr>
            <th scope="col">{text.axis}</th>
            {withAngles && (
              <th scope="col" class="number">
                °
              </th>
            )}
            <th scope="col" class="number">
              °/s
            </th>
            <th scope="col" class="number">
              °/s²
            </th>
            <th scope="col" class="number">
              °/s³
            </th>
          </tr>
        </thead>
        <tbody>
          {Object.entries(view.axes).map(([name, axis]) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              {withAngles && <td class="number">{fixed(at(axis.angle_deg), 4)}</td>}
              <td class="number">{fixed(at(axis.rate_deg_s), 5)}</td>
              <td class="number">{fixed(axis.acceleration_deg_s2[row], 5)}</td>
              <td class="number">{fixed(axis.jerk_deg_s3[row], 5)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <dl>
        <dt>{text.carrier}</dt>
        <dd>{place(at(carrier.latitude_deg), longitudeAt(view, carrier.longitude_deg, t_s))}</dd>
        <dt>{text.height}</dt>
        <dd>{km(at(carrier.height_m), 1)}</dd>
        <dt>{text.sunlight}</dt>
        <dd>{isLit == null ? "–" : isLit >= 1 ? text.lit : isLit > 0 ? text.penumbra : text.shadow}</dd>
        <dt>{text.boresight}</dt>
        <dd>{place(at(boresight.latitude_deg), longitudeAt(view, boresight.longitude_deg, t_s))}</dd>
        <dt>{text.range}</dt>
        <dd>{km(at(boresight.range_m), 1)}</dd>
        <dt>{text.offNadir}</dt>
        <dd>{unit(at(boresight.off_nadir_deg), 2, "°")}</dd>
        <dt>{text.fromSun}</dt>
        <dd>{unit(at(boresight.sun_separation_deg), 1, "°")}</dd>
        <dt>{text.fromMoon}</dt>
        <dd>{unit(at(boresight.moon_separation_deg), 1, "°")}</dd>
        <dt>{text.sunAboveLimb}</dt>
        <dd>{unit(at(sun.above_limb_deg), 1, "°")}</dd>
        {target && (
          <>
            <dt>{text.target}</dt>
            <dd>{targetTold(target.name)}</dd>
            <dt>{heightName(target)}</dt>
            <dd>{unit(at(target.elevation_deg), 2, "°")}</dd>
            <dt>{text.sample}</dt>
            <dd>{sample(at(target.ground_sample_across_m), at(target.ground_sample_along_m))}</dd>
            <dt>{text.sunElevation}</dt>
            <dd>{unit(at(target.sun_elevation_deg), 1, "°")}</dd>
          </>
        )}
        <dt>{text.error}</dt>
        <dd>{unit(pointing.error_arcsec[row] ?? null, 3, "″")}</dd>
      </dl>
      <Aloud view={view} />
    </section>
  );
}

/** Not while it moves: nobody could follow. */
function Aloud({ view }: { view: View }) {
  const [said, setSaid] = useState("");
  const t_s = cursor_s.value;
  const plays = isPlaying.value;
  useEffect(() => {
    if (plays) return;
    const timer = setTimeout(() => {
      const row = rowAt(view, t_s);
      const axes = Object.entries(view.axes).map(([name, axis]) => {
        const angle = valueAt(view, axis.angle_deg, t_s);
        const rate = `${number(valueAt(view, axis.rate_deg_s, t_s), 3)} °/s`;
        return `${name} ${angle === null ? "" : `${number(angle, 2)}°, `}${rate}`;
      });
      const kinds = words.value.viewer.kinds;
      const target = targetAt(view, row);
      const elevation = target && number(valueAt(view, target.elevation_deg, t_s), 1);
      setSaid(
        [
          `${clock(Date.parse(view.epoch) + 1000 * t_s)} UTC`,
          kinds[view.activity[row] ?? "wait"],
          ...axes,
          target && elevation && `${heightName(target)} ${elevation}°`,
        ]
          .filter(Boolean)
          .join("; "),
      );
    }, QUIET_MS);
    return () => clearTimeout(timer);
  }, [view, t_s, plays]);
  return (
    <p class="hidden" aria-live="polite" data-testid="aloud">
      {said}
    </p>
  );
}

/** Of the session that the row belongs to or leads to. */
export function targetAt(view: View, row: number): View["targets"][number] | null {
  const session = view.session[row];
  return view.targets.find((one) => one.session === session) ?? null;
}

/** What its angle is measured from: the horizon of its place, or the Earth's limb of what is in space. */
function heightName(target: View["targets"][number]): string {
  const { elevation, aboveLimb } = words.value.viewer.values;
  return target.latitude_deg.some((one) => one !== null) ? elevation : aboveLimb;
}

function unit(value: number | null, decimals: number, sign: string): string {
  return value === null ? "–" : `${fixed(value, decimals)}${sign}`;
}

function km(value_m: number | null, decimals: number): string {
  return value_m === null ? "–" : `${fixed(value_m / 1000, decimals)} ${words.value.viewer.units.km}`;
}

function sample(across_m: number | null, along_m: number | null): string {
  return across_m === null ? "–" : `${digits(across_m)} × ${digits(along_m)} ${words.value.viewer.units.m}`;
}

function place(latitude_deg: number | null, longitude_deg: number | null): string {
  if (latitude_deg === null || longitude_deg === null) return "–";
  return `${fixed(latitude_deg, 3)}, ${fixed(longitude_deg, 3)}`;
}
