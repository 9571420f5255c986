"""The parts of a CCSDS message in KVN."""

from collections.abc import Iterable, Sequence
from datetime import datetime

import numpy as np

from planner.arrays import Array
from planner.export.description import DECIMALS, TEXT_MAX, carrier
from planner.export.table_states import axes_turn
from planner.frames.time_scales import Instants, utc_text
from planner.orbits import Orbit

ORIGINATOR = "SLEWTRACK"
ATTITUDE_FRAME_A = "GCRF"
QUATERNION_DECIMALS = 13


def epochs(instants: Instants) -> list[str]:
    """ASCII time code A of UTC to the millisecond; rows stand on a fifth of a second."""
    return [text.removesuffix("Z") for text in instants.utc_text(3)]


def header(kind: str, version: str, created_utc: datetime, notes: Iterable[str]) -> list[str]:
    """Lines from the version to the originator; long notes are broken at spaces."""
    return [
        f"CCSDS_{kind}_VERS = {version}",
        *(f"COMMENT {line}" for note in notes for line in _wrap(note)),
        f"CREATION_DATE = {utc_text(created_utc).removesuffix('Z')}",
        f"ORIGINATOR = {ORIGINATOR}",
    ]


def object_lines(orbit: Orbit) -> list[str]:
    """Which spacecraft, and about which body."""
    named = carrier(orbit)
    return [
        f"OBJECT_NAME = {named.name}",
        f"OBJECT_ID = {named.designator}",
        "CENTER_NAME = EARTH",
    ]


def data_lines(moments: Sequence[str], blocks: Sequence[tuple[Array, int]]) -> list[str]:
    """Epoch and numbers; blocks: arrays of shape (n, k) with their decimals."""
    formats = [f"%.{decimals}f" for values, decimals in blocks for _ in range(values.shape[1])]
    layout = " ".join(formats)
    numbers = np.hstack([values for values, _ in blocks]) + 0.0
    rows = zip(moments, map(tuple, numbers.tolist()), strict=True)
    return [f"{moment} {layout % row}" for moment, row in rows]


def attitude_message(
    created_utc: datetime,
    notes: Iterable[str],
    orbit: Orbit,
    frame_b: str,
    instants: Instants,
    q_b_from_eci_xyzw: Array,
    omega_b_rad_s: Array,
    *,
    about: Iterable[str] = (),
) -> bytes:
    """An AEM, version 2: quaternion of a frame B from GCRF, (n, 4), and its rate, (n, 3).

    The message's quaternion (Q1 Q2 Q3 QC) turns the axes of frame A into those of frame B
    (`axes_turn`).  Angular velocities are of B against A in B's axes,
    so that two rows and a cubic Hermite give back what is flown between them.
    about: comments of its segment.  Source: CCSDS 504.0-B-2, sections 4 and A3.
    """
    moments = epochs(instants)
    lines = [
        *header("AEM", "2.0", created_utc, notes),
        "META_START",
        *(f"COMMENT {line}" for line in about),
        "COMMENT data: Q1 Q2 Q3 QC, scalar last, then ANGVEL_X ANGVEL_Y ANGVEL_Z in deg/s",
        *object_lines(orbit),
        f"REF_FRAME_A = {ATTITUDE_FRAME_A}",
        f"REF_FRAME_B = {frame_b}",
        "TIME_SYSTEM = UTC",
        f"START_TIME = {moments[0]}",
        f"STOP_TIME = {moments[-1]}",
        "ATTITUDE_TYPE = QUATERNION/ANGVEL",
        f"ANGVEL_FRAME = {frame_b}",
        "INTERPOLATION_METHOD = HERMITE",
        "INTERPOLATION_DEGREE = 3",
        "META_STOP",
        "DATA_START",
        *data_lines(
            moments,
            [
                (axes_turn(q_b_from_eci_xyzw), QUATERNION_DECIMALS),
                (np.degrees(omega_b_rad_s), DECIMALS),
            ],
        ),
        "DATA_STOP",
    ]
    return ("\n".join(lines) + "\n").encode("ascii")


def _wrap(note: str) -> list[str]:
    lines = [""]
    for word in note.split(" "):
        if lines[-1] and len(lines[-1]) + len(word) >= TEXT_MAX:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
