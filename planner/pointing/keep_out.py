"""How deep the boresight enters the cones it must keep out of, as they move."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from planner.arrays import Array, Mask
from planner.commands import COMMAND_STEP_S
from planner.frames.time_scales import Instants
from planner.orbits import Ephemeris
from planner.platforms import TwoAxisPlatform
from planner.pointing.angles import boresight_platform
from planner.scenario import Scenario

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

NODE_STEP_S = 10.0  # a carrier turning at 0.1 deg/s: cubics between nodes err by 0.005 arcsec
NODES_MIN = 4
FINER = 20  # instants per row where a cone is near
CARRIER_RATE_RAD_S = math.radians(1.0)
ACCELERATION = 0.1  # rad/s2, more than any platform's


@dataclass(frozen=True, kw_only=True, eq=False)
class MovingCone:
    """One cone in the platform frame.

    t_s: (k,) nodes; axis_platform: (k, 3) there; counts_rad: (k,), the cone counts where a
    cubic through it is positive.
    """

    about: str
    half_angle_rad: float
    t_s: Array
    axis_platform: Array
    counts_rad: Array

    @cached_property
    def _curve(self) -> "CubicSpline":
        # SciPy's interpolators take 0.2 s to import, which only a plan should pay.
        from scipy.interpolate import CubicSpline

        return CubicSpline(self.t_s, np.column_stack([self.axis_platform, self.counts_rad]))

    def at(self, t_s: Array) -> tuple[Array, Mask]:
        """Axes, unit vectors (n, 3), and whether the cone counts, (n,)."""
        found = self._curve(t_s)
        axis = found[:, :3] / np.linalg.norm(found[:, :3], axis=1, keepdims=True)
        return axis, found[:, 3] > 0.0

    def depth_rad(self, t_s: Array, directions_platform: Array) -> Array:
        """How far inside unit vectors (n, 3) are; negative outside, -pi where nothing counts."""
        axis, counts = self.at(t_s)
        across = np.linalg.norm(np.cross(axis, directions_platform), axis=1)
        away = np.arctan2(across, np.sum(axis * directions_platform, axis=1))
        return np.where(counts, self.half_angle_rad - away, -math.pi)


@dataclass(frozen=True, kw_only=True, eq=False)
class KeepOutView:
    """The cones as one platform meets them over a stretch of time."""

    platform: TwoAxisPlatform
    cones: tuple[MovingCone, ...]

    def from_time(self, begins_s: float) -> "KeepOutView":
        """The same with its time counted from begins_s on."""
        cones = tuple(replace(cone, t_s=cone.t_s - begins_s) for cone in self.cones)
        return replace(self, cones=cones)

    def boresight(self, angle_rad: Array) -> Array:
        """Unit vectors (n, 3) by axis angles (n, 2)."""
        return boresight_platform(self.platform, angle_rad)

    def depths_rad(self, t_s: Array, angle_rad: Array) -> Array:
        """How deep each cone is entered, shape (cones, n), by axis angles (n, 2)."""
        boresight = self.boresight(angle_rad)
        return np.stack([cone.depth_rad(t_s, boresight) for cone in self.cones])


@dataclass(frozen=True, kw_only=True)
class ConeEntry:
    """The deepest a motion goes into any cone, negative when it stays outside; and when."""

    depth_rad: float
    t_s: float
    about: str


def deepest_entry(
    view: KeepOutView, motion: Callable[[Array], tuple[Array, Array]], start_s: float, stop_s: float
) -> ConeEntry:
    """Looked for every 10 ms wherever a cone may be met.

    motion: angles and rates, (n, 2) each, at times (n,).
    """
    count = max(round((stop_s - start_s) / COMMAND_STEP_S), 1)
    t_s = np.linspace(start_s, stop_s, count + 1)
    angle, rate = motion(t_s)
    depth = view.depths_rad(t_s, angle)
    step_s = t_s[1] - t_s[0]
    # What boresight and cone may still do before the next row; a carrier turns slower than 1 deg/s.
    ahead = step_s * (np.abs(rate).sum(axis=1) + CARRIER_RATE_RAD_S) + step_s**2 * ACCELERATION
    near = np.flatnonzero((depth > -ahead).any(axis=0))
    if near.size:
        finer = np.arange(-FINER, FINER + 1) * (step_s / FINER)
        t_s = np.unique(np.clip(t_s[near, None] + finer, start_s, stop_s))
        depth = view.depths_rad(t_s, motion(t_s)[0])
    cone, at = np.unravel_index(int(np.argmax(depth)), depth.shape)
    return ConeEntry(
        depth_rad=float(depth[cone, at]), t_s=float(t_s[at]), about=view.cones[cone].about
    )


def keep_out_view(
    scenario: Scenario, ephemeris: Ephemeris, start_s: float, stop_s: float
) -> KeepOutView | None:
    """The scenario's cones from start_s to stop_s on the table's clock; None without any.

    Time in the view is counted from start_s.  Raises OutsideCoverage.
    """
    if not scenario.slew.keep_out:
        return None
    count = max(NODES_MIN, math.ceil((stop_s - start_s) / NODE_STEP_S) + 1)
    t_s = np.linspace(start_s, stop_s, count)
    instants = Instants(scenario.initial_state.epoch, t_s)
    states = ephemeris.states(instants)
    q_platform_from_eci = scenario.platform.q_platform_from_body * (
        scenario.attitude.q_body_from_eci(instants, states)
    )
    cones = []
    for cone in scenario.slew.keep_out:
        axis_platform, counts_rad = cone.axis_platform(instants, states, q_platform_from_eci)
        cones.append(
            MovingCone(
                about=cone.about,
                half_angle_rad=math.radians(cone.half_angle_deg),
                t_s=t_s - start_s,
                axis_platform=axis_platform,
                counts_rad=counts_rad,
            )
        )
    return KeepOutView(platform=scenario.platform, cones=tuple(cones))
