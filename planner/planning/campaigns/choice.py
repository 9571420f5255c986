"""Chooses observations, passes and order, and bounds how far from the best they can be."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.reporting import Reporter
from planner.planning.campaigns.looking import targets_of
from planner.planning.campaigns.network import NO_COST, Cut
from planner.planning.campaigns.orders import ordered_path
from planner.planning.campaigns.path import Look, Path, Worth, exact_path
from planner.planning.campaigns.pricing import (
    Ask,
    AskedPass,
    PricedPasses,
    PricedPath,
    Put,
    Question,
    bounded_held_path,
    free_path,
    held_path,
    most_at_best,
)
from planner.planning.campaigns.programmes import (
    Mixture,
    Proposal,
    best_mixture,
    best_together,
)

Prove = Callable[[Array], float]
"""What no choice is worth more than, by prices of looks at each target."""


Passes = list[tuple[Look, ...]]


@dataclass(frozen=True, kw_only=True)
class ChoiceOptions:
    """How long prices, mixtures and parts of a campaign's choice are searched."""

    gap_enough: float = 1e-3  # share of the bound: nobody weighs targets to a thousandth
    # Measured with five small satellites, 2,000 targets and a day: after 50 steps with a choice
    # every 10 the bound is 0.05 % lower than after 100 with one every 25, which take twice as long:
    # what steps aim at is the value of the best choice.  Mixtures do the rest.
    steps_max: int = 50
    step_shrinks: float = 0.96  # of Polyak's, from one to the next
    fill_every: int = 10  # steps between whole choices at the prices reached
    # programmes over all proposals, cheaper than steps where targets are many
    mixtures_max: int = 40
    mixture_enough: float = 1e-3  # share of the bound, as for the gap
    proposals_a_pass: int = 25  # the latest, made at the best prices
    proposals_least: int = 2000  # kept in any case, where passes are few
    # where they are many: the time of a mixture grows with more than the square
    proposals_most: int = 10_000
    # Rows of a mixture, passes and targets, from which interior points take less time than simplex:
    # of 10,000 rows and 4,000 proposals 4 s, not 18.
    interior_rows: int = 5000
    # of a mixture by simplex, a minute or so; without it the choice is that at the prices of steps
    mixture_iterations_max: int = 50_000
    fixed_share: int = 8  # of the passes open, one in so many is fixed at a time
    # The integer programme over all proposals: of 6,000 for 1,000 passes it ends at its root, and
    # of the hardest kind 500 nodes found no more than 20, which are the same on every machine.
    together_nodes: int = 20
    together_most: int = 6000  # of 12,000 a node took more than a minute, and gained nothing
    together_gap: float = 1e-6  # of its value, at which it may end sooner
    # over all passes, one chosen anew after the other; each gains, or it is the last
    sweeps_max: int = 10
    # Of a pass, and of all: some seconds.  A quarter as many of a pass left the bound 0.4 %
    # higher.
    pass_labels_max: int = 100_000
    # of all passes together, shared out evenly where they are many
    bound_labels_max: int = 16_000_000
    # of a pass, for each mixture; without, paths that may miss a better one bound nothing
    priced_labels_max: int = 0
    # of a pass, for all tries to fill it by its best path: half a second where it is crowded
    exact_labels_max: int = 200_000
    pass_orders: int = 30_000  # of as many looks, where a pass is filled by the best order of them
    # of looks within all passes together, shared out evenly: a second for a million
    bound_orders_max: int = 1_000_000
    # to place a group anew: each fills all passes anew
    group_tries: int = 60
    worthless: float = 1e-9  # of rounding


OPTIONS = ChoiceOptions()


@dataclass(frozen=True, kw_only=True)
class CampaignChoice:
    """passes: looks in order of time, one tuple per pass.

    value: what they are worth.  greedy_value: worth of the choice that takes whatever is worth most
    in each pass, one pass after another.  price: of a look at each target at which the bound is
    least, (targets,): for `bound_at`.  row_price: of further rows then.
    """

    passes: tuple[tuple[Look, ...], ...]
    value: float
    greedy_value: float
    price: Array
    row_price: Array = field(default_factory=lambda: np.zeros(0))


