"""Which looks, in which passes, in what order; and how far from the best can that be?"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.schedule.network import Network
from planner.schedule.path import Look, best_path, path_bound

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Passes = list[tuple[Look, ...]]
Reporter = Callable[[str, int, int], None]
"""What is being done, and how many parts of how many of it are."""

ROUNDS_MAX = 150
STEP_MIN = 1e-3  # of Polyak's: no price moves any more
PATIENCE = 8  # rounds without a better bound before the step is halved
FILL_EVERY = 10
SWEEPS_MAX = 10
GAP_ENOUGH = 1e-3
WORTHLESS = 1e-9  # of rounding


@dataclass(frozen=True, kw_only=True)
class Choice:
    """passes: looks in order of time, one tuple per pass.

    value: what they are worth.  greedy_value: what taking pass after pass whatever is worth
    most there is worth.  price: of a look at each target at which the bound is least,
    (targets,).
    """

    passes: tuple[tuple[Look, ...], ...]
    value: float
    greedy_value: float
    price: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Looking:
    """What looks at each target may be.

    length_steps, worth: (targets, lengths), steps on the grid until it has ended and what it
    is worth; worth 0 for lengths there are not.  most_looks: (targets,).
    """

    length_steps: Indices
    worth: Array
    most_looks: Array

    def worth_of(self, passes: Iterable[Sequence[Look]]) -> float:
        """Of all looks together."""
        return float(sum(self.worth[one.target, one.length] for looks in passes for one in looks))

    def looks_of(self, passes: Iterable[Sequence[Look]]) -> Array:
        """How many looks each target gets, (targets,)."""
        target = [one.target for looks in passes for one in looks]
        return np.bincount(target, minlength=len(self.most_looks)).astype(np.float64)


def choose(networks: Sequence[Network], looking: Looking, tell: Reporter) -> Choice:
    """Prices on looks that more passes want than may have them; one network per pass.

    Subgradient steps on the prices, and at every few of them a choice that can be flown.
    Source: Fisher 1981, "The Lagrangian relaxation method", Management Science 27.
    """
    free = np.zeros(len(looking.most_looks))
    greedy = _filled(networks, looking, [()] * len(networks), free)
    best = _improved(networks, looking, greedy)
    greedy_value, value = looking.worth_of(greedy), looking.worth_of(best)
    price, best_price, least_bound = free, free, np.inf
    step, waited = 1.0, 0
    for done in range(ROUNDS_MAX):
        tell("choosing", done, ROUNDS_MAX)
        bound, passes = _answers(networks, looking, price)
        if bound < least_bound * (1.0 - 1e-5):
            least_bound, best_price, waited = bound, price, 0
        else:
            waited += 1
            if waited % PATIENCE == 0:
                step *= 0.5
        if done % FILL_EVERY == 0:
            filled = _filled(networks, looking, [()] * len(networks), price)
            found = _improved(networks, looking, filled)
            if looking.worth_of(found) > value:
                best, value = found, looking.worth_of(found)
        if least_bound - value <= GAP_ENOUGH * least_bound or step < STEP_MIN:
            break
        wanted = looking.looks_of(passes) - looking.most_looks
        wanted[(wanted < 0.0) & (price <= 0.0)] = 0.0
        square = float(wanted @ wanted)
        if square == 0.0:
            break
        price = np.maximum(price + step * (bound - value) / square * wanted, 0.0)
    return Choice(passes=tuple(best), value=value, greedy_value=greedy_value, price=best_price)


def _answers(networks: Sequence[Network], looking: Looking, price: Array) -> tuple[float, Passes]:
    """What the passes would take at these prices, and what the Lagrangian then is."""
    gain = looking.worth - price[:, None]
    paths = [best_path(one, looking.length_steps, gain, each_once=True) for one in networks]
    lagrangian = float(looking.most_looks @ price) + sum(path.value for path in paths)
    return lagrangian, [path.looks for path in paths]


def bound_at(networks: Sequence[Network], looking: Looking, price: Array) -> float:
    """No choice of paths is worth more, whatever the prices >= 0, (targets,).

    Lagrangian relaxation of "no more looks than most_looks".
    """
    gain = looking.worth - price[:, None]
    return float(looking.most_looks @ price) + sum(
        path_bound(one, looking.length_steps, gain) for one in networks
    )


def _filled(networks: Sequence[Network], looking: Looking, start: Passes, price: Array) -> Passes:
    """Pass after pass is given its best path at the prices for what the others leave."""
    passes = list(start)
    left = looking.most_looks - looking.looks_of(passes)
    for number, network in enumerate(networks):
        left += looking.looks_of([passes[number]])
        gain = np.where((left > 0.0)[:, None], looking.worth - price[:, None], 0.0)
        path = best_path(network, looking.length_steps, gain, each_once=True)
        own = sum(gain[look.target, look.length] for look in passes[number])
        if path.value > own + WORTHLESS:
            passes[number] = path.looks
        left -= looking.looks_of([passes[number]])
    return passes


def _improved(networks: Sequence[Network], looking: Looking, start: Passes) -> Passes:
    """Refilled without prices until nothing is gained."""
    free = np.zeros(len(looking.most_looks))
    passes = start
    for _ in range(SWEEPS_MAX):
        better = _filled(networks, looking, passes, free)
        if looking.worth_of(better) <= looking.worth_of(passes) + WORTHLESS:
            break
        passes = better
    return passes
