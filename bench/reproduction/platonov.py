"""Platonov, Sumarokov 2019: imaging from a spacecraft with control moment gyros."""

import dataclasses
import json
import math
from collections.abc import Sequence
from datetime import timedelta
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from imaging_cases import (
    EPOCH,
    PAPER_TURNS_S,
    area,
    itself,
    line,
    local_axes,
    orbit_states,
    positions,
    session_request,
    settle_table,
    sun_synchronous,
)
from matplotlib.figure import Figure
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from app.requests.spacecraft import read_spacecraft_request
from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.rotation import of_like_sign
from planner.inflight.simulation.gyros.closed_loop import Log
from planner.inflight.simulation.gyros.dispersed import (
    Dispersion,
    as_designed,
    camera_on,
    computer,
    draw_dispersion,
    fly_table,
)
from planner.inflight.simulation.gyros.onboard import (
    PAPER,
    TABLE,
    OnboardEstimate,
    estimate_rate,
    memory_at,
)
from planner.inflight.simulation.gyros.steadiness import rate_errors, settled_after_s
from planner.motion.attitude.eigenaxis import quickest_angle
from planner.motion.attitude.track import agility_limits, attitude_motion
from planner.spacecraft.flights import fly_many
from planner.spacecraft.imaging.candidates import candidates
from planner.spacecraft.imaging.choice import options_of
from planner.spacecraft.imaging.session import GroundArc, ImagingSession, make_session
from planner.spacecraft.plan import ImagingPlan, plan_imaging
from planner.spacecraft.requests import (
    SCAN_SPEED_M_S,
    GeoLineString,
    ImagingPlanRequest,
    StripRequest,
)
from planner.spacecraft.vehicle import AgileSpacecraft
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text
from planner.world.orbits import StateVectorOrbit
from planner.world.platforms.cmg_array import CmgArray
from planner.world.platforms.gyro_craft import ControlGains, GyroCraft
from planner.world.platforms.steering import steer
from reproduction.report import Numbers

# The sessions of Platonov, Sumarokov 2019, Figs. 3 to 9: requests, plans and dispersed flights.
# `text` makes the requests in examples/.  The paper gives times and sizes, neither orbit nor
# places; here strips lie along the track where the orbit passes at those times.

STRIP_S, STEREO_S, SCAN_S, GAP_S = 128.0, 338.0, 16.0, 110.0  # Figs. 4 and 6
STEREO_KM, AREAS_KM = 700.0, 640.0  # of the paper's 600 to 700; lower, the ends lie beyond 30 deg
LONG_START_S = 400.0  # the paper's clock at row 0 of the long session
FIRST_SCAN_S, SCAN_AFTER_S = 15.0, 14.0  # Figs. 8 and 9: 866-881 and 1405-1419 s
SEEDS = range(8)  # dispersed runs: 40 move the worst by a fifth


def at(t_s: float) -> str:
    return utc_text(EPOCH + timedelta(seconds=t_s), 1)


def lines(
    orbit: StateVectorOrbit, t_s: float, half_m: float, across_m: tuple[float, ...]
) -> list[Sequence]:
    """Lines along the track beside each other, where the orbit passes at t_s."""
    origin, along, across = local_axes(orbit, t_s)
    return [
        positions([origin + a * across - half_m * along, origin + a * across + half_m * along])
        for a in across_m
    ]


def one(name: str, mode: str, line: Sequence, start_s: float, **more: object) -> dict:
    coordinates = [[round(x, 6) for x in position] for position in line]
    return {
        "mode": mode,
        "name": name,
        "geometry": {"type": "LineString", "coordinates": coordinates},
        "start": at(start_s),
        **more,
    }


def session(
    name: str, orbit: StateVectorOrbit, stop_s: float, requests: list[dict], **more: object
) -> dict:
    return {
        "name": name,
        "orbit": {
            "source": "state",
            "frame": "GCRF",
            "epoch": at(0.0),
            "position_km": [round(x, 6) for x in orbit.position_km],
            "velocity_km_s": [round(x, 9) for x in orbit.velocity_km_s],
        },
        "start": at(0.0),
        "stop": at(stop_s),
        **more,
        "requests": requests,
    }