def worth_of(passes: Iterable[Sequence[Look]]) -> float:
    """The worth of all observations together."""
    return sum(one.value for looks in passes for one in looks)


def choose(
    passes: PricedPasses,
    tell: Reporter,
    options: ChoiceOptions = OPTIONS,
    *,
    ask: Ask | None = None,
    prove: Prove | None = None,
) -> CampaignChoice:
    """Price observations that more passes want than may have.

    Subgradient steps find the prices, and mixtures of what the passes want at them the rest of
    the way; the last mixture is then made whole, pass after pass, and one integer programme
    puts together what was proposed, where the choice isn't near the bound yet.
    ask: where passes are priced; None: here.
    Source: Fisher 1981, "The Lagrangian relaxation method", Management Science 27; Barnhart et
    al. 1998, "Branch-and-price", Operations Research 46(3) (column generation, diving).
    """
    return Search(passes, options, ask).found(tell, prove)


def choices_with_group(
    passes: PricedPasses, chosen: Passes, group: int, options: ChoiceOptions = OPTIONS
) -> list[Passes]:
    """Choices with all of a group, the most worth first: at its best places for looks of any
    length, and of each alone; other looks last as long, or make way."""
    looking = passes.looking
    members, found = looking.members(group), []
    lasts = np.zeros_like(looking.length_steps, np.bool_)
    for look in (look for looks in chosen for look in looks):
        lasts[look.target, look.length] = True
    every = np.arange(looking.length_steps.shape[1])
    for lengths in (every, *every[:, None]):
        lasts[members] = np.isin(every, lengths)
        steps, value = looking.length_steps * lasts, looking.look_value * lasts
        own = replace(looking, length_steps=steps, look_value=value)
        search = Search(passes.with_looking(own), options)
        search.best = chosen
        found += [
            search.whole_groups(search.with_group(members, first))
            for first in range(len(passes.networks))
            if np.isin(passes.networks[first].target, members).any()
        ]
    return sorted(found, key=worth_of, reverse=True)


def refill(passes: PricedPasses, chosen: Passes, options: ChoiceOptions = OPTIONS) -> Passes:
    """Pass after pass takes what is worth most of what the others leave, until nothing gains."""
    search = Search(passes, options)
    search.refill_passes(chosen)
    return search.best


