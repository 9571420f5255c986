"""Passes priced, many at a time, here or elsewhere: what each would take at prices of looks."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from planner.base.arrays import Array
from planner.base.at_once import done_at_once
from planner.planning.campaigns.looking import FirstUnheld, Looking
from planner.planning.campaigns.network import NO_COST, Cut, Network, without_look
from planner.planning.campaigns.orders import most_worth
from planner.planning.campaigns.path import Path, Worth, best_path, bounded_path


class Networks(Protocol):
    """Of passes, by their number."""

    def __len__(self) -> int: ...

    def __getitem__(self, number: int, /) -> Network: ...


class AskedPass(NamedTuple):
    """A pass: its number, what is known that can't be held in it, and what its looks cost, as of
    `Network`."""

    number: int
    cuts: tuple[Cut, ...] = ()
    cost: Array = NO_COST


class PricedPath(NamedTuple):
    """Of a pass: what none of its paths gains more than, the best one known, and what can't be
    held, with all that was found out meanwhile."""

    most_value: float
    path: Path
    cuts: tuple[Cut, ...]


Put = Callable[["PricedPasses", AskedPass, Worth], PricedPath]


class Question(NamedTuple):
    """Put to each of many passes.

    put: a function of this module, or part of one.  price: of a look at each target, (targets,).
    """

    put: Put
    price: Array


Ask = Callable[[Question, Sequence[AskedPass]], Sequence[PricedPath]]
"""Answers in the passes' order, the same wherever they are found."""


class PricedPasses:
    """Passes that answer here.

    networks: slew times suffice.  relaxed: the same at slew times that nothing can beat.
    looking: settle_steps are by these passes' numbers.
    """

    def __init__(
        self,
        networks: Networks,
        relaxed: Networks,
        looking: Looking,
        first_unheld: FirstUnheld,
    ) -> None:
        self.networks, self.relaxed, self.looking = networks, relaxed, looking
        self.first_unheld = first_unheld
        self._cut: dict[int, tuple[tuple[Cut, ...], Network]] = {}

    def answers(self, question: Question, asked: Sequence[AskedPass]) -> Sequence[PricedPath]:
        """An `Ask`, by threads."""
        worth = self.looking.less_prices(question.price)
        return [*done_at_once(lambda one: question.put(self, one, worth), asked)]

    def with_looking(self, looking: Looking) -> "PricedPasses":
        """The same passes, with other looks in them."""
        return PricedPasses(self.networks, self.relaxed, looking, self.first_unheld)

    def cut_network(self, number: int, cuts: tuple[Cut, ...]) -> Network:
        """Without what can't be held."""
        known, network = self._cut.get(number, ((), self.networks[number]))
        if cuts[: len(known)] != known:
            known, network = (), self.networks[number]
        if len(cuts) > len(known):
            for cut in cuts[len(known) :]:
                network = without_look(network, cut)
            self._cut[number] = cuts, network
        return network


def free_path(passes: PricedPasses, asked: AskedPass, worth: Worth) -> PricedPath:
    """The best path, whether or not its looks can be held."""
    settled = passes.looking.settled(worth, asked.number)
    path = best_path(passes.networks[asked.number]._replace(cost=asked.cost), settled)
    return PricedPath(path.value, path, asked.cuts)


def held_path(passes: PricedPasses, asked: AskedPass, worth: Worth) -> PricedPath:
    """The best path whose looks can be held: one that those before it don't let be held is taken
    after them no more."""
    number, cuts, cost = asked
    settled = passes.looking.settled(worth, number)
    while True:
        network = passes.cut_network(number, cuts)
        path = best_path(network._replace(cost=cost), settled)
        unheld = passes.first_unheld(path.looks)
        if unheld is None:
            return PricedPath(path.value, path, cuts)
        cuts = (*cuts, _cut_at(network, path, *unheld, settled.settle_steps))


def _cut_at(network: Network, path: Path, place: int, last_step: int, settle_steps: int) -> Cut:
    """place, last_step: as of `FirstUnheld`."""
    look = path.looks[place]
    way, *before = (
        int(network.way.searchsorted(one.way))
        for one in reversed(path.looks[max(place - 1, 0) : place + 1])
    )
    cell = int(network.offset[way] - network.first[way]) - network.first_step
    begin = cell + look.first_step - settle_steps
    end = max(cell + last_step, begin)
    return Cut(before[0] if before else None, way, begin, end)


def bounded_held_path(
    passes: PricedPasses, asked: AskedPass, worth: Worth, labels_max: int
) -> PricedPath:
    """As `held_path`, and what no path, held or not, is worth more than."""
    settled = passes.looking.settled(worth, asked.number)
    most, path = bounded_path(passes.networks[asked.number], settled, labels_max)
    if passes.first_unheld(path.looks) is None:
        return PricedPath(most, path, asked.cuts)
    return held_path(passes, asked, worth)._replace(most_value=most)


def most_at_best(
    passes: PricedPasses, asked: AskedPass, worth: Worth, labels_max: int, orders_max: int
) -> PricedPath:
    """What no path is worth more than at slew times that nothing can beat; the path isn't told."""
    settled = passes.looking.settled(worth, asked.number)
    network = passes.relaxed[asked.number]._replace(cost=asked.cost)
    most = min(
        bounded_path(network, settled, labels_max)[0], most_worth(network, settled, orders_max)
    )
    return PricedPath(most, Path(value=0.0, looks=()), asked.cuts)
