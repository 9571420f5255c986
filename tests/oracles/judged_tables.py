"""Command tables that the judge is tried on.

Made with ERFA and SciPy, none of the planner's geometry.

A circular orbit over Las Vegas on 27 Feb 2015; a quintic slew from rest, then the exact track.
"""

import dataclasses
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

import erfa
import numpy as np
from scipy.interpolate import BPoly, make_interp_spline
from scipy.spatial.transform import Rotation

from planner.base.commands import CommandTable, axis_channels
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms import ISS_HRC
from planner.world.scenario import InitialState, Scenario, Session
from planner.world.targets import GroundTarget

EPOCH_UTC = datetime(2015, 2, 27, 17, 36, 0, tzinfo=UTC)
START_S, STOP_S = 60.1, 99.9  # off the grid: the table must track from 60.0 to 100.0 s
FIRST_ROW, LAST_ROW = 300, 500
OVERHEAD_S = 85.0
ARCSEC_RAD = np.pi / 648000.0
# c2t06a knows no dX, dY: 0.3 mas of the Earth's radius is 1 cm, 5 mas seen from 450 km
ORACLE_RAD = 0.005 * ARCSEC_RAD
SPEED_OF_LIGHT_M_S = 299792458.0
MU_M3_S2 = 3.986004418e14
LAS_VEGAS = GroundTarget(latitude_deg=36.1147, longitude_deg=-115.1728, height_m=610.0)

# IERS finals2000A.all, Bulletin A, 2015-02-27 and 28 0h UTC: x, y (arcsec), UT1-UTC (s)
EOP_57080 = np.array([0.003247, 0.353179, -0.5259277])
EOP_57081 = np.array([0.003160, 0.354817, -0.5268002])


def erfa_times(t_s):
    """TT and UT1 two-part Julian dates and polar motion (rad), t_s after EPOCH_UTC."""
    utc = erfa.dtf2d("UTC", 2015, 2, 27, 17, 36, 0.0)
    tai = erfa.utctai(*utc)
    tai = (tai[0], tai[1] + np.asarray(t_s) / 86400.0)
    tt = erfa.taitt(*tai)
    eop = EOP_57080 + (utc[1] + t_s[:, None] / 86400.0) * (EOP_57081 - EOP_57080)
    ut1 = erfa.taiut1(*tai, eop[:, 2] - 35.0)
    return tt, ut1, eop[:, :2] * erfa.DAS2R


def r_target_eci_m(target, t_s):
    """Full IAU 2006/2000A series at each instant."""
    tt, ut1, pole_rad = erfa_times(t_s)
    c_itrf_from_eci = erfa.c2t06a(*tt, *ut1, pole_rad[:, 0], pole_rad[:, 1])
    r_itrf_m = erfa.gd2gc(
        1, np.deg2rad(target.longitude_deg), np.deg2rad(target.latitude_deg), target.ground_height_m
    )
    return np.einsum("nji,j->ni", c_itrf_from_eci, r_itrf_m)


@dataclass(frozen=True)
class CircularOrbit:
    """415 km up, 1.5 deg beside the target at OVERHEAD_S, its own ephemeris."""

    radius_m: float = 6371e3 + 415e3
    beside_deg: float = 1.5
    opposite: bool = False
    warnings: tuple[str, ...] = ()
    plane: tuple[np.ndarray, np.ndarray] = field(init=False)

    def __post_init__(self):
        up = r_target_eci_m(LAS_VEGAS, np.array([OVERHEAD_S]))[0]
        up /= np.linalg.norm(up)
        ahead = np.cross([0.3, -0.5, 1.0], up)
        ahead /= np.linalg.norm(ahead)
        aside = np.deg2rad(self.beside_deg)
        over = np.cos(aside) * up + np.sin(aside) * np.cross(up, ahead)
        object.__setattr__(self, "plane", (-over if self.opposite else over, ahead))

    def ephemeris(self, start_utc, stop_utc):
        return self

    def states(self, instants):
        t_s = instants.t_s + (instants.epoch_utc - EPOCH_UTC).total_seconds()
        mean_motion = np.sqrt(MU_M3_S2 / self.radius_m**3)
        phase = mean_motion * (t_s - OVERHEAD_S)[:, None]
        over, ahead = self.plane
        return OrbitStates(
            self.radius_m * (np.cos(phase) * over + np.sin(phase) * ahead),
            self.radius_m * mean_motion * (np.cos(phase) * ahead - np.sin(phase) * over),
        )


@dataclass(frozen=True)
class OrbitFacing(CircularOrbit):
    """The same circle turned so that a direction stands from_nadir_deg ahead at OVERHEAD_S."""

    towards_eci: tuple[float, float, float] = (1.0, 0.0, 0.0)
    from_nadir_deg: float = 82.0

    def __post_init__(self):
        towards = np.asarray(self.towards_eci) / np.linalg.norm(self.towards_eci)
        across = np.cross(towards, [0.3, -0.5, 1.0])
        across /= np.linalg.norm(across)
        cos, sin = np.cos(np.deg2rad(self.from_nadir_deg)), np.sin(np.deg2rad(self.from_nadir_deg))
        plane = (sin * across - cos * towards, cos * across + sin * towards)
        object.__setattr__(self, "plane", plane)


