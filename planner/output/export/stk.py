"""Attitudes for STK: the carrier's (.a) and the payload's on it (.sp).

Both hold quaternions q1 q2 q3 q4, scalar last, that turn the reference axes into the
described ones (`axes_turn`).  Source: STK help, "Attitude File Format (*.a)" and "Sensor
Pointing File Format (*.sp)", whose example AttitudeFile4 turns by +6 deg/s about Z.
"""

from collections.abc import Sequence
from datetime import datetime

from planner.base.arrays import Array
from planner.output.export.ccsds import data_lines, epochs
from planner.output.export.description import notes
from planner.output.export.table_states import TableStates, axes_turn, table_states
from planner.world.plan import FlightPlan

_ORDER = 5  # of the polynomial STK lays through the rows; its default bends 18 arcsec off


def write_stk_attitude(plan: FlightPlan, created_utc: datetime) -> bytes:
    """`.a`: the carrier's body against ICRF, to be given to the vehicle."""
    rows = table_states(plan)
    return _file(
        notes(plan, created_utc),
        rows,
        rows.q_body_from_eci_xyzw,
        "attitude of the carrier's body axes against ICRF (GCRF); q1 q2 q3 q4, scalar last",
        ["CentralBody Earth", "CoordinateAxes ICRF"],
    )


def write_stk_sensor(plan: FlightPlan, created_utc: datetime) -> bytes:
    """`.sp`: the payload (+Z boresight) against the body axes of the vehicle it sits on.

    No CoordinateAxes: STK then takes the parent's body.  With the `.a` of the same plan
    loaded into the parent the sensor flies the command table.
    """
    rows = table_states(plan)
    return _file(
        notes(plan, created_utc),
        rows,
        rows.q_payload_from_body_xyzw,
        "pointing of the payload axes against the parent's body axes; q1 q2 q3 q4, scalar last",
        [],
    )


def _file(
    remarks: Sequence[str],
    rows: TableStates,
    q_described_from_reference_xyzw: Array,
    title: str,
    axes: Sequence[str],
) -> bytes:
    """Times are UTC in full, so that no scenario epoch has to agree."""
    lines = [
        "stk.v.11.0",
        f"# {title}",
        *(f"# {remark}" for remark in remarks),
        "BEGIN Attitude",
        f"NumberOfAttitudePoints {len(rows.instants)}",
        f"InterpolationOrder {min(_ORDER, len(rows.instants) - 1)}",
        *axes,
        "TimeFormat ISO-YMD",
        "AttitudeTimeQuaternions",
        *data_lines(epochs(rows.instants), (axes_turn(q_described_from_reference_xyzw), 13)),
        "END Attitude",
    ]
    return ("\n".join(lines) + "\n").encode("ascii")
