"""The search for windows of two axes on a carrier that somebody else steers."""

from dataclasses import replace

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.motion.pointing.reach import reach_of
from planner.planning.opportunities.closing import Closing
from planner.planning.opportunities.margins import NOTHING, WindowScene
from planner.planning.opportunities.platforms.lookout import HeldScans
from planner.planning.opportunities.request import OpportunityConditions
from planner.planning.opportunities.sessions import hold, hold_line
from planner.planning.opportunities.sights import Sight
from planner.planning.opportunities.sweep import Found
from planner.planning.opportunities.windows import Cause
from planner.world.attitude import AttitudeLaw, LvlhAttitude
from planner.world.attitude.lvlh import level_warnings
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms import AnyPlatform, TwoAxisPlatform


class TwoAxisLookout:
    """As `Lookout` says; the base is the mounting plate."""

    has_branches = True
    settle_s = 0.0

    def __init__(self, platform: AnyPlatform, attitude: AttitudeLaw | None) -> None:
        if not isinstance(platform, TwoAxisPlatform):
            raise TypeError(f"{platform.name} has no two axes")
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
        return (found, *hold(scene, found, looks_limit))

    def held_scans(self, sight: Sight, begins_s: Array, duration_s: float) -> HeldScans:
        scene = WindowScene(sight.carrier.tables, self.reach, NOTHING, sight.places)
        held = hold_line(scene, begins_s, duration_s)
        return HeldScans(np.ones(len(held), np.bool_), held)

    def narrowing(self) -> tuple[tuple[Closing, AnyPlatform, str], ...]:
        within = "no angles of the axes within their stops point there while it is in sight"
        hidden = "what stands in the platform's view hides it whenever the axes can point there"
        bare = replace(self.platform, masks=())
        steps: tuple[tuple[Closing, AnyPlatform, str], ...] = (("reach", bare, within),)
        return (*steps, ("mask", self.platform, hidden)) if self.platform.masks else steps
