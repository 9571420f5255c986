"""Axis motions that identify the platform on the bench, with no target in sight."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import InvalidInput, TrackBreaksLimit, figures
from planner.base.spec import spec
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text
from planner.world.platforms import MotionBounds
from planner.world.targets.axis_signals import Chirp, ConstantRate, Multisine, Sine, Step, Triangle
from planner.world.targets.session_target import TimedTarget

Motion = Annotated[
    ConstantRate | Sine | Chirp | Step | Triangle | Multisine, Field(discriminator="kind")
]

ON_GRID_RAD = math.radians(0.1 / 3600.0)  # how closely the table's cubics must follow a plan


@dataclass(frozen=True, kw_only=True)
class BenchMotionOptions:
    """How densely a test motion is looked at for its peaks."""

    samples_per_period: int = 64  # a sine's peak is met within 0.03 %
    samples_per_row: int = 8  # where no period is shorter
    samples_max: int = 2_000_000  # of a motion, 16 MB each; beyond, it is refused


OPTIONS = BenchMotionOptions()

_UNITS = {"angle": "deg", "rate": "deg/s", "acceleration": "deg/s2", "jerk": "deg/s3"}


class PrescribedMotion(NamedTuple):
    """Angle, rate and acceleration of m axes at n instants, each of shape (n, m)."""

    angle_rad: Array
    rate_rad_s: Array
    acceleration_rad_s2: Array


@spec
class BenchMotionTarget(TimedTarget):
    """A test signal for each axis; t = 0 is its start.

    Source of the mode: Sumarokov 2016, p. 85.

    axes: one motion per axis of the platform, by the axis's name.
    start: time of t = 0; UTC, the session's start unless given. E.g. `"2015-02-27T17:36:20Z"`.
    """

    images: ClassVar[bool] = False
    mode: Literal["test_motion"] = "test_motion"
    axes: Mapping[str, Motion]
    start: datetime | None = None

    def __post_init__(self) -> None:
        if not self.axes:
            raise ValueError("axes must name a motion for each axis of the platform")

    @property
    def label(self) -> str:
        """None: lists tell of what is looked at."""
        return ""

    def axis_motion(self, dof_names: tuple[str, ...], t_s: Array) -> PrescribedMotion:
        """Analytic derivatives; raises InvalidInput unless `axes` are the platform's."""
        if set(self.axes) != set(dof_names):
            raise InvalidInput(
                f"axes must give a motion for each of {', '.join(dof_names)}, not for "
                f"{', '.join(self.axes)}; constant_rate with rate_deg_s 0 keeps an axis still",
                field="axes",
            )
        motion_rad = np.deg2rad([self.axes[name].motion_deg(t_s) for name in dof_names])
        return PrescribedMotion(*motion_rad.transpose(1, 2, 0))

    def require_flyable(
        self,
        dof_names: tuple[str, ...],
        bounds: tuple[MotionBounds, ...],
        start_utc: datetime,
        duration_s: float,
    ) -> None:
        """Refuse what breaks a limit or is too quick for the 0.2 s table.

        start_utc: of the session, which may begin amid the motion.  Looks at 64 instants per
        period of the fastest component and 8 per row.
        """
        shortest_s = min(motion.shortest_period_s() for motion in self.axes.values())
        sample_s = min(
            COMMAND_STEP_S / OPTIONS.samples_per_row, shortest_s / OPTIONS.samples_per_period
        )
        row = math.ceil(COMMAND_STEP_S / sample_s)
        row += row % 2
        count = math.ceil(duration_s / COMMAND_STEP_S * row) + 1
        if count > OPTIONS.samples_max:
            raise InvalidInput(
                f"a test motion can't be checked every {sample_s:.2g} s over {duration_s:.0f} s; "
                "shorten the session or slow its fastest part",
                field="axes",
            )
        zero_utc = self.start or start_utc
        t_s = np.arange(count, dtype=np.float64) * (COMMAND_STEP_S / row)
        instants = Instants(zero_utc, t_s + elapsed_s(start_utc, zero_utc))
        motion = self.axis_motion(dof_names, instants.t_s)
        for axis, (name, each) in enumerate(zip(dof_names, bounds, strict=True)):
            axis_states = [part[:, axis] for part in motion]
            _require_within(name, each, instants, axis_states)
            _require_on_grid(name, row, instants, axis_states)


def _require_within(
    axis: str, bounds: MotionBounds, instants: Instants, axis_states: Sequence[Array]
) -> None:
    """axis_states: angle, rate and acceleration of one axis (rad, s) at even instants, (n,)."""
    jerk_rad_s3 = np.diff(axis_states[2]) / (instants.t_s[1] - instants.t_s[0])
    parts = (*axis_states, jerk_rad_s3)
    for (limit, unit), values, bound in zip(_UNITS.items(), parts, bounds, strict=True):
        low, high = bound or (-math.inf, math.inf)
        excess = np.maximum(values - high, low - values)
        worst = int(np.argmax(excess))
        if excess[worst] > 0.0:
            at_utc = instants.utc(worst)
            raise TrackBreaksLimit(
                f"{axis}'s test motion reaches "
                f"{figures(*np.rad2deg([values[worst], low, high]).tolist())} "
                f"{unit} at {utc_text(at_utc)}, beyond its {limit} limits of "
                f"{math.degrees(low):.4g}..{math.degrees(high):.4g}; lower its amplitude "
                "or frequency, or give its steps and turns more time",
                field=f"axes.{axis}",
                axis=axis,
                limit=limit,
                at_utc=at_utc,
            )


def _require_on_grid(axis: str, row: int, instants: Instants, axis_states: Sequence[Array]) -> None:
    """The cubic Hermite of rows 0.2 s apart, wherever they fall, must follow the motion.

    row: how many of the instants lie in a row.  axis_states: as of `_require_within`.
    """
    if len(instants) <= row:
        return
    angle_rad, rate_rad_s, _ = axis_states
    middle_rad = (angle_rad[:-row] + angle_rad[row:]) / 2.0 + (
        rate_rad_s[:-row] - rate_rad_s[row:]
    ) * (COMMAND_STEP_S / 8.0)
    off_rad = np.abs(middle_rad - angle_rad[row // 2 : row // 2 - row])
    worst = int(np.argmax(off_rad))
    if off_rad[worst] > ON_GRID_RAD:
        raise TrackBreaksLimit(
            f"{axis}'s test motion leaves the 0.2 s table by "
            f"{figures(off_rad[worst] / ON_GRID_RAD / 10.0, 0.1, digits=2)} arcsec between "
            "rows (0.1 at most); lower its amplitude (proportional) or frequency (fourth "
            "power)",
            field=f"axes.{axis}",
            axis=axis,
            limit="table step",
            at_utc=instants.utc(worst),
        )
