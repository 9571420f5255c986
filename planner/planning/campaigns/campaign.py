"""From targets over days to the sessions of every pass: the whole choice on one screen."""

import functools
import itertools
import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, replace
from datetime import datetime
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import figures
from planner.base.reporting import Reporter, tell_nobody
from planner.planning.campaigns.candidates import LookCandidate, candidates_of, scan_roll
from planner.planning.campaigns.choice import CampaignChoice, FirstUnheld, Looking
from planner.planning.campaigns.chosen import ChosenLook, UnchosenTarget
from planner.planning.campaigns.displaced import Displaced, displaced_by
from planner.planning.campaigns.gaps import Gaps
from planner.planning.campaigns.keeping import bound_keeping, choose_keeping
from planner.planning.campaigns.network import Network, Rests, Slewing, network_of, relax
from planner.planning.campaigns.passes import SESSIONS_MAX, Looks, in_passes, longest_pass_s
from planner.planning.campaigns.path import Look
from planner.planning.campaigns.platforms.follower import FollowedLook, Follower
from planner.planning.campaigns.platforms.registry import follower_of
from planner.planning.campaigns.request import BOUNDS as CAMPAIGN_BOUNDS
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.campaigns.resources import Keeping, RunsOut
from planner.planning.campaigns.view import Viewing
from planner.planning.campaigns.ways import ScannedLook, Ways, ways_to_follow
from planner.planning.opportunities import Windows, opportunities_however_many
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.closing import Closing, Unseen
from planner.planning.opportunities.scans import Scans, scans_by_pass
from planner.planning.opportunities.unseen import unseen_because
from planner.world.conditions import Conditions
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.resources import Resources
from planner.world.scenario import Scenario, Session
from planner.world.targets import GroundPathTarget, ImagingMode


@dataclass(frozen=True, kw_only=True)
class ChosenPass:
    """Looks in order of time, with the platform at rest from start and again by stop.

    resources: as the passes before leave them, where the campaign has any.
    """

    start_utc: datetime
    stop_utc: datetime
    looks: tuple[ChosenLook, ...]
    resources: Resources | None = None


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """Passes in order of time.

    The first may begin on the start, where the platform rests, and the last end on the stop.
    value: what the looks are worth together.  bound: no choice is worth more whose looks
    begin on the grid, have one of the lengths tried and lie in the same passes.
    greedy_value: worth of the choice that takes whatever is worth most in each pass, one pass after
    another.
    windows: number of windows to choose from.
    unseen: targets that can't be looked at for as long as they must.  left_out: that can, but
    others are worth more.
    """

    passes: tuple[ChosenPass, ...]
    value: float
    bound: float
    greedy_value: float
    windows: int
    unseen: tuple[Unseen, ...]
    left_out: tuple[UnchosenTarget, ...]
    warnings: tuple[str, ...]

    @property
    def gap_share(self) -> float:
        """How much more than `value` there could be at most, as a share of the bound."""
        return 1.0 - self.value / self.bound if self.bound > 0.0 else 0.0


