"""All looks that one carrier can take: its windows, its ways to follow targets, its passes."""

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from typing import Any, NamedTuple, Self

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.at_once import done_at_once
from planner.base.commands import COMMAND_STEP_S
from planner.base.reporting import Reporter
from planner.planning.campaigns.candidates import LookCandidate, candidates_of, scan_roll
from planner.planning.campaigns.gaps import Gaps
from planner.planning.campaigns.network import Network, Rests, Slewing, network_of, relax
from planner.planning.campaigns.passes import SESSIONS_MAX, Looks, in_passes, longest_pass_s
from planner.planning.campaigns.path import Look
from planner.planning.campaigns.platforms.follower import FollowedLook, Follower
from planner.planning.campaigns.platforms.registry import follower_of
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.campaigns.view import Viewing
from planner.planning.campaigns.ways import ScannedLook, Ways, ways_to_follow
from planner.planning.opportunities import Windows, opportunities_however_many
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.closing import Closing, Unseen
from planner.planning.opportunities.scans import Scans, scans_by_pass
from planner.planning.opportunities.unseen import highest_of, unseen_because
from planner.world.frames.time_scales import shifted_utc
from planner.world.targets import GroundPathTarget


class _Aboard(NamedTuple):
    """What follows from the request of a carrier alone, as `CarrierLooks` has it."""

    follower: Follower
    carrier: Carrier
    viewing: Viewing
    grid_s: float
    settle_steps: int
    gaps: Gaps
    slewing: Slewing


_FOLLOWS = {*_Aboard._fields, "request", "candidates"}