def strip_and_stereo() -> dict:
    orbit = sun_synchronous(STEREO_KM)
    half_m = 0.5 * SCAN_S * SCAN_SPEED_M_S
    [strip] = lines(orbit, STRIP_S + 0.5 * SCAN_S, half_m, (0.0,))
    [stereo] = lines(orbit, STEREO_S + 0.5 * (GAP_S + SCAN_S), half_m, (0.0,))
    return session(
        "Strip and stereo pair of Platonov, Sumarokov 2019",
        orbit,
        560.0,
        [
            one("strip", "strip", strip, STRIP_S),
            one("stereo", "stereo", stereo, STEREO_S, gap_s=GAP_S),
        ],
    )


def eight_areas() -> dict:
    """Each area of 48 x 60 km as its four strips, so that each has the paper's moment."""
    orbit = sun_synchronous(AREAS_KM)
    requests = []
    for block in range(8):
        turns_s = [t - LONG_START_S for t in PAPER_TURNS_S[4 * block : 4 * block + 5]]
        scans_s = [FIRST_SCAN_S, *[SCAN_AFTER_S] * 3]
        stops_s = [turns_s[1] - 1.0, *[t - 0.2 for t in turns_s[2:]]]
        starts_s = [stop - scan for stop, scan in zip(stops_s, scans_s, strict=True)]
        aside_m = 60e3 * (-1) ** block
        across_m = tuple(aside_m + 12e3 * (k - 1.5) for k in range(4))
        middle_s = 0.5 * (starts_s[0] + stops_s[-1])
        strips = lines(orbit, middle_s, 30e3, across_m)
        requests += [
            one(
                f"area {block + 1} strip {k + 1}",
                "strip",
                strip,
                start_s,
                scan_speed_m_s=round(60e3 / (scan_s - 0.05), 3),
            )
            for k, (strip, scan_s, start_s) in enumerate(
                zip(strips, scans_s, starts_s, strict=True)
            )
        ]
    inertial = Rotation.from_euler("XYZ", [0.3, 1.0, -0.4]).as_quat()
    return session(
        "The long session of Platonov, Sumarokov 2019: eight areas",
        orbit,
        1590.0,
        requests,
        initial_q_body_from_eci_xyzw=[round(x, 9) for x in inertial.tolist()],
    )


@lru_cache(maxsize=2)
def planned(name: str) -> ImagingPlan:
    """The plan of "strip_and_stereo" or "eight_areas"."""
    return plan_imaging(read_spacecraft_request(text(name).encode()))


@lru_cache(maxsize=2)
def flown(name: str) -> tuple[Log, ...]:
    """Its table in closed loop, one run for each of SEEDS."""
    plan = planned(name)
    return tuple(
        fly_many(
            plan.request.definition(), plan.table, plan.windows, orbit_states(plan), SEEDS, itself
        )
    )


def text(name: str) -> str:
    """The request as a file."""
    document = {"strip_and_stereo": strip_and_stereo, "eight_areas": eight_areas}[name]()
    return json.dumps(document, indent=2) + "\n"


# The paper's own control laws on its own turns, flown in the product's simulation.
# A goal is given at each of the paper's moments: the attitude that scans the next strip,
# continued backwards along its line, or orbital orientation.  The laws of the paper turn to it
# about the Euler axis and hold it; nothing is fed forward.
# Source: Platonov, Sumarokov 2019, "Control law of the gyro system" and the text at Figs. 3, 5,
# 7.

OWN_SEEDS = range(4)
OWN_TURN_RATE_RAD_S = math.radians(2.4)  # the paper: 3.5 at most; its laws settle soonest with this
TOLD_STRIP_S = 11.0  # of a strip as the paper's text has it, instead of 14 or 15 as its figures
# When goals are given, and the number of the scan each is for (None: orbital orientation).
COMMANDS: dict[str, tuple[tuple[float, int | None], ...]] = {
    "strip_and_stereo": ((72.0, 0), (144.0, None), (252.0, 1), (354.0, 2), (464.0, None)),
    "eight_areas": (
        (0.2, None),
        *((t - LONG_START_S, k) for k, t in enumerate(PAPER_TURNS_S[:-1])),
        (PAPER_TURNS_S[-1] - LONG_START_S, None),
    ),
}
# Stiffer than when a table is fed forward: these settle the paper's laws soonest.
GAINS = ControlGains(k1_per_s=1.8, k2_per_s2=1.0)


