"""The choice is the best there is, and its bound a bound: all sequences are tried.

The oracle knows every set of targets looked at so far, every way and every step, and asks
Ruckig for each slew: no estimate, no dominance, no prices.
"""

import math
from dataclasses import replace
from datetime import timedelta
from functools import cache

import numpy as np
import pytest
from opportunity_requests import ISS, START

from planner.base.reporting import tell_nobody
from planner.motion.slew import AxisState, next_duration_s
from planner.planning import label_search
from planner.planning.campaigns import (
    CampaignRequest,
    CampaignTarget,
    carrier_looks,
    choose_campaign,
    choose_together,
    keeping,
    orders,
)
from planner.planning.campaigns import campaign as campaigns
from planner.planning.campaigns.choice import ChoiceOptions, choose
from planner.planning.campaigns.looking import Looking
from planner.planning.campaigns.network import NEVER, Network
from planner.planning.campaigns.orders import most_worth, ordered_path
from planner.planning.campaigns.path import Worth, best_path, bounded_path
from planner.planning.campaigns.pricing import PricedPasses
from planner.planning.opportunities import OpportunityConditions
from planner.world.orbits import TleOrbit
from planner.world.platforms import PLATFORMS
from planner.world.targets import GroundTarget

# 6 deg of mean anomaly behind the ISS
BEHIND = TleOrbit(
    line1=ISS.line1, line2="2 25544  51.6478 271.9610 0008043  54.4849  12.6646 15.54887163930968"
)
WEST = ((36.1, -115.2), (37.8, -122.4), (40.8, -111.9), (33.4, -112.1), (34.1, -118.2))
EUROPE = ((51.5, -0.1), (48.9, 2.4), (41.4, 2.2), (45.5, 9.2), (52.5, 13.4))


def request_for(places, days, **fields):
    targets = tuple(
        CampaignTarget(
            id=str(number),
            target=GroundTarget(latitude_deg=latitude, longitude_deg=longitude),
            priority=1.0 + 0.37 * number,  # no two sets are worth the same
            session_s=48.0,
            min_session_s=16.0,
        )
        for number, (latitude, longitude) in enumerate(places)
    )
    return CampaignRequest(
        **{
            "orbit": ISS,
            "platform": PLATFORMS["iss-hrc"],
            "rest_angles_deg": {"alpha": 0.0, "beta": 0.0},
            "targets": targets,
            "start": START,
            "stop": START + timedelta(days=days),
            "conditions": OpportunityConditions(min_elevation_deg=35.0),
            "step_s": 8.0,
            **fields,
        }
    )


@pytest.fixture
def kept_ways(monkeypatch):
    """The ways that choices are made from, as they are found."""
    found_ways, kept = carrier_looks.ways_to_follow, []

    def keeping(*given):
        kept.append(found_ways(*given))
        return kept[-1]

    monkeypatch.setattr(carrier_looks, "ways_to_follow", keeping)
    return kept


def in_groups(request, groups):
    """Its targets, each in the group that a letter names."""
    targets = zip(request.targets, groups, strict=True)
    asked = tuple(replace(one, group=None if name == "." else name) for one, name in targets)
    return replace(request, targets=asked)


@pytest.mark.parametrize(
    ("places", "days"), [(WEST, 0.6), (EUROPE, 0.5), (WEST[:2] + EUROPE[:3], 1.0)]
)
def test_choice_is_the_best_of_all(places, days, kept_ways):
    request = request_for(places, days)
    campaign = choose_campaign(request)
    best = best_of_all(request, kept_ways[-1])
    # The estimate of slews is at most 0.2 s above Ruckig's, a fortieth of the step: no slew of
    # these cases falls in between.
    assert campaign.value == pytest.approx(best, abs=1e-9)
    assert campaign.bound >= best - 1e-9
    assert best > campaign.greedy_value * 0.5 > 0.0