ATTITUDE = LvlhAttitude(yaw_deg=-4.1, pitch_deg=-2.0, roll_deg=0.7)


def scenario_of(attitude=ATTITUDE, platform=ISS_HRC, orbit=None, target=LAS_VEGAS):
    return Scenario(
        orbit=orbit or CircularOrbit(),
        attitude=attitude,
        platform=platform,
        initial_state=InitialState(epoch=EPOCH_UTC, angles_deg={"alpha": 0.0, "beta": 0.0}),
        sessions=(
            Session(
                target=target,
                start=EPOCH_UTC + timedelta(seconds=START_S),
                stop=EPOCH_UTC + timedelta(seconds=STOP_S),
            ),
        ),
    )


def apparent_eci(orbit, target, t_s, light_time=1.0, aberration=1.0):
    """Light time and aberration, each times a factor so that it can be dropped or turned over."""
    states = orbit.states(Instants(EPOCH_UTC, t_s))
    light_s = np.zeros(len(t_s))
    for _ in range(3):
        to_target_m = r_target_eci_m(target, t_s - light_time * light_s) - states.r_sat_eci_m
        light_s = np.linalg.norm(to_target_m, axis=1) / SPEED_OF_LIGHT_M_S
    natural = to_target_m / np.linalg.norm(to_target_m, axis=1, keepdims=True)
    beta = aberration * states.v_sat_eci_m_s / SPEED_OF_LIGHT_M_S
    far_from_sun_au = np.full(len(t_s), 1e12)
    return erfa.ab(natural, beta, far_from_sun_au, np.sqrt(1.0 - np.sum(beta**2, axis=1)))


def q_platform_from_eci(scenario, t_s):
    """LVLH by SciPy's Euler angles; other laws as they say."""
    states = scenario.orbit.states(Instants(EPOCH_UTC, t_s))
    attitude = scenario.attitude
    if isinstance(attitude, LvlhAttitude):
        down = -states.r_sat_eci_m / np.linalg.norm(states.r_sat_eci_m, axis=1, keepdims=True)
        normal = np.cross(states.r_sat_eci_m, states.v_sat_eci_m_s)
        right = -normal / np.linalg.norm(normal, axis=1, keepdims=True)
        q_lvlh_from_eci = Rotation.from_matrix(np.stack([np.cross(right, down), right, down], 1))
        angles = [attitude.yaw_deg, attitude.pitch_deg, attitude.roll_deg]
        q_body_from_eci = Rotation.from_euler("ZYX", angles, degrees=True).inv() * q_lvlh_from_eci
    else:
        q_body_from_eci = attitude.q_body_from_eci(Instants(EPOCH_UTC, t_s), states)
    return Rotation.from_quat(scenario.platform.q_platform_from_body_xyzw) * q_body_from_eci


def hrc_angles_rad(los_platform):
    """Closed form for the axes of the HRC platform: Sumarokov 2016, eq. 11, the branch ahead."""
    tilt = np.deg2rad(5.0)
    x, y, z = los_platform.T
    across = np.sin(tilt) * y + np.cos(tilt) * z
    beta = np.arctan2(-np.cos(tilt) * y + np.sin(tilt) * z, np.hypot(x, across)) - tilt
    return np.stack([np.arctan2(-x, across), beta], axis=1)


def table_of(scenario, **light):
    """On a ground point; `light` as for `apparent_eci`."""
    target = scenario.sessions[0].target
    return table_along(scenario, lambda t_s: apparent_eci(scenario.orbit, target, t_s, **light))


def table_along(scenario, los_eci):
    """Slew from rest at zero to the track of los_eci(t_s) in 60 s, then the track to LAST_ROW."""
    margin_rows = 5
    rows = np.arange(FIRST_ROW - margin_rows, LAST_ROW + margin_rows + 1)
    t_s = rows / 5.0
    angle_rad = hrc_angles_rad(q_platform_from_eci(scenario, t_s).apply(los_eci(t_s)))
    track = make_interp_spline(t_s, angle_rad, k=7)
    join_s = FIRST_ROW / 5.0
    end = np.stack([track.derivative(k)(join_s) if k else track(join_s) for k in range(3)])
    slew = BPoly.from_derivatives([0.0, join_s], [np.zeros((3, 2)), end])
    slew_s, track_s = np.arange(FIRST_ROW) / 5.0, np.arange(FIRST_ROW, LAST_ROW + 1) / 5.0
    return CommandTable(
        epoch_utc=EPOCH_UTC,
        channels=axis_channels(("alpha", "beta")),
        position=np.concatenate([slew(slew_s), track(track_s)]),
        rate_rad_s=np.concatenate([slew.derivative()(slew_s), track.derivative()(track_s)]),
    )


def changed(table, column, row, *, angle_rad=0.0, rate_rad_s=0.0):
    """The table with one row, or a slice of rows, of one axis shifted."""
    angles, rates = table.position.copy(), table.rate_rad_s.copy()
    angles[row, column] += angle_rad
    rates[row, column] += rate_rad_s
    return dataclasses.replace(table, position=angles, rate_rad_s=rates)


def only(report, limit):
    """The one finding of its kind in a report that failed."""
    (finding,) = [finding for finding in report.findings if finding.limit == limit]
    assert not report.passed
    return finding
