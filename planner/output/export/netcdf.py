"""A plan as NetCDF: classic format, CF conventions."""

from __future__ import annotations

import io
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import Channel
from planner.base.header_text import one_line
from planner.output.export.description import QUATERNION, TIME_SCALE, carrier_name
from planner.output.export.ground import BORESIGHT_PAYLOAD, sights
from planner.output.export.table_states import (
    TableStates,
    omega_payload_from_eci_rad_s,
    table_states,
)
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import DAY_S, Instants, utc_text
from planner.world.plan import KINDS, FlightPlan, segment_rows

if TYPE_CHECKING:
    from scipy.io import netcdf_file, netcdf_variable

FILL = np.float64(9.969209968386869e36)  # NetCDF's own default for doubles
NO_SESSION = -1
_TEXT = len("2015-02-27T17:34:00.0Z")


def write_netcdf(plan: FlightPlan, created_utc: datetime) -> bytes:
    """Angles, rates, what is being done, attitude, orbit and where the boresight meets the ground.

    `time` counts SI seconds since row 0, whose UTC is its reference; so no leap second lies
    between reference and data unless the table itself holds one, and then the calendar is
    "utc" (CF 1.12), which programs that don't count leap seconds refuse to misread.
    `utc` is the text of every row.  Source: CF conventions 1.12, sections 3, 4.4, 5.
    """
    rows = table_states(plan)
    buffer = io.BytesIO()
    from scipy.io import netcdf_file  # what only names the format needn't load

    with netcdf_file(buffer, "w", version=2) as file:
        write_global_attributes(file, plan, created_utc)
        file.createDimension("time", len(plan.table.t_s))
        file.createDimension("xyz", 3)
        file.createDimension("xyzw", 4)
        write_times(file, Instants(plan.table.epoch_utc, plan.table.t_s))
        for channel, value_by_row in plan.table.columns:
            _write(file, _identifier(channel, plan), value_by_row, channel.unit, _meaning(channel))
        _segments(file, plan)
        _attitude(file, plan, rows)
        _ground(file, rows)
        file.flush()
        return buffer.getvalue()


def write_global_attributes(file: netcdf_file, plan: FlightPlan, created_utc: datetime) -> None:
    """What the file is of, and its frames."""
    scenario = plan.scenario
    spacecraft, about = carrier_name(scenario.orbit), scenario.platform.described()
    describe(
        file,
        Conventions="CF-1.12",
        title=one_line(scenario.name) or "slewtrack plan",
        history=f"{utc_text(created_utc)} written by slewtrack",
        platform=one_line(scenario.platform.name),
        carrier=f"{spacecraft.name} ({spacecraft.designator})",
        rotation_order=about.rotation_order,
        mount=about.mount,
        time_scale=TIME_SCALE,
        interpolation=about.interpolation,
        frames="gcrf: geocentric, axes of the ICRF; body: of the carrier; "
        f"{about.payload_axes}; {QUATERNION}",
    )


def write_times(file: netcdf_file, instants: Instants) -> None:
    """Along the dimension `time`, counted from the epoch, which is a row of a table."""
    texts, epoch = instants.utc_text(1), utc_text(instants.epoch_utc, 1)
    time = file.createVariable("time", "d", ("time",))
    time[:] = instants.t_s
    describe(
        time,
        standard_name="time",
        long_name="SI seconds since row 0",
        units=f"seconds since {epoch.replace('T', ' ').removesuffix('Z')}",
        calendar="utc" if _holds_leap_second(instants) else "standard",
        axis="T",
    )
    file.createDimension("utc_characters", _TEXT)
    utc = file.createVariable("utc", "c", ("time", "utc_characters"))
    utc[:] = np.array([list(text) for text in texts], dtype="S1")
    describe(utc, long_name="UTC of the row, RFC 3339; a leap second reads 23:59:60")


def _holds_leap_second(instants: Instants) -> bool:
    """Whether a clock of 86400 s days would lose a second between first and last row."""
    jd1, jd2 = instants.utc_jd()
    counted_s = ((jd1[-1] - jd1[0]) + (jd2[-1] - jd2[0])) * DAY_S
    in_leap = any(text[17:19] == "60" for text in instants.utc_text(1))
    return in_leap or abs(counted_s - (instants.t_s[-1] - instants.t_s[0])) > 0.5


