"""Notes for the reader of an exported file: frames, units, time scale, rotations."""

from datetime import datetime

from planner.base.commands import COMMAND_STEP_S
from planner.base.header_text import one_line
from planner.world.frames.time_scales import utc_text
from planner.world.orbits import CarrierName, Orbit
from planner.world.plan import FlightPlan
from planner.world.scenario import Session

DECIMALS = 9  # 1e-9 deg is 4 microarcsec, 1/25,000 of what the table promises
UNKNOWN = "UNKNOWN"

TIME_SCALE = "UTC; t_s are SI seconds since the epoch, leap seconds counted"
QUATERNION = (
    "q_b_from_a_xyzw is scalar last and turns coordinates, v_b = q(v_a); a body turned by +theta "
    "about Z has [0, 0, -sin(theta/2), cos(theta/2)]"
)


def notes(plan: FlightPlan, created_utc: datetime) -> tuple[str, ...]:
    """Lines of one text each, for headers and comments."""
    scenario, table = plan.scenario, plan.table
    return (
        f"slewtrack plan {one_line(scenario.name) or 'without a name'}, "
        f"platform {one_line(scenario.platform.name)}, written {utc_text(created_utc)}",
        f"epoch {utc_text(table.epoch_utc, 1)}, a row every {COMMAND_STEP_S} s; "
        f"time scale {TIME_SCALE}",
        *scenario.platform.described(),
    )


def carrier_name(orbit: Orbit) -> CarrierName:
    """The satellite as its source names it, UNKNOWN for what that leaves out."""
    name, designator = orbit.carrier_name
    return CarrierName(one_line(name) or UNKNOWN, one_line(designator) or UNKNOWN)


def session_label(session: Session, number: int) -> str:
    """What it is called on maps and in lists."""
    return session.label or f"session {number + 1}"
