"""Sumarokov 2016: pointing the high-resolution camera of the ISS."""

import json
import math
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from app.requests.plan import read_plan_request
from planner.motion.baseline.paper_cubic import (
    cubic_profile,
    filter_lag_s,
    paper_duration_s,
    paper_slew,
)
from planner.motion.pointing.angles import axis_angles, boresight_platform
from planner.motion.pointing.line_of_sight import line_of_sight
from planner.motion.slew.problem import AxisState, SlewProblem
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.plan import Plan
from planner.world.attitude import InertialAttitude
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import MU_EARTH_M3_S2, WGS84_A_M, WGS84_F, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates, paper_model
from planner.world.orbits.gravity import RADIUS_M
from planner.world.platforms import ISS_HRC
from planner.world.scenario import SlewOptions
from reproduction.report import Numbers

# The requests of examples/, planned.

EXAMPLES = Path(__file__).parents[2] / "examples"
THREE_SESSIONS = "three_sessions.json"


@cache
def plan_of(example: str) -> Plan:
    """With the attitude level, as the papers state none."""
    request = json.loads((EXAMPLES / example).read_text(encoding="utf-8"))
    return make_plan(
        read_plan_request(json.dumps(request | {"attitude": {"law": "lvlh"}}).encode())
    )


# The prediction of the orbit: Sumarokov 2016, eqs. 3 to 7.

FULL_HARMONICS = files("planner.world.orbits") / "data" / "eigen6s_n36.csv"
DIFFERENCE_M = 50.0
ISS: paper_model.State = (545284.0, 4217457.4, 5288809.9, -7328.9, 208.6, 656.3)  # m, m/s


def zonal(degree: int) -> float:
    """J of the packaged field, from its normalised coefficient."""
    rows = (line.split(",") for line in FULL_HARMONICS.read_text("ascii").splitlines())
    [c] = [float(row[2]) for row in rows if row[:2] == [str(degree), "0"]]
    return -c * float(np.sqrt(2 * degree + 1))


def gradient_miss_m_s2() -> float:
    """Of eq. 3, p2 ours, from the slope of the potential with J2 and J4, rms."""
    errors = []
    for latitude in np.radians([0.0, 15.0, 30.0, 51.6]):
        x_m, z_m = 6.785e6 * np.cos(latitude), 6.785e6 * np.sin(latitude)
        slope = [
            (_potential(x_m + dx, z_m + dz) - _potential(x_m - dx, z_m - dz)) / (2.0 * DIFFERENCE_M)
            for dx, dz in ((DIFFERENCE_M, 0.0), (0.0, DIFFERENCE_M))
        ]
        derivative = paper_model._derivative((float(x_m), 0.0, float(z_m), 0.0, 0.0, 0.0))
        errors.append(np.array([derivative[3], derivative[5]]) - slope)
    return float(np.sqrt(np.mean(np.sum(np.square(errors), axis=1))))


def _potential(x_m: float, z_m: float) -> float:
    r_m = np.hypot(x_m, z_m)
    sine = z_m / r_m
    p2 = 0.5 * (3.0 * sine**2 - 1.0)
    p4 = 0.125 * (35.0 * sine**4 - 30.0 * sine**2 + 3.0)
    flattened = zonal(2) * (RADIUS_M / r_m) ** 2 * p2 + zonal(4) * (RADIUS_M / r_m) ** 4 * p4
    return float(MU_EARTH_M3_S2 / r_m * (1.0 - flattened))


def orbit_numbers() -> Numbers:
    _, states = paper_model.predict(ISS, paper_model.STEP_S)
    return {
        "p0": MU_EARTH_M3_S2 / 1e9,
        "p1": -1.5 * zonal(2) * RADIUS_M**2 / 1e6,
        "p2": -0.625 * zonal(4) * RADIUS_M**4 / 1e12,
        "field": gradient_miss_m_s2() * 1e6,
        "missing X_n": float(np.linalg.norm(states[-1, :3])) / 1e3,
    }


# The prediction of the attitude: Sumarokov 2016, eqs. 1 and 2.

CLOCK_UTC = datetime(2017, 12, 31, tzinfo=UTC)
TAU_S = 0.1
RATE_BODY_RAD_S = np.deg2rad([-0.003, 0.065, 0.0])  # the ISS's, once an orbit

Quaternion = NDArray[np.float64]


