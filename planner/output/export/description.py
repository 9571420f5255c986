"""Notes for the reader of an exported file: frames, units, time scale, rotations."""

from datetime import datetime
from typing import NamedTuple

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S
from planner.world.frames.time_scales import utc_text
from planner.world.orbits import CarrierName, Orbit
from planner.world.plan import FlightPlan
from planner.world.platforms import TwoAxisPlatform
from planner.world.platforms.body import BodyPlatform
from planner.world.scenario import Scenario, Session

DECIMALS = 9  # 1e-9 deg is 4 microarcsec, 1/25,000 of what the table promises
TEXT_MAX = 200  # a KVN line may have 254 characters
UNKNOWN = "UNKNOWN"

TIME_SCALE = "UTC; t_s are SI seconds since the epoch, leap seconds counted"
INTERPOLATION = "between rows the platform flies the cubic Hermite of angle and rate"
PAYLOAD_AXES = (
    "payload: +Z boresight, +X at zero angles the inner axis (its part across the boresight), "
    "+Y completes; both axes carry it"
)
BODY_ROTATION = (
    "q_eci_from_body is scalar last and turns vectors of the body into GCRF; omega_body and "
    "alpha_body are the body's rate and acceleration against GCRF in body axes, about x, y, z"
)
BODY_AXES = "payload: +Z boresight, +X along the frame's first side or across the line of pixels"
BODY_BETWEEN = (
    "between rows the body flies the quintic in modified Rodrigues parameters that meets attitude, "
    "rate and acceleration of both"
)
QUATERNION = (
    "q_b_from_a_xyzw is scalar last and turns coordinates, v_b = q(v_a); a body turned by +theta "
    "about Z has [0, 0, -sin(theta/2), cos(theta/2)]"
)


def rotation_order(platform: TwoAxisPlatform) -> str:
    """The boresight as a product of right-handed turns, and the axes turned about."""
    outer, inner = platform.axes_platform
    a, b = map(one_line, platform.axis_names)
    return (
        f"boresight_platform = R({a}) R({b}) zero, right-handed; {a} about {_vector(outer)} "
        f"(outer, fixed to the base), {b} about {_vector(inner)} (inner, carried by {a}), "
        f"zero {_vector(platform.zero_direction_platform)}, platform axes"
    )


def mount(platform: TwoAxisPlatform) -> str:
    """The constant rotation from body to platform."""
    return f"q_platform_from_body_xyzw = {_vector(platform.q_platform_from_body_xyzw)}"


class Described(NamedTuple):
    """What a table's columns mean: how they turn, the frames, what is flown between rows."""

    rotation_order: str
    mount: str
    payload_axes: str
    interpolation: str


def described(scenario: Scenario) -> Described:
    """By the kind of the scenario's platform."""
    if isinstance(scenario.platform, BodyPlatform):
        c_payload_from_body = scenario.platform.camera.c_payload_from_body
        return Described(BODY_ROTATION, _vectors(c_payload_from_body), BODY_AXES, BODY_BETWEEN)
    platform = scenario.two_axis
    return Described(rotation_order(platform), mount(platform), PAYLOAD_AXES, INTERPOLATION)


def notes(plan: FlightPlan, created_utc: datetime) -> tuple[str, ...]:
    """Lines of one text each, for headers and comments."""
    scenario, table = plan.scenario, plan.table
    return (
        f"slewtrack plan {one_line(scenario.name) or 'without a name'}, "
        f"platform {one_line(scenario.platform.name)}, written {utc_text(created_utc)}",
        f"epoch {utc_text(table.epoch_utc, 1)}, a row every {COMMAND_STEP_S} s; "
        f"time scale {TIME_SCALE}",
        *described(scenario),
    )


def carrier_name(orbit: Orbit) -> CarrierName:
    """The satellite as its source names it, UNKNOWN for what that leaves out."""
    name, designator = orbit.carrier_name
    return CarrierName(one_line(name) or UNKNOWN, one_line(designator) or UNKNOWN)


def one_line(text: str) -> str:
    """Printable ASCII on one line, so that no name can break out of a header."""
    printable = "".join(c if " " <= c <= "~" else " " if c.isspace() else "?" for c in text)
    return " ".join(printable.split())[:TEXT_MAX]


def _vectors(c_payload_from_body: Array) -> str:
    return "payload axes in body axes: " + ", ".join(map(_vector, c_payload_from_body))


def _vector(unit: tuple[float, ...] | Array) -> str:
    return "[" + ", ".join(f"{value + 0.0:.12g}" for value in unit) + "]"


def session_label(session: Session, number: int) -> str:
    """What it is called on maps and in lists."""
    return session.label or f"session {number + 1}"
