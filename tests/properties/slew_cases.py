"""Random slews of the HRC platform, drawn once for every test and benchmark that needs them."""

import math
from dataclasses import dataclass

import numpy as np

from planner.motion.slew.feasibility import next_duration_s
from planner.motion.slew.problem import AxisState, SlewProblem
from planner.world.platforms import ISS_HRC

LIMITS = ISS_HRC.outer_limits
NAMES = ISS_HRC.axis_names
KINDS = ("rest", "moving", "near a stop")


@dataclass(frozen=True)
class Case:
    start: tuple[AxisState, ...]
    end: tuple[AxisState, ...]

    def problem(self, duration_s):
        return SlewProblem(
            axis_names=NAMES[: len(self.start)],
            limits=(LIMITS,) * len(self.start),
            start=self.start,
            end=self.end,
            duration_s=duration_s,
        )


def deg_state(angle_deg, rate_deg_s=0.0, acceleration_deg_s2=0.0):
    return AxisState(
        angle_rad=math.radians(angle_deg),
        rate_rad_s=math.radians(rate_deg_s),
        acceleration_rad_s2=math.radians(acceleration_deg_s2),
    )


def can_brake(state, limits=LIMITS):
    """By stepping the hardest braking in 1 ms steps: independent of the closed forms."""
    jerk, brake = limits.jerk_max_rad_s3, limits.acceleration_max_rad_s2
    for side in (1.0, -1.0):
        q, v, a = (
            side * state.angle_rad,
            side * state.rate_rad_s,
            side * state.acceleration_rad_s2,
        )
        v_most = v
        while v > 0.0 or (a > 0.0 and v > -limits.rate_max_rad_s):
            q, v, a = q + 1e-3 * v, v + 1e-3 * a, max(a - 1e-3 * jerk, -brake)
            v_most = max(v_most, v)
        if q > limits.angle_max_rad - 1e-3 or v_most > limits.rate_max_rad_s:
            return False
    return True


def draw_state(rng, kind):
    while True:
        if kind == "near a stop":
            angle_deg = rng.choice([-1.0, 1.0]) * rng.uniform(160.0, 174.9)
        else:
            angle_deg = rng.uniform(-174.0, 174.0)
        moving = kind != "rest"
        state = deg_state(
            float(angle_deg), moving * rng.uniform(-2.9, 2.9), moving * rng.uniform(-0.9, 0.9)
        )
        mirrored_in_time = deg_state(
            float(angle_deg),
            -math.degrees(state.rate_rad_s),
            math.degrees(state.acceleration_rad_s2),
        )
        if can_brake(state) and can_brake(mirrored_in_time):
            return state


def draw_cases(seed, count):
    rng = np.random.default_rng(seed)
    for number in range(count):
        start_kind, end_kind = KINDS[number % 3], KINDS[(number // 3) % 3]
        yield Case(
            start=tuple(draw_state(rng, start_kind) for _ in NAMES),
            end=tuple(draw_state(rng, end_kind) for _ in NAMES),
        )


def sampled(profile, step_s=1e-3):
    """Angle, rate, acceleration, jerk on a fine grid, by numpy alone from the coefficients."""
    parts = [[], [], [], []]
    for k, c in enumerate(profile.coefficients):
        width = profile.breakpoints_s[k + 1] - profile.breakpoints_s[k]
        t = np.append(np.arange(0.0, width, step_s), width)
        poly = np.polynomial.Polynomial(c)
        for order in range(4):
            derivative = poly if order == 0 else poly.deriv(order)
            parts[order].append(derivative(t))
    return [np.concatenate(part) for part in parts]


def least_shared_s(case):
    """Least duration that suits both axes: beyond each least time and outside every gap."""
    shared = 0.0
    for _ in range(4):
        for start, end in zip(case.start, case.end, strict=True):
            shared = max(shared, next_duration_s(start, end, LIMITS, shared))
    return shared