def printed_step(q: Quaternion, omega_rad_s: NDArray, tau_s: float) -> Quaternion:
    """Eqs. 1 and 2, scalar first, commas restored, |q| squared as the paper's source has it."""
    q_n = 1.0 + (1.0 - q @ q) / 2.0 - tau_s**2 / 8.0 * omega_rad_s @ omega_rad_s
    q0, q1, q2, q3 = q
    x, y, z = 0.5 * tau_s * omega_rad_s
    turned = np.array(
        [-q1 * x - q2 * y - q3 * z, q0 * x + q2 * z - q3 * y, q0 * y + q3 * x - q1 * z,
         q0 * z + q1 * y - q2 * x]
    )  # fmt: skip
    return np.asarray(q * q_n + turned)


def predicted(law: InertialAttitude, at: Instants) -> Rotation:
    """Body from ECI at one instant; an inertial attitude needs no orbit."""
    nowhere = OrbitStates(np.zeros((1, 3)), np.zeros((1, 3)))
    return law.q_law_body_from_eci(at, nowhere)[0]


def recursion_error_arcsec(span_s: float) -> float:
    """Of the paper's steps against the law `inertial`, which is the closed form."""
    law = InertialAttitude(
        epoch=CLOCK_UTC,
        q_body_from_eci_xyzw=(0.0, 0.0, 0.0, 1.0),
        omega_body_deg_s=tuple(np.rad2deg(RATE_BODY_RAD_S).tolist()),
    )
    closed = predicted(law, Instants(CLOCK_UTC, np.array([span_s])))
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for _ in range(int(span_s / TAU_S)):
        q = printed_step(q, RATE_BODY_RAD_S, TAU_S)
    stepped = Rotation.from_quat([*q[1:], q[0]])  # eci from body, as the paper's q
    return float(np.rad2deg((stepped * closed).magnitude()) * 3600.0)


def steps_to_unit_norm() -> int:
    """From a norm 1 % too large to one within 1e-9."""
    q = np.array([1.01, 0.0, 0.0, 0.0])
    steps = 0
    while abs(np.linalg.norm(q) - 1.0) > 1e-9:
        q = printed_step(q, np.zeros(3), TAU_S)
        steps += 1
    return steps


def attitude_numbers() -> Numbers:
    return {
        "recursion": recursion_error_arcsec(900.0),
        "norm correction": float(steps_to_unit_norm()),
    }


# From the target to the angles of the axes: Sumarokov 2016, eqs. 8 to 11.

TILT_RAD = np.radians(5.0)
ZERO = np.array([0.0, 0.0, 1.0])  # the paper leaves its V open
ALPHA_DEG, BETA_DEG = 60.0, 45.0  # how far a session over a city goes


def printed_target_m(latitude_rad: NDArray, longitude_rad: NDArray, height_m: NDArray) -> NDArray:
    """Eq. 8, with WGS 84's a_E and K_E."""
    k = WGS84_F
    n_m = WGS84_A_M / np.sqrt(1.0 - (2.0 * k - k**2) * np.sin(latitude_rad) ** 2)
    x = (n_m + height_m) * np.cos(latitude_rad) * np.cos(longitude_rad)
    y = (n_m + height_m) * np.cos(latitude_rad) * np.sin(longitude_rad)
    z = ((1.0 - 2.0 * k + k**2) * n_m + height_m) * np.sin(latitude_rad)
    return np.stack([x, y, z], axis=-1)


def printed_intersections(target: NDArray) -> NDArray:
    """Eq. 11 as printed: both directions L of n targets, (2, n, 3); NaN where there are none."""
    cosine, sine = np.cos(TILT_RAD), np.sin(TILT_RAD)
    along = -cosine * target[:, 1] + sine * target[:, 2]
    a, b, v_x = along / sine, cosine / sine, ZERO[0]
    root = 4.0 * a**2 * b**2 - 4.0 * (1.0 + b**2) * (v_x**2 - 1.0 + a**2)
    root = np.sqrt(np.where(root >= 0.0, root, np.nan))
    y = (-2.0 * a * b + np.array([[1.0], [-1.0]]) * root) / (2.0 * (1.0 + b**2))
    z = (along + y * cosine) / sine
    return np.stack([np.full_like(y, v_x), y, z], axis=-1)


