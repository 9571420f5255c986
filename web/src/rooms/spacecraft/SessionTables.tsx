/** Looks, slews and what is left out, in order of time. */
import type { ComponentChildren } from "preact";

import { words } from "../../i18n";
import { digits, number, period } from "../../i18n/forms";
import type { Session } from "./session";

type Look = Session["windows"][number];
type Slew = Session["slews"][number];
/** A heading, and what stands under it; the first names the row. */
type Column<Row> = [heading: string, told: (row: Row, index: number) => ComponentChildren];

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
  const flown = (index: number) => session.stabilisation.windows[index];
  const ofRuns = (told: (one: NonNullable<ReturnType<typeof flown>>) => ComponentChildren) => (_: Look, index: number) => {
    const one = flown(index);
    return one ? told(one) : "–";
  };
  const all: Column<Look>[] = [
    [columns.request, (one) => nameOf(session, one)],
    [columns.times, timesOf],
    [columns.speed, (one) => number(one.scan_speed_m_s, 0)],
    [columns.miss, (one) => (one.miss_m < 0.001 ? "< 0.001" : digits(one.miss_m, 2))],
    [columns.along, (one) => number(one.along_deg)],
    [columns.across, (one) => number(one.across_deg)],
    [columns.rateError, ofRuns((one) => digits(Math.max(...one.rate_error_deg_s), 2))],
    [columns.smear, ofRuns((one) => digits(one.smear_px, 2))],
    [columns.spare, ofRuns((one) => number(one.spare_s))],
    [columns.momentumMargin, ofRuns((one) => number(one.momentum_margin_n_m_s))],
    [columns.steady, ofRuns((one) => <span class={one.steady ? "is-good" : "is-bad"}>{one.steady ? text.yes : text.no}</span>)],
  ];
  return <Listed id="session-looks" title={text.looks} rows={session.windows} columns={all} />;
}

export function Slews({ session }: { session: Session }) {
  const text = words.value.spacecraft;
  const { columns } = text;
  const ontoOf = ({ onto }: Slew) => {
    const look = onto === null ? undefined : session.windows[onto];
    return look ? nameOf(session, look) : text.rest;
  };
  const all: Column<Slew>[] = [
    [columns.onto, ontoOf],
    [columns.times, timesOf],
    [columns.angle, (one) => number(one.angle_deg)],
    [columns.duration, (one) => number(one.duration_s)],
    [columns.eigenaxis, (one) => number(one.eigenaxis_s)],
    [columns.bangCoastBang, (one) => number(one.bang_coast_bang_s)],
    [columns.torqueRate, (one) => digits(one.torque_rate_peak_n_m_s)],
    [columns.torqueRateEigenaxis, (one) => digits(one.eigenaxis_torque_rate_peak_n_m_s)],
  ];
  return <Listed id="session-slews" title={text.slews} rows={session.slews} columns={all} />;
}

interface ListedProps<Row> {
  id: string;
  title: string;
  rows: readonly Row[];
  columns: readonly Column<Row>[];
}

function Listed<Row extends { start: string }>({ id, title, rows, columns: [named, ...others] }: ListedProps<Row>) {
  const kindOf = (column: number) => (column === 0 ? "mono nowrap" : "number");
  return (
    <section class="panel" aria-labelledby={id}>
      <h2 id={id}>{title}</h2>
      <div class="scroll-x" tabIndex={0} role="group" aria-label={title}>
        <table class="session-table">
          <thead>
            <tr>
              <th scope="col">{named?.[0]}</th>
              {others.map(([heading], column) => (
                <th key={heading} scope="col" class={column === 0 ? undefined : "number"}>
                  {heading}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {rows.map((row, index) => (
              <tr key={row.start}>
                <th scope="row">{named?.[1](row, index)}</th>
                {others.map(([heading, told], column) => (
                  <td key={heading} class={kindOf(column)}>
                    {told(row, index)}
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}

function timesOf({ start, stop }: { start: string; stop: string }): string {
  return period(start, stop).replace(" UTC", "");
}

/** "stereo", or "stereo 2" where a request has several looks. */
function nameOf(session: Session, { request, look }: { request: string; look: number }): string {
  const several = session.windows.filter((one) => one.request === request).length > 1;
  return several ? `${request} ${look + 1}` : request;
}
