"""Sumarokov 2016: pointing the high-resolution camera of the ISS."""

import csv
import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal, NamedTuple
from unittest.mock import patch

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.signal import find_peaks
from scipy.spatial.transform import Rotation

from app.requests.opportunities import read_opportunity_request
from app.requests.plan import read_plan_request
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.inflight.simulation.flight import fly
from planner.motion.baseline import compare_with_spline
from planner.motion.baseline.paper_cubic import OPTIONS as PAPER_SPLINE_OPTIONS
from planner.motion.baseline.paper_cubic import (
    cubic_profile,
    filter_lag_s,
    paper_duration_s,
    paper_slew,
)
from planner.motion.pointing.angles import axis_angles, boresight_platform
from planner.motion.pointing.line_of_sight import line_of_sight
from planner.motion.slew.optimal import optimal_slew
from planner.motion.slew.problem import AxisState, SlewProblem
from planner.output.export.table_states import TableStates, table_states
from planner.output.view.targets import TargetTrack
from planner.output.view.view import PlanView, view_plan
from planner.planning.opportunities import find_opportunities
from planner.planning.opportunities.ground_sample import sample_along_m
from planner.planning.opportunities.request import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
)
from planner.planning.opportunities.windows import Windows
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.plan import Plan
from planner.world.attitude import InertialAttitude
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S, c_itrf_from_eci
from planner.world.frames.geodesy import MU_EARTH_M3_S2, WGS84_A_M, WGS84_F, itrf_from_geodetic
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import (
    Instants,
    elapsed_s,
    shifted_utc,
    utc_from_text,
    utc_text,
)
from planner.world.messages.oem import OemSegment
from planner.world.orbits import OemOrbit, OrbitStates, StateVectorOrbit, TleOrbit, paper_model
from planner.world.orbits.gravity import RADIUS_M
from planner.world.platforms import ISS_HRC
from planner.world.platforms.camera import HRC_CAMERA, HRC_PIXEL_ARCSEC
from planner.world.platforms.two_axis import HRC_FRAME_HALF_RAD
from planner.world.scenario import SlewOptions
from planner.world.targets import VisibleTarget
from planner.world.targets.ground import GroundTarget
from planner.world.targets.ground_moving import MovingGroundTarget
from reproduction.report import Numbers

# The requests of examples/, planned, and what there is to see of them.

EXAMPLES = Path(__file__).parents[2] / "examples"
LAS_VEGAS = "las_vegas_2015.json"
BOSTON = "gallery/boston.json"
THREE_SESSIONS = "three_sessions.json"


def level_request(example: str) -> dict[str, Any]:
    request: dict[str, Any] = json.loads((EXAMPLES / example).read_text(encoding="utf-8"))
    return {**request, "attitude": {"law": "lvlh"}}


def planned(request: dict[str, Any]) -> Plan:
    return make_plan(read_plan_request(json.dumps(request).encode()))


@cache
def plan_of(example: str) -> Plan:
    """With the attitude level, as the papers state none."""
    return planned(level_request(example))


@cache
def view_of(example: str) -> PlanView:
    """At every row."""
    return view_plan(plan_of(example), None, HRC_PIXEL_ARCSEC)


def closest(track: TargetTrack, t_s: NDArray) -> tuple[int, float]:
    """The row of a session at the least range, and when that is."""
    rows = track.in_session.nonzero()[0]
    row = int(rows[track.range_m[rows].argmin()])
    return row, float(t_s[row])


# Camera and platform: Sumarokov 2016, pp. 85 and 86.

HEIGHT_KM = 350.0


def equipment_numbers() -> Numbers:
    limits, view = ISS_HRC.outer_limits, view_of(LAS_VEGAS)
    track = view.targets[0]
    [below_m] = sample_along_m(np.ones(1), np.array([HEIGHT_KM * 1e3]), HRC_CAMERA.pixel_rad)
    long_km, short_km = (2.0 * HEIGHT_KM * math.tan(half) for half in HRC_FRAME_HALF_RAD)
    return {
        "frame, long": long_km,
        "frame, short": short_km,
        "pixel": float(below_m),
        "pixel, Las Vegas": float(np.min(track.ground_sample_across_m[track.in_session])),
        "exposure": HRC_CAMERA.exposure_s,
        "stops": math.degrees(limits.angle_max_rad),
        "fastest": math.degrees(limits.rate_max_rad_s),
        "slowest": math.degrees(limits.rate_min_rad_s) * 60.0,
        "acceleration": math.degrees(limits.acceleration_max_rad_s2),
        "table": COMMAND_STEP_S,
        "pixel_arcsec": HRC_PIXEL_ARCSEC,
        "height_km": float(view.carrier.height_m.mean()) / 1e3,
        "along_m": float(np.max(track.ground_sample_along_m[track.in_session])),
    }


# The prediction of the orbit: Sumarokov 2016, eqs. 3 to 7.

EPHEMERIDES = Path(__file__).parents[2] / "tests/data"
FULL_HARMONICS = files("planner.world.orbits") / "data" / "eigen6s_n36.csv"
PRINTED_P2_KM4 = 2.5023e9
BURN_STEP_S = 60.0  # NASA's nodes crowd where an engine burns
DIFFERENCE_M = 50.0
STARTS = 8  # of each ephemeris
ISS: paper_model.State = (545284.0, 4217457.4, 5288809.9, -7328.9, 208.6, 656.3)  # m, m/s

Model = Literal["full", "j2j4"]


