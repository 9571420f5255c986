"""A table flown by a platform's drives, as they are and as they may be."""

import math
from dataclasses import replace

import numpy as np

from planner.base.commands import CommandTable
from planner.inflight.flights.runs import Fly
from planner.inflight.simulation.flight import FlownMotion, fly
from planner.world.platforms import AxisDrive, TwoAxisPlatform
from planner.world.platforms.drive import (
    CABLE_STIFFNESS_MAX_PER_S2,
    CABLE_TENSION_MAX_DEG_S2,
    FRICTION_MAX_DEG_S2,
    VISCOUS_MAX_PER_S,
)

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


def flown_by(platform: TwoAxisPlatform) -> Fly:
    """A seed draws each axis's friction and cable, log-normal about the platform's, and noise.

    The noise is another in each session, friction and cables are the same in all.
    """

    def fly_once(table: CommandTable, session: int, seed: int | None) -> FlownMotion:
        if seed is None:
            return fly(table, platform, seed=session)
        random = np.random.default_rng(seed)
        outer, inner = (_drawn(drive, random) for drive in platform.drives)
        # From 1 on: a last 0 would make the stream of the seed alone.
        return fly(table, platform, drives=(outer, inner), seed=(seed, 1 + session))

    return fly_once


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
