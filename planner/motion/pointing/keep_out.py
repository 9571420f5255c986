"""Depth of the boresight in what it must keep out of: cones as they move, masks that stand."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Mask
from planner.base.commands import COMMAND_STEP_S
from planner.motion.pointing.angles import boresight_platform
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.platforms import FieldMask, TwoAxisPlatform
from planner.world.rules.two_axis import axes_of
from planner.world.scenario import Scenario

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline


@dataclass(frozen=True, kw_only=True)
class KeepOutOptions:
    """How densely cones and masks are looked at along a motion."""

    # a carrier turning at 0.1 deg/s: cubics between nodes err by 0.005 arcsec
    node_step_s: float = 10.0
    nodes_min: int = 4  # of a cubic
    finer: int = 20  # instants per row where a cone is near
    # instants per such instant beside a mask, whose corners a motion cuts in a moment
    mask_finer: int = 20
    near_row: float = 3.5  # of `effort`: those of a row, beside each region
    carrier_rate_rad_s: float = math.radians(1.0)  # no carrier of a camera turns faster
    acceleration: float = 0.1  # rad/s2, more than any platform's


OPTIONS = KeepOutOptions()


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

    @property
    def title(self) -> str:
        """The region's name in a sentence."""
        return f"the cone about {self.about}"

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
    """Cones and masks as one platform meets them over a stretch of time."""

    platform: TwoAxisPlatform
    cones: tuple[MovingCone, ...] = ()
    masks: tuple[FieldMask, ...] = ()

    @property
    def regions(self) -> tuple[MovingCone | FieldMask, ...]:
        """All that it must keep out of, in the order of `depths_rad`."""
        return (*self.cones, *self.masks)

    def with_region_alone(self, region: MovingCone | FieldMask) -> "KeepOutView":
        """The view with but one region to keep out of."""
        return replace(
            self,
            cones=tuple(cone for cone in self.cones if cone is region),
            masks=tuple(mask for mask in self.masks if mask is region),
        )

    def from_time(self, begins_s: float) -> "KeepOutView":
        """The view with its time counted from begins_s on."""
        cones = tuple(replace(cone, t_s=cone.t_s - begins_s) for cone in self.cones)
        return replace(self, cones=cones)

    def boresight(self, angle_rad: Array) -> Array:
        """Unit vectors (n, 3) by axis angles (n, 2)."""
        return boresight_platform(self.platform, angle_rad)

    def depths_rad(self, t_s: Array, angle_rad: Array) -> Array:
        """How deep each region is entered, shape (regions, n), by axis angles (n, 2)."""
        boresight = self.boresight(angle_rad)
        of_cones = [cone.depth_rad(t_s, boresight) for cone in self.cones]
        return np.stack([*of_cones, *(mask.depth_rad(boresight) for mask in self.masks)])


@dataclass(frozen=True, kw_only=True)
class DeepestEntry:
    """The deepest a motion goes into any region, negative when it stays outside; and when.

    title: the region's, for a sentence.
    """

    depth_rad: float
    t_s: float
    title: str


def deepest_entry(
    view: KeepOutView, motion: Callable[[Array], tuple[Array, Array]], start_s: float, stop_s: float
) -> DeepestEntry:
    """Looked for every 10 ms wherever a region may be met, and every 0.5 ms beside masks.

    motion: angles and rates, (n, 2) each, at times (n,).
    """
    count = max(round((stop_s - start_s) / COMMAND_STEP_S), 1)
    t_s = np.linspace(start_s, stop_s, count + 1)
    angle, rate = motion(t_s)
    depth = view.depths_rad(t_s, angle)
    step_s = t_s[1] - t_s[0]
    # What boresight and cone may still do before the next row; a carrier turns slower than 1 deg/s.
    ahead = (
        step_s * (np.abs(rate).sum(axis=1) + OPTIONS.carrier_rate_rad_s)
        + step_s**2 * OPTIONS.acceleration
    )
    near = np.flatnonzero((depth > -ahead).any(axis=0))
    if near.size:
        effort.charge(OPTIONS.near_row * near.size * len(view.regions))
        t_s = _instants_beside(t_s[near], step_s, OPTIONS.finer, start_s, stop_s)
        angle, rate = motion(t_s)
        depth = view.depths_rad(t_s, angle)
        step_s /= OPTIONS.finer
        reach = step_s * np.abs(rate).sum(axis=1) + step_s**2 * OPTIONS.acceleration
        may_be_deepest = depth[len(view.cones) :] > max(depth.max(), 0.0) - reach
        near = np.flatnonzero(may_be_deepest.any(axis=0))
        if near.size:
            finest_s = _instants_beside(t_s[near], step_s, OPTIONS.mask_finer, start_s, stop_s)
            t_s = np.concatenate([t_s, finest_s])
            depth = np.hstack([depth, view.depths_rad(finest_s, motion(finest_s)[0])])
    region, at = np.unravel_index(int(np.argmax(depth)), depth.shape)
    return DeepestEntry(
        depth_rad=float(depth[region, at]), t_s=float(t_s[at]), title=view.regions[region].title
    )


def _instants_beside(
    near_s: Array, step_s: float, finer: int, start_s: float, stop_s: float
) -> Array:
    """Up to a step before and after each of these, so many per step."""
    since_s = np.arange(-finer, finer + 1) * (step_s / finer)
    return np.unique(np.clip(near_s[:, None] + since_s, start_s, stop_s))


def keep_out_view(
    scenario: Scenario, ephemeris: Ephemeris, start_s: float, stop_s: float
) -> KeepOutView | None:
    """What to keep out of from start_s to stop_s on the table's clock; None where nothing.

    Time in the view is counted from start_s.  Raises OutsideCoverage, where there are cones.
    """
    if not scenario.keeps_out:
        return None
    cones = _moving_cones(scenario, ephemeris, start_s, stop_s) if scenario.slew.keep_out else ()
    return KeepOutView(platform=axes_of(scenario), cones=cones, masks=scenario.platform.masks)


def _moving_cones(
    scenario: Scenario, ephemeris: Ephemeris, start_s: float, stop_s: float
) -> tuple[MovingCone, ...]:
    count = max(OPTIONS.nodes_min, math.ceil((stop_s - start_s) / OPTIONS.node_step_s) + 1)
    t_s = np.linspace(start_s, stop_s, count)
    instants = Instants(scenario.initial_state.epoch, t_s)
    states = ephemeris.states(instants)
    q_platform_from_eci = axes_of(scenario).q_platform_from_body * (
        scenario.law.q_body_from_eci(instants, states)
    )
    cones = []
    for cone in scenario.slew.keep_out:
        axis_platform, counts_rad = cone.axis_base(instants, states, q_platform_from_eci)
        cones.append(
            MovingCone(
                about=cone.about,
                half_angle_rad=math.radians(cone.half_angle_deg),
                t_s=t_s - start_s,
                axis_platform=axis_platform,
                counts_rad=counts_rad,
            )
        )
    return tuple(cones)