def quaternion_line_of_sight() -> tuple[NDArray, NDArray]:
    """By eq. 10 as printed and by the product, unit vectors (n, 3).

    The pass over Las Vegas; the mount D is one that does something.
    """
    scenario = plan_of("las_vegas_2015.json").scenario
    session = scenario.sessions[0]
    instants = Instants(session.start, np.linspace(0.0, 90.0, 46))
    ephemeris = scenario.orbit.ephemeris(session.start, session.stop)
    mount = Rotation.from_euler("xyz", [10.0, -20.0, 30.0], degrees=True)
    seen = line_of_sight(instants, ephemeris, scenario.attitude, mount, session.target)
    c_itrf = c_itrf_from_eci(instants)
    r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf, seen.states.r_sat_eci_m)
    v_m = session.target.r_target_itrf_m(instants) - r_sat_itrf_m
    # A quaternion q of a transition carries a vector's components as q~ o v o q.
    g = Rotation.from_matrix(c_itrf)
    a = scenario.attitude.q_body_from_eci(instants, seen.states).inv()
    d = mount.inv()
    chain = d.inv() * a.inv() * g.inv()
    platform = chain.apply(v_m)
    return platform / np.linalg.norm(platform, axis=1)[:, None], seen.los_base


def angles_numbers() -> Numbers:
    return {**_chain(), **_intersections(), **_misread_angles()}


def _chain() -> Numbers:
    rng = np.random.default_rng(8)
    latitude, longitude = rng.uniform(-1.57, 1.57, 1000), rng.uniform(-3.14, 3.14, 1000)
    height_m = rng.uniform(-400.0, 9000.0, 1000)
    difference_m = printed_target_m(latitude, longitude, height_m) - itrf_from_geodetic(
        latitude, longitude, height_m
    )
    printed, ours = quaternion_line_of_sight()
    apart_rad = np.linalg.norm(printed - ours, axis=1)
    return {
        "target": float(np.abs(difference_m).max()) * 1e3,
        "line of sight": float(ours.shape[1]),
        "rotations": float(np.rad2deg(apart_rad.max())) * 3600.0,
    }


def _intersections() -> Numbers:
    target = np.random.default_rng(11).normal(size=(20000, 3))
    target /= np.linalg.norm(target, axis=1, keepdims=True)
    printed = printed_intersections(target)
    branches = axis_angles(ISS_HRC, target)
    turned = np.stack([boresight_platform(ISS_HRC, one * [0.0, 1.0]) for one in branches.angle_rad])
    known = branches.reachable
    # The two solutions come in no order.
    apart = np.minimum(
        np.linalg.norm(printed - turned, axis=2).max(axis=0),
        np.linalg.norm(printed - turned[::-1], axis=2).max(axis=0),
    )
    return {
        "intersections": float(np.rad2deg(apart[known].max())) * 3600.0,
        "z as a root": 100.0 * float(np.mean(printed[:, known, 2] >= 0.0)),
    }


def _misread_angles() -> Numbers:
    """Over what a session asks for, the angles as the text tells them."""
    alpha, beta = np.meshgrid(
        np.radians(np.arange(-ALPHA_DEG + 0.5, ALPHA_DEG)),
        np.radians(np.arange(-BETA_DEG + 0.5, BETA_DEG)),
    )
    angle_rad = np.stack([alpha.ravel(), beta.ravel()], axis=1)
    target = boresight_platform(ISS_HRC, angle_rad)
    turned = boresight_platform(ISS_HRC, angle_rad * [0.0, 1.0])
    alpha_rad = np.arccos(np.clip(np.sum(target * turned, axis=1), -1.0, 1.0))
    beta_rad = np.arccos(np.clip(turned @ ZERO, -1.0, 1.0))
    alpha_off, beta_off = np.stack([alpha_rad, beta_rad]) - np.abs(angle_rad.T)
    return {
        "alpha as told": float(np.rad2deg(np.sqrt(np.mean(alpha_off**2)))),
        "beta as told": float(np.rad2deg(np.abs(beta_off).max())),
    }


# The transfer onto the track: Sumarokov 2016, eqs. 12 to 14 and the filter.

UNFILTERED = SlewOptions(filter_cutoff_hz=None)


def deg_state(angle: float, rate: float = 0.0) -> AxisState:
    return AxisState(angle_rad=math.radians(angle), rate_rad_s=math.radians(rate))


def in_paper_time(start: tuple[AxisState, ...], end: tuple[AxisState, ...]) -> SlewProblem:
    """The slew of all axes in the time of eq. 12."""
    problem = SlewProblem(
        axis_names=ISS_HRC.axis_names,
        limits=ISS_HRC.axis_limits,
        start=start,
        end=end,
        duration_s=1e3,
    )
    return replace(problem, duration_s=paper_duration_s(problem))


