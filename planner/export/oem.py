"""The carrier's orbit as a CCSDS orbit ephemeris message (OEM)."""

from datetime import datetime

import numpy as np

from planner.commands import ROWS_PER_S
from planner.export.ccsds import data_lines, epochs, header, object_lines
from planner.export.description import notes
from planner.export.flight_plan import FlightPlan
from planner.export.table_states import table_states
from planner.frames.time_scales import Instants

_DEGREE = 3  # h^4/384 of the fourth derivative, 1e-5 m/s4, is 3e-8 m


def write_oem(plan: FlightPlan, created_utc: datetime) -> bytes:
    """Version 2, KVN: GCRF position and velocity every second and on the last row.

    The degree asked for is low because SGP4's velocity is not quite the derivative of its
    position (16 mm/s on the ISS): a polynomial of degree 15 through the rows makes 0.1 m of
    it near the ends, a cubic 1.5 mm.  Source: CCSDS 502.0-B-2, section 5.
    """
    rows = table_states(plan)
    count = len(rows.instants)
    kept = np.unique([*range(0, count, ROWS_PER_S), count - 1])
    moments = epochs(Instants(rows.instants.epoch_utc, rows.instants.t_s[kept]))
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
            [
                (rows.states.r_sat_eci_m[kept] / 1e3, 9),
                (rows.states.v_sat_eci_m_s[kept] / 1e3, 12),
            ],
        ),
    ]
    return ("\n".join(lines) + "\n").encode("ascii")
