"""The flight of two axes: drives as they are and as they may be, on a carrier that turns."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import CommandTable
from planner.base.rotation import Rotation
from planner.inflight.simulation.flight import FlownMotion, fly
from planner.inflight.simulation.platforms.flyer import ATTITUDE, CLOCK, EARTH, ORBIT
from planner.world.attitude import AttitudeErrors
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms import AxisDrive
from planner.world.platforms.drive import (
    CABLE_STIFFNESS_MAX_PER_S2,
    CABLE_TENSION_MAX_DEG_S2,
    FRICTION_MAX_DEG_S2,
    VISCOUS_MAX_PER_S,
)
from planner.world.rules.two_axis import axes_of
from planner.world.scenario import Scenario

DRIVE = "drive"
# What temperature and age change; the loop is software and stays.  A fifth is assumed.
TOLERANCE = 0.2
# Which of them is drawn, and the most that a drive may have of it.
_TOGETHER = {"coulomb_deg_s2": FRICTION_MAX_DEG_S2, "breakaway_deg_s2": FRICTION_MAX_DEG_S2}
_EACH = {
    "viscous_per_s": VISCOUS_MAX_PER_S,
    "cable_tension_deg_s2": CABLE_TENSION_MAX_DEG_S2,
    "cable_stiffness_per_s2": CABLE_STIFFNESS_MAX_PER_S2,
}
_FARTHEST_SIGMAS = 3.0


@dataclass(frozen=True)
class TwoAxisFlyer:
    """As `Flyer` says; the base turns by an attitude law."""

    causes: ClassVar[tuple[str, ...]] = (ORBIT, ATTITUDE, EARTH, CLOCK, DRIVE)
    flown_causes: ClassVar[tuple[str, ...]] = (DRIVE,)
    lead_s: ClassVar[float] = 10.0
    scenario: Scenario

    def q_base_from_eci(
        self, instants: Instants, states: OrbitStates, turned_body_rad: Array | None = None
    ) -> Rotation:
        q_base_from_body = axes_of(self.scenario).q_platform_from_body
        if turned_body_rad is not None:
            q_base_from_body = q_base_from_body * Rotation.from_rotvec(-turned_body_rad)
        return q_base_from_body * self.scenario.law.q_body_from_eci(instants, states)

    def base_errors(self, instants: Instants) -> AttitudeErrors:
        return self.scenario.law.errors(instants)

    def fly(
        self, table: CommandTable, from_s: float, session: int, seeds: Mapping[str, int] | None
    ) -> FlownMotion:
        """A seed draws each axis's friction and cable, log-normal about the platform's, and noise.

        The noise is another in each session, friction and cables are the same in all.
        """
        platform = axes_of(self.scenario)
        if seeds is None:
            return fly(table, platform, seed=session)
        random = np.random.default_rng(seeds[DRIVE])
        outer, inner = (_drawn(drive, random) for drive in platform.drives)
        # From 1 on: a last 0 would make the stream of the seed alone.
        return fly(table, platform, drives=(outer, inner), seed=(seeds[DRIVE], 1 + session))


def _drawn(drive: AxisDrive, random: np.random.Generator) -> AxisDrive:
    sigmas = np.clip(random.standard_normal(1 + len(_EACH)), -_FARTHEST_SIGMAS, _FARTHEST_SIGMAS)
    factors = [math.exp(TOLERANCE * sigma) for sigma in sigmas]
    factor_of = dict.fromkeys(_TOGETHER, factors[0]) | dict(zip(_EACH, factors[1:], strict=True))
    most = _TOGETHER | _EACH
    changed = {
        name: min(max(getattr(drive, name) * factor, -most[name]), most[name])
        for name, factor in factor_of.items()
    }
    return replace(drive, **changed)