@pytest.mark.parametrize(
    ("places", "days", "groups"),
    [(WEST, 0.6, "aabb."), (EUROPE, 0.5, "a.bab"), (WEST, 0.6, ".aaaa"), (WEST, 0.6, "..aa.")],
)
def test_groups_are_chosen_whole_or_not_at_all(places, days, groups, kept_ways):
    request = in_groups(request_for(places, days, step_s=12.0), groups)
    campaign = choose_campaign(request)
    value = {look.row: look.value for flight in campaign.passes for look in flight.looks}
    assert is_whole(request, value.keys())
    best = best_of_all(request, kept_ways[-1])
    assert campaign.bound >= best - 1e-9 > 0.0
    # It is the best of all but where two groups vie with a target within one pass: 2.3 % less.
    assert 0.97 * best <= campaign.value <= best + 1e-9
    for one in campaign.left_out:
        group = request.targets[one.row].group
        assert group is None or f"group {group}" in one.because
        displaced = rows_of(one.displaced_by)
        assert is_whole(request, value.keys() - displaced)
        assert one.displaced_value == pytest.approx(sum(value[row] for row in displaced))


@pytest.mark.parametrize(
    ("places", "days", "groups"),
    [(WEST, 0.6, "....."), (EUROPE, 0.5, "....."), (WEST, 0.6, "aa.bb"), (EUROPE, 0.5, ".aabb")],
)
def test_two_carriers_choose_the_best_of_all(places, days, groups, kept_ways):
    """The second flies 93 s behind and may not look at the first target, nor the first at the
    last."""
    both = in_groups(request_for(places, days, step_s=12.0), groups)
    requests = {
        "ahead": replace(both, targets=both.targets[:4]),
        "behind": replace(both, targets=both.targets[1:], orbit=BEHIND),
    }
    campaign = choose_together(requests)
    by_ids = [
        {frozenset(request.targets[row].id for row in seen): worth for seen, worth in sets.items()}
        for request, ways in zip(requests.values(), kept_ways, strict=True)
        for sets in [best_by_set(request, ways)]
    ]
    best = max(
        ahead + behind
        for one, ahead in by_ids[0].items()
        for other, behind in by_ids[1].items()
        if one.isdisjoint(other) and is_whole(both, rows_of(one | other))
    )
    assert campaign.bound >= best - 1e-9 > 0.0
    assert 0.97 * best <= campaign.value <= best + 1e-9
    if set(groups) == {"."}:
        assert campaign.value == pytest.approx(best, abs=1e-9)
    looks = [(one.carrier, look) for one in campaign.passes for look in one.looks]
    assert sum(look.value for _, look in looks) == pytest.approx(campaign.value)
    targets = [look.target for _, look in looks]
    assert len(set(targets)) == len(targets)
    assert is_whole(both, rows_of(targets))
    assert {carrier for carrier, _ in looks} == {"ahead", "behind"}
    for carrier, look in looks:
        assert requests[carrier].targets[look.row].id == look.target


def rows_of(ids):
    return {int(one) for one in ids}


def is_whole(request, seen):
    members = {}
    for row, wanted in enumerate(request.targets):
        if wanted.group is not None:
            members.setdefault(wanted.group, set()).add(row)
    return all(one <= seen or one.isdisjoint(seen) for one in members.values())


def test_a_group_that_lacks_a_target_is_left_out():
    """The ISS never rises high at 80 deg of latitude."""
    request = request_for(WEST, 0.6)
    far = CampaignTarget(
        id="far",
        target=GroundTarget(latitude_deg=80.0, longitude_deg=20.0),
        session_s=30.0,
        group="pair",
    )
    pair = replace(request.targets[4], group="pair", priority=50.0)
    campaign = choose_campaign(replace(request, targets=(*request.targets[:4], pair, far)))
    assert "far" in [one.target for one in campaign.unseen]
    [alone] = [one for one in campaign.left_out if one.target == "4"]
    assert "its group pair lacks far" in alone.because
    # With whatever stands beside it left out, it would lack as much.
    assert (alone.displaced_by, alone.displaced_value) == ((), 0.0)
    assert campaign.bound < 50.0


