"""Feasibility of a slew in exactly the time an axis has, and the reason where it is infeasible."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import InfeasibleSlew
from planner.motion.slew.closed_forms import (
    DURATION_TOLERANCE,
    least_jerk_profile,
    profile_lasting,
    quickest_profile,
)
from planner.motion.slew.problem import AxisSlew, AxisState, broken_limit
from planner.motion.slew.solution import AxisProfile, obeys
from planner.motion.slew.stops import margins_on_rows, rate_margin_rad_s, stop_margin_rad
from planner.world.platforms import AxisLimits


@dataclass(frozen=True, kw_only=True)
class AxisVerdict:
    """Whether one axis can slew in exactly the given time.

    profile: a motion of that duration within every limit, the proof of feasibility.
    limit: set on a proof of the contrary: "angle", "rate" or "acceleration" when the start or
    end breaks it or can't be left or reached without breaking it, else "duration".
    Neither: undecided, the stops are in the way and a solver must look for a motion; about one
    case in 5,000.
    """

    profile: AxisProfile | None = None
    limit: str | None = None


def verdict(start: AxisState, end: AxisState, limits: AxisLimits, duration_s: float) -> AxisVerdict:
    """Decide with closed forms: microseconds where the stops are out of the way.

    The time itself is tested, not only against the least one: the durations an axis can
    take may have a gap.
    """
    limit = broken_limit(start, limits) or broken_limit(end, limits)
    if limit is not None:
        return AxisVerdict(limit=limit)
    limit = dead_end(start, end, limits)
    if not passes_certificate(start, end, limits, duration_s):
        return AxisVerdict(limit=limit or "duration")
    profile = profile_lasting(start, end, limits, duration_s)
    for candidate in (profile, least_jerk_profile(start, end, duration_s)):
        if candidate is not None and obeys(candidate, start, end, limits):
            return AxisVerdict(profile=candidate)
    if limit is None and profile is None and quickest_profile(start, end, limits) is not None:
        limit = "duration"
    return AxisVerdict(limit=limit)


def passes_certificate(
    start: AxisState, end: AxisState, limits: AxisLimits, duration_s: float
) -> bool:
    """Whether the slew would fit with unlimited jerk and no stops: necessary, exact, cheap."""
    fits = fits_without_jerk(
        start, np.array(end.angle_rad), np.array(end.rate_rad_s), limits, np.array(duration_s)
    )
    return bool(fits)


def fits_without_jerk(
    start: AxisState, angle_rad: Array, rate_rad_s: Array, limits: AxisLimits, duration_s: Array
) -> NDArray[np.bool_]:
    """Decide for many ends at once: arrays of one shape.

    Source: extreme displacement of a bang-coast-bang rate profile between the two rates.
    """
    v0, v1 = start.rate_rad_s, rate_rad_s
    a, v = limits.acceleration_max_rad_s2, limits.rate_max_rad_s
    enough = duration_s * (1.0 + DURATION_TOLERANCE)
    delta = angle_rad - start.angle_rad
    slack = DURATION_TOLERANCE * v * duration_s
    return np.asarray(
        (enough >= np.abs(v1 - v0) / a)
        & (-_farthest_rad(-v0, -v1, a, v, enough) - slack <= delta)
        & (delta <= _farthest_rad(v0, v1, a, v, enough) + slack)
    )


def _farthest_rad(v0: float, v1: Array, a: float, v: float, t: Array) -> Array:
    peak = (a * t + v0 + v1) / 2.0
    without_coast = (2.0 * peak * peak - v0 * v0 - v1 * v1) / (2.0 * a)
    with_coast = (2.0 * v * v - v0 * v0 - v1 * v1) / (2.0 * a) + v * (t - (2.0 * v - v0 - v1) / a)
    return np.where(peak <= v, without_coast, with_coast)


def dead_end(start: AxisState, end: AxisState, limits: AxisLimits) -> str | None:
    """The limit, "angle" or "rate", that breaks however long the slew may take, or None."""
    rounding = DURATION_TOLERANCE * (limits.angle_max_rad - limits.angle_min_rad)
    for state in (start, end.backwards()):
        if stop_margin_rad(state, limits) < -rounding:
            return "angle"
        if rate_margin_rad_s(state, limits) < -DURATION_TOLERANCE * limits.rate_max_rad_s:
            return "rate"
    return None


def require_brakable(
    axis_names: tuple[str, ...], state: tuple[AxisState, ...], limits: tuple[AxisLimits, ...]
) -> None:
    """Raises InfeasibleSlew where the platform's own motion can't be braked before a limit.

    Braked in rows of the command table, as it is flown: that costs up to 0.1 deg, or in rate
    nothing, beside braking whose jerk changes at any time.
    """
    failing = [
        (name, limit, _unbrakable_because(name, limit, motion, bound))
        for name, motion, bound in zip(axis_names, state, limits, strict=True)
        if (limit := _broken_on_rows(motion, bound)) is not None
    ]
    if failing:
        raise InfeasibleSlew(
            "; ".join(why for _, _, why in failing)
            + "; begin with less rate or acceleration, or farther from the limit",
            field="initial_state",
            axis=failing[0][0],
            limit=failing[0][1],
        )


def _broken_on_rows(state: AxisState, limits: AxisLimits) -> str | None:
    angle_rad, rate_rad_s = margins_on_rows(state, limits)
    if rate_rad_s < -DURATION_TOLERANCE * limits.rate_max_rad_s:
        return "rate"
    if angle_rad < -DURATION_TOLERANCE * (limits.angle_max_rad - limits.angle_min_rad):
        return "angle"
    return None


def _unbrakable_because(name: str, limit: str, state: AxisState, limits: AxisLimits) -> str:
    rate, acceleration = math.degrees(state.rate_rad_s), math.degrees(state.acceleration_rad_s2)
    begins = f"{name} begins with {rate:.4g} deg/s and {acceleration:.4g} deg/s2"
    angle_rad, rate_rad_s = margins_on_rows(state, limits)
    if limit == "rate":
        bound = f"{math.degrees(limits.rate_max_rad_s):.6g} deg/s"
        passes = f"its rate passes {bound} by {_degrees_text(-rate_rad_s)} deg/s"
    else:
        stops = math.degrees(limits.angle_min_rad), math.degrees(limits.angle_max_rad)
        bound = f"its stops at {stops[0]:.6g} and {stops[1]:.6g} deg"
        passes = f"it passes {bound} by {_degrees_text(-angle_rad)} deg"
    return f"{begins}, and however hard it brakes, in rows {COMMAND_STEP_S} s apart, {passes}"


def _degrees_text(value_rad: float) -> str:
    return f"{math.degrees(value_rad):.3g}"


def next_duration_s(
    start: AxisState, end: AxisState, limits: AxisLimits, at_least_s: float
) -> float | None:
    """The least duration from at_least_s on that an axis can take, stops aside; None: never."""
    if dead_end(start, end, limits) is not None:
        return None
    profile = quickest_profile(start, end, limits, at_least_s)
    return None if profile is None else profile.duration_s


def axis_refusal(name: str, slew: AxisSlew, limit: str) -> InfeasibleSlew:
    """The refusal for one axis; the caller who knows the clock adds the earliest start."""
    start, end, limits, available_s = slew.start, slew.end, slew.limits, slew.duration_s
    if limit == "duration":
        needed_s = next_duration_s(start, end, limits, available_s)
        if needed_s is not None:
            shown_s = math.ceil(needed_s * 1e3) / 1e3
            return InfeasibleSlew(
                f"{name} needs {shown_s:.3f} s to slew but {available_s:.3f} s are available; "
                "begin the session later or start the slew nearer to it",
                axis=name,
                limit=limit,
            )
    side = "start" if dead_end(start, start.at_rest(), limits) == limit else "end"
    what = {"angle": "its hard stop", "rate": "its rate limit"}.get(limit, "its limits")
    return InfeasibleSlew(
        f"{name} can't keep {what} in a slew of {available_s:.3f} s: its motion at the {side} "
        "can't be braked in time; begin the session at another time or slow the axis down",
        axis=name,
        limit=limit,
    )