def _segments(file: netcdf_file, plan: FlightPlan) -> None:
    count = len(plan.table.t_s)
    kind, session = np.zeros(count, dtype="i1"), np.zeros(count, dtype="i4")
    for segment in plan.segments:
        first, last = segment_rows(plan.table, segment)
        kind[first : last + 1] = KINDS.index(segment.kind)
        session[first : last + 1] = NO_SESSION if segment.session is None else segment.session
    activity = file.createVariable("activity", "b", ("time",))
    activity[:] = kind
    describe(
        activity,
        long_name="what the platform does",
        flag_values=np.arange(len(KINDS), dtype="i1"),
        flag_meanings=" ".join(KINDS),
    )
    number = file.createVariable("session", "i", ("time",))
    number[:] = session
    describe(
        number,
        long_name=f"index of the session flown or slewed to, {NO_SESSION}: to the final state",
    )


def _attitude(file: netcdf_file, plan: FlightPlan, rows: TableStates) -> None:
    for name, values, unit, meaning in (
        ("q_payload_from_gcrf_xyzw", rows.q_payload_from_eci_xyzw, "1", "attitude of the payload"),
        ("q_body_from_gcrf_xyzw", rows.q_body_from_eci_xyzw, "1", "attitude of the carrier"),
        (
            "omega_payload_deg_s",
            np.degrees(omega_payload_from_eci_rad_s(plan, rows)),
            "degree s-1",
            "angular velocity of the payload against gcrf, payload axes",
        ),
        ("r_sat_gcrf_m", rows.states.r_sat_eci_m, "m", "position of the carrier, gcrf axes"),
        ("v_sat_gcrf_m_s", rows.states.v_sat_eci_m_s, "m s-1", "velocity of the carrier"),
    ):
        _write(file, name, values, unit, meaning, rows.first_row)


def _ground(file: netcdf_file, rows: TableStates) -> None:
    """The boresight's latitude and longitude, filled where it passes the Earth by."""
    boresight = sights(rows, BORESIGHT_PAYLOAD)
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(boresight.end_itrf_m[:, 0])
    for name, values, unit in (
        ("latitude", latitude_rad, "degrees_north"),
        ("longitude", longitude_rad, "degrees_east"),
    ):
        degrees = np.where(boresight.on_ground[:, 0], np.degrees(values), FILL)
        meaning = f"geodetic {name} where the boresight meets the WGS84 ellipsoid"
        variable = _write(file, f"boresight_{name}_deg", degrees, unit, meaning, rows.first_row)
        describe(variable, standard_name=name)


def axis_identifiers(names: tuple[str, ...]) -> tuple[str, ...]:
    """NetCDF has no names with blanks or slashes: such axes are numbered."""
    if all(name.isascii() and name.isidentifier() for name in names):
        return names
    return tuple(f"axis{number}" for number in range(len(names)))


def _identifier(channel: Channel, plan: FlightPlan) -> str:
    names = plan.table.dof_names
    identifiers = axis_identifiers(names)
    if identifiers == names:
        return channel.name
    return identifiers[names.index(channel.dof)] + channel.name.removeprefix(channel.dof)


def _meaning(channel: Channel) -> str:
    if channel.unit == "1":
        return f"attitude, part {channel.dof} of the quaternion"
    if channel.of == "extra":
        motion = "rate, held until the next row," if "rate" in channel.name else "angle"
        return f"{motion} of gimbal {channel.dof}"
    motion = "angle" if channel.of == "position" else channel.of
    return f"{motion} of axis {one_line(channel.dof)}"


def _write(
    file: netcdf_file, name: str, value_by_row: Array, unit: str, meaning: str, first_row: int = 0
) -> netcdf_variable:
    """value_by_row: one line per row from first_row on; rows before are filled."""
    sides = {1: (), 3: ("xyz",), 4: ("xyzw",)}[value_by_row[0].size]
    variable = file.createVariable(name, "d", ("time", *sides))
    variable[:first_row] = FILL
    variable[first_row:] = value_by_row
    describe(variable, _FillValue=FILL, units=unit, long_name=meaning)
    return variable


def describe(thing: netcdf_file | netcdf_variable, **attributes: object) -> None:
    """Give a file or one of its variables attributes."""
    for name, value in attributes.items():
        setattr(thing, name, value)
