"""The outcomes of flights, run by run."""

from collections.abc import Mapping
from dataclasses import dataclass

from planner.base.arrays import Array, Mask


@dataclass(frozen=True, kw_only=True, eq=False)
class RunOutcomes:
    """What r runs made of one session, each (r,), and p pairs of them.

    holds, sharp: whether all frames hold the target, and whether all are sharp, too.
    holds_share, sharp_share: of the frames.  miss_rad: the largest angle between boresight and
    target; miss_m: that on the ground, across the line of sight, infinite for a target in the sky.
    smear_px: median of the frames.
    variance_px2: (p, 2), of the target's places in the image and of the smear, as two independent
    runs show them.  total_px2, first_px2: (p, 2, causes), half the square by which exchanging a
    cause moves a run away from itself, and leaves it away from the other.
    """

    holds: Mask
    sharp: Mask
    holds_share: Array
    sharp_share: Array
    miss_rad: Array
    miss_m: Array
    smear_px: Array
    variance_px2: Array
    total_px2: Array
    first_px2: Array

    @property
    def columns(self) -> Mapping[str, Array]:
        """By name."""
        return vars(self)
