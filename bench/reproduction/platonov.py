"""Platonov, Sumarokov 2019: imaging from a spacecraft with control moment gyros."""

import dataclasses
import math
from collections.abc import Sequence
from datetime import timedelta
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from imaging_cases import (
    EPOCH,
    PAPER_TURNS_S,
    line,
    orbit_states,
    session_request,
    settle_table,
    sun_synchronous,
)
from matplotlib.figure import Figure
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from app.requests.spacecraft import read_spacecraft_request
from planner.base.arrays import Array
from planner.base.commands import CommandTable
from planner.base.rotation import of_like_sign
from planner.inflight.simulation.gyros.closed_loop import Log
from planner.inflight.simulation.gyros.dispersed import (
    Dispersion,
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
from planner.inflight.simulation.gyros.steadiness import settled_after_s
from planner.motion.attitude.eigenaxis import quickest_angle
from planner.motion.attitude.track import attitude_motion
from planner.spacecraft.imaging.choice import options_of
from planner.spacecraft.imaging.session import GroundArc, ImagingSession, make_session
from planner.spacecraft.plan import ImagingPlan, plan_imaging
from planner.spacecraft.requests import (
    GeoLineString,
    ImagingPlanRequest,
    StripRequest,
)
from planner.spacecraft.vehicle import AgileSpacecraft
from planner.world.frames.time_scales import Instants
from planner.world.platforms.cmg_array import CmgArray
from planner.world.platforms.gyro_craft import ControlGains
from planner.world.platforms.steering import steer
from reproduction.report import Numbers

# The sessions of Platonov, Sumarokov 2019, Figs. 3 to 9: plans and dispersed flights.
# The paper gives times and sizes, neither orbit nor places; in examples/ strips lie along the track
# where the orbit passes at those times.

EXAMPLES = Path(__file__).parents[2] / "examples"
STRIPS, AREAS = "strip_and_stereo", "eight_areas"
AREAS_KM = 640.0  # of the paper's 600 to 700; lower, the areas' ends lie beyond 30 deg
LONG_START_S = 400.0  # the paper's clock at row 0 of the long session


@lru_cache(maxsize=2)
def planned(name: str) -> ImagingPlan:
    """The plan of STRIPS or AREAS."""
    return plan_imaging(
        read_spacecraft_request((EXAMPLES / f"spacecraft_{name}.json").read_bytes())
    )


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
    STRIPS: ((72.0, 0), (144.0, None), (252.0, 1), (354.0, 2), (464.0, None)),
    AREAS: (
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


CRAFT = AgileSpacecraft().craft
PITCH_KG_M2 = float(CRAFT.inertia_kg_m2[2, 2])
# With the torque of 30 N m that the paper counts on and gains for its laws.
OWN_CRAFT = dataclasses.replace(
    CRAFT,
    gains=GAINS,
    turn_acceleration_rad_s2=GAINS.acceleration_share * 30.0 / PITCH_KG_M2,
    turn_rate_rad_s=OWN_TURN_RATE_RAD_S,
)


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
    arcs = sorted((one.begun(0) for one in options), key=lambda arc: arc.first_row)
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
    imaging = camera_on(_spans(planned(name)), len(table.position))
    return fly_table(OWN_CRAFT, table, imaging, states, dispersion, law=PAPER, commanded=given)


@lru_cache(maxsize=2)
def settling(name: str) -> Settling:
    """How the paper's laws meet the paper's intervals in OWN_SEEDS runs."""
    windows = planned(name).windows
    goals = [(round(t * 5.0), windows[k]) for t, k in COMMANDS[name] if k is not None]
    needed, worst, late = [], [], []
    for seed in OWN_SEEDS:
        log = fly(name, draw_dispersion(OWN_CRAFT, seed))
        needed.append([settled_after_s(log, row, one.last_row - 1) for row, one in goals])
        errors = [log.rate_error_rad_s[one.first_row : one.last_row - 1] for _, one in goals]
        worst.append([np.rad2deg(np.abs(error).max()) for error in errors])
        late.append([np.rad2deg(np.abs(e[-round(5 * TOLD_STRIP_S) :]).max()) for e in errors])
    return Settling(
        given_s=np.array([(one.first_row - row) / 5.0 for row, one in goals]),
        needed_s=np.array(needed),
        worst_deg_s=np.array(worst),
        worst_of_11_s_deg_s=np.array(late),
    )


def switching_rate_deg_s(torque_n_m: float) -> float:
    """Rate the imaging law asks for where the paper hands over to it without a limit of rate.

    sqrt(2 a1 phi) = phi k2/k1 at phi = 2 a1 (k1/k2)^2; the rate is 2 a1 k1/k2.
    """
    a1 = GAINS.acceleration_share * torque_n_m / PITCH_KG_M2
    return float(np.rad2deg(2.0 * a1 * GAINS.k1_per_s / GAINS.k2_per_s2))


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


def needed_gyro_n_m_s(gimbal_rad: Array) -> float:
    """The size of each of four gyros whose envelope just does for rows (n, 4) of a table."""
    h = ARRAY.momentum(gimbal_rad)
    low, high = 0.1, 60.0
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        fits = bool(np.all(CmgArray(momentum_n_m_s=middle).in_envelope(h)))
        low, high = (low, middle) if fits else (middle, high)
    return high


def spin_up_s(rate_deg_s: float, torque_n_m: float) -> float:
    """Until a turn in pitch has its full rate, its torque rising by 40 N m/s."""
    limits = (math.radians(rate_deg_s), torque_n_m / PITCH_KG_M2, 40.0 / PITCH_KG_M2)
    turn = quickest_angle(math.radians(60.0), *limits)
    t_s = np.linspace(0.0, turn.x[-1], 4001)
    speed = turn(t_s, 1)
    return float(t_s[np.argmax(speed >= 0.999 * speed.max())])


def settled_s() -> float:
    """Median of dispersed runs from the command to settled: a smooth turn by a table over 20 deg,
    followed by the product's law."""
    own = AgileSpacecraft()
    turns = dataclasses.replace(own.gyros.turns, rate_max_deg_s=own.rate_deg_s(1.58))
    gyros = dataclasses.replace(own.gyros, turns=turns)
    spacecraft = dataclasses.replace(own, body=dataclasses.replace(own.body, gyros=gyros))
    table = settle_table(spacecraft, 20.0, 15.4)
    ephemeris = sun_synchronous(600.0).ephemeris(EPOCH, EPOCH + timedelta(seconds=60))
    states = ephemeris.states(Instants(EPOCH, table.t_s))
    craft = spacecraft.craft
    imaging = camera_on([(250, 300)], len(table.position))
    runs = [draw_dispersion(craft, seed) for seed in SETTLE_SEEDS]
    logs = [fly_table(craft, table, imaging, states, one) for one in runs]
    return float(np.median([settled_after_s(log, 50, 300) for log in logs]))


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


def imaging_numbers() -> Numbers:
    plan, aside = planned(AREAS), plan_imaging(far_aside())
    windows = plan.windows
    between = [slew for slew in plan.slews if slew.onto is not None and slew.onto % 4 != 0]
    return {
        "angle between strips": float(np.mean([math.degrees(turn.angle_rad) for turn in between])),
        "time of a strip": (windows[1].last_row - windows[1].first_row) / 5.0,
        "angle along the track": max(w.along_deg for w in plan.verification.windows),
        "angle across the track": max(abs(w.across_deg) for w in aside.verification.windows),
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
    return session_request(orbit, 400.0, strips, simulation_runs=0)


def _spans(plan: ImagingPlan) -> list[tuple[int, int]]:
    """Rows of its looks."""
    return [(one.first_row, one.last_row) for one in plan.windows]


def draw_imaging(folder: Path) -> None:
    for name in (STRIPS, AREAS):
        plan = planned(name)
        craft = plan.request.definition().craft
        imaging = camera_on(_spans(plan), len(plan.table.t_s))
        log = fly_table(craft, plan.table, imaging, orbit_states(plan), draw_dispersion(craft, 0))
        figure = draw(plan, log, SHOWN[name], CLOCK_S[name])
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


def laws_numbers() -> Numbers:
    short, found = settling(STRIPS), settling(AREAS)
    numbers = {
        "rate at the hand-over": switching_rate_deg_s(30.0),
        "own time of a turn": float(np.median(found.needed_s[:, found.given_s < 30.0])),
        "own laws over the long session": 100.0
        * float(np.mean(found.worst_of_11_s_deg_s <= LIMIT_DEG_S)),
        "own laws in Fig. 8": float(np.median(found.worst_deg_s[:, 4])),
        "own laws in Fig. 9": float(np.median(found.worst_deg_s[:, 18])),
    }
    for k, what in enumerate(("strip", "first look", "second look")):
        numbers[f"own turn to the {what}"] = float(np.median(short.needed_s[:, k]))
        numbers[f"own laws, {what}"] = float(np.max(short.worst_deg_s[:, k]))
    return numbers


# The spacecraft's gyros: Platonov, Sumarokov 2019.


def spacecraft_numbers() -> Numbers:
    inertia, least_n_m = np.diag(CRAFT.inertia_kg_m2), ARRAY.momentum_n_m_s * ARRAY.rate_step_rad_s
    most_n_m_s = max(
        needed_gyro_n_m_s(planned(name).table.extra_rad[:, :4]) for name in (STRIPS, AREAS)
    )
    envelope = {
        f"envelope along {axis}": reach_n_m_s(np.eye(3)[k])
        for k, axis in enumerate(("OX", "OY", "OZ"))
    }
    return {
        **envelope,
        "four times what is needed": 60.0 / most_n_m_s,
        "torque in the sphere": least_torque_n_m(60.0),
        "momentum at 3.5 deg/s": float(inertia.max() * math.radians(3.5)),
        "least torque": least_n_m,
        "least acceleration": math.degrees(least_n_m / inertia[2]),
        "spin-up": spin_up_s(3.5, 30.0),
        "20 deg by table": settled_s(),
        "3.5 deg/s against 1.6": gyro_reach_deg_s(),
    }
