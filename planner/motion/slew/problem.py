"""The slew to solve: each axis's states at both ends, its limits, and the time they share."""

from dataclasses import dataclass

from planner.base.arrays import Array
from planner.base.spec import spec
from planner.motion.pointing.keep_out import KeepOutView
from planner.world.platforms import AxisLimits, StructuralMode

LIMIT_TOLERANCE = 1e-9  # of the limit's range: rounding of degrees to radians and back


@spec
class AxisState:
    """How one axis moves at one instant."""

    angle_rad: float
    rate_rad_s: float = 0.0
    acceleration_rad_s2: float = 0.0

    def backwards(self) -> "AxisState":
        """The state at the same instant with time running backwards."""
        return AxisState(
            angle_rad=self.angle_rad,
            rate_rad_s=-self.rate_rad_s,
            acceleration_rad_s2=self.acceleration_rad_s2,
        )

    def mirror_image(self) -> "AxisState":
        """The state with the axis turned round."""
        return AxisState(
            angle_rad=-self.angle_rad,
            rate_rad_s=-self.rate_rad_s,
            acceleration_rad_s2=-self.acceleration_rad_s2,
        )

    def at_rest(self) -> "AxisState":
        """The state at the same angle, standing still."""
        return AxisState(angle_rad=self.angle_rad)


def axis_states(
    angle_rad: Array, rate_rad_s: Array, acceleration_rad_s2: Array
) -> tuple[AxisState, ...]:
    """The states of m axes at one instant, from arrays (m,)."""
    return tuple(
        AxisState(angle_rad=float(q), rate_rad_s=float(v), acceleration_rad_s2=float(a))
        for q, v, a in zip(angle_rad, rate_rad_s, acceleration_rad_s2, strict=True)
    )


@dataclass(frozen=True, kw_only=True)
class AxisSlew:
    """One axis of a slew, in exactly duration_s.  avoid_modes: as in `SlewProblem`."""

    start: AxisState
    end: AxisState
    limits: AxisLimits
    duration_s: float
    avoid_modes: tuple[StructuralMode, ...] = ()


@spec
class SlewProblem:
    """One slew of all axes, in exactly duration_s.

    axis_names, limits, start, end: one entry per axis, in the same order.
    avoid_modes: structural modes to leave at rest.  keep_out: cones the boresight must not
    enter, time counted from the slew's start; the axes are then those of its platform.
    """

    axis_names: tuple[str, ...]
    limits: tuple[AxisLimits, ...]
    start: tuple[AxisState, ...]
    end: tuple[AxisState, ...]
    duration_s: float
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

    @property
    def axes(self) -> tuple[AxisSlew, ...]:
        """The slew of each axis by itself, cones aside."""
        return tuple(
            AxisSlew(
                start=start,
                end=end,
                limits=limits,
                duration_s=self.duration_s,
                avoid_modes=self.avoid_modes,
            )
            for start, end, limits in zip(self.start, self.end, self.limits, strict=True)
        )


def is_within(state: AxisState, limits: AxisLimits) -> bool:
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
    orders = ("angle_rad", "rate_rad_s", "acceleration_rad_s2")
    for name, (low, high) in zip(orders, limits.bounds[:3], strict=True):
        value = getattr(state, name)
        slack = LIMIT_TOLERANCE * (high - low)
        if not low - slack <= value <= high + slack:
            return name, value, low, high
    return None
