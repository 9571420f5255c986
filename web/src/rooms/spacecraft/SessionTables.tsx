/** Looks, turns and what is left out, in order of time. */
import { words } from "../../i18n";
import { digits, number, period } from "../../i18n/forms";
import type { Session } from "./session";
import { nameOf } from "./stretches";

export function LeftOut({ session }: { session: Session }) {
  const text = words.value.spacecraft;
  return (
    <section class="notice notice-warn" aria-labelledby="session-left-out">
      <h2 id="session-left-out">{text.leftOut}</h2>
      <dl class="left-out">
        {session.left_out.map((one) => (
          <>
            <dt>{one.name}</dt>
            <dd>{one.reason}</dd>
          </>
        ))}
      </dl>
    </section>
  );
}

export function Looks({ session }: { session: Session }) {
  const text = words.value.spacecraft;
  const { columns } = text;
  return (
    <section class="panel" aria-labelledby="session-looks">
      <h2 id="session-looks">{text.looks}</h2>
      <div class="scroll-x" tabIndex={0} role="group" aria-label={text.looks}>
        <table class="session-table">
          <thead>
            <tr>
              <th scope="col">{columns.request}</th>
              <th scope="col">{columns.times}</th>
              <th scope="col" class="number">
                {columns.speed}
              </th>
              <th scope="col" class="number">
                {columns.miss}
              </th>
              <th scope="col" class="number">
                {columns.along}
              </th>
              <th scope="col" class="number">
                {columns.across}
              </th>
              <th scope="col" class="number">
                {columns.rateError}
              </th>
              <th scope="col" class="number">
                {columns.smear}
              </th>
              <th scope="col" class="number">
                {columns.spare}
              </th>
              <th scope="col" class="number">
                {columns.momentumMargin}
              </th>
              <th scope="col">{columns.steady}</th>
            </tr>
          </thead>
          <tbody>
            {session.windows.map((one, k) => {
              const flown = session.stabilisation.windows[k];
              return (
                <tr key={one.first_row}>
                  <th scope="row">{nameOf(session, one)}</th>
                  <td class="mono nowrap">{period(one.start, one.stop).replace(" UTC", "")}</td>
                  <td class="number">{number(one.scan_speed_m_s, 0)}</td>
                  <td class="number">{one.miss_m < 0.001 ? "< 0.001" : digits(one.miss_m, 2)}</td>
                  <td class="number">{number(one.along_deg)}</td>
                  <td class="number">{number(one.across_deg)}</td>
                  <td class="number">{flown ? digits(Math.max(...flown.rate_error_deg_s), 2) : "–"}</td>
                  <td class="number">{flown ? digits(flown.smear_px, 2) : "–"}</td>
                  <td class="number">{flown ? number(flown.spare_s) : "–"}</td>
                  <td class="number">{flown ? number(flown.momentum_margin_n_m_s) : "–"}</td>
                  <td>{flown && <span class={flown.steady ? "is-good" : "is-bad"}>{flown.steady ? text.yes : text.no}</span>}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      </div>
    </section>
  );
}

export function Slews({ session }: { session: Session }) {
  const text = words.value.spacecraft;
  const { columns } = text;
  return (
    <section class="panel" aria-labelledby="session-slews">
      <h2 id="session-slews">{text.slews}</h2>
      <div class="scroll-x" tabIndex={0} role="group" aria-label={text.slews}>
        <table class="session-table">
          <thead>
            <tr>
              <th scope="col">{columns.onto}</th>
              <th scope="col">{columns.times}</th>
              <th scope="col" class="number">
                {columns.angle}
              </th>
              <th scope="col" class="number">
                {columns.duration}
              </th>
              <th scope="col" class="number">
                {columns.eigenaxis}
              </th>
              <th scope="col" class="number">
                {columns.bangCoastBang}
              </th>
              <th scope="col" class="number">
                {columns.torqueRate}
              </th>
              <th scope="col" class="number">
                {columns.torqueRateEigenaxis}
              </th>
            </tr>
          </thead>
          <tbody>
            {session.slews.map((one) => {
              const onto = one.onto === null ? null : session.windows[one.onto];
              return (
                <tr key={one.start}>
                  <th scope="row">{onto ? nameOf(session, onto) : text.rest}</th>
                  <td class="mono nowrap">{period(one.start, one.stop).replace(" UTC", "")}</td>
                  <td class="number">{number(one.angle_deg)}</td>
                  <td class="number">{number(one.duration_s)}</td>
                  <td class="number">{number(one.eigenaxis_s)}</td>
                  <td class="number">{number(one.bang_coast_bang_s)}</td>
                  <td class="number">{digits(one.torque_rate_peak_n_m_s)}</td>
                  <td class="number">{digits(one.eigenaxis_torque_rate_peak_n_m_s)}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      </div>
    </section>
  );
}
