"""Looks that a campaign may take at each target, and what they are worth at prices."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from planner.base.arrays import Array, Indices, Mask, rank_among
from planner.planning.campaigns.path import NOT_HELD, Look, Worth

FirstUnheld = Callable[[tuple[Look, ...]], tuple[int, int] | None]
"""The first look that those before it don't let be held, and the last step at which it is not."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Looking:
    """What looks at each target may be.

    length_steps, look_value: (targets, lengths), steps on the grid and what it is worth at the
    best view; 0 for lengths there are not.  look_limit: (targets,).
    group: number of each target's group, whose members are all looked at or none; -1 of none.
    way_to: (groups,), number of what a group is one way to do.  way_limit: how many of its ways are
    taken at most.  settle_steps: (networks,), before a look begins in that pass.
    held_steps: whole steps that a look lasts at least, as length_steps.
    spare_value: (targets,), no look that the networks leave out is worth more; 0 of groups.
    """

    length_steps: Indices
    look_value: Array
    look_limit: Array
    group: Indices
    way_to: Indices
    way_limit: Array
    settle_steps: Indices
    held_steps: Indices = field(default_factory=lambda: NOT_HELD)
    spare_value: Array = field(default_factory=lambda: np.zeros(1))

    @property
    def groups(self) -> int:
        """How many there are."""
        return int(self.group.max(initial=-1)) + 1

    def members(self, group: int) -> Indices:
        """Its targets."""
        return np.flatnonzero(self.group == group)

    def allowed(self, price: Array) -> Array:
        """How many looks at each target pay most at these prices, (targets,): a group's members
        one each, or none, and of the ways to do one thing the best.  Prices of members may be
        negative."""
        together = np.asarray(np.bincount(self.group + 1, price, self.groups + 1)[1:], np.float64)
        taken = self.best_ways(together)
        return np.where(self.group < 0, self.look_limit, np.append(taken, 0.0)[self.group])

    def best_ways(self, value: Array) -> Mask:
        """Groups worth something, (groups,), as many of the best as are taken of ways to do one
        thing."""
        taken = rank_among(self.way_to, value) < self.way_limit[self.way_to]
        return np.asarray(taken & (value > 0.0))

    def beside(self, price: Array) -> float:
        """What all looks allowed pay at these prices, and those that no network has gain."""
        spare = self._spare_looks(price) * (self.spare_value - price)
        return float(self.allowed(price) @ price + spare.sum())

    def _spare_looks(self, price: Array) -> Array:
        """How many looks that no network has would gain at these prices, (targets,)."""
        gains = (self.group < 0) & (self.spare_value > price)
        return np.where(gains, self.look_limit, 0.0)

    def wanted(self, passes: Iterable[Sequence[Look]], price: Array) -> Array:
        """Looks taken at these prices beyond those that pay most, (targets,)."""
        return self.looks_of(passes) + self._spare_looks(price) - self.allowed(price)

    def less_prices(self, price: Array) -> Worth:
        """The worth less a price for each observation, (targets,)."""
        return Worth(self.length_steps, self.look_value, price, held_steps=self.held_steps)

    def settled(self, worth: Worth, network: int) -> Worth:
        """The same with the time that a look in that pass takes to settle."""
        settle_steps = int(self.settle_steps[network])
        if not settle_steps:
            return worth
        if settle_steps not in self._settled_steps:
            steps = np.where(self.length_steps > 0, self.length_steps + settle_steps, 0)
            self._settled_steps[settle_steps] = steps
        return worth._replace(steps=self._settled_steps[settle_steps], settle_steps=settle_steps)

    @cached_property
    def _settled_steps(self) -> dict[int, Indices]:
        """length_steps with so many more, by how many."""
        return {}

    def looks_of(self, passes: Iterable[Sequence[Look]]) -> Array:
        """How many observations each target gets, (targets,)."""
        target = [one for looks in passes for one in targets_of(looks)]
        return np.bincount(target, minlength=len(self.look_limit)).astype(np.float64)


def targets_of(looks: Sequence[Look]) -> list[int]:
    """Of a pass, each once."""
    return [one.target for one in looks]
