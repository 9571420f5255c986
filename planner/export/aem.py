"""How is the payload's attitude written as a CCSDS attitude ephemeris message (AEM)?"""

from datetime import datetime

import numpy as np

from planner.export.ccsds import data_lines, epochs, header, object_lines
from planner.export.description import notes
from planner.export.flown import FlownPlan, axes_turn, flown

FRAME_A, FRAME_B = "GCRF", "INSTRUMENT_1"


def write_aem(plan: FlownPlan, created_utc: datetime) -> bytes:
    """Version 2, KVN: the quaternion from GCRF to the payload and its angular velocity.

    The message's quaternion (Q1 Q2 Q3 QC) turns the axes of frame A into those of frame B
    (`axes_turn`).  Angular velocities are of B against A in B's axes,
    so that two rows and a cubic Hermite give back what is flown between them.
    Source: CCSDS 504.0-B-2, sections 4 and A3.
    """
    rows = flown(plan)
    moments = epochs(rows.instants)
    lines = [
        *header("AEM", "2.0", created_utc, notes(plan, created_utc)),
        "META_START",
        f"COMMENT attitude of the payload ({FRAME_B}: +Z boresight) against {FRAME_A}",
        "COMMENT data: Q1 Q2 Q3 QC, scalar last, then ANGVEL_X ANGVEL_Y ANGVEL_Z in deg/s",
        *object_lines(plan),
        f"REF_FRAME_A = {FRAME_A}",
        f"REF_FRAME_B = {FRAME_B}",
        "TIME_SYSTEM = UTC",
        f"START_TIME = {moments[0]}",
        f"STOP_TIME = {moments[-1]}",
        "ATTITUDE_TYPE = QUATERNION/ANGVEL",
        f"ANGVEL_FRAME = {FRAME_B}",
        "INTERPOLATION_METHOD = HERMITE",
        "INTERPOLATION_DEGREE = 3",
        "META_STOP",
        "DATA_START",
        *data_lines(
            moments,
            [
                (axes_turn(rows.q_payload_from_eci_xyzw), 13),
                (np.degrees(rows.omega_payload_rad_s), 9),
            ],
        ),
        "DATA_STOP",
    ]
    return ("\n".join(lines) + "\n").encode("ascii")
