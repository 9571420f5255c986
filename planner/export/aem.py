"""The payload's attitude as a CCSDS attitude ephemeris message (AEM)."""

from datetime import datetime

from planner.export.ccsds import ATTITUDE_FRAME_A, attitude_message
from planner.export.description import notes
from planner.export.flight_plan import FlightPlan
from planner.export.table_states import table_states

FRAME_B = "INSTRUMENT_1"


def write_aem(plan: FlightPlan, created_utc: datetime) -> bytes:
    """Version 2, KVN: the quaternion from GCRF to the payload and its angular velocity."""
    rows = table_states(plan)
    return attitude_message(
        created_utc,
        notes(plan, created_utc),
        plan.scenario.orbit,
        FRAME_B,
        rows.instants,
        rows.q_payload_from_eci_xyzw,
        rows.omega_payload_rad_s,
        about=[f"attitude of the payload ({FRAME_B}: +Z boresight) against {ATTITUDE_FRAME_A}"],
    )
