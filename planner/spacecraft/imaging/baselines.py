"""Slews as they were planned, beside those about the Euler axis."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from planner.base.commands import ROWS_PER_S, Motion
from planner.base.mrp import BodyMotion
from planner.motion.attitude.eigenaxis import eigenaxis_slew, quickest_eigenaxis
from planner.motion.attitude.problem import BodySlewProblem, between_rows, rows_of
from planner.motion.attitude.track import agility_limits
from planner.planning.sessions.plan import Plan
from planner.spacecraft.found import AttitudeSlewReport
from planner.world.frames.time_scales import elapsed_s
from planner.world.platforms import BodyPlatform


@dataclass(frozen=True, kw_only=True)
class BaselineOptions:
    """How closely slews are looked at."""

    any_jerk: float = 1e4  # times its limit: none
    instants: int = 400  # of a slew about the Euler axis
    looks: tuple[float, ...] = (0.0, 0.5, 1.0)  # between two rows


OPTIONS = BaselineOptions()


def report_slews(platform: BodyPlatform, plan: Plan) -> Iterator[AttitudeSlewReport]:
    """In order of time, those back to orbital orientation among them."""
    table, runs = plan.table, {run.session: run for run in plan.slews}
    assert table.acceleration_rad_s2 is not None  # a body's table has it
    whole = Motion(table.position, table.rate_rad_s, table.acceleration_rad_s2)
    for one in plan.segments:
        if one.kind not in ("brake", "slew"):
            continue
        first, last = (
            round(elapsed_s(utc, table.epoch_utc) * ROWS_PER_S)
            for utc in (one.start_utc, one.stop_utc)
        )
        run, is_slew = runs[one.session], one.kind == "slew"
        yield AttitudeSlewReport(
            start_utc=one.start_utc,
            stop_utc=one.stop_utc,
            onto=one.session if is_slew else None,
            method="ocp",
            time_from="ocp" if plan.scenario.slew.objective == "minimum_time" else None,
            status=run.status,
            solve_s=run.wall_s if is_slew else 0.0,
            first_row=first,
            last_row=last,
            **compare(rows_of(whole, slice(first, last + 1)), platform),
        )


def compare(motion: Motion, platform: BodyPlatform) -> dict[str, float]:
    """Figures of a slew's rows, its ends among them, as `AttitudeSlewReport` names them.

    The torque rate's peak, of this slew and of the eigenaxis one of the same duration, is what
    shakes the modes; it is counted without the momentum that is turned with the body.
    """
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

    even_s = np.linspace(0.0, duration_s, OPTIONS.instants)
    return {
        "angle_rad": float(problem.angles_rad[0]),
        "duration_s": duration_s,
        "eigenaxis_s": quickest_eigenaxis(problem)[0].duration_s,
        "bang_coast_bang_s": quickest_eigenaxis(replace(problem, limits=abrupt))[0].duration_s,
        "torque_rate_peak_n_m_s": peak_n_m_s(between_rows(motion, np.array(OPTIONS.looks))[1]),
        "eigenaxis_torque_rate_peak_n_m_s": peak_n_m_s(same_time.motion(even_s)[1]),
    }
