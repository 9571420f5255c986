"""The search for windows of two axes on a carrier that somebody else steers."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.motion.pointing.reach import reach_of
from planner.planning.opportunities.margins import KEPT, NOTHING, WindowScene, scene_of
from planner.planning.opportunities.platforms.lookout import HeldScans, Narrowing, kept_before
from planner.planning.opportunities.request import OpportunityConditions
from planner.planning.opportunities.sessions import hold, hold_line
from planner.planning.opportunities.sights import Sight
from planner.planning.opportunities.sweep import Found
from planner.planning.opportunities.windows import Cause
from planner.planning.resources import spans_above
from planner.world.attitude import AttitudeLaw, LvlhAttitude
from planner.world.attitude.lvlh import level_warnings
from planner.world.exclusions import Surroundings, unkept_told
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms import AnyPlatform, TwoAxisPlatform
from planner.world.platforms.kept_direction import unit_vector


@dataclass(frozen=True, kw_only=True)
class DirectionOptions:
    """How a window is cut where a direction isn't kept, and what that takes."""

    scan_step_s: float = 1.0  # between looks along a scan: no direction comes and goes in less
    window: float = 300.0  # of `effort`: a window, its edges sought
    look: float = 0.5  # of `effort`: a second of it


OPTIONS = DirectionOptions()


class TwoAxisLookout:
    """As `Lookout` says; the base is the mounting plate."""

    has_branches = True
    settle_s = 0.0
    sees_bodies = False

    def __init__(self, platform: AnyPlatform, attitude: AttitudeLaw | None) -> None:
        assert isinstance(platform, TwoAxisPlatform)  # by the registry
        self.platform, self.attitude = platform, attitude or LvlhAttitude()
        self.reach = reach_of(platform)
        self.angle_names = platform.axis_names
        self.causes: tuple[Cause, ...] = ("reach", "mask") if platform.masks else ("reach",)

    @property
    def rests_in_orbit(self) -> bool:
        return isinstance(self.attitude, LvlhAttitude) and not self.attitude.corrections

    def q_base_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        q_body_from_eci = self.attitude.q_body_from_eci(instants, states)
        return self.platform.q_platform_from_body * q_body_from_eci

    def warnings_at(self, instants: Instants) -> tuple[str, ...]:
        return (
            *level_warnings(
                self.attitude, self.platform.name, self.platform.usual_yaw_pitch_roll_deg
            ),
            *self.attitude.warnings_at(instants),
        )

    def conditions(self, asked: OpportunityConditions) -> OpportunityConditions:
        return asked

    def hold(
        self, sight: Sight, scene: WindowScene, found: Found, shortest_s: float, looks_limit: float
    ) -> tuple[Found, Array, int]:
        found = self._clear(sight, found, shortest_s)
        return (found, *hold(scene, found, looks_limit))

    def held_scans(self, sight: Sight, begins_s: Array, duration_s: float) -> HeldScans:
        scene = scene_of(sight.carrier.tables, self.reach, NOTHING, sight.places)
        held = hold_line(scene, begins_s, duration_s)
        within = np.ones(len(held), np.bool_)
        if sight.images and self.platform.directions:
            looks_s = np.linspace(0.0, duration_s, math.ceil(duration_s / OPTIONS.scan_step_s) + 1)
            for number, begin_s in enumerate(begins_s.tolist()):
                within[number] = np.all(self._kept_rad(sight, number, begin_s + looks_s) >= 0.0)
        return HeldScans(within, held & within)

    def _clear(self, sight: Sight, found: Found, shortest_s: float) -> Found:
        """Windows as far as the request's directions keep away, or stay near."""
        if not sight.images or not self.platform.directions:
            return found
        rows, edges_s, causes = [], [], []
        for row, (number, (rise_s, set_s)) in enumerate(
            zip(found.target.tolist(), found.edge_s.tolist(), strict=True)
        ):
            effort.charge(OPTIONS.window + OPTIONS.look * (set_s - rise_s))
            kept = partial(self._kept_rad_since, sight, number, rise_s)
            long_s = set_s - rise_s
            for start_s, stop_s in spans_above(kept, long_s):
                if stop_s - start_s < shortest_s:
                    continue
                ends_s = np.array([rise_s + start_s, rise_s + stop_s])
                unkept = KEPT + np.argmin(self._margins_rad(sight, number, ends_s), axis=0)
                rows.append(row)
                edges_s.append(ends_s)
                causes.append(
                    np.where([start_s == 0.0, stop_s == long_s], found.cause[row], unkept)
                )
        return Found(
            target=found.target[rows],
            edge_s=np.array(edges_s).reshape(-1, 2),
            cause=np.array(causes, dtype=found.cause.dtype).reshape(-1, 2),
            is_plain=found.is_plain[rows],
            looks=found.looks,
        )

    def _kept_rad_since(self, sight: Sight, number: int, begin_s: float, t_s: Array) -> Array:
        return self._kept_rad(sight, number, begin_s + t_s)

    def _kept_rad(self, sight: Sight, number: int, t_s: Array) -> Array:
        """The least margin of all directions at instants of a look at one target, (n,)."""
        return np.asarray(self._margins_rad(sight, number, t_s).min(axis=0))

    def _margins_rad(self, sight: Sight, number: int, t_s: Array) -> Array:
        """Of each direction, (k, n)."""
        carrier = sight.carrier
        instants = Instants(carrier.start_utc, t_s)
        states = carrier.states(instants)
        around, margins = Surroundings(instants, states), []
        for one in self.platform.directions:
            if one.direction_body is None:
                numbers = np.full(len(t_s), number)
                c_itrf, los_itrf = around.c_itrf_from_eci, sight.sighting(numbers, t_s)
                direction_eci = np.einsum("nji,nj->ni", c_itrf, los_itrf.direction_itrf)
            else:
                q_eci_from_body = self.attitude.q_body_from_eci(instants, states).inv()
                direction_eci = q_eci_from_body.apply(unit_vector(one.direction_body))
            margins.append(around.kept_margin_rad(one, direction_eci))
        return np.stack(margins)

    def kept_names(self, images: bool) -> tuple[str, ...]:
        return tuple(f"directions.{one.name}" for one in self.platform.directions)

    def narrowing(self) -> Iterator[Narrowing]:
        within = "no angles of the axes within their stops point there while it is in sight"
        hidden = "what stands in the platform's view hides it whenever the axes can point there"
        masked = replace(self.platform, directions=())
        yield Narrowing("reach", replace(masked, masks=()), within, "reach")
        if masked.masks:
            yield Narrowing("mask", masked, hidden, "mask")
        names, directions = self.kept_names(images=True), self.platform.directions
        for count, name in enumerate(names, start=1):
            kept = replace(masked, directions=directions[:count])
            told = replace(directions[count - 1], name=name)
            because = f"whenever the axes can point there{kept_before(count)}, {unkept_told(told)}"
            yield Narrowing("exclusion", kept, because, name)