class Search:
    """The best choice so far, the best prices, and what was proposed on the way.

    price: of each target's observation, at which the bound is least as far as known.  row_price: of
    further rows likewise.
    """

    def __init__(
        self, passes: PricedPasses, options: ChoiceOptions, ask: Ask | None = None
    ) -> None:
        self._passes, self._ask = passes, ask or passes.answers
        self._networks = [passes.networks[n] for n in range(len(passes.networks))]
        self._looking = looking = passes.looking
        self._options = options
        self._cuts: list[tuple[Cut, ...]] = [()] * len(self._networks)
        self.best: Passes = [()] * len(self._networks)
        self.value = 0.0
        # At these nothing gains: all observations at their best.
        self.price: Array = looking.look_value.max(axis=1)
        self.row_price: Array = np.zeros(0)
        self._bound = float(looking.look_limit @ self.price)
        self._kept = 1.0 + self._bound  # a look of so much more is given up for nothing
        self._proposed: dict[Proposal, None] = {}
        self._holds = False  # whether paths that passes take at prices are such as can be held
        self._is_priced = False
        # Of each pass at its latest own prices.
        self._answered: dict[int, tuple[bytes, PricedPath]] = {}
        self._fitted: dict[int, tuple[bytes, Path]] = {}

    def found(self, tell: Reporter, prove: Prove | None = None) -> CampaignChoice:
        """The choice, after all of the search.

        prove: the bound at prices, told as soon as these are found.
        """
        greedy_value, bound = self.begin(), np.inf
        self.take_groups()
        mixture = self.find_prices(tell)
        if prove is not None:
            tell("bound", 0, 1, value=self.value)
            bound = prove(self.price)
            tell("bound", 1, 1, value=self.value, bound=bound)
        if mixture is not None:
            self.make_whole(mixture, tell)
            self.put_together(tell)
        self.take_groups()
        self.fill_exactly(bound)
        return CampaignChoice(
            passes=tuple(self.best),
            value=self.value,
            greedy_value=greedy_value,
            price=self.price,
            row_price=self.row_price,
        )

    def begin(self) -> float:
        """With what is worth most in each pass, one pass after another; its worth."""
        greedy = self.fill_passes([()] * len(self._networks), np.zeros_like(self.price))
        self.refill_passes(greedy)
        return worth_of(greedy)

    def find_prices(self, tell: Reporter) -> tuple[Mixture, list[Proposal]] | None:
        """Improves the choice on the way; the last mixture, None if near."""
        self.step_prices(tell)
        return self.mix_prices(tell)

    def step_prices(self, tell: Reporter) -> None:
        """Towards the prices at which the bound is least; improves the choice on the way."""
        looking = self._looking
        price = np.zeros_like(self.price)
        for done in range(self._options.steps_max):
            tell("choosing", done, self._options.steps_max, value=self.value)
            bound, passes = self._answer_prices(price)
            if done % self._options.fill_every == 0:
                self.refill_passes(self.fill_passes([()] * len(self._networks), price))
            wanted = looking.wanted(passes, price)
            is_single = looking.group < 0
            wanted[(wanted < 0.0) & (price <= 0.0) & is_single] = 0.0
            square = float(wanted @ wanted)
            if self._is_near() or (square == 0.0 and self._holds):
                return
            # Whether looks can be held takes longer to tell than to find them: of the latest alone.
            self._holds |= (
                square == 0.0 or done + self._options.proposals_a_pass >= self._options.steps_max
            )
            step = self._options.step_shrinks**done * (bound - self.value) / max(square, 1.0)
            price = price + step * wanted
            price[is_single] = np.maximum(price[is_single], 0.0)

    def mix_prices(self, tell: Reporter) -> tuple[Mixture, list[Proposal]] | None:
        """The rest of the way by mixtures of the latest proposals; the last one, None if near."""
        found: tuple[Mixture, list[Proposal]] | None = None
        self._holds, bound_before = True, np.inf
        if self._options.priced_labels_max:  # what steps found bounds nothing
            self._is_priced, self._bound = True, np.inf
            self._answer_prices(self.price)
        for done in range(self._options.mixtures_max):
            if self._is_near() or not self._proposed:
                return None
            tell("mixing", done, self._options.mixtures_max, value=self.value)
            proposals = self._latest_proposals()
            mixture = self._mixed(proposals, self._looking.look_limit, ())
            if mixture is None:
                break
            is_worse = (
                found is not None and mixture.value < found[0].value - self._options.worthless
            )
            if is_worse and self._bound >= bound_before:
                break  # what was proposed meanwhile displaced what is worth more
            found, bound_before = (mixture, proposals), self._bound
            # Half-way from the best prices, so that they don't swing (Wentges 1997).
            known, bound = len(self._proposed), self._bound
            self._answer_prices(0.5 * (self.price + mixture.price))
            enough = self._options.mixture_enough * self._bound
            is_still = len(self._proposed) == known and 0.0 <= bound - self._bound < enough
            if self._bound - mixture.value <= enough or (self._is_priced and is_still):
                break
        return found

    def make_whole(self, mixed: tuple[Mixture, list[Proposal]], tell: Reporter) -> None:
        """Largest shares first, some passes at a time; the others are mixed anew each time."""
        mixture, proposals = mixed
        left = self._looking.look_limit.copy()
        passes: Passes = [()] * len(self._networks)
        is_open = np.ones(len(passes), np.bool_)
        refused: set[Proposal] = set()
        while proposals:
            tell("rounding", int(np.count_nonzero(~is_open)), len(is_open), value=self.value)
            allowed = max(1, int(np.count_nonzero(is_open)) // self._options.fixed_share)
            for place in np.argsort(-mixture.share, kind="stable").tolist():
                number, looks = proposals[place]
                if mixture.share[place] < 1.0 - self._options.worthless and allowed <= 0:
                    break
                if not is_open[number] or any(left[look.target] <= 0.0 for look in looks):
                    continue
                if not self.keeps(passes, number, looks):
                    refused.add(proposals[place])
                else:
                    passes[number], is_open[number] = looks, False
                    left[targets_of(looks)] -= 1.0
                    allowed -= 1
            proposals = [
                (number, looks)
                for number, looks in [
                    *proposals,
                    *self._wanted_proposals(np.flatnonzero(is_open), mixture.price, left)
                ]
                if is_open[number]
                and all(left[look.target] > 0.0 for look in looks)
                and (number, looks) not in refused
            ]  # fmt: skip
            proposals = list(dict.fromkeys(proposals))
            mixed_anew = proposals and self._mixed(proposals, left, passes)
            if not mixed_anew:
                break
            mixture = mixed_anew
        self.refill_passes(passes)

    def put_together(self, tell: Reporter) -> None:
        """Whole proposals that a better choice may have: at the best prices none of them is further
        from its pass's best than the choice from the bound."""
        if self._is_near():
            return
        tell("exchanging", 0, 1, value=self.value)
        proposals = list(dict.fromkeys([*self._proposed, *self._own_proposals()]))
        gains = [self._gain(one) for one in proposals]
        most = np.zeros(len(self._networks))
        np.maximum.at(most, [number for number, _ in proposals], gains)
        lacks = [most[number] - gain for (number, _), gain in zip(proposals, gains, strict=True)]
        gap = self._bound - self.value
        near = [one for one, lack in zip(proposals, lacks, strict=True) if lack <= gap]
        if len(near) > self._options.together_most:
            return
        passes: Passes = [()] * len(self._networks)
        for number, looks in self._together(near):
            passes[number] = looks
        self.refill_passes(passes)

    def _together(self, proposals: Sequence[Proposal]) -> list[Proposal]:
        return best_together(proposals, len(self._networks), self._looking, self._options)

    def _gain(self, proposal: Proposal) -> float:
        """Of a pass, at the best prices."""
        return sum(one.value - float(self.price[one.target]) for one in proposal[1])

    def _wanted_proposals(self, part: Indices, price: Array, left_limit: Array) -> list[Proposal]:
        """What passes would take at these prices of the observations that are left."""
        numbers, left_price = part.tolist(), np.where(left_limit > 0.0, price, np.inf)
        answers = self._answers(held_path, left_price, numbers, self._costs(numbers))
        return [
            (number, path.looks)
            for number, (_, path, _) in zip(numbers, answers, strict=True)
            if path.looks
        ]

    def _costs(self, numbers: Sequence[int]) -> Sequence[Array]:
        """What looks of some passes pay at the best prices of further rows; nothing of none."""
        return ()

    def _held_path(self, number: int, worth: Worth, cost: Array = NO_COST) -> Path:
        """Of a pass."""
        answer = held_path(self._passes, AskedPass(number, self._cuts[number], cost), worth)
        self._cuts[number] = answer.cuts
        return answer.path

    def _answers(
        self, put: Put, price: Array, numbers: Sequence[int], costs: Sequence[Array] = ()
    ) -> Sequence[PricedPath]:
        """Of some passes, whose looks cost something or nothing."""
        own_costs = costs or [NO_COST] * len(numbers)
        asked = [
            AskedPass(number, self._cuts[number], cost)
            for number, cost in zip(numbers, own_costs, strict=True)
        ]
        answers = self._ask(Question(put, price), asked)
        for number, answer in zip(numbers, answers, strict=True):
            self._cuts[number] = answer.cuts
        return answers

    def _priced(self, price: Array) -> Sequence[PricedPath]:
        """Of all passes."""
        numbers = range(len(self._networks))
        if not self._is_priced:
            return self._answers(held_path if self._holds else free_path, price, numbers)
        own = [price[network.target].tobytes() for network in self._networks]
        anew = [  # most passes' prices stand still near the end
            number for number in numbers if self._answered.get(number, (b"",))[0] != own[number]
        ]
        put = partial(bounded_held_path, labels_max=self._options.priced_labels_max)
        for number, answer in zip(anew, self._answers(put, price, anew), strict=True):
            self._answered[number] = own[number], answer
        return [self._answered[number][1] for number in numbers]

    def keeps(self, passes: Passes, number: int, looks: tuple[Look, ...]) -> bool:
        """Whether a pass (-1: none) may have these looks beside what the others have."""
        return True

    def _mixed(
        self, proposals: Sequence[Proposal], left_limit: Array, fixed: Passes | tuple[()]
    ) -> Mixture | None:
        """fixed: looks of passes that no proposal is for."""
        return best_mixture(
            proposals, len(self._networks), self._looking, left_limit, self._options
        )

    def _fitting_path(self, number: int, worth: Worth, passes: Passes) -> Path:
        """The path of a pass that is worth most beside what the others have."""
        own = worth.price[self._networks[number].target].tobytes()  # most stand still in a sweep
        if self._fitted.get(number, (b"",))[0] != own:
            self._fitted[number] = own, self._held_path(number, worth)
        return self._fitted[number][1]

    def _latest_proposals(self) -> list[Proposal]:
        """For a mixture, with those of the best choice."""
        options = self._options
        most = max(options.proposals_a_pass * len(self._networks), options.proposals_least)
        latest = list(self._proposed)[-min(most, options.proposals_most) :]
        return list(dict.fromkeys([*latest, *self._own_proposals()]))

    def _own_proposals(self) -> list[Proposal]:
        return [(number, looks) for number, looks in enumerate(self.best) if looks]

    def _is_near(self) -> bool:
        return self._bound - self.value <= self._options.gap_enough * self._bound

    def _answer_prices(self, price: Array) -> tuple[float, Passes]:
        """What the passes would take at these prices, and what the Lagrangian then is."""
        answers = self._priced(price)
        passes = [path.looks for _, path, _ in answers]
        lagrangian = self._looking.beside(price)
        lagrangian += sum(most for most, _, _ in answers)
        for number, looks in enumerate(passes):
            self._proposed.pop((number, looks), None)  # the latest come last
            if looks and self._holds:
                self._proposed[number, looks] = None
        if lagrangian < self._bound:
            self._bound, self.price = lagrangian, price
        return lagrangian, passes

    def fill_passes(self, start: Passes, price: Array) -> Passes:
        """Pass after pass is given its best path at the prices for what the others leave.

        Members of groups stay where they are.
        """
        looking = self._looking
        passes = list(start)
        left = looking.look_limit - looking.looks_of(passes)
        for number in range(len(self._networks)):
            left[targets_of(passes[number])] += 1.0
            charged = self._charged(passes[number], np.where(left > 0.0, price, np.inf))
            path = self._fitting_path(number, looking.less_prices(charged), passes)
            own = sum(look.value - charged[look.target] for look in passes[number])
            if path.value > own + self._options.worthless:
                passes[number] = path.looks
            left[targets_of(passes[number])] -= 1.0
        return passes

    def _charged(self, looks: Sequence[Look], price: Array) -> Array:
        """Prices at which members of groups are kept if they are among the looks, or else left."""
        is_member = self._looking.group >= 0
        price = np.where(is_member, np.inf, price)
        price[[one.target for one in looks if is_member[one.target]]] = -self._kept
        return price

    def whole_groups(self, passes: Passes) -> Passes:
        """Without looks at groups of which others lack, or that are one way too many."""
        looking = self._looking
        while True:
            count = looking.looks_of(passes)
            least = np.full(looking.groups, np.inf)
            members = looking.group >= 0
            np.minimum.at(least, looking.group[members], count[members])
            worths = np.zeros_like(self.price)
            for look in (one for looks in passes for one in looks):
                worths[look.target] += look.value
            worth = np.bincount(looking.group + 1, worths, looking.groups + 1)[1:]
            whole = looking.best_ways(np.where(least > 0.0, worth, 0.0))
            begun = np.bincount(looking.group + 1, count, looking.groups + 1)[1:] > 0.0
            lacking = np.flatnonzero(begun & ~whole)
            if not len(lacking):
                return passes
            passes = self._without(passes, np.flatnonzero(np.isin(looking.group, lacking)))

    def _without(self, passes: Passes, targets: Indices) -> Passes:
        """The same looks but those at some targets."""
        passes, gone = list(passes), set(targets.tolist())
        for number, looks in enumerate(passes):
            rest = [one.target for one in looks if one.target not in gone]
            if len(rest) < len(looks):
                passes[number] = self._with_only(number, rest)
        return passes

    def _with_only(self, number: int, targets: list[int]) -> tuple[Look, ...]:
        """Looks of a pass at no targets but these."""
        price = np.full(len(self.price), np.inf)
        price[targets] = -self._kept
        return self._held_path(number, self._looking.less_prices(price)).looks

    def refill_passes(self, passes: Passes) -> None:
        """Refill without prices until nothing is gained; the best choice is kept."""
        free = np.zeros(len(self._looking.look_limit))
        if self._looking.groups:
            passes = self.whole_groups(passes)
        value = worth_of(passes)
        for _ in range(self._options.sweeps_max):
            better = self.fill_passes(passes, free)
            gained = worth_of(better) - value
            if gained <= self._options.worthless:
                break
            passes, value = better, value + gained
        if value > self.value and self.keeps(passes, -1, ()):
            self.best, self.value = passes, value

    def fill_exactly(self, bound: float) -> None:
        """Each pass is filled by the best path, not one that a better label at a place may have
        hidden: with its groups, or with one more, less or another.

        bound: where the choice is near it, passes without scans stay as they are.
        """
        tries, near = self._options.group_tries, (1.0 - self._options.gap_enough) * bound
        most = self._options.bound_labels_max // max(len(self._networks), 1)
        left = self._looking.look_limit - self._looking.looks_of(self.best)
        for number, network in enumerate(self._networks):
            is_better = bool(network.scanned.any()) or self.value < near
            labels = min(most, self._options.exact_labels_max)
            left[targets_of(self.best[number])] += 1.0
            while is_better:
                is_better = False
                for out in self._exchanges(number):
                    tries -= len(out) > 0
                    if labels <= 0 or (out and tries < 0):
                        continue
                    looks, made = self._better_looks(number, out, left, labels)
                    labels -= made
                    if looks is not None:
                        is_better = True
                        self.value = self._value_with(number, looks)
                        self.best = [*self.best[:number], looks, *self.best[number + 1 :]]
            left[targets_of(self.best[number])] -= 1.0

    def _exchanges(self, number: int) -> Iterator[tuple[int, ...]]:
        """Groups that may be put into a pass or taken out of it: none, one, or one for another."""
        looking = self._looking
        yield ()
        if not looking.groups:
            return
        here = np.bincount(
            looking.group + 1, looking.looks_of([self.best[number]]), looking.groups + 1
        )
        count = np.bincount(looking.group + 1, looking.looks_of(self.best), looking.groups + 1)
        there = np.isin(np.arange(len(looking.group)), self._networks[number].target)
        lacking = np.bincount(looking.group + 1, ~there, looking.groups + 1)
        inside = [g for g in range(looking.groups) if 0.0 < here[g + 1] == count[g + 1]]
        outside = [g for g in range(looking.groups) if not count[g + 1] and not lacking[g + 1]]
        for one in (*inside, *outside):
            yield (one,)
        for one in inside:
            for other in outside:
                yield one, other

    def _better_looks(
        self, number: int, exchanged: tuple[int, ...], left_limit: Array, labels_max: int
    ) -> tuple[tuple[Look, ...] | None, int]:
        """Of the pass's best path with these groups put in or out, None where the choice isn't
        better by it; and labels made.

        left_limit: looks at each target that other passes leave, (targets,).
        """
        looking, looks = self._looking, self.best[number]
        wanted = looking.looks_of([looks])
        for group in exchanged:
            members = looking.members(group)
            wanted[members] = 1.0 - wanted[members]
        taken = np.zeros(looking.groups)
        is_member = looking.group >= 0
        looked_at = looking.look_limit - left_limit + wanted
        np.maximum.at(taken, looking.group[is_member], looked_at[is_member])
        if (np.bincount(looking.way_to, taken) > looking.way_limit).any():
            return None, 0
        price = np.where(left_limit > 0.0, 0.0, np.inf)
        kept = is_member & (wanted > 0.0)
        price = np.where(is_member, np.where(kept, -self._kept, np.inf), price)
        network = self._passes.cut_network(number, self._cuts[number])
        worth = looking.settled(looking.less_prices(price), number)
        path, labels = exact_path(network, worth, labels_max, np.flatnonzero(kept).tolist())
        if path is None and network.scanned.any():
            path = ordered_path(network, worth, self._options.pass_orders)
        is_better = (
            path is not None
            and self._passes.first_unheld(path.looks) is None
            and self._value_with(number, path.looks) > self.value + self._options.worthless
            and set(np.flatnonzero(kept).tolist()).issubset(targets_of(path.looks))
            and self.keeps(self.best, number, path.looks)
        )
        return (path.looks if path is not None and is_better else None), labels

    def _value_with(self, number: int, looks: tuple[Look, ...]) -> float:
        """Of the best choice with other looks in a pass."""
        return self.value + worth_of([looks]) - worth_of([self.best[number]])

    def take_groups(self) -> None:
        """Groups, the most worth first, take the place of other looks, or other places."""
        looking, tries = self._looking, self._options.group_tries
        best = np.bincount(looking.group + 1, looking.look_value.max(axis=1), looking.groups + 1)
        for group in np.argsort(-best[1:], kind="stable").tolist():
            members = looking.members(group)
            for first, network in enumerate(self._networks):
                if tries > 0 and np.isin(network.target, members).any():
                    tries -= 1
                    self.refill_passes(self.with_group(members, first))

    def with_group(self, members: Indices, first: int) -> Passes:
        """The best choice with a group's members in the first passes from one on with them, in the
        place of any other way to do the same."""
        looking = self._looking
        same = looking.way_to == looking.way_to[looking.group[members[0]]]
        instead = np.isin(looking.group, np.flatnonzero(same))
        taken = looking.looks_of(self.best)[instead & (looking.group != looking.group[members[0]])]
        is_full = (
            looking.way_limit[looking.way_to[looking.group[members[0]]]] <= (taken > 0.0).any()
        )
        out = np.flatnonzero(instead) if is_full else members
        passes = self._without(self.best, out)
        missing = set(members.tolist())
        left = looking.look_limit - looking.looks_of(passes)
        for number in [*range(first, len(passes)), *range(first)]:
            own = looking.looks_of([passes[number]])
            price = self._charged(passes[number], np.where(left + own > 0.0, 0.0, np.inf))
            kept = set(np.flatnonzero(price < 0.0).tolist())
            price[list(missing)] = -self._kept
            if missing.isdisjoint(self._networks[number].target.tolist()):
                continue
            path = self._held_path(number, looking.less_prices(price))
            seen = {one.target for one in path.looks}
            if kept <= seen and not missing.isdisjoint(seen):
                passes[number] = path.looks
                left += own - looking.looks_of([path.looks])
                missing -= seen
        return passes


def bound_at(
    passes: PricedPasses,
    price: Array,
    options: ChoiceOptions = OPTIONS,
    *,
    ask: Ask | None = None,
    costs: Sequence[Array] = (),
    rent_costs: Sequence[float] = (),
    room_value: float = 0.0,
) -> float:
    """No choice of paths is worth more, whatever the prices, (targets,), >= 0 but of groups.

    Lagrangian relaxation of "no more looks than look_limit", and "as many as its group's".
    ask: where passes are priced; None: here.
    costs, rent_costs: of further rows, what each pass pays for its looks, as of `Network`, and what
    it pays where it has any.
    room_value: of all that these rows have.
    """
    looking, count = passes.looking, len(passes.networks)
    most = partial(
        most_at_best,
        labels_max=min(options.pass_labels_max, options.bound_labels_max // max(count, 1)),
        orders_max=options.bound_orders_max // max(count, 1),
    )
    asked = [AskedPass(number, cost=cost) for number, cost in enumerate(costs or [NO_COST] * count)]
    priced = looking.beside(price) + room_value
    answers = (ask or passes.answers)(Question(most, price), asked)
    for answer, rent in zip(answers, rent_costs or [0.0] * count, strict=True):
        priced += max(answer.most_value - rent, 0.0)
    return min(priced, float(looking.look_limit @ looking.look_value.max(axis=1, initial=0.0)))