@dataclass(frozen=True, kw_only=True, eq=False)
class CarrierWindows:
    """When one carrier can look at what; goes through pickle without what follows from the request,
    which carriers share, until it is `completed`.

    candidates: its own, by which everything here counts.  in_view: rows of targets with windows.
    grid_s: from the request's start to the grid's first step.  settle_steps: before every look.
    shortest: (candidates,), steps of the shortest look, settling included.
    """

    request: CampaignRequest
    follower: Follower
    carrier: Carrier
    viewing: Viewing
    grid_s: float
    candidates: tuple[LookCandidate, ...]
    in_view: frozenset[int]
    windows: "CandidateWindows"
    warnings: tuple[str, ...]
    scans: Scans
    looks: Looks
    settle_steps: int
    shortest: Indices
    slewing: Slewing
    gaps: Gaps

    def __getstate__(self) -> dict[str, Any]:
        found = {field.name for field in fields(self)}.difference(_FOLLOWS)
        return {name: getattr(self, name) for name in found}

    def completed(self, request: CampaignRequest) -> Self:
        """Again with the request that it is of, one of several carriers'."""
        candidates = candidates_of(request, self.scans.found, modes_by_pass=True)
        vars(self).update(_aboard(request)._asdict(), request=request, candidates=candidates)
        return self

    def ways_to(self, kept: Mask | None = None) -> Ways:
        """To follow all `looks`, or those kept."""
        rows = np.arange(len(self.looks.target)) if kept is None else np.flatnonzero(kept)
        return ways_to_follow(
            self.looks,
            rows,
            self.candidates,
            self._scanned,
            self.shortest,
            self.carrier,
            self.viewing,
            self.request.step_s,
            self.grid_s,
        )

    @property
    def _scanned(self) -> Mapping[int, ScannedLook]:
        return {
            number: ScannedLook(
                path_at=_path_at(one),
                roll=scan_roll(self.request, one.wanted),
                settle_steps=self.settle_steps,
                scan_steps=int(self.shortest[number]) - self.settle_steps,
            )
            for number, one in enumerate(self.candidates)
            if one.scans
        }

    def with_looks(
        self, tell: Reporter, kept: Mask | None = None, spare_quality: Array | None = None
    ) -> "CarrierLooks":
        """With the ways of all `looks`, or of those kept, and the slews between them."""
        ways = self.ways_to(kept)
        return CarrierLooks(
            **{field.name: getattr(self, field.name) for field in fields(self)},
            ways=ways,
            spare_quality=(
                np.zeros(len(self.candidates)) if spare_quality is None else spare_quality
            ),
            networks=_build_networks(ways, self.shortest, self.slewing, self.gaps, tell),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class CarrierLooks(CarrierWindows):
    """What one carrier can look at, and how its looks follow each other.

    spare_quality: (candidates,), of the best looks that are left out of `ways`; 0 of none.
    networks: one a pass.
    """

    ways: Ways
    spare_quality: Array
    networks: Sequence[Network]

    def pass_span_s(self, look_start_s: float, look_stop_s: float) -> tuple[float, float]:
        """When a pass with looks from start to stop begins at rest, and is at rest again."""
        rest_s = self.follower.rest_s
        # From an attitude of its own to the idle one, and from that onto a look.
        before_s = 0.0 if self.request.initial_q_body_from_eci_xyzw is None else rest_s
        start_s = look_start_s - rest_s
        return (
            self.grid_s if start_s < self.grid_s + before_s else start_s,
            min(look_stop_s + rest_s, last_row_s(self.request)),
        )

    def relaxed(self, number: int) -> Network:
        """A network at slew times that nothing can beat."""
        relaxed = relax(self.networks[number], self.ways, self.shortest, self.slewing)
        return self.gaps.keep(relaxed, self.shortest)

    def first_unheld(self, looks: tuple[Look, ...]) -> tuple[int, int] | None:
        """Of looks at its candidates by its ways, as `FirstUnheld`."""
        step_s, ways = self.request.step_s, self.ways
        followed = []
        for look in looks:
            one = self.candidates[look.target]
            start_s = self.grid_s + look.first_step * step_s
            length_s = one.lengths_s[look.length]
            step = look.first_step + math.ceil(length_s / step_s - 1e-9)
            at = ways.offset[look.way] + step - ways.first_step[look.way]
            row = None if one.scans else one.row
            followed.append(FollowedLook(row, start_s, start_s + length_s, ways.states[at]))
        found = self.follower.first_unheld(self.carrier, followed, self._followed_rows)
        return found and (found[0], math.floor((found[1] - self.grid_s) / step_s + 1e-9))

    @functools.cached_property
    def _followed_rows(self) -> Sequence[int]:
        """Of targets that there is a way to follow, modes apart."""
        ones = (self.candidates[number] for number in np.unique(self.ways.target).tolist())
        return [one.row for one in ones if not one.scans]

    def has_windows(self, row: int) -> bool:
        """Whether a target is in view at all, or a mode, whose scans have reasons of their own."""
        return row in self.request.modes or row in self.in_view

    @functools.cached_property
    def _numbers(self) -> Mapping[int, Sequence[int]]:
        """Candidates by the row of their target."""
        by_row: dict[int, list[int]] = {}
        for number, one in enumerate(self.candidates):
            by_row.setdefault(one.row, []).append(number)
        return by_row

    def highest_rad(self, rows: Sequence[int]) -> Sequence[float]:
        """The greatest elevation of these targets of the request."""
        if not rows:
            return ()
        best_rad, _ = highest_of(self.request.opportunities(), self.carrier, np.array(rows))
        return tuple(best_rad.tolist())

    def unseen(self, rows: Sequence[int]) -> tuple[Unseen, ...]:
        """Why there is no look at these targets of the request."""
        return unseen_because(
            self.request.opportunities(),
            self.carrier,
            rows,
            {row: self._closed_later(row) for row in rows if self.has_windows(row)},
        )

    def _closed_later(self, row: int) -> tuple[Closing, str]:
        """Why no observation of a target with windows that hold all conditions, or of a mode."""
        candidates, windows, resting = self.candidates, self.windows, self.follower.resting
        if row in self.scans.because:
            return "duration", self.scans.because[row]
        numbers = self._numbers.get(row, ())
        late: dict[object, bool] = {}
        for number in numbers:
            one = candidates[number]
            flown_with = one.scans[0].pass_number if one.is_part else row
            is_too_late = windows.is_too_late(number, one.lengths_s[0])
            late[flown_with] = late.get(flown_with, False) or is_too_late
        if late and all(late.values()):
            return "due", "no window long enough for a look is left from its release to its due"
        if row in self.request.modes:
            own_scans = [scan for number in numbers for scan in candidates[number].scans]
            lacking = [scan for scan in own_scans if not len(scan.begins_s)]
            if lacking:
                return "duration", (
                    f"scan {lacking[0].part} of {lacking[0].parts} can't be within the conditions "
                    "from its begin to its end"
                )
            return "motion", (
                "one of its scans can't be followed within what the platform can do, or has no "
                f"time {resting}"
            )
        own = windows.target == numbers[0]
        least_s = candidates[numbers[0]].lengths_s[0]
        longest_s = float((windows.set_s - windows.rise_s)[own].max())
        count = np.count_nonzero(own)
        several = f"the longest of its {count} windows" if count > 1 else "its only window"
        if longest_s < least_s:
            return (
                "duration",
                f"{several} lasts {longest_s:.1f} s, less than the {least_s:g} s of a look",
            )
        if not (self.looks.target == numbers[0]).any() or (self.ways.target == numbers[0]).any():
            return "rest", f"no {least_s:g} s of its windows are left beside the time {resting}"
        return "motion", (self.follower.unable.format(least_s=least_s))


def _aboard(request: CampaignRequest) -> _Aboard:
    follower, grid_s = follower_of(request), _first_row_s(request)
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    carrier = follower.carrier(ephemeris)
    settle_steps = math.ceil(follower.settle_s / request.step_s - 1e-9)
    gaps = Gaps(request, follower, settle_steps)
    return _Aboard(
        follower=follower,
        carrier=carrier,
        viewing=Viewing(
            weights=request.view, ephemeris=ephemeris, follower=follower, clouds=request.clouds
        ),
        grid_s=grid_s,
        settle_steps=settle_steps,
        gaps=gaps,
        slewing=_slewing_of(request, follower, gaps, carrier, grid_s),
    )


def looks_of_carrier(
    request: CampaignRequest, tell: Reporter, *, modes_by_pass: bool = False
) -> CarrierLooks:
    """All that there is to choose from.

    modes_by_pass: as in `candidates_of`.  Raises OutsideCoverage.
    """
    tell("opportunities", 0, 1)
    windows = windows_of_carrier(request, modes_by_pass=modes_by_pass)
    tell("ways", 0, 1)
    return windows.with_looks(tell)


def windows_of_carrier(request: CampaignRequest, *, modes_by_pass: bool) -> CarrierWindows:
    """When there is what to choose from; as `looks_of_carrier`."""
    aboard = _aboard(request)
    found = opportunities_however_many(request.opportunities())
    scans = scans_by_pass(request, request.modes, aboard.carrier, request.step_s)
    candidates = candidates_of(request, scans.found, modes_by_pass)
    windows = _windows_of(request, candidates, found.windows, aboard.follower.settle_s)
    return CarrierWindows(
        **aboard._asdict(),
        request=request,
        candidates=candidates,
        in_view=frozenset(found.windows.target.tolist()),
        windows=windows,
        warnings=found.warnings,
        scans=scans,
        looks=_looks_in_passes(request, candidates, windows, aboard.follower, aboard.gaps.rest_s),
        shortest=np.array(
            [aboard.settle_steps + one.length_steps(request.step_s)[0] for one in candidates],
            np.intp,
        ),
    )


def _path_at(one: LookCandidate) -> Callable[[float], GroundPathTarget]:
    return lambda begin_s: one.scan_at(begin_s).path


def _first_row_s(request: CampaignRequest) -> float:
    """Seconds from the start to the first command row, which counts from a whole UTC second."""
    row_us = round(COMMAND_STEP_S * 1e6)
    return (-request.start.microsecond % row_us) / 1e6


class CandidateWindows(NamedTuple):
    """When candidates can be looked at, (n,) each.

    longest_s: (candidates,), of any window, whatever release and due.
    """

    target: Indices
    rise_s: Array
    set_s: Array
    longest_s: Array

    def is_too_late(self, number: int, needed_s: float) -> bool:
        """Whether a candidate has windows so long, but none from release to due."""
        own = self.target == number
        left_s = (self.set_s - self.rise_s)[own].max(initial=0.0)
        return bool(left_s < needed_s - 1e-6 <= self.longest_s[number])


def _windows_of(
    request: CampaignRequest, candidates: Sequence[LookCandidate], found: Windows, settle_s: float
) -> CandidateWindows:
    """Of targets as found, of scans from the first begin, and settling before it, to the last
    one's end; all from release, and settling before it, to due."""
    parts, longest_s = [], np.zeros(len(candidates))
    by_target = np.argsort(found.target, kind="stable")
    edges_s = np.stack([found.rise_s, found.set_s], axis=1)[by_target]
    rows = [one.row for one in candidates]
    begins = np.searchsorted(found.target[by_target], rows, "left")
    ends = np.searchsorted(found.target[by_target], rows, "right")
    for number, one in enumerate(candidates):
        spans_s = edges_s[begins[number] : ends[number]]
        if one.scans:
            begins_s = np.concatenate([scan.begins_s for scan in one.scans])
            spans_s = begins_s + np.array([-settle_s, one.lengths_s[0]])
        longest_s[number] = np.diff(spans_s).max(initial=0.0)
        release_s, due_s = one.wanted.span_s(request.start)
        spans_s = np.clip(spans_s, release_s - settle_s, due_s)
        spans_s = spans_s[spans_s[:, 1] > spans_s[:, 0]]
        parts.append(np.insert(spans_s, 0, number, axis=1))
    columns = np.concatenate(parts).T if parts else np.empty((3, 0))
    return CandidateWindows(columns[0].astype(np.intp), columns[1], columns[2], longest_s)


def _looks_in_passes(
    request: CampaignRequest,
    candidates: Sequence[LookCandidate],
    windows: CandidateWindows,
    follower: Follower,
    apart_s: float,
) -> Looks:
    """apart_s: the room a pass needs at either end, beside another one."""
    least_s, rest_s = np.array([one.lengths_s[0] for one in candidates]), follower.rest_s
    sessions_max = SESSIONS_MAX - 2
    # Every observation is followed by one step of slewing at least, and each candidate has but one.
    shortest_s = float(least_s.min(initial=math.inf)) + request.step_s
    crowded_s = sessions_max * shortest_s if len(least_s) > sessions_max else math.inf
    # Its settling ends, and it begins, on the grid.
    longest_s = max((one.lengths_s[-1] for one in candidates), default=0.0)
    # The first look of all is slewed onto within the windows' time.
    whole_s = longest_s + follower.settle_s + 3.0 * request.step_s + rest_s
    return in_passes(
        windows.target,
        np.maximum(windows.rise_s, COMMAND_STEP_S),
        np.minimum(windows.set_s, request.span_s - COMMAND_STEP_S),
        least_s[windows.target],
        apart_s,
        min(longest_pass_s(whole_s, apart_s), crowded_s),
        whole_s,
    )


def first_utc(request: CampaignRequest) -> datetime:
    """Of the first command row."""
    return shifted_utc(request.start, _first_row_s(request))


def last_row_s(request: CampaignRequest) -> float:
    """Seconds from the start to the last command row."""
    rows = math.floor((request.span_s - _first_row_s(request)) / COMMAND_STEP_S + 1e-6)
    return _first_row_s(request) + rows * COMMAND_STEP_S


def _slewing_of(
    request: CampaignRequest, follower: Follower, gaps: Gaps, carrier: Carrier, grid_s: float
) -> Slewing:
    back_s = last_row_s(request) - follower.held_s
    rests = Rests(
        start_state=follower.start_state(carrier, grid_s),
        stop_state=follower.rest_state(carrier, back_s),
        stop_s=back_s - grid_s,
    )
    return Slewing(follower.slew_limits, rests, gaps.longest_s)


def _build_networks(
    ways: Ways, shortest: Indices, slewing: Slewing, gaps: Gaps, tell: Reporter
) -> list[Network]:
    numbers = np.unique(ways.pass_number)

    def build_network(number: int) -> Network:
        rows = np.flatnonzero(ways.pass_number == number)
        return gaps.keep(network_of(ways, rows, shortest, slewing), shortest)

    networks: list[Network] = []
    for one in done_at_once(build_network, numbers.tolist()):
        tell("slews", len(networks), len(numbers))
        networks.append(one)
    return networks
