"""The slew to take: the OCP's if it is better, the eigenaxis's if not, a refusal if neither."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from planner.base.errors import InfeasibleSlew
from planner.spacecraft.slews.eigenaxis import eigenaxis_slew
from planner.spacecraft.slews.slew_ocp import solve_slew
from planner.spacecraft.slews.slew_problem import AttitudeSlew, AttitudeSlewProblem, Method
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.definition import SlewObjective


@dataclass(frozen=True, kw_only=True)
class SlewChoiceOptions:
    """How long a turn is planned, and by which method."""

    first_guess_ticks: int = 200  # 40 s, of the time in which moving ends are continued
    never_s: float = 1e4  # told as missing where no turn was found
    runaway: float = 2.5  # moving ends continued for longer than that swing a blend too far
    # jerk steps inside a 0.2 s row make the table's torque bulge by 5 %
    fallback_share: float = 0.9
    # a smooth slew with time to spare takes this much of the eigenaxis's quickest time
    easy: float = 2.0
    easy_least_s: float = 8.0  # and so much at least: a short turn is no smoother for being doubled
    attempts: int = 3  # each a little longer; then all the time there is


OPTIONS = SlewChoiceOptions()


class SlewNeedsTime(InfeasibleSlew):
    """A slew with too little time; missing_s: how much more it needs, about."""

    def __init__(self, angle_rad: float, least_s: float, available_s: float) -> None:
        self.missing_s = least_s - available_s
        super().__init__(
            f"a slew of {math.degrees(angle_rad):.1f} deg needs about {least_s:.1f} s within "
            f"the limits of rate, torque and momentum, but only {available_s:.1f} s are left; "
            f"give it {self.missing_s:.1f} s more, or image less",
            limit="time",
        )


class GyrosTooFull(SlewNeedsTime):
    """A slew to or from a rate at which the gyros would hold more than the sphere."""

    def __init__(self, stored_n_m_s: float, sphere_n_m_s: float) -> None:
        self.missing_s = OPTIONS.never_s
        InfeasibleSlew.__init__(
            self,
            f"at the rate of the scan the gyros would hold {stored_n_m_s:.1f} N m s, beyond the "
            f"{sphere_n_m_s:.0f} N m s sphere they are steered in, however slow the slew; unload "
            "momentum first",
            limit="momentum",
        )


@dataclass(frozen=True, kw_only=True)
class AttitudeSlewComparison:
    """One slew beside its baselines at the same limits.

    angle_rad: of the rotation between its ends.  eigenaxis_s: the quickest found about the Euler
    axis with the same torque and torque rate; bang_coast_bang_s: the paper's, any torque rate.
    The torque rate's peak, of this slew and of the eigenaxis one of the same duration, is what
    shakes the modes.  time_from: as of an `AttitudeSlew`.
    """

    angle_rad: float
    duration_s: float
    eigenaxis_s: float
    bang_coast_bang_s: float
    torque_rate_peak_n_m_s: float
    eigenaxis_torque_rate_peak_n_m_s: float
    method: str
    time_from: Method | None
    status: str
    solve_s: float


def quickest_slew(problem: AttitudeSlewProblem) -> AttitudeSlew:
    """The least-time slew found: never longer than the eigenaxis slew at the same limits."""
    baseline = eigenaxis_slew(problem)
    at_rest_s = eigenaxis_slew(problem.from_rest_to_rest()).duration_s
    guess = baseline
    if baseline.duration_s > OPTIONS.runaway * at_rest_s:
        guess = eigenaxis_slew(problem, OPTIONS.runaway * at_rest_s)
    best = solve_slew(problem, guess, "minimum_time", None)
    if best is None or best.duration_s >= baseline.duration_s:
        return baseline
    return best


def smooth_slew(problem: AttitudeSlewProblem, duration_s: float) -> AttitudeSlew:
    """The slew of this duration that shakes the structure least.

    Raises SlewNeedsTime, with the quickest time found, when it doesn't fit.
    """
    found = _smooth_slew(problem, duration_s)
    if found is not None:
        return found
    least_s = math.ceil(quickest_slew(problem).duration_s / TICK_S) * TICK_S
    # The spline of a smooth slew bends less sharply than that of the quickest.
    least_s = max(least_s, duration_s + TICK_S)
    raise SlewNeedsTime(problem.angle_rad(), least_s, duration_s)


def _smooth_slew(problem: AttitudeSlewProblem, duration_s: float) -> AttitudeSlew | None:
    guess = eigenaxis_slew(problem, duration_s)
    best = solve_slew(problem, guess, "smooth", duration_s)
    if best is not None:
        return best
    return guess if guess.loads.share_of(problem.limits) <= OPTIONS.fallback_share else None


def slew_onto(
    problem_at: Callable[[float], AttitudeSlewProblem], available_s: float, objective: SlewObjective
) -> AttitudeSlew:
    """The slew onto a moving goal, its duration a whole number of ticks, at most available_s.

    problem_at: the problem when the goal is met after so many seconds.  `smooth` takes what
    time there is, up to twice the eigenaxis's; `minimum_time` as little as it can.
    """
    ticks = math.floor(available_s / TICK_S + 1e-6)
    if ticks < 1:
        problem = problem_at(OPTIONS.first_guess_ticks * TICK_S)
        raise SlewNeedsTime(problem.angle_rad(), quickest_slew(problem).duration_s, available_s)
    used = min(ticks, OPTIONS.first_guess_ticks)
    time_from: Method | None = None
    for is_first in (True, False, False):
        problem = problem_at(used * TICK_S)
        stored, sphere = problem.ends_momentum_n_m_s(), problem.limits.momentum_sphere_n_m_s
        if stored > sphere:
            raise GyrosTooFull(stored, sphere)
        if objective == "smooth":
            wanted_s = max(OPTIONS.easy * eigenaxis_slew(problem).duration_s, OPTIONS.easy_least_s)
        elif is_first:  # near enough to where the quickest one ends
            wanted_s = eigenaxis_slew(problem).duration_s
        else:
            quickest = quickest_slew(problem)
            wanted_s, time_from = quickest.duration_s + 0.5 * TICK_S, quickest.method
        guessed, used = used, min(ticks, math.ceil(wanted_s / TICK_S))
        if used == guessed and (objective == "smooth" or not is_first):
            break
    for _ in range(OPTIONS.attempts):
        if used >= ticks:
            break
        found = _smooth_slew(problem_at(used * TICK_S), used * TICK_S)
        if found is not None:
            return replace(found, time_from=time_from)
        used += max(1, used // (4 if objective == "smooth" else 50))
    return replace(smooth_slew(problem_at(ticks * TICK_S), ticks * TICK_S), time_from=time_from)


def compare(problem: AttitudeSlewProblem, slew: AttitudeSlew) -> AttitudeSlewComparison:
    """A planned slew beside the eigenaxis ones."""
    same_time = eigenaxis_slew(problem, slew.duration_s)
    return AttitudeSlewComparison(
        angle_rad=problem.angle_rad(),
        duration_s=slew.duration_s,
        eigenaxis_s=eigenaxis_slew(problem).duration_s,
        bang_coast_bang_s=eigenaxis_slew(problem, jerk=False).duration_s,
        torque_rate_peak_n_m_s=slew.loads.torque_rate_n_m_s,
        eigenaxis_torque_rate_peak_n_m_s=same_time.loads.torque_rate_n_m_s,
        method=slew.method,
        time_from=slew.time_from,
        status=slew.status,
        solve_s=slew.solve_s,
    )
