"""CCSDS messages in KVN: the payload's attitude (AEM), the carrier's orbit (OEM)."""

from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S
from planner.base.header_text import TEXT_MAX
from planner.output.export.description import DECIMALS, carrier_name, notes
from planner.output.export.table_states import axes_turn, omega_payload_from_eci_rad_s, table_states
from planner.world.frames.time_scales import Instants, utc_text
from planner.world.orbits import Orbit
from planner.world.plan import FlightPlan

ORIGINATOR = "SLEWTRACK"
ATTITUDE_FRAME_A = "GCRF"
QUATERNION_DECIMALS = 13
_PAYLOAD_FRAME, BODY_FRAME = "INSTRUMENT_1", "SC_BODY_1"  # as CCSDS 504.0-B names them
_DEGREE = 3  # h^4/384 of the fourth derivative, 1e-5 m/s4, is 3e-8 m


class AttitudeSegment(NamedTuple):
    """Of an AEM: a frame's attitude against GCRF, and its rate in its own axes.

    q_frame_from_eci_xyzw: from GCRF to the frame, (n, 4).  omega_rad_s: (n, 3).  about: a comment.
    """

    frame: str
    q_frame_from_eci_xyzw: Array
    omega_rad_s: Array
    about: str = ""


def write_aem(plan: FlightPlan, created_utc: datetime) -> bytes:
    """Version 2, KVN: the quaternion from GCRF to the payload and its angular velocity.

    Of a body that turns as a whole its own attitude comes first, as another segment.
    """
    rows = table_states(plan)
    segments = [
        AttitudeSegment(
            _PAYLOAD_FRAME,
            rows.q_payload_from_eci_xyzw,
            omega_payload_from_eci_rad_s(plan, rows),
            f"attitude of the payload ({_PAYLOAD_FRAME}: +Z boresight) against {ATTITUDE_FRAME_A}",
        )
    ]
    if plan.scenario.attitude is None:
        omega_body_rad_s = plan.table.rate_rad_s[rows.row]
        about = f"attitude of the spacecraft ({BODY_FRAME}) against {ATTITUDE_FRAME_A}"
        body = AttitudeSegment(BODY_FRAME, rows.q_body_from_eci_xyzw, omega_body_rad_s, about)
        segments.insert(0, body)
    remarks, orbit = notes(plan, created_utc), plan.scenario.orbit
    return attitude_message(created_utc, remarks, orbit, rows.instants, segments)


def write_oem(plan: FlightPlan, created_utc: datetime) -> bytes:
    """Version 2, KVN: GCRF position and velocity every second and on the last row.

    The degree asked for is low because SGP4's velocity is not quite the derivative of its
    position (16 mm/s on the ISS): a polynomial of degree 15 through the rows makes 0.1 m of
    it near the ends, a cubic 1.5 mm.  Source: CCSDS 502.0-B-2, section 5.
    """
    rows = table_states(plan)
    count = len(rows.instants)
    seconds = np.unique([*range(0, count, ROWS_PER_S), count - 1])
    moments = epochs(Instants(rows.instants.epoch_utc, rows.instants.t_s[seconds]))
    lines = [
        *header("OEM", "2.0", created_utc, notes(plan, created_utc)),
        "META_START",
        *object_lines(plan.scenario.orbit),
        "REF_FRAME = GCRF",
        "TIME_SYSTEM = UTC",
        f"START_TIME = {moments[0]}",
        f"STOP_TIME = {moments[-1]}",
        "INTERPOLATION = HERMITE",
        f"INTERPOLATION_DEGREE = {_DEGREE}",
        "META_STOP",
        "COMMENT data: X Y Z in km, X_DOT Y_DOT Z_DOT in km/s",
        *data_lines(
            moments,
            (rows.states.r_sat_eci_m[seconds] / 1e3, 9),
            (rows.states.v_sat_eci_m_s[seconds] / 1e3, 12),
        ),
    ]
    return ("\n".join(lines) + "\n").encode("ascii")


def epochs(instants: Instants) -> list[str]:
    """ASCII time code A of UTC to the millisecond; rows stand on a fifth of a second."""
    return [text.removesuffix("Z") for text in instants.utc_text(3)]


def header(kind: str, version: str, created_utc: datetime, remarks: Iterable[str]) -> list[str]:
    """Lines from the version to the originator; long notes are broken at spaces."""
    return [
        f"CCSDS_{kind}_VERS = {version}",
        *(f"COMMENT {line}" for remark in remarks for line in _wrap(remark)),
        f"CREATION_DATE = {utc_text(created_utc).removesuffix('Z')}",
        f"ORIGINATOR = {ORIGINATOR}",
    ]


def object_lines(orbit: Orbit) -> list[str]:
    """Which spacecraft, and about which body."""
    spacecraft = carrier_name(orbit)
    return [
        f"OBJECT_NAME = {spacecraft.name}",
        f"OBJECT_ID = {spacecraft.designator}",
        "CENTER_NAME = EARTH",
    ]


def data_lines(moments: Sequence[str], *blocks: tuple[Array, int]) -> list[str]:
    """Epoch and numbers; blocks: arrays of shape (n, k) with their decimals."""
    formats = [f"%.{decimals}f" for values, decimals in blocks for _ in range(values.shape[1])]
    layout = " ".join(formats)
    numbers = np.hstack([values for values, _ in blocks]) + 0.0
    rows = zip(moments, map(tuple, numbers.tolist()), strict=True)
    return [f"{moment} {layout % row}" for moment, row in rows]


def attitude_message(
    created_utc: datetime,
    remarks: Iterable[str],
    orbit: Orbit,
    instants: Instants,
    segments: Iterable[AttitudeSegment],
) -> bytes:
    """An AEM, version 2: quaternions of frames B from GCRF, and their rates.

    The message's quaternion (Q1 Q2 Q3 QC) turns the axes of frame A into those of frame B
    (`axes_turn`).  Angular velocities are of B against A in B's axes,
    so that two rows and a cubic Hermite give back what is flown between them.
    Source: CCSDS 504.0-B-2, sections 4 and A3.
    """
    moments = epochs(instants)
    lines = header("AEM", "2.0", created_utc, remarks)
    for segment in segments:
        lines += [
            "META_START",
            *(f"COMMENT {line}" for line in [segment.about] if line),
            "COMMENT data: Q1 Q2 Q3 QC, scalar last, then ANGVEL_X ANGVEL_Y ANGVEL_Z in deg/s",
            *object_lines(orbit),
            f"REF_FRAME_A = {ATTITUDE_FRAME_A}",
            f"REF_FRAME_B = {segment.frame}",
            "TIME_SYSTEM = UTC",
            f"START_TIME = {moments[0]}",
            f"STOP_TIME = {moments[-1]}",
            "ATTITUDE_TYPE = QUATERNION/ANGVEL",
            f"ANGVEL_FRAME = {segment.frame}",
            "INTERPOLATION_METHOD = HERMITE",
            "INTERPOLATION_DEGREE = 3",
            "META_STOP",
            "DATA_START",
            *data_lines(
                moments,
                (axes_turn(segment.q_frame_from_eci_xyzw), QUATERNION_DECIMALS),
                (np.degrees(segment.omega_rad_s), DECIMALS),
            ),
            "DATA_STOP",
        ]
    return ("\n".join(lines) + "\n").encode("ascii")


def _wrap(remark: str) -> list[str]:
    lines = [""]
    for word in remark.split(" "):
        if lines[-1] and len(lines[-1]) + len(word) >= TEXT_MAX:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
