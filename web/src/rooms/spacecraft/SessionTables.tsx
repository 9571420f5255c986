/** Looks and slews, in order of time. */
import { words } from "../../i18n";
import { digits, number } from "../../i18n/forms";
import { type Column, TablePanel, timesOf } from "../../parts/TablePanel";
import type { Session } from "./session";

/** Without what closed-loop runs tell where there were none. */
type Look = Session["windows"][number] & Partial<Session["stabilisation"]["windows"][number]>;
type Slew = Session["slews"][number];

export function Looks({ session }: { session: Session }) {
  const text = words.value.spacecraft;
  const { columns } = text;
  const told = (isSteady: boolean) => <span class={isSteady ? "is-good" : "is-bad"}>{isSteady ? text.yes : text.no}</span>;
  const all: Column<Look>[] = [
    [columns.request, (one) => nameOf(session, one)],
    [columns.times, timesOf, "mono nowrap"],
    [columns.speed, (one) => number(one.scan_speed_m_s, 0), "number"],
    [columns.miss, (one) => (one.miss_m < 0.001 ? "< 0.001" : digits(one.miss_m, 2)), "number"],
    [columns.along, (one) => number(one.along_deg), "number"],
    [columns.across, (one) => number(one.across_deg), "number"],
    [columns.rateError, (one) => digits(Math.max(...(one.rate_error_deg_s ?? [Number.NaN])), 2), "number"],
    [columns.smear, (one) => digits(one.smear_px, 2), "number"],
    [columns.spare, (one) => number(one.spare_s), "number"],
    [columns.momentumMargin, (one) => number(one.momentum_margin_n_m_s), "number"],
    [columns.steady, ({ steady }) => (steady === undefined ? "–" : told(steady)), "number"],
  ];
  const rows = session.windows.map((one, index) => ({ ...one, ...session.stabilisation.windows[index] }));
  return <TablePanel title={text.looks} rows={rows} columns={all} />;
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
    [columns.times, timesOf, "mono nowrap"],
    [columns.angle, (one) => number(one.angle_deg), "number"],
    [columns.duration, (one) => number(one.duration_s), "number"],
    [columns.eigenaxis, (one) => number(one.eigenaxis_s), "number"],
    [columns.bangCoastBang, (one) => number(one.bang_coast_bang_s), "number"],
    [columns.torqueRate, (one) => digits(one.torque_rate_peak_n_m_s), "number"],
    [columns.torqueRateEigenaxis, (one) => digits(one.eigenaxis_torque_rate_peak_n_m_s), "number"],
  ];
  return <TablePanel title={text.slews} rows={session.slews} columns={all} />;
}

/** "stereo", or "stereo 2" where a request has several looks. */
function nameOf(session: Session, { request, look }: { request: string; look: number }): string {
  const several = session.windows.filter((one) => one.request === request).length > 1;
  return several ? `${request} ${look + 1}` : request;
}
