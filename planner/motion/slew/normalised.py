"""A slew in normalised time: the motion lasts 1, and angles are of its own size."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Mask
from planner.motion.slew.problem import AxisSlew
from planner.motion.slew.solution import AxisProfile


@dataclass(frozen=True, eq=False)
class NormalisedSlew:
    """The slew lasts 1; angles count from its start in units of scale_rad.

    ends (2, 3): angle, rate, acceleration at start and end.  limits (4, 2): least and greatest
    angle, rate, acceleration, jerk.
    """

    ends: Array
    limits: Array
    start_angle_rad: float
    scale_rad: float
    duration_s: float

    @property
    def cost_unit_rad2_s5(self) -> float:
        """What an integral of squared jerk of 1 is."""
        return self.scale_rad**2 / self.duration_s**5

    def profile(self, knots: Array, flat: Mask, states: Array, jerks: Array) -> AxisProfile:
        """The motion in SI: jerks (n, 2) at both ends of each span, or their mean where flat."""
        widths = np.diff(knots)
        slope = np.where(flat, 0.0, (jerks[:, 1] - jerks[:, 0]) / widths)
        begin = np.where(flat, jerks.mean(axis=1), jerks[:, 0])
        coefficients = np.column_stack(
            [states[:-1, 0], states[:-1, 1], states[:-1, 2] / 2.0, begin / 6.0, slope / 24.0]
        )
        coefficients *= self.scale_rad / self.duration_s ** np.arange(5)
        coefficients[:, 0] += self.start_angle_rad
        return AxisProfile(breakpoints_s=knots * self.duration_s, coefficients=coefficients)


def normalise_slew(slew: AxisSlew) -> NormalisedSlew:
    start, end, T = slew.start, slew.end, slew.duration_s
    rates = (abs(start.rate_rad_s) + abs(end.rate_rad_s)) * T / 4.0
    accelerations = (abs(start.acceleration_rad_s2) + abs(end.acceleration_rad_s2)) * T**2 / 40.0
    scale_rad = max(abs(end.angle_rad - start.angle_rad), rates, accelerations, 1e-9)
    times = T ** np.arange(4) / scale_rad
    ends = [
        (state.angle_rad - start.angle_rad, state.rate_rad_s, state.acceleration_rad_s2)
        for state in (start, end)
    ]
    limits = np.array(slew.limits.bounds)
    limits[0] -= start.angle_rad
    return NormalisedSlew(
        ends=np.array(ends) * times[:3],
        limits=limits * times[:, None],
        start_angle_rad=start.angle_rad,
        scale_rad=scale_rad,
        duration_s=T,
    )
