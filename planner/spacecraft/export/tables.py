"""The table of an imaging session as CSV, NetCDF and CCSDS AEM."""

import io
from datetime import datetime
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.csv_cells import comment_lines
from planner.base.header_text import one_line
from planner.base.rotation import continuous
from planner.output.export.ccsds import (
    BODY_FRAME,
    QUATERNION_DECIMALS,
    AttitudeSegment,
    attitude_message,
)
from planner.output.export.csv import rows_csv
from planner.output.export.description import DECIMALS, QUATERNION, TIME_SCALE
from planner.output.export.netcdf import describe
from planner.spacecraft.export.session_table import SessionTable
from planner.spacecraft.table import TICK_S, AttitudeTable
from planner.world.frames.time_scales import Instants, utc_text

_BODY_AXES = "body: X along flight, Y up (the optical axis is -Y), Z = X x Y; eci: GCRF axes"
_BETWEEN = "between rows: quintic Hermite in modified Rodrigues parameters; gimbal rates are held"


_PARTS_BY_SIDE = {
    "": ("",),
    "xyz": ("x", "y", "z"),
    "xyzw": ("x", "y", "z", "w"),
    "gimbal": ("1", "2", "3", "4"),
}


class _Column(NamedTuple):
    """rows: shape (n, k), one value a part of its side; unit as UDUNITS writes it."""

    name: str
    side: str
    unit: str
    rows: Array
    decimals: int = DECIMALS


def _table_columns(table: AttitudeTable) -> tuple[_Column, ...]:
    on = np.append(table.imaging(), False)
    for window in table.windows:
        on[window.last_row] = True
    q_body_from_eci_xyzw = continuous(table.q_body_from_eci)
    return (
        _Column("q_body_from_eci", "xyzw", "1", q_body_from_eci_xyzw, QUATERNION_DECIMALS),
        _degrees_column("omega_body_deg_s", "xyz", "degree s-1", table.omega_body_rad_s),
        _degrees_column("alpha_body_deg_s2", "xyz", "degree s-2", table.alpha_body_rad_s2),
        _degrees_column("gimbal_deg", "gimbal", "degree", table.gimbal_rad),
        _degrees_column("gimbal_rate_deg_s", "gimbal", "degree s-1", table.gimbal_rate_rad_s),
        _Column("imaging", "", "1", on[:, None].astype(float), decimals=0),
    )


def _degrees_column(name: str, side: str, unit: str, values_rad: Array) -> _Column:
    return _Column(name, side, unit, np.degrees(values_rad) + 0.0)


def session_notes(plan: SessionTable, created_utc: datetime) -> tuple[str, ...]:
    """Lines of one text each, for headers and comments."""
    return (
        f"slewtrack imaging session {one_line(plan.request.name) or 'without a name'}, "
        f"spacecraft {one_line(plan.spacecraft.name)}, written {utc_text(created_utc)}",
        f"epoch {utc_text(plan.table.epoch_utc, 1)}, a row every {TICK_S} s; "
        f"time scale {TIME_SCALE}",
        _BODY_AXES,
        QUATERNION,
        _BETWEEN,
        *(
            f"imaging {one_line(window.request)} look {window.look}: rows "
            f"{window.first_row} to {window.last_row}"
            for window in plan.table.windows
        ),
    )


def write_csv(plan: SessionTable, created_utc: datetime) -> bytes:
    """One row per 0.2 s under lines that begin with `#` and say what the columns don't."""
    head = comment_lines(session_notes(plan, created_utc))
    columns = _table_columns(plan.table)
    parts = [(column, part) for column in columns for part in _PARTS_BY_SIDE[column.side]]
    names = [f"{column.name}_{part}".rstrip("_") for column, part in parts]
    rows = np.hstack([column.rows for column in columns])
    decimals = [column.decimals for column, _ in parts]
    return (head + rows_csv(plan.table.epoch_utc, plan.table.t_s, names, rows, decimals)).encode()


def write_netcdf(plan: SessionTable, created_utc: datetime) -> bytes:
    """Classic format, CF: `time` counts SI seconds since row 0, whose UTC is its reference."""
    table = plan.table
    buffer = io.BytesIO()
    from scipy.io import netcdf_file

    with netcdf_file(buffer, "w", version=2) as file:
        describe(
            file,
            Conventions="CF-1.12",
            title=one_line(plan.request.name) or "slewtrack imaging session",
            history=f"{utc_text(created_utc)} written by slewtrack",
            comment="\n".join(session_notes(plan, created_utc)),
        )
        file.createDimension("time", len(table.t_s))
        for side, parts in _PARTS_BY_SIDE.items():
            if side:
                file.createDimension(side, len(parts))
        time = file.createVariable("time", "d", ("time",))
        time[:] = table.t_s
        since = utc_text(table.epoch_utc, 1).replace("T", " ").removesuffix("Z")
        describe(
            time,
            standard_name="time",
            units=f"seconds since {since}",
            calendar="standard",
            axis="T",
        )
        for column in _table_columns(table):
            name = column.name + "_xyzw" * (column.side == "xyzw")
            sides = (column.side,) if column.side else ()
            variable = file.createVariable(name, "d", ("time", *sides))
            variable[:] = column.rows if sides else column.rows[:, 0]
            describe(variable, units=column.unit)
        file.flush()
        return buffer.getvalue()


def write_aem(plan: SessionTable, created_utc: datetime) -> bytes:
    """CCSDS AEM 2.0, KVN: attitude of the body against GCRF and its angular velocity."""
    table = plan.table
    return attitude_message(
        created_utc,
        session_notes(plan, created_utc),
        plan.request.orbit,
        Instants(table.epoch_utc, table.t_s),
        [AttitudeSegment(BODY_FRAME, continuous(table.q_body_from_eci), table.omega_body_rad_s)],
    )
