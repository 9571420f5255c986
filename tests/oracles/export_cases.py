"""Plans that the exports are tried on, and the payload's true attitude in them.

The attitude is made with matrix exponentials and SciPy, none of the planner's geometry.
"""

import json
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from planner.base.commands import CommandTable, axis_channels
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.orbits import StateVectorOrbit, TleOrbit
from planner.world.platforms import ISS_HRC, TwoAxisPlatform
from planner.world.scenario import InitialState, Scenario, Session
from planner.world.targets import GroundTarget

ARCSEC_RAD = np.pi / 648000.0
READ_BACK_RAD = 0.01 * ARCSEC_RAD  # a tenth of what the table promises between its rows
EPOCH_UTC = datetime(2015, 2, 27, 17, 36, 0, tzinfo=UTC)
CREATED_UTC = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
YAW_DEG, PITCH_DEG, ROLL_DEG = -4.1, 12.0, 7.5
LAS_VEGAS = GroundTarget(latitude_deg=36.1147, longitude_deg=-115.1728, height_m=610.0)

EXAMPLE = Path(__file__).parents[2] / "examples" / "las_vegas_2015.json"
ISS = TleOrbit(**json.loads(EXAMPLE.read_text())["orbit"])


def _unit(x, y, z):
    return tuple((np.array([x, y, z]) / np.linalg.norm([x, y, z])).tolist())


SKEW = TwoAxisPlatform(  # nothing perpendicular, nothing along an axis
    name="skew",
    outer_name="pan",
    outer_axis_platform=_unit(0.1, -0.97, 0.2),
    outer_limits=ISS_HRC.outer_limits,
    inner_name="tilt",
    inner_axis_platform=_unit(0.9, 0.3, -0.4),
    inner_limits=ISS_HRC.inner_limits,
    zero_direction_platform=_unit(0.2, -0.1, 0.97),
    q_platform_from_body_xyzw=tuple(
        Rotation.from_euler("ZYX", [30.0, -20.0, 50.0], True).as_quat()
    ),
)


@dataclass(frozen=True)
class Stretch:
    kind: str
    session: int
    start_utc: datetime
    stop_utc: datetime


@dataclass(frozen=True)
class Case:
    scenario: Scenario
    segments: tuple[Stretch, ...]
    table: CommandTable


def case(*, platform=SKEW, orbit=ISS, target=LAS_VEGAS, epoch_utc=EPOCH_UTC, seconds=60, tilt=0.6):
    """A second of rest, a slew, and a session from 20 s on; both axes sway all along."""
    t_s = np.arange(seconds * 5 + 1) / 5.0
    angular_rad_s = 2.0 * np.pi / np.array([47.0, 31.0])
    amplitude_rad = np.array([0.9, tilt])
    phase = t_s[:, None] * angular_rad_s

    def after(s):
        return epoch_utc + timedelta(seconds=s)

    return Case(
        scenario=Scenario(
            name="Sway & <turn>",
            orbit=orbit,
            attitude=LvlhAttitude(yaw_deg=YAW_DEG, pitch_deg=PITCH_DEG, roll_deg=ROLL_DEG),
            platform=platform,
            initial_state=InitialState(
                epoch=epoch_utc, angles_deg=dict.fromkeys(platform.axis_names, 0.0)
            ),
            sessions=(Session(target=target, start=after(20.1), stop=after(seconds - 0.3)),),
        ),
        segments=(
            Stretch("wait", 0, epoch_utc, after(1)),
            Stretch("slew", 0, after(1), after(20)),
            Stretch("track", 0, after(20), after(seconds)),
        ),
        table=CommandTable(
            epoch_utc=epoch_utc,
            channels=axis_channels(platform.axis_names),
            position=amplitude_rad * np.sin(phase),
            rate_rad_s=amplitude_rad * angular_rad_s * np.cos(phase),
        ),
    )


def orbit_states(orbit, instants):
    """The planner's own orbit: the exports are not what tests it."""
    start_utc, stop_utc = (
        instants.epoch_utc + timedelta(seconds=float(t)) for t in instants.t_s[[0, -1]]
    )
    return orbit.ephemeris(start_utc, stop_utc).states(instants)


def c_body_from_eci(states):
    """LVLH by its definition, then yaw, pitch and roll, each about the axis already turned."""
    down = -states.r_sat_eci_m / np.linalg.norm(states.r_sat_eci_m, axis=1, keepdims=True)
    right = -np.cross(states.r_sat_eci_m, states.v_sat_eci_m_s)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    c_lvlh_from_eci = np.stack([np.cross(right, down), right, down], axis=1)
    turned = Rotation.from_euler("ZYX", [YAW_DEG, PITCH_DEG, ROLL_DEG], degrees=True).as_matrix()
    return turned.T @ c_lvlh_from_eci


def c_payload_from_body(platform, angle_rad):
    """Matrix exponentials of both turns; at zero +Z is the zero direction, +X by the inner."""
    outer, inner = np.array(platform.outer_axis_platform), np.array(platform.inner_axis_platform)
    z = np.array(platform.zero_direction_platform)
    y = np.cross(z, inner)
    y /= np.linalg.norm(y)
    at_zero = np.stack([np.cross(y, z), y, z], axis=1)
    mount = Rotation.from_quat(platform.q_platform_from_body_xyzw).as_matrix()
    turns = [expm(a * _cross(outer)) @ expm(b * _cross(inner)) for a, b in angle_rad]
    return np.array([(turn @ at_zero).T @ mount for turn in turns])


def _cross(axis):
    x, y, z = axis
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turned_axes_quaternions(c_b_from_a):
    """Quaternions, scalar last, that turn the axes of A into those of B, from matrices.

    The eigenvector of the turn and half its angle: [e sin(theta/2), cos(theta/2)].
    """
    return Rotation.from_matrix(np.swapaxes(c_b_from_a, 1, 2)).as_quat()


def apart_rad(q_xyzw, expected_xyzw):
    """Largest angle between attitudes; a quaternion and its negative are the same."""
    likeness = np.sign(np.sum(q_xyzw * expected_xyzw, axis=1))[:, None]
    return np.max(2.0 * np.linalg.norm(q_xyzw * likeness - expected_xyzw, axis=1))


def state_vector(epoch_utc):
    """A low orbit known at any time."""
    return StateVectorOrbit(
        frame="GCRF",
        epoch=epoch_utc,
        position_km=(2916.692669, -4925.372335, 3616.770049),
        velocity_km_s=(3.438279501, 5.274775263, 4.394743638),
        force_model="j2j4",
    )
