"""A campaign's choice that keeps the resources of its carriers, and what bounds it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Array
from planner.base.reporting import Reporter
from planner.planning.campaigns.choice import (
    OPTIONS,
    CampaignChoice,
    ChoiceOptions,
    Passes,
    Prove,
    Search,
    bound_at,
    choose,
)
from planner.planning.campaigns.network import NO_COST, Network
from planner.planning.campaigns.path import Look, Path, Worth
from planner.planning.campaigns.pricing import Ask, PricedPasses, held_path
from planner.planning.campaigns.programmes import (
    Mixture,
    Proposal,
    Rows,
    best_mixture,
    best_together,
)
from planner.planning.campaigns.resources import Keeping, RoomStretch
from planner.planning.campaigns.stores import Curve


@dataclass(frozen=True, kw_only=True)
class KeepingOptions:
    """How hard a choice that keeps all resources is sought."""

    rounds: int = 12  # of rows that a programme's answer breaks
    dearer: int = 10  # halvings of what a second costs, until a pass's path fits
    fill_every: int = 5  # mixtures between whole choices at the prices reached
    # passes filled anew to exchange looks: in tens of passes each look is left out in turn
    exchanged_passes_max: int = 400


KEEPING = KeepingOptions()


def choose_keeping(
    keeping: Keeping | None,
    passes: PricedPasses,
    tell: Reporter,
    options: ChoiceOptions = OPTIONS,
    *,
    ask: Ask | None = None,
    prove: Prove | None = None,
) -> tuple[CampaignChoice, tuple[RoomStretch, ...]]:
    """As `choose`, and the rows that its `row_price` is of.

    A choice that keeps all resources without being asked to stays as it is.  Else passes are filled
    by their best paths at a price for each second of a look, as low as lets all resources keep;
    prices of stretches come from the programmes' rows, with those of targets.
    """
    if keeping is None:
        return choose(passes, tell, options, ask=ask, prove=prove), ()

    def tell_stage(stage: str, done: int, of: int, /, **_: float | None) -> None:
        """Without a value that may take more than there is."""
        tell(stage, done, of)

    free = choose(passes, tell_stage, options, ask=ask)
    if keeping.keeps(free.passes):
        return free, ()
    search = _KeepingSearch(passes, options, ask, keeping, free)
    choice = search.found(tell)
    return choice, tuple(search.rows[: len(choice.row_price)])


def bound_keeping(
    keeping: Keeping,
    passes: PricedPasses,
    choice: CampaignChoice,
    rows: Sequence[RoomStretch],
    ask: Ask,
) -> float:
    """As `bound_at`, of choices that keep all resources.

    No such choice uses more over a stretch than there is; each pass is taken to use what its looks
    do for their whole steps, and the ways from rest and back, with panels of a body at their best
    all the while: no more than it does.  What wheels hold is left out: no choice is worth more for
    keeping that, too.
    """
    costs, rents, room_value = keeping.priced(passes.networks, rows, choice.row_price)
    return bound_at(
        passes, choice.price, ask=ask, costs=costs, rent_costs=rents, room_value=room_value
    )


class _KeepingSearch(Search):
    """A search among choices that keep all resources.

    rows: stretches that were ever broken.  row_price: of the first ones, at which the bound is
    least as far as known.
    """

    def __init__(
        self,
        passes: PricedPasses,
        options: ChoiceOptions,
        ask: Ask | None,
        keeping: Keeping,
        free: CampaignChoice,
    ) -> None:
        super().__init__(passes, options, ask)
        self._keeping = keeping
        self.rows: list[RoomStretch] = []
        self.price = free.price
        self._free_passes = list(free.passes)
        self._rented: Array | None = None
        self._proposed.update(
            ((number, looks), None) for number, looks in enumerate(free.passes) if looks
        )

    def keeps(self, passes: Passes, number: int, looks: tuple[Look, ...]) -> bool:
        return self._keeping.keeps(passes, number, looks)

    def fill_passes(self, start: Passes, price: Array) -> Passes:
        """At prices of targets those of rows count, too."""
        self._rented = self.row_price if price.any() and len(self.row_price) else None
        return super().fill_passes(start, price)

    def begin(self) -> float:
        """With what is left of the choice that keeps nothing, too."""
        greedy_value = super().begin()
        self.refill_passes(self._free_passes)
        return greedy_value

    def refill_passes(self, passes: Passes) -> None:
        super().refill_passes(self._repaired(passes))

    def find_prices(self, tell: Reporter) -> tuple[Mixture, list[Proposal]] | None:
        """Prices of targets and rows by mixtures, and choices at them; the last mixture."""
        options, found = self._options, None
        self._answer(self.price, self.row_price)
        for done in range(options.mixtures_max):
            if self._is_near() or not self._proposed:
                break
            tell("mixing", done, options.mixtures_max, value=self.value)
            proposals = self._latest_proposals()
            mixture = self._mixed(proposals, self._looking.look_limit, ())
            if mixture is None:
                break
            found = mixture, proposals
            known, bound = len(self._proposed), self._bound
            row_price = _as_long(self.row_price, mixture.row_price)
            self._answer(0.5 * (self.price + mixture.price), 0.5 * (row_price + mixture.row_price))
            if self._bound - mixture.value > options.mixture_enough * self._bound:
                self._answer(mixture.price, mixture.row_price)
            if done % KEEPING.fill_every == 0:
                self.refill_passes(self.fill_passes([()] * len(self._networks), self.price))
            enough = options.mixture_enough * self._bound
            is_still = len(self._proposed) == known and bound - self._bound < enough
            if self._bound - mixture.value <= enough or is_still:
                break
        return found

    def put_together(self, tell: Reporter) -> None:
        super().put_together(tell)
        self._exchange()

    def _exchange(self) -> None:
        """Each look of the best choice is left out in turn, and what then fits is filled in without
        its target, then with it, until nothing is gained: prices miss what few large looks use."""
        tries = KEEPING.exchanged_passes_max // len(self._networks)
        untried = [(number, look) for number, looks in enumerate(self.best) for look in looks]
        while untried and tries > 0 and not self._is_near():
            number, out = untried.pop(0)
            if out not in self.best[number] or self._looking.group[out.target] >= 0:
                continue
            tries -= 1
            value, passes = self.value, list(self.best)
            passes[number] = self._lacking(passes[number], number, out)
            barred = np.zeros_like(self.price)
            barred[out.target] = np.inf
            self.refill_passes(self.fill_passes(passes, barred))
            if self.value > value + self._options.worthless:
                untried = [(n, look) for n, looks in enumerate(self.best) for look in looks]

    def _answer(self, price: Array, row_price: Array) -> None:
        """What the passes would take at these prices, and what the Lagrangian then is."""
        rows = self.rows[: len(row_price)]
        costs, rents, room_value = self._keeping.priced(self._networks, rows, row_price)
        lagrangian = self._looking.beside(price) + room_value
        answers = self._answers(held_path, price, range(len(costs)), costs)
        for number, ((_, path, _), rent) in enumerate(zip(answers, rents, strict=True)):
            lagrangian += max(path.value - rent, 0.0)
            if path.looks:
                self._proposed.pop((number, path.looks), None)  # the latest come last
                self._proposed[number, path.looks] = None
        if lagrangian < self._bound:
            self._bound, self.price, self.row_price = lagrangian, price, row_price

    def _mixed(
        self, proposals: Sequence[Proposal], left_limit: Array, fixed: Passes | tuple[()]
    ) -> Mixture | None:
        """Rows that the mixture breaks join, until it breaks none."""
        own = [(number, looks) for number, looks in enumerate(fixed) if looks]
        mixture = None
        for _ in range(KEEPING.rounds):
            rows, scale = self._further(self._keeping.used_at_least, proposals, own)
            mixture = best_mixture(
                proposals, len(self._networks), self._looking, left_limit, self._options, rows
            )
            if mixture is None:
                return None
            mixture = replace(mixture, row_price=mixture.row_price / scale)
            if not self._joined(proposals, mixture.share, own):
                return mixture
        assert mixture is not None
        return replace(mixture, row_price=_as_long(mixture.row_price, np.zeros(len(self.rows))))

    def _further(
        self,
        used: Callable[[Sequence[Proposal], Sequence[RoomStretch]], Array],
        proposals: Sequence[Proposal],
        own: Sequence[Proposal],
    ) -> tuple[Rows, Array]:
        """Rows of like size, and what each was divided by."""
        taken = used(proposals, self.rows)
        room = [one.room_share for one in self.rows] - used(own, self.rows).sum(axis=1)
        scale = np.abs(taken).max(axis=1, initial=0.0)
        scale[scale < self._options.worthless] = 1.0
        return (taken / scale[:, None], room / scale), scale

    def _joined(self, proposals: Sequence[Proposal], share: Array, own: Sequence[Proposal]) -> bool:
        """Whether rows joined that these shares break."""
        mixed: list[list[tuple[float, tuple[Curve, ...]]]] = [[] for _ in self._networks]
        for (number, looks), part in zip(
            [*proposals, *own], [*share.tolist(), *([1.0] * len(own))], strict=True
        ):
            if part > self._options.worthless:
                mixed[number].append((part, self._keeping.curves(number, looks)))
        known = set(self.rows)
        new = [one for one in self._keeping.broken(mixed) if one not in known]
        self.rows += new
        return bool(new)

    def _together(self, proposals: Sequence[Proposal]) -> list[Proposal]:
        """By what is used as simulated, with rows that the answer breaks, until it breaks none."""
        found: list[Proposal] = []
        for _ in range(KEEPING.rounds):
            rows, _ = self._further(self._keeping.used, proposals, ())
            found = best_together(
                proposals, len(self._networks), self._looking, self._options, rows
            )
            if not self._joined(found, np.ones(len(found)), ()):
                break
        return found

    def _gain(self, proposal: Proposal) -> float:
        rows = self.rows[: len(self.row_price)]
        used = self._keeping.used_at_least([proposal], rows)[:, 0]
        return super()._gain(proposal) - float(self.row_price @ used)

    def _fitting_path(self, number: int, worth: Worth, passes: Passes) -> Path:
        """At the least price of a second at which all resources keep beside what others use."""
        network = self._networks[number]
        cost = NO_COST
        if self._rented is not None:
            rows = self.rows[: len(self._rented)]
            cost = self._keeping.cost(number, network, rows, self._rented)
        path = self._held_path(number, worth, cost)
        own = sum(look.value - worth.price[look.target] for look in passes[number])
        if path.value <= own + self._options.worthless:
            return path
        if self._keeping.keeps(passes, number, path.looks):
            return _unpaid(path, worth)
        found = [Path(value=0.0, looks=())]
        low, high = 0.0, self._most_a_second(network)
        for _ in range(KEEPING.dearer):
            middle = 0.5 * (low + high)
            dearer = self._keeping.dear(network._replace(cost=cost), middle)
            path = self._held_path(number, worth, dearer)
            if path.looks:
                self._proposed[number, path.looks] = None
            if self._keeping.keeps(passes, number, path.looks):
                found.append(_unpaid(path, worth))
                high = middle
                continue
            low = middle
            found += self._fewer(number, path, worth, passes)
        return max(found, key=lambda one: one.value)

    def _most_a_second(self, network: Network) -> float:
        """No look of a pass is worth more in a second."""
        targets, looking = network.target, self._looking
        held = looking.held_steps[targets]
        worths = np.where(held > 0, looking.look_value[targets] / np.maximum(held, 1), 0.0)
        return float(worths.max()) / self._keeping.step_s

    def _costs(self, numbers: Sequence[int]) -> Sequence[Array]:
        rows, networks = self.rows[: len(self.row_price)], self._networks
        return [self._keeping.cost(n, networks[n], rows, self.row_price) for n in numbers]

    def _fewer(self, number: int, path: Path, worth: Worth, passes: Passes) -> Iterator[Path]:
        """A path that uses too much, without the looks that are worth least for their time."""
        looks = list(path.looks)
        gain = {
            look: (look.value - worth.price[look.target]) / worth.steps[look.target, look.length]
            for look in looks
        }
        for worst in sorted(looks, key=lambda look: gain[look])[:-1]:
            looks.remove(worst)
            if self._looking.group[worst.target] >= 0:
                return
            fewer = self._with_only(number, [look.target for look in looks])
            is_held = self._passes.first_unheld(fewer) is None
            if is_held and self._keeping.keeps(passes, number, fewer):
                self._proposed[number, fewer] = None
                yield _unpaid(Path(value=0.0, looks=fewer), worth)
                return

    def _repaired(self, passes: Passes) -> Passes:
        """Without looks that are worth least for what they use, until all resources keep."""
        passes = list(passes)
        while (row := self._first_broken(passes)) is not None:
            rows = [row]
            taken = [
                (look.value / max(float(used), self._options.worthless), number, look)
                for number, looks in enumerate(passes)
                for look in looks
                for used in self._keeping.used_at_least([(number, (look,))], rows)[:, 0]
                if self._keeping.is_in(number, row)
            ]
            _, number, look = min(taken, key=lambda one: (one[0], one[1], one[2].first_step))
            passes[number] = self._lacking(passes[number], number, look)
        while turning := self._keeping.turning_looks(passes):
            number, look = min(turning, key=lambda one: (one[1].value, one[1].first_step))
            passes[number] = self._lacking(passes[number], number, look)
        return passes if self._first_broken(passes) is None else self._repaired(passes)

    def _lacking(self, looks: tuple[Look, ...], number: int, out: Look) -> tuple[Look, ...]:
        rest = [one.target for one in looks if one is not out]
        return self._with_only(number, rest) if rest else ()

    def _first_broken(self, passes: Passes) -> RoomStretch | None:
        mixed = [[(1.0, self._keeping.curves(number, one))] for number, one in enumerate(passes)]
        return min(self._keeping.broken(mixed), key=lambda one: one.to_s, default=None)


def _as_long(price: Array, other_price: Array) -> Array:
    """Prices of rows, none of those that joined since."""
    return np.append(price, np.zeros(max(len(other_price) - len(price), 0)))


def _unpaid(path: Path, worth: Worth) -> Path:
    """Worth what it is less the prices of targets alone."""
    value = sum(look.value - float(worth.price[look.target]) for look in path.looks)
    return replace(path, value=value)