def test_a_target_of_a_group_is_looked_at_once():
    with pytest.raises(ValueError, match="looks must be 1, not 2, of a target with a group"):
        replace(request_for(WEST, 0.4).targets[0], group="pair", looks=2)


@pytest.mark.parametrize(("places", "days"), [(WEST, 0.6), (EUROPE, 0.5)])
def test_looks_begin_after_release_and_end_by_due(places, days, kept_ways):
    request = request_for(places, days)
    looks = [look for one in choose_campaign(request).passes for look in one.looks]
    spans = {
        looks[0].row: {"release": looks[0].start_utc + timedelta(seconds=5)},
        looks[1].row: {"due": looks[1].stop_utc - timedelta(seconds=5)},
        looks[2].row: {"due": request.start + timedelta(seconds=1)},
    }
    asked = [replace(one, **spans.get(n, {})) for n, one in enumerate(request.targets)]
    request = replace(request, targets=tuple(asked))
    campaign = choose_campaign(request)
    for look in (look for one in campaign.passes for look in one.looks):
        wanted = request.targets[look.row]
        assert wanted.release is None or wanted.release <= look.start_utc
        assert wanted.due is None or look.stop_utc <= wanted.due
    assert campaign.value == pytest.approx(best_of_all(request, kept_ways[-1]), abs=1e-9)
    assert (looks[2].row, "due") in [(one.row, one.closed_by) for one in campaign.unseen]


def best_of_all(request, ways):
    whole = [worth for seen, worth in best_by_set(request, ways).items() if is_whole(request, seen)]
    return max(whole)


def best_by_set(request, ways):
    """Of sets of targets, over last way and step it is left at: what they can be worth."""
    limits = request.platform.axis_limits
    looks = [
        (way, int(ways.target[way]), first, first + math.ceil(length_s / request.step_s), length_s)
        for way in range(len(ways.target))
        for length_s in request.targets[ways.target[way]].lengths_s
        for first in range(
            int(ways.first_step[way]),
            int(ways.first_step[way] + ways.steps[way]) - math.ceil(length_s / request.step_s),
        )
        if is_in_time(request, int(ways.target[way]), first * request.step_s, length_s)
    ]
    looks.sort(key=lambda look: look[2])
    states = {
        (way, int(ways.first_step[way]) + row): axes(
            ways.states[ways.offset[way] + row].reshape(3, 2)
        )
        for way in range(len(ways.target))
        for row in range(int(ways.steps[way]))
    }
    fits = {}

    def slew_fits(way, leave, to, join):
        if ways.pass_number[way] != ways.pass_number[to]:
            return ways.pass_number[way] < ways.pass_number[to]
        key = (way, leave, to, join)
        if key not in fits:
            needed = [
                next_duration_s(*ends, 0.0)
                for ends in zip(states[way, leave], states[to, join], limits, strict=True)
            ]
            available_s = (join - leave) * request.step_s
            fits[key] = all(s is not None and s <= available_s for s in needed)
        return fits[key]

    ended = {}  # (set, way, step of leaving) -> worth
    for way, target, first, last, length_s in looks:
        rows = ways.offset[way] - ways.first_step[way] + np.arange(first, last + 1)
        quality = np.trapezoid(ways.quality[rows], dx=1.0 / (last - first))
        worth = request.targets[target].worth_value(length_s) * quality
        reached = {frozenset([target]): worth}
        for (seen, before, leave), so_far in ended.items():
            if target in seen or leave >= first:
                continue
            more = seen | {target}
            if so_far + worth > reached.get(more, 0.0) and slew_fits(before, leave, way, first):
                reached[more] = so_far + worth
        for seen, total in reached.items():
            key = (seen, way, last)
            ended[key] = max(ended.get(key, 0.0), total)
    best = {frozenset(): 0.0}
    for (seen, *_), worth in ended.items():
        best[seen] = max(best.get(seen, 0.0), worth)
    return best