def choose_campaign(request: CampaignRequest, tell: Reporter = tell_nobody) -> Campaign:
    """Choose sessions and their order.

    tell: is called with what is being done, and how many parts of how many are done.
    Slew times are those of `slew_time`: without hard stops on the way and
    without cones to keep out of, which planning the passes then may find in the way.
    Raises OutsideCoverage.
    """
    tell("opportunities", 0, 1)
    follower = follower_of(request)
    grid_s = _first_row_s(request)
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    carrier = follower.carrier(ephemeris)
    found = opportunities_however_many(request.opportunities())
    scans = scans_by_pass(request, request.modes, carrier, request.step_s)
    candidates = candidates_of(request, scans.found)
    windows = _windows_of(request, candidates, found.windows, follower.settle_s)
    looking = _looking_of(request, candidates, follower.settle_s)
    gaps = Gaps(request, follower, looking.settle_steps)
    looks = _looks_in_passes(request, candidates, windows, follower, gaps.rest_s)
    tell("ways", 0, 1)
    viewing = Viewing(
        weights=request.view, ephemeris=ephemeris, follower=follower, clouds=request.clouds
    )
    shortest = looking.length_steps[:, 0]
    scanned = {
        number: ScannedLook(
            path_at=_path_at(one),
            roll=scan_roll(request, one.wanted),
            settle_steps=looking.settle_steps,
            scan_steps=int(shortest[number]) - looking.settle_steps,
        )
        for number, one in enumerate(candidates)
        if one.scans
    }
    ways = ways_to_follow(
        looks, candidates, scanned, shortest, carrier, viewing, request.step_s, grid_s
    )
    slewing = _slewing_of(request, follower, gaps, carrier, grid_s)
    networks = _build_networks(ways, shortest, slewing, gaps, tell)
    first_unheld = _first_unheld_by(request, candidates, ways, follower, carrier, grid_s)
    seen = set(np.unique(ways.target).tolist())
    unseen = [number for number in range(len(candidates)) if number not in seen]
    # A group that lacks a target is worth nothing.
    hopeful = ~np.isin(looking.group, looking.group[unseen]) | (looking.group < 0)
    hopeful_looking = replace(looking, look_value=looking.look_value * hopeful[:, None])
    keeping = None
    if request.resources is not None:
        keeping = Keeping(request, candidates, ways, networks, looking, ephemeris, grid_s, follower)
    choice, rows = choose_keeping(keeping, networks, hopeful_looking, tell, first_unheld)
    tell("bound", 0, 1)
    # At slew times that nothing can beat.
    with _thread_count() as threads:
        optimistic = [
            gaps.keep(one, shortest)
            for one in threads.map(lambda one: relax(one, ways, shortest, slewing), networks)
        ]
    bound = bound_keeping(keeping, optimistic, hopeful_looking, choice, rows)
    looked_at = {candidates[look.target].row for one in choice.passes for look in one}
    left_out = displaced_by(
        networks,
        choice.passes,
        looking.less_prices(np.zeros(len(candidates))),
        np.array(
            sorted(number for number in seen if candidates[number].row not in looked_at), np.intp
        ),
    )
    told = _left_out(request, candidates, left_out, grid_s, unseen, choice, keeping)
    hidden = sorted(
        {one.row for one in candidates}.union(scans.because).difference(
            looked_at, (one.row for one in told)
        )
    )
    return Campaign(
        passes=_in_utc(request, candidates, choice, grid_s, carrier, viewing, keeping),
        value=choice.value,
        bound=max(bound, choice.value),
        greedy_value=choice.greedy_value,
        windows=len(windows.target),
        unseen=unseen_because(
            request.opportunities(),
            carrier,
            hidden,
            {
                row: _closed_later(request, candidates, row, windows, looks, ways, scans, follower)
                for row in hidden
                if row in request.modes or (found.windows.target == row).any()
            },
        ),
        left_out=told,
        warnings=found.warnings,
    )


def scenario_of(request: CampaignRequest, flight: ChosenPass, number: int) -> Scenario:
    """The pass as it is to be planned: from rest over all observations to rest.

    What a slew lacks, its neighbours give where none of them scans: slew times were estimated
    without stops.
    """
    ends = follower_of(request).pass_ends(
        flight.start_utc, flight.stop_utc, is_first=flight.start_utc == _first_utc(request)
    )
    return Scenario(
        name=f"{request.name or 'campaign'}, pass {number + 1}",
        orbit=request.orbit,
        attitude=ends.attitude,
        platform=request.platform,
        initial_state=ends.initial_state,
        sessions=(
            *(_session_of(request, look) for look in flight.looks),
            *ends.rest,
        ),
        slew=ends.slew,
        # What a slew took from a scan would be missing from its line.
        on_conflict="refuse" if any(look.path for look in flight.looks) else "least_loss",
        final_state=ends.final_state,
        final_by=ends.final_by,
        conditions=_conditions_of(request),
        resources=flight.resources,
    )


def _conditions_of(request: CampaignRequest) -> Conditions:
    """Of a plan, whose pixel is that of the platform's camera."""
    asked = request.conditions
    kept = {field.name: getattr(asked, field.name) for field in fields(Conditions)}
    if asked.max_ground_sample_m is not None:
        pixel_ratio = request.platform.camera.pixel_rad / request.opportunities().pixel_rad
        kept["max_ground_sample_m"] = asked.max_ground_sample_m * pixel_ratio
    return Conditions(**kept)


def _path_at(one: LookCandidate) -> Callable[[float], GroundPathTarget]:
    return lambda begin_s: one.scan_at(begin_s).path


