"""From targets over days to the sessions of every pass: the whole choice on one screen."""

import functools
import itertools
import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S
from planner.base.reporting import Reporter, tell_nobody
from planner.planning.campaigns.choice import CampaignChoice, FirstUnheld, Looking, bound_at, choose
from planner.planning.campaigns.chosen import ChosenLook, UnchosenTarget
from planner.planning.campaigns.displaced import Displaced, displaced_by
from planner.planning.campaigns.network import Network, network_of, relax
from planner.planning.campaigns.passes import SESSIONS_MAX, Looks, in_passes, longest_pass_s
from planner.planning.campaigns.path import Look
from planner.planning.campaigns.platforms.follower import FollowedLook, Follower
from planner.planning.campaigns.platforms.registry import follower_of
from planner.planning.campaigns.request import BOUNDS as CAMPAIGN_BOUNDS
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.campaigns.view import Viewing
from planner.planning.campaigns.ways import Ways, ways_to_follow
from planner.planning.opportunities import Windows, opportunities_however_many
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.closing import Closing, Unseen
from planner.planning.opportunities.unseen import unseen_because
from planner.world.frames.time_scales import shifted_utc, utc_text
from planner.world.scenario import Scenario, Session


@dataclass(frozen=True, kw_only=True)
class ChosenPass:
    """Looks in order of time, with the platform at rest from start and again by stop."""

    start_utc: datetime
    stop_utc: datetime
    looks: tuple[ChosenLook, ...]


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """Passes in order of time.

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
    found = opportunities_however_many(request.opportunities())
    looks = _looks_in_passes(request, found.windows, follower)
    tell("ways", 0, 1)
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    carrier = follower.carrier(ephemeris)
    viewing = Viewing(weights=request.view, ephemeris=ephemeris, follower=follower)
    looking = _looking_of(request, follower.settle_s)
    shortest = looking.length_steps[:, 0]
    ways = ways_to_follow(
        looks, request.targets, shortest, carrier, viewing, request.step_s, grid_s
    )
    networks = _build_networks(ways, shortest, follower, tell)
    first_unheld = _first_unheld_by(request, ways, follower, carrier, grid_s)
    seen = set(np.unique(ways.target).tolist())
    unseen = [row for row in range(len(request.targets)) if row not in seen]
    # A group that lacks a target is worth nothing.
    hopeful = ~np.isin(looking.group, looking.group[unseen]) | (looking.group < 0)
    hopeful_looking = replace(looking, look_value=looking.look_value * hopeful[:, None])
    choice = choose(networks, hopeful_looking, tell, first_unheld)
    tell("bound", 0, 1)
    # At slew times that nothing can beat.
    limits = follower.slew_limits
    with _thread_count() as threads:
        optimistic = list(threads.map(lambda one: relax(one, ways, shortest, limits), networks))
    bound = bound_at(optimistic, hopeful_looking, choice.price)
    looked_at = {look.target for one in choice.passes for look in one}
    left_out = displaced_by(
        networks,
        choice.passes,
        looking.less_prices(np.zeros(len(request.targets))),
        np.array(sorted(seen - looked_at), np.intp),
    )
    return Campaign(
        passes=_in_utc(request, choice, grid_s, carrier, viewing),
        value=choice.value,
        bound=max(bound, choice.value),
        greedy_value=choice.greedy_value,
        windows=len(found.windows),
        unseen=unseen_because(
            request.opportunities(),
            carrier,
            unseen,
            {
                row: _closed_later(request, row, found.windows, looks, follower)
                for row in unseen
                if (found.windows.target == row).any()
            },
        ),
        left_out=tuple(_left_out(request, one, grid_s, unseen) for one in left_out),
        warnings=found.warnings,
    )


def scenario_of(request: CampaignRequest, flight: ChosenPass, number: int) -> Scenario:
    """The pass as it is to be planned: from rest over all observations to rest.

    What a slew lacks, its neighbours give: slew times were estimated without stops.
    """
    ends = follower_of(request).pass_ends(flight.start_utc, flight.stop_utc)
    return Scenario(
        name=f"{request.name or 'campaign'}, pass {number + 1}",
        orbit=request.orbit,
        attitude=ends.attitude,
        platform=request.platform,
        initial_state=ends.initial_state,
        sessions=(
            *(
                Session(
                    id=look.target,
                    target=request.targets[look.row].target.with_heights(),
                    start=look.start_utc,
                    stop=look.stop_utc,
                    roll=request.targets[look.row].roll,
                )
                for look in flight.looks
            ),
            *ends.rest,
        ),
        slew=ends.slew,
        on_conflict="least_loss",
        final_state=ends.final_state,
    )


def _first_row_s(request: CampaignRequest) -> float:
    """Seconds from the start to the first command row, which counts from a whole UTC second."""
    row_us = round(COMMAND_STEP_S * 1e6)
    return (-request.start.microsecond % row_us) / 1e6


def _least_s(request: CampaignRequest) -> Array:
    return np.array([wanted.lengths_s[0] for wanted in request.targets])


def _looks_in_passes(request: CampaignRequest, windows: Windows, follower: Follower) -> Looks:
    least_s, rest_s = _least_s(request), follower.rest_s
    sessions_max = SESSIONS_MAX - 2
    # Every observation is followed by one step of slewing at least, and each target has but one.
    shortest_s = float(least_s.min()) + request.step_s
    crowded_s = sessions_max * shortest_s if len(least_s) > sessions_max else math.inf
    # Its settling ends, and it begins, on the grid.
    whole_s = request.longest_s + follower.settle_s + 3.0 * request.step_s
    return in_passes(
        windows.target,
        np.maximum(windows.rise_s, rest_s + COMMAND_STEP_S),
        np.minimum(windows.set_s, request.span_s - rest_s - COMMAND_STEP_S),
        least_s[windows.target],
        rest_s,
        min(longest_pass_s(whole_s, rest_s), crowded_s),
        whole_s,
    )


def _looking_of(request: CampaignRequest, settle_s: float) -> Looking:
    settle_steps = math.ceil(settle_s / request.step_s - 1e-9)
    names = [wanted.group for wanted in request.targets]
    number = {
        name: n for n, name in enumerate(dict.fromkeys(name for name in names if name is not None))
    }
    length_steps = np.zeros((len(request.targets), CAMPAIGN_BOUNDS.lengths), np.intp)
    look_value = np.zeros((len(request.targets), CAMPAIGN_BOUNDS.lengths))
    for row, wanted in enumerate(request.targets):
        for place, length_s in enumerate(wanted.lengths_s):
            length_steps[row, place] = settle_steps + math.ceil(length_s / request.step_s - 1e-9)
            look_value[row, place] = wanted.worth_value(length_s)
    return Looking(
        length_steps=length_steps,
        look_value=look_value,
        look_limit=np.array([float(wanted.looks) for wanted in request.targets]),
        group=np.array([-1 if name is None else number[name] for name in names], np.intp),
        settle_steps=settle_steps,
    )


def _first_unheld_by(
    request: CampaignRequest, ways: Ways, follower: Follower, carrier: Carrier, grid_s: float
) -> FirstUnheld:
    @functools.cache
    def first_unheld(looks: tuple[Look, ...]) -> tuple[int, int] | None:
        followed = []
        for look in looks:
            start_s = grid_s + look.first_step * request.step_s
            length_s = request.targets[look.target].lengths_s[look.length]
            step = look.first_step + math.ceil(length_s / request.step_s - 1e-9)
            row = ways.offset[look.way] + step - ways.first_step[look.way]
            followed.append(
                FollowedLook(look.target, start_s, start_s + length_s, ways.states[row])
            )
        found = follower.first_unheld(carrier, followed)
        return found and (found[0], math.floor((found[1] - grid_s) / request.step_s + 1e-9))

    return first_unheld


def _build_networks(
    ways: Ways, shortest: Indices, follower: Follower, tell: Reporter
) -> list[Network]:
    numbers = np.unique(ways.pass_number)
    limits, longest_s = follower.slew_limits, follower.longest_slew_s

    def build_network(number: int) -> Network:
        rows = np.flatnonzero(ways.pass_number == number)
        return network_of(ways, rows, shortest, limits, longest_s)

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
    request: CampaignRequest, row: int, windows: Windows, looks: Looks, follower: Follower
) -> tuple[Closing, str]:
    """Why no observation of a target with windows that hold all conditions."""
    own = windows.select(windows.target == row)
    least_s = request.targets[row].lengths_s[0]
    longest_s = float((own.set_s - own.rise_s).max())
    several = f"the longest of its {len(own)} windows" if len(own) > 1 else "its only window"
    if longest_s < least_s:
        return (
            "duration",
            f"{several} lasts {longest_s:.1f} s, less than the {least_s:g} s of a look",
        )
    if not (looks.target == row).any():
        return "rest", (
            f"no {least_s:g} s of its windows are left beside the time {follower.resting}"
        )
    return "motion", (follower.unable.format(least_s=least_s))


def _left_out(
    request: CampaignRequest, one: Displaced, grid_s: float, unseen: Sequence[int]
) -> UnchosenTarget:
    start_utc = shifted_utc(request.start, grid_s + one.first_step * request.step_s)
    ids = tuple(request.targets[look.target].id for look in one.by)
    displaced_value = sum((look.value for look in one.by), 0.0)
    group = request.targets[one.target].group
    lacks = [request.targets[row].id for row in unseen if request.targets[row].group == group]
    if group is not None and lacks:
        why = f"but its group {group} lacks {', '.join(lacks)}"
    elif group is not None:
        why = f"but no sequence with all of its group {group} was found that is worth more"
    elif ids:
        why = f"and what it displaces, {', '.join(ids)}, is worth {displaced_value:.4g}"
    elif one.value <= 0.0:
        why = "and no other view of it is worth more, as `view` weighs them"
    else:
        why = "but no sequence with it was found that is worth more"
    return UnchosenTarget(
        row=one.target,
        target=request.targets[one.target].id,
        because=f"a look from {utc_text(start_utc, 1)} would be worth {one.value:.4g}, {why}",
        start_utc=start_utc,
        stop_utc=shifted_utc(start_utc, request.targets[one.target].lengths_s[one.length]),
        value=one.value,
        displaced_by=ids,
        displaced_value=displaced_value,
    )


def _in_utc(
    request: CampaignRequest,
    choice: CampaignChoice,
    grid_s: float,
    carrier: Carrier,
    viewing: Viewing,
) -> tuple[ChosenPass, ...]:
    chosen = [look for looks in choice.passes for look in looks]
    start_s = np.array([grid_s + look.first_step * request.step_s for look in chosen])
    length_s = np.array([request.targets[look.target].lengths_s[look.length] for look in chosen])
    target = np.array([look.target for look in chosen], np.intp)
    rest_s = viewing.follower.rest_s
    pixel_rad = request.opportunities().pixel_rad
    views = viewing.seen(carrier, request.targets, target, start_s + 0.5 * length_s, pixel_rad)
    pending = iter(
        ChosenLook(
            row=look.target,
            target=request.targets[look.target].id,
            start_utc=shifted_utc(request.start, begin_s),
            stop_utc=shifted_utc(shifted_utc(request.start, begin_s), lasts_s),
            value=look.value,
            # Where it is 1, the quotient may round up.
            quality=min(look.value / request.targets[look.target].worth_value(lasts_s), 1.0),
            **vars(seen),
        )
        for look, begin_s, lasts_s, seen in zip(
            chosen, start_s.tolist(), length_s.tolist(), views, strict=True
        )
    )
    flown = [tuple(itertools.islice(pending, len(looks))) for looks in choice.passes]
    return tuple(
        ChosenPass(
            start_utc=shifted_utc(looks[0].start_utc, -rest_s),
            stop_utc=shifted_utc(looks[-1].stop_utc, rest_s),
            looks=looks,
        )
        for looks in flown
        if looks
    )