class Settling(NamedTuple):
    """After each goal that is for a scan: seconds to the scan, to the rate error's being within
    0.001 deg/s for good until its end, and the greatest rate error in it and in its last 11 s,
    deg/s: (runs, goals).  The last tick, in which the next goal is given, is left out."""

    given_s: Array  # (goals,)
    needed_s: Array
    worst_deg_s: Array
    worst_of_11_s_deg_s: Array
    interval: tuple[str, ...]  # of each goal


CRAFT = AgileSpacecraft().craft
PITCH_KG_M2 = float(CRAFT.inertia_kg_m2[2, 2])
# With the torque of 30 N m that the paper counts on and gains for its laws.
OWN_CRAFT = dataclasses.replace(
    CRAFT,
    gains=GAINS,
    turn_acceleration_rad_s2=GAINS.acceleration_share * 30.0 / PITCH_KG_M2,
    turn_rate_rad_s=OWN_TURN_RATE_RAD_S,
)


def nominal(craft: GyroCraft) -> Dispersion:
    """The spacecraft as designed, sensors and gimbals without errors."""
    return dataclasses.replace(as_designed(craft, 0), noise=False)


def attitudes(session: ImagingSession, arc: GroundArc | None, t_s: Array) -> Rotation:
    """`q_eci_from_body` that scan an arc, or of orbital orientation."""
    begin_s = 0.0 if arc is None else arc.start_s
    return session.q_eci_from_body(arc, np.full(len(t_s), begin_s), t_s)


@lru_cache(maxsize=2)
def goal_table(name: str) -> tuple[CommandTable, tuple[int, ...]]:
    """A table of goals that jumps at the paper's moments, and the rows of the jumps."""
    plan = planned(name)
    session = make_session(plan.request)
    options, _ = options_of(session)
    arcs = sorted((arc for one in options for arc in one.arcs), key=lambda arc: arc.first_row)
    rows = len(plan.table.t_s)
    q = plan.table.position.copy()
    omega, alpha = np.zeros((rows, 3)), np.zeros((rows, 3))
    given = [round(t * 5.0) for t, _ in COMMANDS[name]]
    stops = [*given[1:], rows]
    stretches = [(a, b, k) for a, b, (_, k) in zip(given, stops, COMMANDS[name], strict=True)]
    if plan.request.initial_q_body_from_eci_xyzw is None:
        stretches.insert(0, (0, given[0], None))
    else:
        q[: given[0]] = q[0]  # at rest
    for start, stop, number in stretches:
        arc = None if number is None else arcs[number]
        t_s = plan.table.t_s[start:stop]
        motion = attitude_motion(of_like_sign(attitudes(session, arc, t_s).as_quat()), 0.2)
        q[start:stop] = motion.position
        omega[start:stop], alpha[start:stop] = motion.rate_rad_s, motion.acceleration_rad_s2
    table = dataclasses.replace(plan.table, position=q, rate_rad_s=omega, acceleration_rad_s2=alpha)
    return table, tuple(given)


def fly(name: str, dispersion: Dispersion) -> Log:
    """One run of the paper's laws over all goals of a session."""
    table, given = goal_table(name)
    states = orbit_states(planned(name))
    spans = [(one.first_row, one.last_row) for one in planned(name).windows]
    imaging = camera_on(spans, len(table.position))
    return fly_table(OWN_CRAFT, table, imaging, states, dispersion, law=PAPER, commanded=given)


@lru_cache(maxsize=4)
def settling(name: str, dispersed: bool) -> Settling:
    """How the paper's laws meet the paper's intervals, in one nominal or in OWN_SEEDS runs."""
    windows = planned(name).windows
    runs = [draw_dispersion(OWN_CRAFT, seed) for seed in OWN_SEEDS] if dispersed else [
        nominal(OWN_CRAFT)
    ]  # fmt: skip
    goals = [(round(t * 5.0), k) for t, k in COMMANDS[name] if k is not None]
    needed, worst, late = [], [], []
    for one in runs:
        log = fly(name, one)
        needed.append([settled_after_s(log, row, windows[k].last_row - 1) for row, k in goals])
        errors = [
            log.rate_error_rad_s[windows[k].first_row : windows[k].last_row - 1] for _, k in goals
        ]
        worst.append([np.rad2deg(np.abs(error).max()) for error in errors])
        late.append([np.rad2deg(np.abs(e[-round(5 * TOLD_STRIP_S) :]).max()) for e in errors])
    return Settling(
        given_s=np.array([(windows[k].first_row - row) / 5.0 for row, k in goals]),
        needed_s=np.array(needed),
        worst_deg_s=np.array(worst),
        worst_of_11_s_deg_s=np.array(late),
        interval=tuple(f"{windows[k].request} {windows[k].look}" for _, k in goals),
    )


