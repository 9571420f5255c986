"""From which state to which must each axis move, in what time, within which limits?"""

from typing import Literal

from planner.platforms import AxisLimits, StructuralMode
from planner.pointing.keep_out import KeepOutView
from planner.spec import spec

Objective = Literal["smooth", "minimum_time"]
LIMIT_TOLERANCE = 1e-9  # of the limit's range: rounding of degrees to radians and back


@spec
class AxisState:
    """How one axis moves at one instant."""

    angle_rad: float
    rate_rad_s: float = 0.0
    acceleration_rad_s2: float = 0.0

    def reversed(self) -> "AxisState":
        """The same instant with time running backwards."""
        return AxisState(
            angle_rad=self.angle_rad,
            rate_rad_s=-self.rate_rad_s,
            acceleration_rad_s2=self.acceleration_rad_s2,
        )

    def at_rest(self) -> "AxisState":
        """The same angle, standing still."""
        return AxisState(angle_rad=self.angle_rad)


@spec
class SlewProblem:
    """One slew of all axes.

    axis_names, limits, start, end: one entry per axis, in the same order.
    objective: "smooth" takes all of duration_s and spends the least integral of squared
    jerk; "minimum_time" takes the least duration, at most duration_s, that all axes share.
    avoid_modes: structural modes to leave at rest.  keep_out: cones the boresight must not
    enter, time counted from the slew's start; the axes are then those of its platform.
    """

    axis_names: tuple[str, ...]
    limits: tuple[AxisLimits, ...]
    start: tuple[AxisState, ...]
    end: tuple[AxisState, ...]
    duration_s: float
    objective: Objective = "smooth"
    avoid_modes: tuple[StructuralMode, ...] = ()
    keep_out: KeepOutView | None = None

    def __post_init__(self) -> None:
        for name in ("limits", "start", "end"):
            count = len(getattr(self, name))
            if count != len(self.axis_names):
                raise ValueError(f"{name} must have one entry per axis, not {count}")
        if not self.duration_s > 0.0:
            raise ValueError(f"duration_s must be positive, not {self.duration_s}")
        for side in ("start", "end"):
            for axis, state, limits in zip(
                self.axis_names, getattr(self, side), self.limits, strict=True
            ):
                _require_within(f"{side}.{axis}", state, limits)


def within(state: AxisState, limits: AxisLimits) -> bool:
    """Whether angle, rate and acceleration keep their limits at this instant."""
    return broken_limit(state, limits) is None


def broken_limit(state: AxisState, limits: AxisLimits) -> str | None:
    """Which of "angle", "rate", "acceleration" the state itself breaks."""
    outside = _first_outside(state, limits)
    return None if outside is None else outside[0].partition("_")[0]


def _require_within(where: str, state: AxisState, limits: AxisLimits) -> None:
    outside = _first_outside(state, limits)
    if outside is not None:
        name, value, low, high = outside
        raise ValueError(f"{where}.{name} is {value}, outside its limits {low}..{high}")


def _first_outside(state: AxisState, limits: AxisLimits) -> tuple[str, float, float, float] | None:
    rate, acceleration = limits.rate_max_rad_s, limits.acceleration_max_rad_s2
    for name, value, low, high in (
        ("angle_rad", state.angle_rad, limits.angle_min_rad, limits.angle_max_rad),
        ("rate_rad_s", state.rate_rad_s, -rate, rate),
        ("acceleration_rad_s2", state.acceleration_rad_s2, -acceleration, acceleration),
    ):
        slack = LIMIT_TOLERANCE * (high - low)
        if not low - slack <= value <= high + slack:
            return name, value, low, high
    return None
