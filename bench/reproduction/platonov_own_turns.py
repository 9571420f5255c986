"""The paper's own control laws on its own turns, flown in the product's simulation.

A goal is given at each of the paper's moments: the attitude that scans the next strip, continued
backwards along its line, or orbital orientation.  The laws of the paper turn to it about the Euler
axis and hold it; nothing is fed forward.
Source: Platonov, Sumarokov 2019, "Control law of the gyro system" and the text at Figs. 3, 5, 7.
"""

import dataclasses
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from spacecraft_flight import PAPER_TURNS_S, orbit_states

from planner.base.arrays import Array
from planner.spacecraft.flight.closed_loop import Log
from planner.spacecraft.flight.simulation import Dispersion, draw_dispersion, fly_table
from planner.spacecraft.flight.stabilisation import settled_after_s
from planner.spacecraft.imaging.choice_with_slews import options_of
from planner.spacecraft.imaging.session import make_session
from planner.spacecraft.imaging.timeline import scans_of
from planner.spacecraft.table import AttitudeTable
from planner.spacecraft.vehicle.definition import AgileSpacecraft, ControlGains, SlewLimits
from planner.spacecraft.vehicle.onboard import PAPER
from reproduction.platonov_sessions import LONG_START_S, planned

SEEDS = range(4)
TURN_RATE_RAD_S = math.radians(2.4)  # the paper: 3.5 at most; its laws settle soonest with this
STRIP_S = 11.0  # of a strip as the paper's text has it, instead of 14 or 15 as its figures
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


def spacecraft_of(name: str) -> AgileSpacecraft:
    """The product's, with the torque of 30 N m that the paper counts on and gains for its laws."""
    limits = SlewLimits(torque_n_m=30.0, rate_axis_rad_s=TURN_RATE_RAD_S)
    return dataclasses.replace(planned(name).spacecraft, gains=GAINS, slew=limits)


def nominal(spacecraft: AgileSpacecraft) -> Dispersion:
    """The spacecraft as designed, sensors and gimbals without errors."""
    zero, one = np.zeros(3), np.ones(len(spacecraft.modes))
    ripple = draw_dispersion(spacecraft, 0).ripple
    return Dispersion(
        frequency_factor=one,
        coupling_factor=one,
        damping_factor=one,
        inertia_factor=np.ones(3),
        gimbal_scale=np.ones(4),
        gimbal_offset_rad_s=np.zeros(4),
        gimbal_jitter_rad_s=0.0,
        ripple=ripple._replace(torque_n_m=np.zeros(4)),
        gyro_bias_rad_s=zero,
        gyro_scale=zero,
        noise=False,
        seed=0,
    )


@lru_cache(maxsize=2)
def goal_table(name: str) -> tuple[AttitudeTable, tuple[int, ...]]:
    """A table of goals that jumps at the paper's moments, and the rows of the jumps."""
    plan = planned(name)
    session = make_session(plan.request)
    options, _ = options_of(session)
    scans = scans_of(options, range(len(options)))
    rows = len(plan.table.t_s)
    q = plan.table.eci_from_body_xyzw.copy()
    omega, alpha = np.zeros((rows, 3)), np.zeros((rows, 3))
    given = [round(t * 5.0) for t, _ in COMMANDS[name]]
    stops = [*given[1:], rows]
    stretches = [(a, b, k) for a, b, (_, k) in zip(given, stops, COMMANDS[name], strict=True)]
    if plan.request.initial_q_body_from_eci_xyzw is None:
        stretches.insert(0, (0, given[0], None))
    else:
        q[: given[0]] = q[0]  # at rest
    for start, stop, number in stretches:
        arc = None if number is None else scans[number].arc
        t_s = plan.table.t_s[start:stop]
        turned, motion = session.profile(arc, t_s[0] - 1.0, t_s[-1] + 1.0).attitude_at(t_s)
        q[start:stop] = turned.inv().as_quat()
        omega[start:stop], alpha[start:stop] = motion.omega_body_rad_s, motion.alpha_body_rad_s2
    table = dataclasses.replace(
        plan.table, eci_from_body_xyzw=q, omega_body_rad_s=omega, alpha_body_rad_s2=alpha
    )
    return table, tuple(given)


def fly(name: str, dispersion: Dispersion) -> Log:
    """One run of the paper's laws over all goals of a session."""
    table, given = goal_table(name)
    spacecraft = spacecraft_of(name)
    states = orbit_states(planned(name))
    return fly_table(spacecraft, table, states, dispersion, law=PAPER, commanded=given)


@lru_cache(maxsize=4)
def settling(name: str, dispersed: bool) -> Settling:
    """How the paper's laws meet the paper's intervals, in one nominal or in SEEDS runs."""
    spacecraft, windows = spacecraft_of(name), planned(name).table.windows
    runs = [draw_dispersion(spacecraft, seed) for seed in SEEDS] if dispersed else [
        nominal(spacecraft)
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
        late.append([np.rad2deg(np.abs(e[-round(5 * STRIP_S) :]).max()) for e in errors])
    return Settling(
        given_s=np.array([(windows[k].first_row - row) / 5.0 for row, k in goals]),
        needed_s=np.array(needed),
        worst_deg_s=np.array(worst),
        worst_of_11_s_deg_s=np.array(late),
        interval=tuple(f"{windows[k].request} {windows[k].look}" for _, k in goals),
    )