K1_PER_S, K2_PER_S2 = 1.8, 1.0


def switching_rate_deg_s(torque_n_m: float, share: float = 0.75) -> float:
    """Rate the imaging law asks for where the paper hands over to it without a limit of rate.

    sqrt(2 a1 phi) = phi k2/k1 at phi = 2 a1 (k1/k2)^2; the rate is 2 a1 k1/k2.
    """
    a1 = share * torque_n_m / PITCH_KG_M2
    return float(np.rad2deg(2.0 * a1 * K1_PER_S / K2_PER_S2))


# The paper's four gyros by the product's array: envelope, torque, spin-up.

ARRAY = CRAFT.array
SETTLE_SEEDS = range(6)


def reach_n_m_s(direction: Array) -> float:
    """Momentum at which the array's envelope ends, by bisection."""

    def beyond(length: float) -> float:
        return -1.0 if ARRAY.in_envelope(length * direction) else 1.0

    return float(brentq(beyond, 1.0, 300.0, xtol=1e-6))


def least_torque_n_m(momentum_n_m_s: float, places: int = 1500) -> float:
    """Least torque the steering law gives in any way, gyros holding so much in any direction.

    A way is worst for the gimbal whose row of D's pseudo-inverse lies along it.
    """
    random, gyros = np.random.default_rng(1), ARRAY.gyros()
    directions = random.standard_normal((places, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rates, least = np.empty(4), math.inf
    for held in (*directions, *np.eye(3)):
        gimbal_rad = ARRAY.gimbal_angles(momentum_n_m_s * held)
        d = ARRAY.jacobian(gimbal_rad)
        rows = np.linalg.pinv(d)
        row = rows[np.argmax(np.linalg.norm(rows, axis=1))]
        way = row / np.linalg.norm(row)
        steer(gyros, gimbal_rad, 1e3 * way, 0.0, rates)  # more than there is: all it can
        least = min(least, float(ARRAY.momentum_n_m_s * (d @ rates) @ way))
    return least


class Needed(NamedTuple):
    """Of a flown session: most momentum held and its greatest part along each axis, N m s, most
    torque, N m, and the size of each of four gyros whose envelope would just do, N m s."""

    held_n_m_s: float
    by_axis_n_m_s: Array
    torque_n_m: float
    gyro_n_m_s: float


def needed(gimbal_rad: Array, tick_s: float) -> Needed:
    """From the rows (n, 4) of a table, or of a run."""
    h = ARRAY.momentum(gimbal_rad)

    def fits(size: float) -> bool:
        return bool(np.all(CmgArray(momentum_n_m_s=size).in_envelope(h)))

    low, high = 0.1, 60.0
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return Needed(
        float(np.linalg.norm(h, axis=1).max()),
        np.abs(h).max(axis=0),
        float(np.linalg.norm(np.diff(h, axis=0), axis=1).max() / tick_s),
        high,
    )


def spin_up_s(rate_deg_s: float, torque_n_m: float) -> float:
    """Until a turn in pitch has its full rate, its torque rising by 40 N m/s."""
    limits = (math.radians(rate_deg_s), torque_n_m / PITCH_KG_M2, 40.0 / PITCH_KG_M2)
    turn = quickest_angle(math.radians(60.0), *limits)
    t_s = np.linspace(0.0, turn.x[-1], 4001)
    speed = turn(t_s, 1)
    return float(t_s[np.argmax(speed >= 0.999 * speed.max())])


def quickest_s(angle_deg: float) -> float:
    """Least time of a turn in pitch from rest to rest within the product's limits."""
    limits = agility_limits(AgileSpacecraft().platform()).about(np.array([0.0, 0.0, 1.0]))
    return float(quickest_angle(math.radians(angle_deg), *limits).x[-1])


class Turned(NamedTuple):
    """A turn flown in dispersed runs: its time and the median from command to settled, s."""

    turn_s: float
    settled_s: float


@lru_cache(maxsize=4)
def turned(rate_deg_s: float, seconds: float, angle_deg: float = 20.0) -> Turned:
    """A smooth turn in so many seconds up to a rate, followed by the product's law."""
    own = AgileSpacecraft()
    turns = dataclasses.replace(own.gyros.turns, rate_max_deg_s=own.rate_deg_s(rate_deg_s))
    gyros = dataclasses.replace(own.gyros, turns=turns)
    spacecraft = dataclasses.replace(own, body=dataclasses.replace(own.body, gyros=gyros))
    table, duration_s = settle_table(spacecraft, angle_deg, seconds)
    ephemeris = sun_synchronous(600.0).ephemeris(EPOCH, EPOCH + timedelta(seconds=60))
    states = ephemeris.states(Instants(EPOCH, table.t_s))
    craft = spacecraft.craft
    imaging = camera_on([(250, 300)], len(table.position))
    settled = [
        settled_after_s(
            fly_table(craft, table, imaging, states, draw_dispersion(craft, seed)),
            50,
            300,
        )
        for seed in SETTLE_SEEDS
    ]
    return Turned(duration_s, float(np.median(settled)))


def gyro_reach_deg_s() -> float:
    """Rate about one body axis up to which the four channels still give the rate."""
    onboard = computer(CRAFT, TABLE, noise=False)
    memory = memory_at(onboard, np.zeros(3), np.zeros((4, 3)))
    estimate = OnboardEstimate(np.array([0.0, 0.0, 0.0, 1.0]), np.empty(3), np.zeros(4))

    def beyond(rate_deg_s: float) -> float:
        z = math.radians(rate_deg_s)
        channels = np.array([0.0, 0.0, z, z / math.sqrt(3.0)])
        return -1.0 if estimate_rate(onboard, memory, estimate, channels) else 1.0

    return float(brentq(beyond, 0.5, 10.0, xtol=1e-6))


# Imaging from a CMG spacecraft: Platonov, Sumarokov 2019, Figs. 3 to 9.

LIMIT_DEG_S = 1e-3
ASIDE_KM = 670.0
STRIPS = "strip_and_stereo"
AREAS = "eight_areas"
Span = tuple[str, float, float]  # name and the paper's interval on its clock, s
SHOWN: dict[str, tuple[Span, ...]] = {
    STRIPS: (
        ("Fig. 4: strip", 128.0, 144.0),
        ("Fig. 6: stereo pair, first look", 338.0, 354.0),
        ("Fig. 6: stereo pair, second look", 448.0, 464.0),
    ),
    AREAS: (
        ("Fig. 8: second area, first strip", 866.0, 881.0),
        ("Fig. 9: fifth area, third strip", 1405.0, 1419.0),
    ),
}
CLOCK_S = {STRIPS: 0.0, AREAS: LONG_START_S}  # the paper's at row 0


def angles_between_strips_deg(height_km: float, scan_s: float) -> list[float]:
    """Of the three turns of the paper's second area, its strips scanned so fast."""
    commands_s = [t - PAPER_TURNS_S[4] for t in PAPER_TURNS_S[4:9]]
    starts_s = [round(5.0 * (t - scan_s)) / 5.0 for t in commands_s[1:]]
    orbit = sun_synchronous(height_km)
    middle_s = 0.5 * (starts_s[0] + starts_s[-1] + scan_s)
    request = area(orbit, middle_s, "area", across_km=60.0)
    session = make_session(session_request(orbit, commands_s[-1] + 60.0, (request,)))
    ends = []
    for strip, start_s in zip(candidates(request, 0, session)[0].arcs, starts_s, strict=True):
        arc = dataclasses.replace(strip, start_s=start_s)
        t_s = np.array([start_s, start_s + arc.duration_s])
        ends.append(attitudes(session, arc, t_s))
    # Both ends lie in inertial axes: what the Earth and the orbit turn meanwhile is in it.
    return [
        float(np.rad2deg((after[0].inv() * before[1]).magnitude()))
        for before, after in pairwise(ends)
    ]


def _along_deg(height_km: float) -> float:
    """How far ahead or behind an area's ends are seen at the paper's moments, flat ground."""
    orbit = sun_synchronous(height_km)
    speed_m_s = 1e3 * math.hypot(*orbit.velocity_km_s)
    ground_m_s = speed_m_s * 6378.137 / (6378.137 + height_km)
    # From the middle of the area's time to the last strip's end, which lies 30 km beyond.
    half_s = 0.5 * (PAPER_TURNS_S[4] - PAPER_TURNS_S[1] + 14.0)
    return math.degrees(math.atan2(ground_m_s * half_s - 30e3, 1e3 * height_km))


def imaging_numbers() -> Numbers:
    return {**_turns(), **_session()}


def worst_deg_s(log: Log, first_row: int, last_row: int) -> float:
    """Largest rate error of any axis between two rows."""
    return float(np.rad2deg(np.abs(rate_errors(log, first_row, last_row)).max()))


def fed_forward_deg_s(name: str, span: Span) -> float:
    """Worst rate error in an interval of the paper, of all runs of the planner's table."""
    rows = [round((t - CLOCK_S[name]) * 5.0) for t in span[1:]]
    return max(worst_deg_s(log, *rows) for log in flown(name))


def _turns() -> Numbers:
    long = planned(AREAS)
    between = [slew for slew in long.slews if slew.onto is not None and slew.onto % 4 != 0]
    angles = [math.degrees(turn.angle_rad) for turn in between]
    as_told = angles_between_strips_deg(600.0, TOLD_STRIP_S)
    return {
        "angle between strips": float(np.mean(angles)),
        "least_deg": min(angles),
        "most_deg": max(angles),
        "eigenaxis_s": float(np.median([turn.eigenaxis_s for turn in between])),
        "at_600_km_deg": float(np.mean(as_told)),
    }


def _session() -> Numbers:
    plan, logs = planned(AREAS), flown(AREAS)
    windows = plan.windows
    worst = [worst_deg_s(log, w.first_row, w.last_row) for log in logs for w in windows]
    aside = plan_imaging(far_aside())
    scans_s = np.diff(PAPER_TURNS_S[1:])[::4]
    return {
        "eight areas": (windows[-1].last_row - windows[0].first_row) / 300.0,
        "time of a strip": (windows[1].last_row - windows[1].first_row) / 5.0,
        "angle along the track": max(w.along_deg for w in plan.verification.windows),
        "angle across the track": max(abs(w.across_deg) for w in aside.verification.windows),
        "strips": len(windows),
        "steady_percent": 100.0 * float(np.mean(np.array(worst) <= LIMIT_DEG_S)),
        "intervals": len(worst),
        "worst_deg_s": max(worst),
        "scan_least_s": float(scans_s.min()),
        "scan_most_s": float(scans_s.max()),
        "along_640_deg": _along_deg(AREAS_KM),
        "along_600_deg": _along_deg(600.0),
        "aside_deg_s": math.degrees(aside.stabilisation.worst_rad_s),
        "aside_runs": aside.request.simulation_runs,
    }


def far_aside() -> ImagingPlanRequest:
    """Two strips of 60 km as far to either side of the track as the camera may look."""
    orbit = sun_synchronous(AREAS_KM)
    strips = tuple(
        StripRequest(
            name=f"strip {k + 1}",
            geometry=GeoLineString(coordinates=line(orbit, at_s, 30.0, side * ASIDE_KM)),
        )
        for k, (at_s, side) in enumerate(((120.0, 1.0), (260.0, -1.0)))
    )
    return session_request(orbit, 400.0, strips, simulation_runs=8)


def draw_imaging(folder: Path) -> None:
    for name in (STRIPS, AREAS):
        figure = draw(planned(name), flown(name)[0], SHOWN[name], CLOCK_S[name])
        figure.savefig(folder / f"reproduction_spacecraft_{name}.png", dpi=90)


def draw(plan: ImagingPlan, log: Log, spans: Sequence[Span], clock_s: float) -> Figure:
    """Rates of the table, whole, and rate errors of a run in each span of the paper's clock."""
    t_s = np.arange(len(log.rate_error_rad_s) * log.rate_error_rad_s.shape[1]) * 0.005 + clock_s
    error_deg_s = np.rad2deg(log.rate_error_rad_s.reshape(-1, 3))
    rate_deg_s = np.rad2deg(plan.table.rate_rad_s)
    figure = Figure(figsize=(9.0, 2.2 * (1 + len(spans))), layout="constrained")
    top, *details = figure.subplots(1 + len(spans), 1)
    for k, axis in enumerate("XYZ"):
        top.plot(plan.table.t_s + clock_s, rate_deg_s[:, k], label=axis, lw=1.0)
    top.set_ylabel("body rate, deg/s")
    for window in plan.windows:
        top.axvspan(window.first_row / 5 + clock_s, window.last_row / 5 + clock_s, alpha=0.15)
    top.legend(loc="upper right", ncols=3)
    for panel, (name, start_s, stop_s) in zip(details, spans, strict=True):
        inside = (t_s >= start_s - 6.0) & (t_s <= stop_s)
        for k in range(3):
            panel.plot(t_s[inside], error_deg_s[inside, k], color=f"C{k}", lw=0.8)
        panel.axvspan(start_s, stop_s, alpha=0.15)
        for limit in (-LIMIT_DEG_S, LIMIT_DEG_S):
            panel.axhline(limit, color="0.4", lw=0.8, ls="--")
        panel.set_ylim(-2.5e-3, 2.5e-3)
        panel.set_ylabel("rate error, deg/s")
        panel.set_title(name, fontsize="medium")
    details[-1].set_xlabel("time on the paper's clock, s")
    return figure


# The paper's own laws on its own turns, and its misprints: Platonov, Sumarokov 2019.

CLOCK = "time on the paper's clock, s"


@lru_cache(maxsize=1)
def _log_by_own_laws() -> tuple[Array, Array]:
    """Time on the paper's clock and rate errors, deg/s, of an undispersed run of the session."""
    log = fly("eight_areas", nominal(OWN_CRAFT))
    errors = np.rad2deg(log.rate_error_rad_s.reshape(-1, 3))
    return np.arange(len(errors)) * 0.005 + LONG_START_S, errors


def laws_numbers() -> Numbers:
    return {
        **_strip_and_stereo(),
        **_long_session(),
        "rate at the hand-over": switching_rate_deg_s(30.0),
    }


def _strip_and_stereo() -> Numbers:
    found = settling("strip_and_stereo", dispersed=True)
    ideal = settling("strip_and_stereo", dispersed=False)
    slews = planned("strip_and_stereo").slews
    numbers: Numbers = {}
    for k, (slew, span) in enumerate(zip((0, 2, 3), SHOWN[STRIPS], strict=True)):
        what = ("strip", "first look", "second look")[k]
        numbers |= {
            f"own turn to the {what}": float(np.median(found.needed_s[:, k])),
            f"own laws, {what}": float(np.max(found.worst_deg_s[:, k])),
            f"ideal_{k}_s": float(ideal.needed_s[0, k]),
            f"leaves_{k}_s": elapsed_s(slews[slew].start_utc, EPOCH),
            f"fed_forward_{k}": fed_forward_deg_s(STRIPS, span),
        }
    return numbers


def _long_session() -> Numbers:
    found, ideal = settling("eight_areas", dispersed=True), settling("eight_areas", dispersed=False)
    needed = found.needed_s[:, found.given_s < 30.0]
    numbers: Numbers = {
        "own time of a turn": float(np.median(needed)),
        "own laws over the long session": 100.0 * _share(found.worst_of_11_s_deg_s),
        "needed_least_s": float(needed.min()),
        "needed_most_s": float(needed.max()),
        "steady_percent": 100.0 * _share(found.worst_deg_s),
        "worst_deg_s": float(found.worst_deg_s.max()),
        "ideal_deg_s": float(ideal.worst_deg_s.max()),
        "runs": len(OWN_SEEDS),
    }
    for figure, k, span in (("8", 4, SHOWN[AREAS][0]), ("9", 18, SHOWN[AREAS][1])):
        worst = found.worst_deg_s[:, k]
        numbers |= {
            f"own laws in Fig. {figure}": float(np.median(worst)),
            f"least_{figure}": float(worst.min()),
            f"most_{figure}": float(worst.max()),
            f"given_{figure}_s": float(found.given_s[k]),
            f"fed_forward_{figure}": fed_forward_deg_s(AREAS, span),
        }
    return numbers


def _share(worst_deg_s: Array) -> float:
    return float(np.mean(worst_deg_s <= LIMIT_DEG_S))


def draw_laws(folder: Path) -> None:
    figure = Figure(figsize=(10.0, 6.4), layout="constrained")
    (top, needed), (eight, nine) = figure.subplots(2, 2)
    t_s, errors = _log_by_own_laws()
    for k, axis in enumerate("XYZ"):
        top.plot(t_s[::40], errors[::40, k], lw=0.8, label=axis)
    top.set(title="Fig. 7: rates relative to the goal's", xlabel=CLOCK, ylabel="rate, deg/s")
    top.legend(fontsize="x-small", ncols=3, loc="upper left")
    found: Settling = settling("eight_areas", dispersed=True)
    needed.plot(found.given_s, "k_", ms=8, label="given until imaging")
    for run in found.needed_s:
        needed.plot(run, "C0.", ms=4)
    needed.plot([], "C0.", label="taken until settled, each run")
    needed.set(title="its turns", xlabel="strip", ylabel="duration, s", ylim=(0.0, 60.0))
    needed.legend(fontsize="x-small")
    for panel, name, start_s, stop_s in (
        (eight, "Fig. 8", 866.0, 881.0),
        (nine, "Fig. 9", 1405.0, 1419.0),
    ):
        inside = (t_s >= start_s - 8.0) & (t_s <= stop_s - 0.4)
        for k in range(3):
            panel.plot(t_s[inside], errors[inside, k], lw=0.9)
        panel.axvspan(start_s, stop_s, alpha=0.15)
        for limit in (-LIMIT_DEG_S, LIMIT_DEG_S):
            panel.axhline(limit, color="0.4", lw=0.8, ls="--")
        panel.set(ylim=(-4e-3, 4e-3), title=name, xlabel=CLOCK, ylabel="rate error, deg/s")
    figure.savefig(folder / "reproduction_spacecraft_own_laws.png", dpi=90)


# The spacecraft's gyros: Platonov, Sumarokov 2019.

NAMES = ("strip_and_stereo", "eight_areas")


def spacecraft_numbers() -> Numbers:
    return {**_gyros(), **_rates()}


def _gyros() -> Numbers:
    array, inertia = CRAFT.array, np.diag(CRAFT.inertia_kg_m2)
    short, long = (needed(planned(name).table.extra_rad[:, :4], COMMAND_STEP_S) for name in NAMES)
    most = max(short.gyro_n_m_s, long.gyro_n_m_s)
    held = max(short.held_n_m_s, long.held_n_m_s)
    least_n_m = array.momentum_n_m_s * array.rate_step_rad_s
    x, y, z = (math.degrees(least_n_m / j) for j in inertia)
    envelope = {
        f"envelope along {axis}": reach_n_m_s(np.eye(3)[k])
        for k, axis in enumerate(("OX", "OY", "OZ"))
    }
    return {
        **envelope,
        "four times what is needed": 60.0 / most,
        "torque in the sphere": least_torque_n_m(60.0),
        "momentum at 3.5 deg/s": float(inertia.max() * math.radians(3.5)),
        "least torque": least_n_m,
        "least acceleration": z,
        "most": most,
        "held": held,
        "in_pitch": float(long.by_axis_n_m_s[2]),
        "long_torque": long.torque_n_m,
        "times_held": 60.0 / held,
        "empty_torque": least_torque_n_m(0.0, 1),
        "about_y": y,
        "in_a_cycle": 0.2 * x,
    }


def _rates() -> Numbers:
    usual, fast = turned(1.58, 15.4), turned(3.3, 13.0)
    return {
        "spin-up": spin_up_s(3.5, 30.0),
        "20 deg by table": usual.settled_s,
        "3.5 deg/s against 1.6": gyro_reach_deg_s(),
        "spin_up_1_58": spin_up_s(1.58, 30.0),
        "spin_up_15_n_m": spin_up_s(3.5, 15.0),
        "spin_up_1_58_15_n_m": spin_up_s(1.58, 15.0),
        "turn_s": usual.turn_s,
        "quickest_s": quickest_s(20.0),
        "fast_s": fast.turn_s,
        "fast_settled_s": fast.settled_s,
    }