def is_in_time(request, target, start_s, length_s):
    """To the tenths of a second by which the grid begins later than the request."""
    release_s, due_s = request.targets[target].span_s(request.start)
    return release_s <= start_s and start_s + length_s <= due_s


def axes(state):
    return tuple(
        AxisState(angle_rad=q, rate_rad_s=v, acceleration_rad_s2=a) for q, v, a in state.T.tolist()
    )


def test_more_looks_are_worth_no_less():
    once = request_for(EUROPE, 0.5)
    twice = replace(once, targets=tuple(replace(one, looks=2) for one in once.targets))
    assert choose_campaign(twice).value >= choose_campaign(once).value


@pytest.mark.parametrize("bits", [62, 2])
@pytest.mark.parametrize("seed", range(24, 30))
def test_a_pass_is_bounded_by_the_best_that_looks_at_each_target_once(seed, bits, monkeypatch):
    monkeypatch.setattr(label_search, "BITS", bits)  # of 2, the memory takes three words
    network, worth = random_pass(seed)
    best = best_sequence(network, worth)
    assert bounded_path(network, worth, labels_max=8_000_000)[0] == pytest.approx(best, abs=1e-9)
    path = best_path(network, worth)
    assert path.value <= best + 1e-9
    assert len({look.target for look in path.looks}) == len(path.looks)


@pytest.mark.parametrize("seed", range(24, 30))
def test_a_pass_alone_is_filled_by_its_best_sequence(seed):
    """Where a path that looks back at its own targets alone misses up to a fifth of it."""
    network, worth = random_pass(seed)
    alone, none = np.full(5, -1), np.zeros(0, np.intp)
    looking = Looking(
        length_steps=worth.steps, look_value=worth.value, look_limit=np.ones(5), group=alone,
        way_to=none, way_limit=np.zeros(0), settle_steps=np.zeros(1, np.intp),
    )  # fmt: skip
    passes = PricedPasses([network], [network], looking, lambda looks: None)
    found = choose(passes, tell_nobody)
    best = best_sequence(network, worth._replace(price=np.zeros(5)))
    assert found.value == pytest.approx(best, abs=1e-9)


@pytest.mark.parametrize("bits", [62, 2])
@pytest.mark.parametrize("seed", range(4))
def test_orders_of_looks_are_worth_the_most_and_bound_it(seed, bits, monkeypatch):
    monkeypatch.setattr(orders, "BITS", bits)
    network, worth = random_pass(seed)
    best = best_sequence(network, worth)
    assert most_worth(network, worth, 10_000) >= best - 1e-9
    assert math.isinf(most_worth(network, worth, 3))
    assert ordered_path(network, worth, 1000) is None  # of two lengths
    alike = Worth(worth.steps[:, :1], worth.value[:, :1], worth.price)
    path = ordered_path(network, alike, 1000)
    assert 0.8 * best_sequence(network, alike) <= path.value  # the soonest may see less well
    assert path.value <= best_sequence(network, alike) + 1e-9
    even = network._replace(
        quality_sum=0.7
        * np.concatenate([np.arange(n) for n in np.diff([*network.offset, network.size])])
    )
    best = best_sequence(even, alike)
    assert most_worth(even, alike, 10_000) == pytest.approx(best, abs=1e-9)
    path = ordered_path(even, alike, 1000)
    assert path.value == pytest.approx(best, abs=1e-9)
    assert len({look.target for look in path.looks}) == len(path.looks)
    gains = [look.value - alike.price[look.target] for look in path.looks]
    assert sum(gains) == pytest.approx(best, abs=1e-9)


