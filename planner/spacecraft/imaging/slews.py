"""Slews between scans, of the times that suffice or are needed in a campaign of any body."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S
from planner.base.compiled import compiled
from planner.base.rotation import Rotation
from planner.planning.campaigns.platforms.body import OPTIONS as FOLLOWING
from planner.planning.campaigns.platforms.body import moving_state, slew_limits
from planner.planning.campaigns.platforms.slew_fits import (
    SUFFICIENT,
    FollowerLimits,
    slew_fits,
)
from planner.world.platforms import BodyPlatform


@dataclass(frozen=True, kw_only=True)
class Slews:
    """Of a body.  more_s: added to what suffices, so that slews are gentler.

    Ends are states as `body_fits` takes them, (n, 11): a scan's entry that in which its line is
    joined, settle_s before it begins.
    """

    platform: BodyPlatform
    more_s: float = 0.0

    @cached_property
    def _limits(self) -> tuple[FollowerLimits, float]:
        return slew_limits(self.platform)

    @property
    def settle_s(self) -> float:
        """On a line before its scan begins."""
        return self.platform.envelope.settle_s

    def states(self, q_eci_from_body_after: Callable[[float], Rotation]) -> Array:
        """Of n attitudes, which are told some seconds later."""
        return moving_state(
            *(q_eci_from_body_after(s) for s in (-FOLLOWING.delta_s, 0.0, FOLLOWING.delta_s))
        )

    @property
    def widest_ticks(self) -> int:
        """The most from any scan's end to another's begin."""
        return math.ceil((self._limits[1] + self.settle_s + self.more_s) / COMMAND_STEP_S)

    def fit(
        self,
        exit_states: Array,
        entry_states: Array,
        before: Indices,
        after: Indices,
        ticks: Indices,
        sign: float = SUFFICIENT,
    ) -> Mask:
        """Whether so many ticks from scan's end to scan's begin suffice, by numbers of the ends;
        sign: as of `slew_fits`."""
        left_s = np.asarray(ticks * COMMAND_STEP_S - self.settle_s - self.more_s + 1e-9, np.float64)
        limits, _ = self._limits
        return np.asarray(_fit(exit_states, entry_states, before, after, limits, sign, left_s))

    def ticks(self, exit_states: Array, entry_states: Array) -> Indices:
        """Whole ticks that suffice from each of n ends to its counterpart."""
        each = np.arange(len(exit_states))
        too_few, enough = (
            np.zeros(len(exit_states), np.intp),
            np.full(len(exit_states), self.widest_ticks),
        )
        while (enough - too_few).max(initial=0) > 1:
            middle = (too_few + enough) // 2
            fits = self.fit(exit_states, entry_states, each, each, middle)
            too_few, enough = np.where(fits, too_few, middle), np.where(fits, middle, enough)
        return enough


@compiled
def _fit(
    exit_states: Array,
    entry_states: Array,
    before: Indices,
    after: Indices,
    limits: FollowerLimits,
    sign: float,
    available_s: Array,
) -> Mask:
    fits = np.empty(len(before), np.bool_)
    for k in range(len(before)):
        start, end = exit_states[before[k]], entry_states[after[k]]
        fits[k] = available_s[k] > 0.0 and slew_fits(start, end, limits, sign, available_s[k])
    return fits
