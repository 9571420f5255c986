"""Chooses looks, passes and order, and bounds how far from the best they can be."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array

from planner.arrays import Array, Indices
from planner.campaigns.network import Network
from planner.campaigns.path import Look, Worth, best_path, path_bound

Passes = list[tuple[Look, ...]]
Proposal = tuple[int, tuple[Look, ...]]
"""A pass by its number, and looks it could have, in order of time."""
Reporter = Callable[[str, int, int], None]
"""What is being done, and how many parts of how many of it are."""

ROUNDS_MAX = 150
STEP_MIN = 1e-3  # of Polyak's: no price moves any more
PATIENCE = 8  # rounds without a better bound before the step is halved
FILL_EVERY = 10
SWEEPS_MAX = 10
PROPOSALS_MAX = 6000  # the latest, made at the best prices
COMBINE_S = 20.0  # most time for the integer programme
COMBINED_GAP_ENOUGH = 1e-4  # of it
GAP_ENOUGH = 1e-3
BOUND_LABELS_MAX = 4_000_000  # of all passes, of one an eighth of them: some seconds
WORTHLESS = 1e-9  # of rounding


@dataclass(frozen=True, kw_only=True)
class CampaignChoice:
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

    length_steps, look_value: (targets, lengths), steps on the grid until it has ended and what
    it is worth at the best view; 0 for lengths there are not.  look_limit: (targets,).
    """

    length_steps: Indices
    look_value: Array
    look_limit: Array

    def at(self, price: Array) -> Worth:
        """Less a price for each look, (targets,)."""
        return Worth(self.length_steps, self.look_value, price)

    def looks_of(self, passes: Iterable[Sequence[Look]]) -> Array:
        """How many looks each target gets, (targets,)."""
        target = [one.target for looks in passes for one in looks]
        return np.bincount(target, minlength=len(self.look_limit)).astype(np.float64)


def worth_of(passes: Iterable[Sequence[Look]]) -> float:
    """Of all looks together."""
    return sum(one.worth for looks in passes for one in looks)


def choose(networks: Sequence[Network], looking: Looking, tell: Reporter) -> CampaignChoice:
    """Prices on looks that more passes want than may have them; one network per pass.

    Subgradient steps on the prices, and at every few of them a choice that can be flown.
    Source: Fisher 1981, "The Lagrangian relaxation method", Management Science 27.
    """
    search = _Search(networks, looking)
    free = np.zeros(len(looking.look_limit))
    greedy = search.fill_passes([()] * len(networks), free)
    search.improve(greedy)
    price = search.find_prices(tell)
    tell("choosing", ROUNDS_MAX, ROUNDS_MAX)
    search.combine()
    return CampaignChoice(
        passes=tuple(search.best),
        value=search.value,
        greedy_value=worth_of(greedy),
        price=price,
    )


