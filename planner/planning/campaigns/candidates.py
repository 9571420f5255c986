"""Candidates of a campaign: targets, and the scans of imaging modes in every pass."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from planner.planning.campaigns.request import CampaignRequest, CampaignTarget
from planner.planning.opportunities.scans import ModeScan
from planner.world.platforms import RollRule
from planner.world.rules.registry import rules_of
from planner.world.targets import ImagingMode, Target


class LookCandidate(NamedTuple):
    """A target, or a scan of an imaging mode, which stands for the middle of its line where it is
    looked up as a place.

    row: of the request's targets.  wanted: that one.  scans: none of a target; of a mode that is
    one scan in every pass all of them, else the one.  is_part: whether it is one of the scans that
    are all done in one pass or none, maybe the only one.
    """

    row: int
    wanted: CampaignTarget
    scans: tuple[ModeScan, ...] = ()
    is_part: bool = False

    @property
    def target(self) -> Target:
        """As a place."""
        if self.scans:
            return self.scans[0].middle
        assert not isinstance(self.wanted.target, ImagingMode)
        return self.wanted.target

    @property
    def roll(self) -> RollRule | None:
        """On it as a place."""
        return None if self.scans else self.wanted.roll

    @property
    def lengths_s(self) -> tuple[float, ...]:
        """The lengths a look may have, ascending, whole command steps."""
        if self.scans:
            return (self.scans[0].duration_s,)
        return self.wanted.lengths_s

    def length_steps(self, step_s: float) -> tuple[int, ...]:
        """The same on the grid."""
        return tuple(math.ceil(length_s / step_s - 1e-9) for length_s in self.lengths_s)

    @property
    def looks(self) -> int:
        return 1 if self.is_part else self.wanted.looks

    def worth_value(self, length_s: float) -> float:
        """The worth of a look that lasts so long at the best view; a scan's share of its mode's."""
        if self.scans:
            return self.wanted.priority * self.scans[0].share
        return self.wanted.worth_value(length_s)

    def scan_at(self, begin_s: float) -> ModeScan:
        """That which begins then."""
        return min(self.scans, key=lambda scan: scan.apart_s(begin_s))


def candidates_of(
    request: CampaignRequest, scans: Sequence[ModeScan], modes_by_pass: bool
) -> tuple[LookCandidate, ...]:
    """Targets that are no modes, in order, then scans.

    modes_by_pass: whether a mode that is one scan in every pass is nevertheless a part in each,
    since another carrier may need several for it.
    """
    found = [
        LookCandidate(row, wanted)
        for row, wanted in enumerate(request.targets)
        if not isinstance(wanted.target, ImagingMode)
    ]
    by_row: dict[int, list[ModeScan]] = {}
    for scan in scans:
        by_row.setdefault(scan.row, []).append(scan)
    for row, own in by_row.items():
        is_single = not modes_by_pass and all(scan.parts == 1 for scan in own)
        found += [
            LookCandidate(row, request.targets[row], together, not is_single)
            for together in ([tuple(own)] if is_single else [(scan,) for scan in own])
        ]
    return tuple(found)


def scan_roll(request: CampaignRequest, wanted: CampaignTarget) -> RollRule | None:
    """How a platform lies on the lines of a mode."""
    return wanted.roll or rules_of(request.platform).scan_roll