@cache
def example() -> SlewProblem:
    """From rest over 60 deg onto a track of 0.8 deg/s; beta goes a little way."""
    return in_paper_time((deg_state(10.0), deg_state(0.0)), (deg_state(70.0, 0.8), deg_state(8.0)))


def high_passed_deg(lag_s: float) -> float:
    """The most that a first-order high-pass lets through of the example's alpha.

    What the low-pass leaves: input less output.
    """
    problem = example()
    t_s = np.linspace(0.0, problem.duration_s, 2001)
    behind = SlewOptions(filter_cutoff_hz=0.5 / math.pi / lag_s, filter_lag_compensation=False)
    low = paper_slew(problem, behind).profiles[0].evaluate(t_s)[0]
    whole = paper_slew(problem, UNFILTERED).profiles[0].evaluate(t_s)[0]
    return float(np.rad2deg(np.abs(whole - low).max()))


def transfer_numbers() -> Numbers:
    start, end, duration_s = deg_state(10.0, 0.5), deg_state(70.0, 0.8), 34.0
    cubic = cubic_profile(start, end, duration_s)
    left = cubic.end_values[1, :2] - [end.angle_rad, end.rate_rad_s]
    transfer = cubic_profile(start, end, 120.0)  # Fig. 2's first, until 1320 s
    lag_s = filter_lag_s(SlewOptions(filter_cutoff_hz=2.0))
    filtered = paper_slew(example(), SlewOptions()).profiles[0]
    return {
        "coefficients": float(np.rad2deg(np.abs(left).max())) * 3600.0,
        "clock": math.degrees(float(transfer.end_values[1, 0])),
        "lag": lag_s,
        "high-pass": high_passed_deg(lag_s),
        "continuous acceleration": math.degrees(filtered.end_values[0, 2]),
    }


# Three consecutive sessions: Sumarokov 2016, Fig. 2.

CLOCK_S = 1200.0  # the paper's at row 0
TRANSFERS_S = ((1200.0, 1320.0), (1450.0, 1660.0), (1750.0, 1800.0))
IMAGING_S = ((1320.0, 1450.0), (1660.0, 1750.0), (1800.0, 1900.0))
CLOSEST_S = (1369.6, 1711.2, 1871.2)  # of ours, as the statements tell
NAMES = ("first", "second", "third")


def sessions_numbers() -> Numbers:
    slews = zip(NAMES, plan_of(THREE_SESSIONS).slews, strict=True)
    return {f"{name} transfer's time": slew.comparison.paper_s for name, slew in slews}


def draw_sessions(folder: Path) -> None:
    plan = plan_of(THREE_SESSIONS)
    t_s = plan.table.t_s + CLOCK_S
    figure = Figure(figsize=(8.4, 5.4), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    _axes_over_time(panels[0], t_s, plan.table.position, "angle, deg")
    _axes_over_time(panels[1], t_s, plan.table.rate_rad_s, "rate, deg/s")
    for panel in panels:
        for start_s, stop_s in IMAGING_S:
            panel.axvspan(start_s, stop_s, color="#f3e9c6", zorder=0)
        for at_s in CLOSEST_S:
            panel.axvline(at_s, color="#7b5aa6", ls="--", lw=1.0)
        panel.grid(alpha=0.3)
    panels[0].legend(loc="upper right", ncols=2)
    panels[1].set_xlabel("time on the paper's clock, s")
    panels[1].set_xticks(sorted({s for span in (*TRANSFERS_S, *IMAGING_S) for s in span}))
    figure.savefig(folder / "reproduction_sessions.png", dpi=100)


def _axes_over_time(panel, t_s: NDArray, values_rad: NDArray, label: str) -> None:  # noqa: ANN001
    for k, name in enumerate(("alpha", "beta")):
        panel.plot(t_s, np.rad2deg(values_rad[:, k]), label=name, lw=1.3)
    panel.set_ylabel(label)


# Las Vegas, 27 February 2015: Sumarokov 2016, Figs. 3 and 4.

TRIALS_UTC = datetime(2014, 11, 24, tzinfo=UTC)  # "since the end of November 2014"
CAPTION_UTC = datetime(2014, 2, 28, tzinfo=UTC)  # the last day that Fig. 4's caption allows


def las_vegas_numbers() -> Numbers:
    return {"caption's date": float((TRIALS_UTC - CAPTION_UTC).days)}