class _Search:
    """The best choice so far, and the paths that were proposed on the way."""

    def __init__(self, networks: Sequence[Network], looking: Looking) -> None:
        self._networks = networks
        self._looking = looking
        self.best: Passes = [()] * len(networks)
        self.value = 0.0
        self._bound = float(looking.look_limit @ looking.look_value.max(axis=1))
        self._proposed: dict[Proposal, None] = {}

    def find_prices(self, tell: Reporter) -> Array:
        """Prices at which the bound is about least; improves the choice on the way."""
        looking = self._looking
        # At these nothing gains: all looks at their best.
        best_price: Array = looking.look_value.max(axis=1)
        price = np.zeros_like(best_price)
        step, waited = 1.0, 0
        for done in range(ROUNDS_MAX):
            tell("choosing", done, ROUNDS_MAX)
            bound, passes = self._answers(price)
            waited += 1
            if bound < self._bound * (1.0 - GAP_ENOUGH / 100.0):
                self._bound, best_price, waited = bound, price, 0
            elif waited % PATIENCE == 0:
                step *= 0.5
            if done % FILL_EVERY == 0:
                self.improve(self.fill_passes([()] * len(self._networks), price))
            wanted = looking.looks_of(passes) - looking.look_limit
            wanted[(wanted < 0.0) & (price <= 0.0)] = 0.0
            square = float(wanted @ wanted)
            if step < STEP_MIN or square == 0.0 or self._is_near():
                break
            price = np.maximum(price + step * (bound - self.value) / square * wanted, 0.0)
        return best_price

    def _is_near(self) -> bool:
        return self._bound - self.value <= GAP_ENOUGH * self._bound

    def _answers(self, price: Array) -> tuple[float, Passes]:
        """What the passes would take at these prices, and what the Lagrangian then is."""
        worth = self._looking.at(price)
        paths = [best_path(one, worth) for one in self._networks]
        lagrangian = float(self._looking.look_limit @ price) + sum(path.value for path in paths)
        self._propose([path.looks for path in paths])
        return lagrangian, [path.looks for path in paths]

    def _propose(self, passes: Passes) -> None:
        self._proposed.update({(n, looks): None for n, looks in enumerate(passes) if looks})

    def fill_passes(self, start: Passes, price: Array) -> Passes:
        """Pass after pass is given its best path at the prices for what the others leave."""
        looking = self._looking
        passes = list(start)
        left = looking.look_limit - looking.looks_of(passes)
        for number, network in enumerate(self._networks):
            left += looking.looks_of([passes[number]])
            charged = np.where(left > 0.0, price, np.inf)
            path = best_path(network, looking.at(charged))
            own = sum(look.worth - price[look.target] for look in passes[number])
            if path.value > own + WORTHLESS:
                passes[number] = path.looks
            left -= looking.looks_of([passes[number]])
        return passes

    def improve(self, passes: Passes) -> None:
        """Refill without prices until nothing is gained; the best choice is kept."""
        free = np.zeros(len(self._looking.look_limit))
        value = worth_of(passes)
        for _ in range(SWEEPS_MAX):
            better = self.fill_passes(passes, free)
            gained = worth_of(better) - value
            if gained <= WORTHLESS:
                break
            passes, value = better, value + gained
        self._propose(passes)
        if value > self.value:
            self.best, self.value = passes, value

    def combine(self) -> None:
        """The best of all that was proposed, unless the choice is near the bound already."""
        if self._is_near():
            return
        latest = list(self._proposed)[-PROPOSALS_MAX:]
        own = [(n, looks) for n, looks in enumerate(self.best) if looks]
        proposals = list(dict.fromkeys([*own, *latest]))
        proposal_value = [worth_of([looks]) for _, looks in proposals]
        passes: Passes = [()] * len(self._networks)
        for number, looks in _best_together(
            proposals, proposal_value, len(passes), self._looking.look_limit, COMBINE_S
        ):
            passes[number] = looks
        self.improve(passes)


def _best_together(
    proposals: Sequence[Proposal],
    proposal_value: Sequence[float],
    passes: int,
    look_limit: Array,
    time_s: float,
) -> list[Proposal]:
    """At most one per pass, no target looked at too often; the best found in time_s.

    proposal_value: of each.  look_limit: (targets,).  An integer programme, solved by HiGHS.
    """
    entries = [
        (row, number)
        for number, (pass_number, looks) in enumerate(proposals)
        for row in (pass_number, *(passes + look.target for look in looks))
    ]
    if not entries:
        return []
    row, place = np.array(entries).T
    shape = (passes + len(look_limit), len(proposals))
    solved = milp(
        -np.array(proposal_value),
        integrality=np.ones(len(proposals), np.intp),
        bounds=Bounds(0.0, 1.0),
        constraints=LinearConstraint(
            csr_array((np.ones(len(row)), (row, place)), shape=shape),
            ub=np.concatenate([np.ones(passes), look_limit]),
        ),
        options={"time_limit": time_s, "mip_rel_gap": COMBINED_GAP_ENOUGH},
    )
    if solved.x is None:
        return []
    return [one for one, share in zip(proposals, solved.x, strict=True) if share > 0.5]


def bound_at(networks: Sequence[Network], looking: Looking, price: Array) -> float:
    """No choice of paths is worth more, whatever the prices >= 0, (targets,).

    Lagrangian relaxation of "no more looks than look_limit".
    """
    labels_max = BOUND_LABELS_MAX // max(len(networks), 8)
    return float(looking.look_limit @ price) + sum(
        path_bound(one, looking.at(price), labels_max) for one in networks
    )
