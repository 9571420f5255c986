"""A slew as it was planned, beside those about the Euler axis."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from planner.base.commands import ROWS_PER_S, Motion
from planner.base.mrp import BodyMotion
from planner.motion.attitude.eigenaxis import eigenaxis_slew, quickest_eigenaxis
from planner.motion.attitude.problem import BodySlewProblem, between_rows, rows_of
from planner.motion.attitude.track import agility_limits
from planner.spacecraft.vehicle.definition import SlewObjective
from planner.world.platforms import BodyPlatform


@dataclass(frozen=True, kw_only=True)
class BaselineOptions:
    """How closely slews are looked at."""

    any_jerk: float = 1e4  # times its limit: none
    instants: int = 400  # of a slew about the Euler axis
    looks: tuple[float, ...] = (0.0, 0.5, 1.0)  # between two rows


OPTIONS = BaselineOptions()


@dataclass(frozen=True, kw_only=True)
class AttitudeSlewComparison:
    """One slew beside its baselines at the same limits.

    angle_rad: of the rotation between its ends.  eigenaxis_s: the quickest found about the Euler
    axis with the same limits; bang_coast_bang_s: the paper's, any torque rate.
    The torque rate's peak, of this slew and of the eigenaxis one of the same duration, is what
    shakes the modes; it is counted without the momentum that is turned with the body.
    time_from: what found the quickest slew, whose time this one was given.
    """

    angle_rad: float
    duration_s: float
    eigenaxis_s: float
    bang_coast_bang_s: float
    torque_rate_peak_n_m_s: float
    eigenaxis_torque_rate_peak_n_m_s: float
    method: str
    time_from: Literal["ocp"] | None
    status: str
    solve_s: float


def compare(
    motion: Motion, platform: BodyPlatform, objective: SlewObjective, status: str, solve_s: float
) -> AttitudeSlewComparison:
    """Of a slew's rows, its ends among them."""
    row = len(motion.position) - 1
    limits, inertia_kg_m2 = agility_limits(platform), np.array(platform.inertia_kg_m2)
    problem = BodySlewProblem(
        start=rows_of(motion, slice(1)),
        goal=rows_of(motion, slice(-1, None)),
        first_arrival_row=row,
        limits=limits,
    )
    abrupt = replace(limits, jerk_rad_s3=OPTIONS.any_jerk * limits.jerk_rad_s3)
    duration_s = row / ROWS_PER_S
    same_time = eigenaxis_slew(problem, row, duration_s=duration_s)

    def peak_n_m_s(body: BodyMotion) -> float:
        torque_rates = body.jerk_body_rad_s3.reshape(-1, 3) @ inertia_kg_m2
        return float(np.max(np.linalg.norm(torque_rates, axis=1)))

    return AttitudeSlewComparison(
        angle_rad=float(problem.angles_rad[0]),
        duration_s=duration_s,
        eigenaxis_s=quickest_eigenaxis(problem)[0].duration_s,
        bang_coast_bang_s=quickest_eigenaxis(replace(problem, limits=abrupt))[0].duration_s,
        torque_rate_peak_n_m_s=peak_n_m_s(between_rows(motion, np.array(OPTIONS.looks))[1]),
        eigenaxis_torque_rate_peak_n_m_s=peak_n_m_s(
            same_time.motion(np.linspace(0.0, duration_s, OPTIONS.instants))[1]
        ),
        method="ocp",
        time_from="ocp" if objective == "minimum_time" else None,
        status=status,
        solve_s=solve_s,
    )