def _session_of(request: CampaignRequest, look: ChosenLook) -> Session:
    wanted = request.targets[look.row]
    if look.path is None:
        assert not isinstance(wanted.target, ImagingMode)
        return Session(
            id=look.target,
            target=wanted.target.with_heights(),
            start=look.start_utc,
            stop=look.stop_utc,
            roll=wanted.roll,
        )
    is_alone = look.parts == 1
    return Session(
        id=look.target if is_alone else f"{look.target}-{look.part}",
        name=None if is_alone else f"{look.target} {look.part}/{look.parts}",
        target=look.path.with_heights(),
        start=look.start_utc,
        stop=look.stop_utc,
        roll=scan_roll(request, wanted),
        of=look.target,
    )


def _first_row_s(request: CampaignRequest) -> float:
    """Seconds from the start to the first command row, which counts from a whole UTC second."""
    row_us = round(COMMAND_STEP_S * 1e6)
    return (-request.start.microsecond % row_us) / 1e6


class _Windows(NamedTuple):
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
) -> _Windows:
    """Of targets as found, of scans from the first begin, and settling before it, to the last
    one's end; all from release, and settling before it, to due."""
    parts, longest_s = [], np.zeros(len(candidates))
    for number, one in enumerate(candidates):
        own = found.target == one.row
        spans_s = np.stack([found.rise_s[own], found.set_s[own]], axis=1)
        if one.scans:
            begins_s = np.concatenate([scan.begins_s for scan in one.scans])
            spans_s = begins_s + np.array([-settle_s, one.lengths_s[0]])
        longest_s[number] = np.diff(spans_s).max(initial=0.0)
        release_s, due_s = one.wanted.span_s(request.start)
        spans_s = np.clip(spans_s, release_s - settle_s, due_s)
        spans_s = spans_s[spans_s[:, 1] > spans_s[:, 0]]
        parts.append(np.insert(spans_s, 0, number, axis=1))
    columns = np.concatenate(parts).T if parts else np.empty((3, 0))
    return _Windows(columns[0].astype(np.intp), columns[1], columns[2], longest_s)