@cache
def misses_m(model: Model, ahead_s: float) -> NDArray:
    """Distances from NASA's ephemerides of the ISS, (k,)."""
    found = []
    for file in sorted(EPHEMERIDES.glob("iss_oem_*_excerpt.xml")):
        orbit = OemOrbit(content=file.read_text(encoding="utf-8"))
        for segment in orbit.message.segments:
            starts = _starts_s(segment.t_s, ahead_s)
            chosen = starts[:: max(1, len(starts) // STARTS)]
            found += [_miss_m(orbit, segment, float(t), model, ahead_s) for t in chosen]
    return np.array(found)


def _miss_m(
    orbit: OemOrbit, segment: OemSegment, t_s: float, model: Model, ahead_s: float
) -> float:
    """Between a state propagated from a node and the ephemeris."""
    start_utc = shifted_utc(segment.epoch_utc, t_s)
    stop_utc = shifted_utc(start_utc, ahead_s)
    ends = Instants(start_utc, np.array([0.0, ahead_s]))
    truth = orbit.ephemeris(start_utc, stop_utc).states(ends)
    state = StateVectorOrbit(
        frame="GCRF",
        epoch=start_utc,
        position_km=tuple((truth.r_sat_eci_m[0] / 1e3).tolist()),
        velocity_km_s=tuple((truth.v_sat_eci_m_s[0] / 1e3).tolist()),
        force_model=model,
    )
    predicted = state.ephemeris(start_utc, stop_utc).states(ends)
    return float(np.linalg.norm(predicted.r_sat_eci_m[1] - truth.r_sat_eci_m[1]))


def _starts_s(node_s: NDArray, ahead_s: float) -> NDArray:
    """Nodes, not the segment's first and last, from which no burn lies ahead."""
    burn_s = node_s[:-1][np.diff(node_s) < BURN_STEP_S]
    until_s = node_s + ahead_s
    burning = (burn_s >= node_s[:, None]) & (burn_s <= until_s[:, None])
    return node_s[1:][((until_s <= node_s[-2]) & ~burning.any(axis=1))[1:]]


def zonal(degree: int) -> float:
    """J of the packaged field, from its normalised coefficient."""
    rows = (line.split(",") for line in FULL_HARMONICS.read_text("ascii").splitlines())
    [c] = [float(row[2]) for row in rows if row[:2] == [str(degree), "0"]]
    return -c * float(np.sqrt(2 * degree + 1))


@contextmanager
def printed_p2() -> Iterator[None]:
    """The product's prediction with the paper's p2."""
    with patch.object(paper_model, "_P2", PRINTED_P2_KM4 * 1e12):
        paper_model._cached_steps.cache_clear()
        yield
    paper_model._cached_steps.cache_clear()


def p2_moves_m(span_s: float) -> float:
    """How far apart the predictions with both values of p2 end."""
    ours = paper_model.predict(ISS, span_s)[1][-1, :3]
    with printed_p2():
        printed = paper_model.predict(ISS, span_s)[1][-1, :3]
    return float(np.linalg.norm(printed - ours))


def gradient_misses_m_s2() -> tuple[float, float]:
    """Of eq. 3, p2 ours and as printed, from the slope of the potential with J2 and J4, rms."""
    errors = []
    for latitude in np.radians([0.0, 15.0, 30.0, 51.6]):
        x_m, z_m = 6.785e6 * np.cos(latitude), 6.785e6 * np.sin(latitude)
        slope = [
            (_potential(x_m + dx, z_m + dz) - _potential(x_m - dx, z_m - dz)) / (2.0 * DIFFERENCE_M)
            for dx, dz in ((DIFFERENCE_M, 0.0), (0.0, DIFFERENCE_M))
        ]
        state = (float(x_m), 0.0, float(z_m), 0.0, 0.0, 0.0)
        ours = _acceleration(state)
        with printed_p2():
            printed = _acceleration(state)
        errors.append([np.linalg.norm(one - slope) for one in (ours, printed)])
    first, second = np.sqrt(np.mean(np.square(errors), axis=0)).tolist()
    return first, second


def _potential(x_m: float, z_m: float) -> float:
    r_m = np.hypot(x_m, z_m)
    sine = z_m / r_m
    p2 = 0.5 * (3.0 * sine**2 - 1.0)
    p4 = 0.125 * (35.0 * sine**4 - 30.0 * sine**2 + 3.0)
    flattened = zonal(2) * (RADIUS_M / r_m) ** 2 * p2 + zonal(4) * (RADIUS_M / r_m) ** 4 * p4
    return float(MU_EARTH_M3_S2 / r_m * (1.0 - flattened))


def _acceleration(state: paper_model.State) -> NDArray:
    """Along x and z, of a place in the plane of both."""
    derivative = paper_model._derivative(state)
    return np.array([derivative[3], derivative[5]])


def orbit_numbers() -> Numbers:
    p2_km4 = -0.625 * zonal(4) * RADIUS_M**4 / 1e12
    ours_m_s2, printed_m_s2 = gradient_misses_m_s2()
    _, states = paper_model.predict(ISS, paper_model.STEP_S)
    there = paper_model.predict(ISS, 900.0)[1][-1]
    back = paper_model.predict((*there.tolist(),), -900.0)[1][-1]
    found: Numbers = {
        "p0": MU_EARTH_M3_S2 / 1e9,
        "p1": -1.5 * zonal(2) * RADIUS_M**2 / 1e6,
        "p2": p2_km4,
        "field": ours_m_s2 * 1e6,
        "missing X_n": float(np.linalg.norm(states[-1, :3])) / 1e3,
        "step": 1e3 * float(np.linalg.norm(back[:3] - np.array(ISS[:3]))),
        "turn": float(OMEGA_EARTH_RAD_S * paper_model.STEP_S * np.linalg.norm(states[0, :2])),
        "p2's effect": p2_moves_m(900.0),
        "too_large": PRINTED_P2_KM4 / p2_km4 - 1.0,
        "printed_um_s2": printed_m_s2 * 1e6,
    }
    for ahead_s in (60.0, 900.0, 5400.0):
        misses = misses_m("j2j4", ahead_s)
        found |= {
            f"orbit, {ahead_s:.0f} s": rms(misses),
            f"count_{ahead_s:.0f}": len(misses),
            f"farthest_{ahead_s:.0f}_m": float(misses.max()),
            f"full_{ahead_s:.0f}_m": rms(misses_m("full", ahead_s)),
        }
    return found


def draw_orbit(folder: Path) -> None:
    figure = Figure(figsize=(7.2, 3.6), layout="constrained")
    panel = figure.add_subplot()
    ahead_s = np.array([60.0, 180.0, 300.0, 600.0, 900.0, 1800.0, 5400.0])
    panel.plot(ahead_s, [rms(misses_m("j2j4", t)) for t in ahead_s], "o-", label="eqs. 3 to 7")
    panel.plot(ahead_s, [p2_moves_m(t) for t in ahead_s], "s:", label="of it by p2 as printed")
    full = [rms(misses_m("full", t)) for t in ahead_s]
    panel.plot(ahead_s, full, "^-", label="full model (ours)")
    panel.axhline(1.15, color="0.5", ls="--", lw=1.0)
    panel.text(60.0, 1.15, "a pixel", color="0.4", va="bottom", fontsize=9)
    panel.set(xscale="log", yscale="log", xlabel="seconds ahead", ylabel="position error, m rms")
    panel.set_xticks(ahead_s, [f"{t:.0f}" for t in ahead_s])
    panel.minorticks_off()
    panel.grid(alpha=0.3)
    panel.legend()
    figure.savefig(folder / "reproduction_orbit.png", dpi=100)


# The prediction of the attitude: Sumarokov 2016, eqs. 1 and 2.

TELEMETRY = Path(__file__).parents[2] / "tests/data/iss_attitude_rates_2018-285.csv"
CLOCK_UTC = datetime(2017, 12, 31, tzinfo=UTC)
TLE = TleOrbit(
    line1="1 25544U 98067A   18282.68010179  .00001200  00000-0  25646-4 0  9993",
    line2="2 25544  51.6418 168.1582 0003545 263.2788 123.8988 15.53792760136320",
)
TAU_S = 0.1
LEADS_S = (60.0, 300.0, 900.0, 1800.0)
START_EVERY = 5  # of the telemetry's minutes
NEAR_S = 5.0  # a row that near to a lead counts as at it
RATE_BODY_RAD_S = np.deg2rad([-0.003, 0.065, 0.0])  # the ISS's, once an orbit

Quaternion = NDArray[np.float64]


def printed_step(q: Quaternion, omega_rad_s: NDArray, tau_s: float, power: int) -> Quaternion:
    """Eqs. 1 and 2, scalar first, commas restored; |q| to the power 1 as printed, or squared."""
    q_n = (
        1.0 + (1.0 - np.linalg.norm(q) ** power) / 2.0 - tau_s**2 / 8.0 * omega_rad_s @ omega_rad_s
    )
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
        q = printed_step(q, RATE_BODY_RAD_S, TAU_S, 2)
    stepped = Rotation.from_quat([*q[1:], q[0]])  # eci from body, as the paper's q
    return float(np.rad2deg((stepped * closed).magnitude()) * 3600.0)


def steps_to_unit_norm(power: int) -> int:
    """From a norm 1 % too large to one within 1e-9."""
    q = np.array([1.01, 0.0, 0.0, 0.0])
    steps = 0
    while abs(np.linalg.norm(q) - 1.0) > 1e-9:
        q = printed_step(q, np.zeros(3), TAU_S, power)
        steps += 1
    return steps


@cache
def telemetry() -> tuple[NDArray, Rotation, NDArray]:
    """Times (n,) since CLOCK_UTC, body from ECI, body rates (n, 3) in deg/s, of the ISS."""
    lines = [line for line in TELEMETRY.read_text("ascii").splitlines() if line[0] != "#"]
    table = np.array([[float(x) for x in row] for row in csv.reader(lines[1:])])
    t_s = table[:, 0]
    instants = Instants(CLOCK_UTC, t_s)
    ends = [shifted_utc(CLOCK_UTC, float(t)) for t in (t_s[0], t_s[-1])]
    states = TLE.ephemeris(*ends).states(instants)
    q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
    return t_s, Rotation.from_quat(table[:, 1:5]).inv() * q_lvlh, table[:, 5:]


@cache
def constant_rate_errors_deg(lead_s: float) -> NDArray:
    """Of attitudes predicted from telemetry by the law `inertial`, each against telemetry, (k,)."""
    t_s, q_body_from_eci, rate_deg_s = telemetry()
    errors = []
    for now in range(0, len(t_s), START_EVERY):
        then = int(np.abs(t_s - t_s[now] - lead_s).argmin())
        if abs(t_s[then] - t_s[now] - lead_s) > NEAR_S:
            continue
        law = InertialAttitude(
            epoch=shifted_utc(CLOCK_UTC, float(t_s[now])),
            q_body_from_eci_xyzw=tuple(q_body_from_eci[now].as_quat().tolist()),
            omega_body_deg_s=tuple(rate_deg_s[now].tolist()),
        )
        at = Instants(CLOCK_UTC, t_s[then : then + 1])
        errors.append((predicted(law, at) * q_body_from_eci[then].inv()).magnitude())
    return np.rad2deg(errors)


def rms(values: NDArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def attitude_numbers() -> Numbers:
    at_900_deg = constant_rate_errors_deg(900.0)
    return {
        "recursion": recursion_error_arcsec(900.0),
        "norm correction": float(steps_to_unit_norm(2)),
        "constant rate, 900 s": rms(at_900_deg),
        "constant rate, 60 s": rms(constant_rate_errors_deg(60.0)),
        "as_printed": steps_to_unit_norm(1),
        "count": len(at_900_deg),
        "frame_deg": float(np.rad2deg(min(HRC_FRAME_HALF_RAD))),
    }


def draw_attitude(folder: Path) -> None:
    figure = Figure(figsize=(7.2, 3.6), layout="constrained")
    panel = figure.add_subplot()
    leads_s = np.array([60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0])
    errors = [constant_rate_errors_deg(float(lead)) for lead in leads_s]
    panel.plot(leads_s, [rms(one) for one in errors], "o-", label="rms")
    panel.plot(leads_s, [one.max() for one in errors], "^:", color="0.5", label="largest")
    frame_deg = float(np.rad2deg(min(HRC_FRAME_HALF_RAD)))
    panel.axhline(frame_deg, color="C3", ls="--", lw=1.0)
    panel.text(60.0, frame_deg, "half the frame's height", color="C3", va="bottom", fontsize=9)
    panel.set(xscale="log", yscale="log", xlabel="seconds ahead", ylabel="attitude error, deg")
    panel.set_xticks(leads_s, [f"{lead:.0f}" for lead in leads_s])
    panel.minorticks_off()
    panel.grid(alpha=0.3)
    panel.legend()
    figure.savefig(folder / "reproduction_attitude.png", dpi=100)


# From the target to the angles of the axes: Sumarokov 2016, eqs. 8 to 11.

TILT_RAD = np.radians(5.0)
ZERO = np.array([0.0, 0.0, 1.0])  # the paper leaves its V open
OUTER, INNER = ISS_HRC.axes_platform
ALPHA_DEG, BETA_DEG = 60.0, 45.0  # how far a session over a city goes
SHAPE = (90, 120)  # of a grid over them, a degree a cell


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


@cache
def grid() -> tuple[NDArray, NDArray]:
    """Angles (n, 2) in rad over what a session asks for, and the error of the text's alpha."""
    alpha, beta = np.meshgrid(
        np.radians(np.arange(-ALPHA_DEG + 0.5, ALPHA_DEG)),
        np.radians(np.arange(-BETA_DEG + 0.5, BETA_DEG)),
    )
    angle_rad = np.stack([alpha.ravel(), beta.ravel()], axis=1)
    target = boresight_platform(ISS_HRC, angle_rad)
    turned = boresight_platform(ISS_HRC, angle_rad * [0.0, 1.0])
    as_told_rad = np.arccos(np.clip(np.sum(target * turned, axis=1), -1.0, 1.0))
    return angle_rad, as_told_rad - np.abs(angle_rad[:, 0])


def quaternion_line_of_sight() -> tuple[NDArray, NDArray, NDArray]:
    """By eq. 10 as printed and by the product, unit vectors (n, 3), and the range, (n,) m.

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
    range_m = np.linalg.norm(platform, axis=1)
    return platform / range_m[:, None], seen.los_platform, range_m


def angles_numbers() -> Numbers:
    return {**_chain(), **_intersections(), **_misread_angles()}


def _chain() -> Numbers:
    rng = np.random.default_rng(8)
    latitude, longitude = rng.uniform(-1.57, 1.57, 1000), rng.uniform(-3.14, 3.14, 1000)
    height_m = rng.uniform(-400.0, 9000.0, 1000)
    difference_m = printed_target_m(latitude, longitude, height_m) - itrf_from_geodetic(
        latitude, longitude, height_m
    )
    printed, ours, range_m = quaternion_line_of_sight()
    apart_rad = np.linalg.norm(printed - ours, axis=1)
    off_m = float((apart_rad * range_m).max())
    return {
        "target": float(np.abs(difference_m).max()) * 1e3,
        "line of sight": float(ours.shape[1]),
        "rotations": float(np.rad2deg(apart_rad.max())) * 3600.0,
        "off_m": off_m,
        "off_px": off_m / 1.15,
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
    found = np.isfinite(printed[..., 2]).all(axis=0)
    return {
        "axes": float(np.rad2deg(np.arccos(OUTER @ INNER))),
        "intersections": float(np.rad2deg(apart[known].max())) * 3600.0,
        "z as a root": 100.0 * float(np.mean(printed[:, known, 2] >= 0.0)),
        "missed": int(np.sum(found != known)),
        "keep_one": float(np.mean((printed[:, known, 2] >= 0.0).any(axis=0))),
    }


def _misread_angles() -> Numbers:
    angle_rad, error_rad = grid()
    turned = boresight_platform(ISS_HRC, angle_rad * [0.0, 1.0])
    beta_error_rad = np.arccos(np.clip(turned @ ZERO, -1.0, 1.0)) - np.abs(angle_rad[:, 1])
    return {
        "alpha as told": float(np.rad2deg(np.sqrt(np.mean(error_rad**2)))),
        "beta as told": float(np.rad2deg(np.abs(beta_error_rad).max())),
        "worst_deg": float(np.rad2deg(np.abs(error_rad).max())),
    }


def draw_angles(folder: Path) -> None:
    _draw_cones(folder / "reproduction_cones.png")
    _draw_error(folder / "reproduction_angles.png")


def _draw_cones(file: Path) -> None:
    target = boresight_platform(ISS_HRC, np.radians([[40.0, 25.0]]))
    lines = printed_intersections(target)[:, 0]
    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    panel = figure.add_subplot(projection="3d")
    around = np.linspace(0.0, 2.0 * np.pi, 121)
    for axis, start, colour in ((INNER, ZERO, "C0"), (OUTER, target[0], "C3")):
        circle = Rotation.from_rotvec(around[:, None] * axis).apply(start)
        x, y, z = (np.stack([0.0 * edge, edge]) for edge in circle.T)
        panel.plot_surface(x, y, z, color=colour, alpha=0.12)
        panel.plot(*circle.T, color=colour, lw=1.0)
    named = (
        ("V", ZERO, "C0"),
        ("T", target[0], "C3"),
        ("$A_β$", INNER, "C0"),
        ("$A_α$", OUTER, "C3"),
    )
    for name, direction, colour in named:
        is_axis = name.startswith("$")
        panel.plot(*np.stack([0.0 * direction, 1.25 * direction]).T, color=colour, lw=1.6,
                   ls="--" if is_axis else "-")  # fmt: skip
        panel.text(*(1.35 * direction), name, color=colour)
    beta_rad = np.abs(np.arctan2(-lines[:, 1], lines[:, 2]))
    for k, line in enumerate(lines):
        chosen = k == int(beta_rad.argmin())
        panel.plot(*np.stack([0.0 * line, 1.1 * line]).T, "k", lw=2.0, ls="-" if chosen else ":")
        panel.text(*(1.2 * line), "L", color="k")
    panel.set(xlabel="x", ylabel="y", zlabel="z", box_aspect=(1, 1, 1))
    ends = {f"{axis}{what}": (-1, 1) for axis in "xyz" for what in ("lim", "ticks")}
    panel.set(**ends)
    panel.view_init(elev=20.0, azim=-25.0)
    figure.savefig(file, dpi=100)


def _draw_error(file: Path) -> None:
    angle_rad, error_rad = grid()
    error_deg = np.rad2deg(error_rad).reshape(SHAPE)
    alpha_deg, beta_deg = (np.rad2deg(angle_rad[:, k]).reshape(SHAPE) for k in (0, 1))
    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    panel = figure.add_subplot()
    filled = panel.contourf(alpha_deg, beta_deg, error_deg, levels=12, cmap="Blues_r")
    lines = panel.contour(alpha_deg, beta_deg, error_deg, [-15, -10, -5, -2, -0.5], colors="k",
                          linewidths=0.6, linestyles="-")  # fmt: skip
    panel.clabel(lines, fmt="%g°", fontsize=8)
    figure.colorbar(filled, label="angle between T and L less |alpha|, deg")
    panel.set(xlabel="alpha, deg", ylabel="beta, deg")
    figure.savefig(file, dpi=100)


# The transfer onto the track: Sumarokov 2016, eqs. 12 to 14 and the filter.

LIMITS = ISS_HRC.outer_limits
UNFILTERED, SLOW = SlewOptions(filter_cutoff_hz=None), SlewOptions(filter_cutoff_hz=0.2)
PRINTED_LAG_S = 0.8
DRAWS, REACH_DEG, TRACK_DEG_S = 300, 170.0, 1.0


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


class Drawn(NamedTuple):
    """Of slews drawn at random, (DRAWS,) each."""

    time_share: NDArray  # of the least
    breaks_any: NDArray
    breaks_published: NDArray  # limits but for jerk
    left_arcsec: NDArray  # at the join, the lag compensated
    left_uncompensated_arcsec: NDArray


@cache
def drawn_slews() -> Drawn:
    rng = np.random.default_rng(12)
    rows = []
    for _ in range(DRAWS):
        start = tuple(deg_state(rng.uniform(-REACH_DEG, REACH_DEG)) for _ in "ab")
        end = tuple(
            deg_state(rng.uniform(-REACH_DEG, REACH_DEG), rng.uniform(-TRACK_DEG_S, TRACK_DEG_S))
            for _ in "ab"
        )
        problem = in_paper_time(start, end)
        filtered = paper_slew(problem, SlewOptions())
        behind = paper_slew(problem, SlewOptions(filter_lag_compensation=False))
        broken = {violation.limit for violation in filtered.violations}
        least_s = compare_with_spline(filtered, SlewOptions(), None).least_s or np.inf
        rows.append(
            (
                problem.duration_s / least_s,
                bool(broken),
                bool(broken - {"jerk"}),
                *(np.rad2deg(np.abs(s.end_error_rad).max()) * 3600.0 for s in (filtered, behind)),
            )
        )
    return Drawn(*np.array(rows).T)


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
    drawn = drawn_slews()
    start, end, duration_s = deg_state(10.0, 0.5), deg_state(70.0, 0.8), 34.0
    cubic = cubic_profile(start, end, duration_s)
    left = cubic.end_values[1, :2] - [end.angle_rad, end.rate_rad_s]
    transfer = cubic_profile(start, end, 120.0)  # Fig. 2's first, until 1320 s
    lag_s = filter_lag_s(SlewOptions(filter_cutoff_hz=2.0))
    unfiltered, filtered = (
        math.degrees(paper_slew(example(), options).profiles[0].end_values[0, 2])
        for options in (UNFILTERED, SlewOptions())
    )
    return {
        "effective rate": PAPER_SPLINE_OPTIONS.rate_share * math.degrees(LIMITS.rate_max_rad_s),
        "effective acceleration": PAPER_SPLINE_OPTIONS.acceleration_share
        * math.degrees(LIMITS.acceleration_max_rad_s2),
        "time": float(np.median(drawn.time_share)),
        "limits broken": 100.0 * float(np.mean(drawn.breaks_any)),
        "coefficients": float(np.rad2deg(np.abs(left).max())) * 3600.0,
        "clock": math.degrees(float(transfer.end_values[1, 0])),
        "lag": lag_s,
        "high-pass": high_passed_deg(lag_s),
        "continuous acceleration": filtered,
        "lag compensated": float(np.median(drawn.left_arcsec)),
        "least": float(drawn.time_share.min()),
        "most": float(drawn.time_share.max()),
        "break_published": 100.0 * float(np.mean(drawn.breaks_published)),
        "misread_deg": math.degrees(start.rate_rad_s * (duration_s - 1.0)),
        "cutoff_hz": 0.5 / math.pi / PRINTED_LAG_S,
        "unfiltered": unfiltered,
        "uncompensated_arcsec": float(np.median(drawn.left_uncompensated_arcsec)),
    }


def draw_transfer(folder: Path) -> None:
    problem = example()
    t_s = np.linspace(0.0, problem.duration_s, 1500)
    figure = Figure(figsize=(7.2, 5.4), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, height_ratios=(1.0, 1.3, 1.0))
    for label, slew, style in (
        ("cubic", paper_slew(problem, UNFILTERED), "C1:"),
        ("through 2 Hz (0.08 s)", paper_slew(problem, SlewOptions()), "C1-"),
        ("through 0.2 Hz (0.8 s)", paper_slew(problem, SLOW), "C3--"),
        ("ours", optimal_slew(problem), "C0-"),
    ):
        angle, _, acceleration, _ = np.rad2deg(slew.profiles[0].evaluate(t_s))
        top.plot(t_s, angle, style, lw=1.2)
        middle.plot(t_s, acceleration, style, lw=1.2, label=label)
    top.set_ylabel("alpha, deg")
    middle.set(ylabel="acceleration, deg/s²", xlabel="time, s")
    middle.legend(fontsize=8, ncols=2)
    bottom.hist(drawn_slews().time_share, bins=40, color="0.6")
    bottom.axvline(float(np.median(drawn_slews().time_share)), color="C3", lw=1.2)
    bottom.set(xlabel="time of eq. 12 over the least time", ylabel=f"of {DRAWS} slews")
    figure.savefig(folder / "reproduction_transfer.png", dpi=100)


# Three consecutive sessions: Sumarokov 2016, Fig. 2.

CLOCK_S = 1200.0  # the paper's at row 0
TRANSFERS_S = ((1200.0, 1320.0), (1450.0, 1660.0), (1750.0, 1800.0))
IMAGING_S = ((1320.0, 1450.0), (1660.0, 1750.0), (1800.0, 1900.0))
NAMES = ("first", "second", "third")


def spans_s(kind: str) -> list[tuple[float, float]]:
    """Of the plan's segments of a kind, on the paper's clock."""
    plan = plan_of(THREE_SESSIONS)
    return [
        (
            CLOCK_S + elapsed_s(segment.start_utc, plan.table.epoch_utc),
            CLOCK_S + elapsed_s(segment.stop_utc, plan.table.epoch_utc),
        )
        for segment in plan.segments
        if segment.kind == kind
    ]


def closest_s() -> list[float]:
    view = view_of(THREE_SESSIONS)
    return [CLOCK_S + closest(track, view.t_s)[1] for track in view.targets]


def sessions_numbers() -> Numbers:
    plan = plan_of(THREE_SESSIONS)
    found: Numbers = {"greatest rate": float(np.rad2deg(np.abs(plan.table.rate_rad_s).max()))}
    transfers, imaging = spans_s("slew"), spans_s("track")
    for name, transfer, image, at_s, slew in zip(
        NAMES, transfers, imaging, closest_s(), plan.slews, strict=True
    ):
        assert slew.comparison is not None
        splines = slew.comparison.spline.values()
        broken = {limit for spline in splines for limit in spline.limits_broken}
        found |= {
            f"{name} transfer": transfer[1] - transfer[0],
            f"{name} imaging": image[1] - image[0],
            f"{name} closest approach": at_s,
            f"{name} transfer's time": slew.comparison.paper_s,
            f"{name}_least_s": slew.minimum_s,
            f"{name}_breaks": ", ".join(sorted(broken)) or "no limit",
        }
    return found


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
        for at_s in closest_s():
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


# Las Vegas flown, with friction and without: Sumarokov 2016, Fig. 3.

TORQUE_EQUILIBRIUM = {"law": "lvlh", "yaw_deg": -4.1, "pitch_deg": -2.0, "roll_deg": 0.7}
LOOP_HZ = 0.25  # with more the axis sticks, but hardly oscillates
FAST_ARCMIN_S = 1.5  # well above the drives' least rate
SWING_ARCSEC = 2.0  # less is the sensors' noise
NO_FRICTION = {"coulomb_deg_s2": 0.0, "breakaway_deg_s2": 0.0, "viscous_per_s": 0.0}
NO_CABLE = {"cable_tension_deg_s2": 0.0, "cable_stiffness_per_s2": 0.0}
ARCSEC = np.degrees(1.0) * 3600.0


class Flown(NamedTuple):
    """At the table's rows in the session, (n,) and (n, 2)."""

    t_s: NDArray  # since the session's start
    angle_rad: NDArray
    commanded_rad: NDArray
    commanded_rate_arcmin_s: NDArray
    error_arcsec: NDArray


class Swings(NamedTuple):
    """Of beta's error while it is commanded below its least rate, after it stuck the longest."""

    largest_arcsec: float
    amplitude_arcsec: float  # median half way from one turning point to the next
    frequency_hz: float
    count: int


@cache
def the_plan() -> Plan:
    request = level_request(LAS_VEGAS)
    return planned({**request, "attitude": TORQUE_EQUILIBRIUM})


@cache
def flight(friction: bool = True, cable: bool = True, loop_hz: float = LOOP_HZ) -> Flown:
    told = the_plan()
    platform = told.scenario.platform
    off = {**({} if friction else NO_FRICTION), **({} if cable else NO_CABLE)}
    alpha, beta = (replace(one, bandwidth_hz=loop_hz, **off) for one in platform.drives)
    motion = fly(told.table, platform, drives=(alpha, beta), output_step_s=COMMAND_STEP_S)
    session = told.scenario.sessions[0]
    start_s, stop_s = (elapsed_s(at, told.table.epoch_utc) for at in (session.start, session.stop))
    inside = (motion.t_s >= start_s - 1e-6) & (motion.t_s <= stop_s + 1e-6)
    commanded_rad = told.table.position[inside]
    return Flown(
        t_s=motion.t_s[inside] - start_s,
        angle_rad=motion.angle_rad[inside],
        commanded_rad=commanded_rad,
        commanded_rate_arcmin_s=np.degrees(told.table.rate_rad_s[inside]) * 60.0,
        error_arcsec=(motion.angle_rad[inside] - commanded_rad) * ARCSEC,
    )


def slow(flown: Flown) -> NDArray:
    """The rows at which beta is commanded below the drives' least rate."""
    return np.abs(flown.commanded_rate_arcmin_s[:, 1]) < 1.0


def swings(flown: Flown) -> Swings:
    error_arcsec = flown.error_arcsec[slow(flown), 1]
    t_s = flown.t_s[slow(flown)]
    worst = int(np.abs(error_arcsec).argmax())
    largest = float(np.abs(error_arcsec[worst]))
    tops, bottoms = (
        worst + find_peaks(sign * error_arcsec[worst:], prominence=SWING_ARCSEC)[0]
        for sign in (1.0, -1.0)
    )
    turns = np.sort(np.concatenate([tops, bottoms]))
    if len(tops) < 2:
        return Swings(largest, 0.5 * float(np.ptp(error_arcsec)), 0.0, len(tops))
    half = 0.5 * float(np.median(np.abs(np.diff(error_arcsec[turns]))))
    period_s = float(np.median(np.diff(t_s[tops])))
    return Swings(largest, half, 1.0 / period_s, len(tops))


def flight_numbers() -> Numbers:
    flown = flight()
    found = swings(flown)
    fast = np.abs(flown.commanded_rate_arcmin_s[:, 1]) > FAST_ARCMIN_S
    return {
        "flown alpha": float(np.abs(flown.error_arcsec[:, 0]).max()),
        "flown beta, amplitude": found.amplitude_arcsec,
        "flown beta, frequency": found.frequency_hz,
        "flown beta, faster": float(np.abs(flown.error_arcsec[fast, 1]).max()),
        "flown beta, no friction": swings(flight(friction=False, cable=False)).amplitude_arcsec,
        "flown beta, no cables": swings(flight(cable=False)).amplitude_arcsec,
        "turned_deg": float(np.degrees(np.ptp(flown.commanded_rad[:, 0]))),
        "slow_s": float(slow(flown).sum()) * COMMAND_STEP_S,
        "largest_arcsec": found.largest_arcsec,
        "count": found.count,
        "only_cable_arcsec": swings(flight(friction=False)).amplitude_arcsec,
    }


def draw_flight(folder: Path) -> None:
    flown, free = flight(), flight(friction=False, cable=False)
    figure = Figure(figsize=(8.4, 7.0), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    for k, name in enumerate(("alpha", "beta")):
        panels[k].plot(flown.t_s, np.degrees(flown.commanded_rad[:, k]), "C3", label="commanded")
        panels[k].plot(flown.t_s, np.degrees(flown.angle_rad[:, k]), "C0", lw=1.0, label="flown")
        panels[k].set_ylabel(f"{name}, deg")
    panels[2].plot(flown.t_s, flown.error_arcsec[:, 1], "C0", label="with friction and cables")
    panels[2].plot(free.t_s, free.error_arcsec[:, 1], "C2", label="without")
    panels[2].set_ylabel("beta off, arcsec")
    for panel in panels:
        panel.fill_between(flown.t_s, 0.0, 1.0, where=slow(flown), color="#f3e9c6", zorder=0,
                           transform=panel.get_xaxis_transform())  # fmt: skip
        panel.grid(alpha=0.3)
        panel.legend(loc="lower right")
    panels[2].set_xlabel("seconds since the session began")
    figure.savefig(folder / "reproduction_las_vegas.png", dpi=100)


# Las Vegas, 27 February 2015: Sumarokov 2016, Figs. 3 and 4.

DAY_UTC = datetime(2015, 2, 27, tzinfo=UTC)
TRIALS_UTC = datetime(2014, 11, 24, tzinfo=UTC)  # "since the end of November 2014"
CAPTION_UTC = datetime(2014, 2, 28, tzinfo=UTC)  # the last day that Fig. 4's caption allows
DAYLIGHT = OpportunityConditions(min_elevation_deg=30.0, sun_elevation_min_deg=10.0)
LORRY_M, CAB_M = 16.0, 2.5


def daylight_passes() -> Windows:
    """Over Las Vegas, on the local day of the paper's session."""
    scenario = plan_of(LAS_VEGAS).scenario
    local_midnight_utc = DAY_UTC + timedelta(hours=8)  # Pacific standard time
    request = OpportunityRequest(
        platform=scenario.platform,
        orbit=scenario.orbit,
        attitude=scenario.attitude,
        targets=(OpportunityTarget(id="Las Vegas", target=scenario.sessions[0].target),),
        start=local_midnight_utc,
        stop=local_midnight_utc + timedelta(days=1),
        conditions=DAYLIGHT,
        samples=3,
    )
    return find_opportunities(request).windows


def las_vegas_numbers() -> Numbers:
    plan, view = plan_of(LAS_VEGAS), view_of(LAS_VEGAS)
    track = view.targets[0]
    row, at_s = closest(track, view.t_s)
    at_utc = plan.table.epoch_utc + timedelta(seconds=at_s)
    rows = track.in_session.nonzero()[0]
    first_deg, last_deg = np.rad2deg(track.elevation_rad[rows[[0, -1]]]).tolist()
    alpha_s, beta_s = (
        sum(
            stretch.stop_s - stretch.start_s
            for session in plan.verification.sessions
            for stretch in session.slow_stretches
            if stretch.axis == axis
        )
        for axis in ("alpha", "beta")
    )
    best_m = float(np.min(track.ground_sample_across_m[track.in_session]))
    return {
        "date": float(len(daylight_passes())),
        "caption's date": float((TRIALS_UTC - CAPTION_UTC).days),
        "closest approach": elapsed_s(at_utc, DAY_UTC),
        "greatest elevation": float(np.rad2deg(track.elevation_rad[rows].max())),
        "slow beta": beta_s,
        "cars": LORRY_M / best_m,
        "at": utc_text(at_utc, 1),
        "range_km": float(track.range_m[row]) / 1e3,
        "sun_deg": math.degrees(float(track.sun_elevation_rad[row])),
        "first_deg": first_deg,
        "last_deg": last_deg,
        "slow_alpha_s": alpha_s,
        "best_m": best_m,
        "cab_px": CAB_M / best_m,
        "car_px": 4.5 / best_m,
    }


# Boston in four frames, and the gallery: Sumarokov 2016, Fig. 5 and p. 95.

PIXEL_RAD = np.radians(HRC_PIXEL_ARCSEC / 3600.0)
FRAMES, APART_S = 4, 10.0
SPEED_KM_H = 75.0
CITIES = ("london", "barcelona", "boston", "mecca", "vancouver")
# Where skyscrapers stand beside the target, and how high they are.
TOWERS = (
    ("One Boston Place", 42.3586, -71.0580, 183.0),
    ("60 State Street", 42.3592, -71.0568, 155.0),
    ("Custom House", 42.3591, -71.0533, 151.0),
)
CAR = (42.3580, -71.0624)  # a street beside; it drives north-east


@cache
def frames() -> TableStates:
    """Four instants about the closest approach."""
    plan, view = plan_of(BOSTON), view_of(BOSTON)
    _, middle_s = closest(view.targets[0], view.t_s)
    t_s = middle_s + APART_S * (np.arange(FRAMES) - 0.5 * (FRAMES - 1))
    return table_states(plan, np.round(t_s * ROWS_PER_S).astype(np.intp))


def car() -> MovingGroundTarget:
    return MovingGroundTarget(
        epoch=frames().instants.utc(0),
        latitude_deg=CAR[0],
        longitude_deg=CAR[1],
        height_m=10.0,
        course_deg=45.0,
        speed_m_s=SPEED_KM_H / 3.6,
    )


def in_frame_px(target: VisibleTarget) -> NDArray:
    """Where the camera sees a place in each frame, from the middle, right and down, (FRAMES, 2)."""
    rows = frames()
    seen = target.apparent(rows.instants, rows.states)
    ray = Rotation.from_quat(rows.q_payload_from_eci_xyzw).apply(seen.direction_eci)
    return np.asarray(ray[:, :2] / ray[:, 2:] / PIXEL_RAD)


def place(latitude_deg: float, longitude_deg: float, height_m: float) -> GroundTarget:
    return GroundTarget(latitude_deg=latitude_deg, longitude_deg=longitude_deg, height_m=height_m)


def boston_numbers() -> Numbers:
    return {**_car(), **_view(), **_sessions()}


def _car() -> Numbers:
    moving = car()
    r_m = moving.r_target_itrf_m(frames().instants)
    moved_px = np.linalg.norm(in_frame_px(moving) - in_frame_px(place(*CAR, 10.0)), axis=1)
    steps_px = np.diff(moved_px)
    return {
        "car, metres": float(np.linalg.norm(np.diff(r_m, axis=0), axis=1).mean()),
        "car, pixels": float(steps_px.mean()),
        "car, speed": SPEED_KM_H / float(steps_px.mean()),
        "least_px": float(steps_px.min()),
        "most_px": float(steps_px.max()),
    }


def _view() -> Numbers:
    rows = frames()
    r_target_itrf_m = plan_of(BOSTON).scenario.sessions[0].target.r_target_itrf_m(rows.instants)
    r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf_from_eci(rows.instants), rows.states.r_sat_eci_m)
    up = r_sat_itrf_m - r_target_itrf_m
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    _, latitude, longitude, height_m = TOWERS[0]
    lean_px = in_frame_px(place(latitude, longitude, height_m)) - in_frame_px(
        place(latitude, longitude, 0.0)
    )
    return {
        "viewpoint": float(np.rad2deg(np.arccos(up[0] @ up[-1]))),
        "tower_m": height_m,
        "lean_px": float(np.linalg.norm(lean_px[-1] - lean_px[0])),
    }


def _sessions() -> Numbers:
    lengths_s, misses_px, passed = [], [], 0
    for city in CITIES:
        plan, view = plan_of(f"gallery/{city}.json"), view_of(f"gallery/{city}.json")
        session, track = plan.scenario.sessions[0], view.targets[0]
        lengths_s.append(elapsed_s(session.stop, session.start))
        misses_px.append(float(np.nanmax(track.error_rad[track.in_session])) / PIXEL_RAD)
        passed += plan.verification.passed
    return {"gallery": passed, "length": min(lengths_s), "same point": max(misses_px)}


def draw_boston(folder: Path) -> None:
    figure = Figure(figsize=(8.4, 6.6), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel()
    path_px = in_frame_px(car())
    feet = [in_frame_px(place(lat, lon, 0.0)) for _, lat, lon, _ in TOWERS]
    tops = [in_frame_px(place(lat, lon, height)) for _, lat, lon, height in TOWERS]
    start_px = in_frame_px(place(*CAR, 10.0))
    streets = _streets_px()
    north = in_frame_px(place(42.3601 + 0.0006, -71.0589, 10.0))
    for k, (panel, letter) in enumerate(zip(panels, "abcd", strict=True)):
        for street in streets:
            panel.plot(street[:, k, 0], street[:, k, 1], color="0.85", lw=0.8, zorder=0)
        for foot, top in zip(feet, tops, strict=True):
            panel.plot(*np.stack([foot[k], top[k]]).T, color="#3c5a78", lw=4.0,
                       solid_capstyle="butt")  # fmt: skip
            panel.plot(*top[k], "s", color="#3c5a78", ms=7)
        panel.plot(*np.stack([start_px[k], path_px[k]]).T, color="C3", lw=0.8, ls=":")
        panel.plot(*path_px[k], "o", mfc="none", mec="C3", mew=1.5, ms=9)
        panel.plot(0.0, 0.0, "+", color="k", ms=9)
        dx, dy = 90.0 * north[k] / np.linalg.norm(north[k])
        panel.annotate("", (430.0 + dx, -180.0 + dy), (430.0, -180.0),
                       arrowprops={"arrowstyle": "->"})  # fmt: skip
        panel.text(430.0 + 1.3 * dx, -180.0 + 1.3 * dy, "N", ha="center", va="center")
        panel.set_title(f"{letter}: {frames().instants.utc_text(0)[k][11:19]} UTC", fontsize=10)
        panel.set(xlim=(-420, 520), ylim=(340, -340), aspect="equal")
    for panel in panels[2:]:
        panel.set_xlabel("pixels")
    for panel in panels[::2]:
        panel.set_ylabel("pixels")
    figure.savefig(folder / "reproduction_boston.png", dpi=100)


def _streets_px() -> list[NDArray]:
    """Lines 200 m apart about the target, (2, FRAMES, 2) each."""
    north_deg, east_deg = 200.0 / 111.1e3, 200.0 / 82.2e3
    ends = (-5.0, 5.0)
    ways = [
        way
        for k in range(-5, 6)
        for way in (
            [(42.3601 + k * north_deg, -71.0589 + end * east_deg) for end in ends],
            [(42.3601 + end * north_deg, -71.0589 + k * east_deg) for end in ends],
        )
    ]
    return [np.stack([in_frame_px(place(lat, lon, 10.0)) for lat, lon in way]) for way in ways]


# The other modes of pointing: Sumarokov 2016, pp. 86 and 96.

DAY = ("2015-02-27T17:00:00Z", "2015-02-28T17:00:00Z")
SESSION_S, LEAD_S = 60.0, 120.0
MODES: dict[str, dict[str, Any]] = {
    "star": {"mode": "star", "ra_deg": 213.915, "dec_deg": 19.182},
    "moon": {"mode": "body", "name": "moon"},
    "sun": {"mode": "body", "name": "sun"},
    "test motion": {
        "mode": "test_motion",
        "axes": {
            "alpha": {"kind": "sine", "amplitude_deg": 5.0, "frequency_hz": 0.02},
            "beta": {"kind": "triangle", "amplitude_deg": 5.0, "period_s": 60.0, "turn_s": 6.0},
        },
    },
}


def session_start(target: dict[str, Any]) -> str:
    """The first of the day at which a minute of the target can be had."""
    base = level_request(LAS_VEGAS)
    if target["mode"] == "test_motion":
        return str(base["sessions"][0]["start"])
    asked = json.dumps(
        {
            **{name: base[name] for name in ("platform", "orbit", "attitude")},
            "targets": [{"id": "it", "target": target}],
            "start": DAY[0],
            "stop": DAY[1],
            "conditions": {"min_duration_s": SESSION_S + 10.0},
            "samples": 2,
        }
    )
    found = find_opportunities(read_opportunity_request(asked.encode()))
    after_start = found.windows.rise_s > 0.0
    first_s = float(np.ceil(found.windows.rise_s[after_start][0]))
    return utc_text(found.start_utc + timedelta(seconds=first_s), 0)


def worst_arcsec(target: dict[str, Any]) -> float:
    """Of a planned session of the mode, by the independent judge, who must pass it."""
    request = level_request(LAS_VEGAS)
    start = session_start(target)
    begins_utc = utc_from_text(start)
    request["initial_state"]["epoch"] = utc_text(begins_utc - timedelta(seconds=LEAD_S), 0)
    stop = utc_text(begins_utc + timedelta(seconds=SESSION_S), 0)
    request["sessions"] = [{"target": target, "start": start, "stop": stop}]
    made = planned(request)
    assert made.verification.passed
    return float(np.degrees(made.verification.sessions[0].max_rad)) * 3600.0


def modes_numbers() -> Numbers:
    return {f"mode, {name}": worst_arcsec(target) for name, target in MODES.items()}