def random_pass(seed):
    """Five targets with two ways each, any of which leads to all others; who begins and ends at
    rest can't be on all of them at all times."""
    random = np.random.default_rng(seed)
    reach, first = 10, np.sort(random.integers(0, 50, 10))
    steps = random.integers(5, 10, 10)
    last, target, offset = first + steps - 1, random.permutation(10) % 5, np.cumsum(steps) - steps
    edges = [np.flatnonzero(target != one) for one in target]
    slew_steps = random.integers(1, reach, (10, 10))
    arrival = []
    for way, to in enumerate(edges):
        for step in range(first[way], last[way] + 1):
            reached = np.maximum(first[to], step + slew_steps[way, to])
            cells = offset[to] + reached - first[to]
            arrival.append(np.where(reached < last[to], cells, NEVER))
    counts = np.array([len(to) for to in edges])
    late = random.integers(0, 4, 10)
    enters = np.where(random.random(10) < 0.2, NEVER, offset + late)
    last_ends = np.repeat(last - random.integers(0, 4, 10), steps)
    ends = np.arange(steps.sum()) - np.repeat(offset - first, steps) <= last_ends
    network = Network(
        first_step=0,
        way=np.arange(10),
        target=target,
        first=first,
        last=last,
        offset=offset,
        size=int(steps.sum()),
        quality_sum=np.concatenate([np.cumsum(random.uniform(0.5, 1.0, n)) for n in steps]),
        stop_step=int(last.max()) + 1,
        edge_from=np.append(0, np.cumsum(counts)),
        edge_to=np.concatenate(edges),
        arrival_offset=np.cumsum(steps * counts) - steps * counts,
        arrival=np.concatenate(arrival).astype(np.int32),
        reach=reach,
        enters=enters,
        ends=ends,
        begins=np.ones(int(steps.sum()), bool),
        scanned=np.zeros(10, bool),
    )
    value = random.uniform(1.0, 2.0, (5, 1)) * [0.6, 1.0]
    return network, Worth(np.tile([2, 4], (5, 1)), value, random.uniform(0.0, 0.3, 5))


def best_sequence(network, worth):
    """All sequences are tried, from every way left at every step."""

    @cache
    def best_from(way, step, seen):
        edges = network.edge_from[way + 1] - network.edge_from[way]
        row = network.arrival_offset[way] + (step - network.first[way]) * edges
        reached = network.arrival[row : row + edges]
        to = network.edge_to[network.edge_from[way] : network.edge_from[way + 1]]
        return max(
            (
                best_on(next_way, cell - network.offset[next_way], seen)
                for next_way, cell in zip(to, reached, strict=True)
                if cell != NEVER
            ),
            default=-math.inf,
        )

    def gain(way, begin, takes, length):
        cell = network.offset[way] + begin - network.first[way]
        seen = network.quality_sum[cell + takes] - network.quality_sum[cell]
        return worth.value[target_of(way), length] * seen / takes - worth.price[target_of(way)]

    def target_of(way):
        return network.target[way]

    def best_on(way, steps, seen):
        target, last = target_of(way), network.last[way]
        return max(
            (
                gain(way, begin, takes, length) + best_after(way, begin + takes, seen | {target})
                for length, takes in enumerate(worth.steps[target])
                for begin in range(network.first[way] + steps, last - takes + 1)
                if target not in seen
            ),
            default=-math.inf,
        )

    def best_after(way, step, seen):
        is_back = network.ends[network.offset[way] + step - network.first[way]]
        return max(best_from(way, step, seen), 0.0 if is_back else -math.inf)

    entered = [(way, cell) for way, cell in enumerate(network.enters) if cell != NEVER]
    return max(
        0.0, *(best_on(way, cell - network.offset[way], frozenset()) for way, cell in entered)
    )


def test_a_choice_with_little_search_is_bounded_too(monkeypatch):
    """Settings are an argument: with few steps and no mixture the bound is wider, and holds."""
    request = request_for(EUROPE, 0.5)
    well = choose_campaign(request)
    hasty = ChoiceOptions(steps_max=2, mixtures_max=0, sweeps_max=1)

    def choose_hastily(*given, **named):
        return keeping.choose_keeping(*given, hasty, **named)

    monkeypatch.setattr(campaigns, "choose_keeping", choose_hastily)
    found = choose_campaign(request)
    assert 0.0 < found.value <= well.bound
    assert found.value <= well.value + 1e-9
    assert found.bound > well.bound