def _looks_in_passes(
    request: CampaignRequest,
    candidates: Sequence[LookCandidate],
    windows: _Windows,
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


def _looking_of(
    request: CampaignRequest, candidates: Sequence[LookCandidate], settle_s: float
) -> Looking:
    settle_steps = math.ceil(settle_s / request.step_s - 1e-9)
    # A group by its name, the scans of a mode in one pass by that, and what each is a way to do.
    names: dict[object, int] = {}
    things: dict[object, int] = {}
    group, way_to, way_limit = np.full(len(candidates), -1, np.intp), [], []
    length_steps = np.zeros((len(candidates), CAMPAIGN_BOUNDS.lengths), np.intp)
    held_steps = np.zeros_like(length_steps)
    look_value = np.zeros((len(candidates), CAMPAIGN_BOUNDS.lengths))
    for number, one in enumerate(candidates):
        for place, length_s in enumerate(one.lengths_s):
            length_steps[number, place] = settle_steps + math.ceil(length_s / request.step_s - 1e-9)
            held_steps[number, place] = math.floor(length_s / request.step_s + 1e-9)
            look_value[number, place] = one.worth_value(length_s)
        name = one.scans[0].pass_number if one.is_part else one.wanted.group
        if name is None:
            continue
        if name not in names:
            names[name] = len(names)
            thing = one.row if one.is_part else one.wanted.group
            if thing not in things:
                things[thing] = len(things)
                way_limit.append(float(one.wanted.looks))
            way_to.append(things[thing])
        group[number] = names[name]
    return Looking(
        length_steps=length_steps,
        look_value=look_value,
        look_limit=np.array([float(one.looks) for one in candidates]),
        group=group,
        way_to=np.array(way_to, np.intp),
        way_limit=np.array(way_limit),
        settle_steps=settle_steps,
        held_steps=held_steps,
    )


def _first_unheld_by(
    request: CampaignRequest,
    candidates: Sequence[LookCandidate],
    ways: Ways,
    follower: Follower,
    carrier: Carrier,
    grid_s: float,
) -> FirstUnheld:
    @functools.cache
    def first_unheld(looks: tuple[Look, ...]) -> tuple[int, int] | None:
        followed = []
        for look in looks:
            one = candidates[look.target]
            start_s = grid_s + look.first_step * request.step_s
            length_s = one.lengths_s[look.length]
            step = look.first_step + math.ceil(length_s / request.step_s - 1e-9)
            at = ways.offset[look.way] + step - ways.first_step[look.way]
            row = None if one.scans else one.row
            followed.append(FollowedLook(row, start_s, start_s + length_s, ways.states[at]))
        found = follower.first_unheld(carrier, followed)
        return found and (found[0], math.floor((found[1] - grid_s) / request.step_s + 1e-9))

    return first_unheld


def _first_utc(request: CampaignRequest) -> datetime:
    return shifted_utc(request.start, _first_row_s(request))


def _last_row_s(request: CampaignRequest) -> float:
    """Seconds from the start to the last command row."""
    rows = math.floor((request.span_s - _first_row_s(request)) / COMMAND_STEP_S + 1e-6)
    return _first_row_s(request) + rows * COMMAND_STEP_S


def _slewing_of(
    request: CampaignRequest, follower: Follower, gaps: Gaps, carrier: Carrier, grid_s: float
) -> Slewing:
    back_s = _last_row_s(request) - follower.held_s
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
    with _thread_count() as threads:
        for one in threads.map(build_network, numbers.tolist()):
            tell("slews", len(networks), len(numbers))
            networks.append(one)
    return networks


def _thread_count() -> ThreadPoolExecutor:
    """The number of cores: slew times are compiled, free of the interpreter's lock."""
    return ThreadPoolExecutor(os.cpu_count())


def _closed_later(
    request: CampaignRequest,
    candidates: Sequence[LookCandidate],
    row: int,
    windows: _Windows,
    looks: Looks,
    ways: Ways,
    scans: Scans,
    follower: Follower,
) -> tuple[Closing, str]:
    """Why no observation of a target with windows that hold all conditions, or of a mode."""
    if row in scans.because:
        return "duration", scans.because[row]
    numbers = [number for number, one in enumerate(candidates) if one.row == row]
    late: dict[object, bool] = {}
    for number in numbers:
        one = candidates[number]
        flown_with = one.scans[0].pass_number if one.is_part else row
        is_too_late = windows.is_too_late(number, one.lengths_s[0])
        late[flown_with] = late.get(flown_with, False) or is_too_late
    if late and all(late.values()):
        return "due", "no window long enough for a look is left from its release to its due"
    if row in request.modes:
        own_scans = [scan for number in numbers for scan in candidates[number].scans]
        lacking = [scan for scan in own_scans if not len(scan.begins_s)]
        if lacking:
            return "duration", (
                f"scan {lacking[0].part} of {lacking[0].parts} can't be within the conditions from "
                "its begin to its end"
            )
        return "motion", (
            "one of its scans can't be followed within what the platform can do, or has no time "
            f"{follower.resting}"
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
    if not (looks.target == numbers[0]).any() or (ways.target == numbers[0]).any():
        return "rest", (
            f"no {least_s:g} s of its windows are left beside the time {follower.resting}"
        )
    return "motion", (follower.unable.format(least_s=least_s))


def _left_out(
    request: CampaignRequest,
    candidates: Sequence[LookCandidate],
    left_out: Sequence[Displaced],
    grid_s: float,
    unseen: Sequence[int],
    choice: CampaignChoice,
    keeping: Keeping | None,
) -> tuple[UnchosenTarget, ...]:
    """Of each target, by the scan of it that comes first."""
    told: dict[int, UnchosenTarget] = {}
    lacking = {
        one.scans[0].pass_number for one in (candidates[number] for number in unseen) if one.is_part
    }
    for one in left_out:
        candidate = candidates[one.target]
        if candidate.is_part and candidate.scans[0].pass_number in lacking:
            continue
        if candidate.row not in told:
            out = None if keeping is None else keeping.lacks(choice.passes, one)
            told[candidate.row] = _unchosen(request, candidates, one, grid_s, unseen, out)
    return tuple(told[row] for row in sorted(told))


def _unchosen(
    request: CampaignRequest,
    candidates: Sequence[LookCandidate],
    one: Displaced,
    grid_s: float,
    unseen: Sequence[int],
    out: RunsOut | None,
) -> UnchosenTarget:
    candidate = candidates[one.target]
    start_utc = shifted_utc(request.start, grid_s + one.first_step * request.step_s)
    ids = tuple(dict.fromkeys(candidates[look.target].wanted.id for look in one.by))
    displaced_value = sum((look.value for look in one.by), 0.0)
    group = candidate.wanted.group
    lacks = [
        candidates[number].wanted.id
        for number in unseen
        if group is not None and candidates[number].wanted.group == group
    ]
    what = "a look"
    if out is not None:
        what = f"a scan of {candidate.scans[0].parts}" if candidate.is_part else what
        at_utc = utc_text(shifted_utc(request.start, out.at_s), 1)
        why = f"but {out.told} at {at_utc}, in the end by {figures(out.short)} {out.unit}"
    elif group is not None and lacks:
        why = f"but its group {group} lacks {', '.join(lacks)}"
    elif group is not None:
        why = f"but no sequence with all of its group {group} was found that is worth more"
    elif candidate.is_part:
        what = f"its scan {candidate.scans[0].part} of {candidate.scans[0].parts}"
        why = "but no sequence with all of its scans was found that is worth more"
    elif ids:
        why = f"and what it displaces, {', '.join(ids)}, is worth {displaced_value:.4g}"
    elif one.value <= 0.0:
        why = "and no other view of it is worth more, as `view` weighs them"
    else:
        why = "but no sequence with it was found that is worth more"
    return UnchosenTarget(
        row=candidate.row,
        target=candidate.wanted.id,
        because=f"{what} from {utc_text(start_utc, 1)} would be worth {one.value:.4g}, {why}",
        start_utc=start_utc,
        stop_utc=shifted_utc(start_utc, candidate.lengths_s[one.length]),
        value=one.value,
        displaced_by=ids,
        displaced_value=displaced_value,
        lacks=None if out is None else out.name,
    )


def _in_utc(
    request: CampaignRequest,
    candidates: Sequence[LookCandidate],
    choice: CampaignChoice,
    grid_s: float,
    carrier: Carrier,
    viewing: Viewing,
    keeping: Keeping | None,
) -> tuple[ChosenPass, ...]:
    chosen = [look for looks in choice.passes for look in looks]
    start_s = np.array([grid_s + look.first_step * request.step_s for look in chosen])
    length_s = np.array([candidates[look.target].lengths_s[look.length] for look in chosen])
    target = np.array([look.target for look in chosen], np.intp)
    rest_s = viewing.follower.rest_s
    pixel_rad = request.opportunities().pixel_rad
    views = viewing.seen(carrier, candidates, target, start_s + 0.5 * length_s, pixel_rad)
    pending = iter(
        [
            ChosenLook(
                row=one.row,
                path=None if scan is None else scan.path,
                target=one.wanted.id,
                part=None if scan is None else scan.part,
                parts=None if scan is None else scan.parts,
                start_utc=shifted_utc(request.start, begin_s),
                stop_utc=shifted_utc(shifted_utc(request.start, begin_s), lasts_s),
                value=look.value,
                # Where it is 1, the quotient may round up.
                quality=min(look.value / one.worth_value(lasts_s), 1.0),
                **vars(seen),
            )
            for one, look, begin_s, lasts_s, seen in zip(
                [candidates[look.target] for look in chosen],
                chosen,
                start_s.tolist(),
                length_s.tolist(),
                views,
                strict=True,
            )
            for scan in [one.scan_at(begin_s) if one.scans else None]
        ]
    )
    flown = [tuple(itertools.islice(pending, len(looks))) for looks in choice.passes if looks]
    begins = [None] * len(flown) if keeping is None else keeping.begins(choice.passes)
    first_utc = _first_utc(request)
    last_utc = shifted_utc(request.start, _last_row_s(request))
    # From an attitude of its own to the idle one, and from that onto a look.
    begun_s = 0.0 if request.initial_q_body_from_eci_xyzw is None else rest_s

    def start_utc(looks: tuple[ChosenLook, ...]) -> datetime:
        begins_utc = shifted_utc(looks[0].start_utc, -rest_s)
        return begins_utc if elapsed_s(begins_utc, first_utc) >= begun_s else first_utc

    return tuple(
        ChosenPass(
            start_utc=start_utc(looks),
            stop_utc=min(shifted_utc(looks[-1].stop_utc, rest_s), last_utc),
            looks=looks,
            resources=resources,
        )
        for looks, resources in zip(flown, begins, strict=True)
    )
