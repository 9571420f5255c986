"""Looks that take the place of what is worth less, and those that targets without one came near."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from planner.planning.campaigns.choice import (
    CampaignChoice,
    ChoiceOptions,
    Passes,
    choices_with_group,
    worth_of,
)
from planner.planning.campaigns.displaced import (
    Displaced,
    Exchanged,
    beside,
    displaced_by,
    lacking,
)
from planner.planning.campaigns.joined import Joined
from planner.planning.campaigns.path import Look
from planner.planning.campaigns.pricing import PricedPasses
from planner.planning.campaigns.resources import OPTIONS, Keeping, RunsOut


def exchange_looks(
    joined: Joined, passes: PricedPasses, choice: CampaignChoice, keeping: Keeping | None
) -> tuple[CampaignChoice, tuple[Displaced, ...]]:
    """The choice with looks in the place of what is worth less, as long as any are found; then the
    look that each target, or scan, without one came nearest to."""
    left = OPTIONS.exchanges_max
    while True:
        found: list[Displaced] = []
        for one, better in _nearest_looks(joined, passes, choice, keeping):
            found.append(one)
            if better is not None and left > 0:
                choice = replace(choice, passes=tuple(better), value=worth_of(better))
                break
        else:
            return choice, tuple(found)
        left -= 1


def _nearest_looks(
    joined: Joined, passes: PricedPasses, choice: CampaignChoice, keeping: Keeping | None
) -> Iterator[tuple[Displaced, Passes | None]]:
    """The look that each target without one came nearest to, and a better choice with it, where
    there is one."""
    candidates, looking = joined.candidates, passes.looking
    networks, group = joined.networks.values(), looking.group
    chosen = [look for looks in choice.passes for look in looks]
    looked_at = {candidates[look.target].wanted.id for look in chosen}
    grouped: dict[int, list[Look]] = {}
    for look in chosen:
        if group[look.target] >= 0:
            grouped.setdefault(int(group[look.target]), []).append(look)
    groups = {look.target: own for own in map(tuple, grouped.values()) for look in own}
    worth = joined.looking.less_prices(np.zeros(len(candidates)))
    exchanged = [
        Exchanged(number, network, looks, looking.settled(worth, number), groups)
        for number, (network, looks) in enumerate(zip(networks, choice.passes, strict=True))
    ]
    unchosen = [n for n in sorted(joined.seen) if candidates[n].wanted.id not in looked_at]
    left_out = displaced_by(exchanged, np.array(unchosen, np.intp))
    tries = max(OPTIONS.looks_tried // max(len(left_out), 1), 1)
    with_groups: dict[int, tuple[Passes | None, RunsOut | None]] = {}
    for one in left_out:
        own_group, better = int(group[one.look.target]), None
        if own_group < 0:
            one = lacking(one, exchanged, keeping, joined.first_unheld, tries) if keeping else one
            is_better = one.out is None and one.gain > ChoiceOptions.worthless
            better = one.taken(choice.passes) if is_better else None
        elif keeping is not None:
            if own_group not in with_groups:
                with_groups[own_group] = _better_with_group(
                    joined, passes, choice, exchanged, keeping, own_group, tries
                )
            better, out = with_groups[own_group]
            one = replace(one, out=out)
        if (
            better is not None
            and all(joined.first_unheld(looks) is None for looks in better)
            and (keeping is None or keeping.keeps(better))
        ):
            yield one, better
        else:
            yield one, None


def _better_with_group(
    joined: Joined,
    passes: PricedPasses,
    choice: CampaignChoice,
    exchanged: Sequence[Exchanged],
    keeping: Keeping,
    group: int,
    tries: int,
) -> tuple[Passes | None, RunsOut | None]:
    """A better choice with all of a group that keeps, or else what the first one runs out of."""
    found = choices_with_group(passes, list(choice.passes), group)
    members = frozenset(passes.looking.members(group).tolist())
    carriers = range(len(joined.carriers))
    tried = (
        (kept, out)
        for one in found
        for _, kept, out in beside(
            one, worth_of(one) - choice.value, members, exchanged, keeping, carriers
        )
    )
    first: RunsOut | None = None
    for kept, out in itertools.islice(tried, tries):
        if out is None:
            return kept, None
        first = first or out
    return None, first
