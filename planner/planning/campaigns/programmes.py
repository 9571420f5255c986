"""Sequences proposed for the passes, put together by linear and integer programmes (HiGHS)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, linprog, milp
from scipy.sparse import csr_array, vstack

from planner.base.arrays import Array
from planner.planning.campaigns.path import Look

if TYPE_CHECKING:
    from planner.planning.campaigns.choice import ChoiceOptions
    from planner.planning.campaigns.looking import Looking

Proposal = tuple[int, tuple[Look, ...]]
"""A pass by its number, and observations it could have, in order of time."""

Rows = tuple[Array, Array]
"""Further rows of a programme: what each takes of every proposal, (rows, proposals), and the most
that all together may take, (rows,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Mixture:
    """The most that shares of proposals are worth together.

    price: of a look at each target, at which none of the proposals gains, (targets,).
    share: of each proposal, (proposals,).  row_price: of each of the further rows.
    """

    value: float
    price: Array
    share: Array
    row_price: Array


def best_mixture(
    proposals: Sequence[Proposal],
    passes: int,
    looking: "Looking",
    left_limit: Array,
    options: "ChoiceOptions",
    further: Rows | None = None,
) -> Mixture | None:
    """Mix at most one share of each pass, no target observed too often, groups evenly.

    left_limit: looks at each target that are left beside those fixed, (targets,).  None where that
    takes too many iterations.
    """
    matrix, low, high = _with_rows(*_rows_of(proposals, passes, looking, left_limit), further)
    is_even = low == high
    even: dict[str, Any] = {"A_eq": matrix[is_even], "b_eq": high[is_even]} if is_even.any() else {}
    found: Any = linprog(
        -_column_worths(proposals, looking),
        A_ub=matrix[~is_even],
        b_ub=high[~is_even],
        **even,
        bounds=(0.0, 1.0 if even else None),
        method="highs" if len(high) < options.interior_rows else "highs-ipm",
        options={"maxiter": options.mixture_iterations_max},
    )
    if found.status != 0:
        return None
    price = np.empty(len(high))
    price[~is_even] = -found.ineqlin.marginals
    price[is_even] = -found.eqlin.marginals
    targets = slice(passes, passes + len(left_limit))
    return Mixture(
        value=-found.fun,
        price=price[targets],
        share=found.x[: len(proposals)],
        row_price=price[targets.stop + len(looking.way_limit) :],
    )


def best_together(
    proposals: Sequence[Proposal],
    passes: int,
    looking: "Looking",
    options: "ChoiceOptions",
    further: Rows | None = None,
) -> list[Proposal]:
    """Choose whole proposals, as far as found within the options' nodes."""
    rows = _rows_of(proposals, passes, looking, looking.look_limit)
    matrix, low, high = _with_rows(*rows, further)
    worths = _column_worths(proposals, looking)
    found = milp(
        -worths,
        integrality=np.ones(len(worths), np.intp),
        bounds=Bounds(0.0, 1.0),
        constraints=LinearConstraint(matrix, low, high),
        options={
            "node_limit": options.together_nodes,
            "mip_rel_gap": options.together_gap,
        },
    )
    if found.x is None:
        return []
    shares = found.x[: len(proposals)]
    return [one for one, share in zip(proposals, shares, strict=True) if share > 0.5]


def _with_rows(
    matrix: csr_array, low_limits: Array, high_limits: Array, further: Rows | None
) -> tuple[csr_array, Array, Array]:
    """With further rows below."""
    if further is None or not len(further[1]):
        return matrix, low_limits, high_limits
    takes, most = further
    wide = np.zeros((len(most), matrix.shape[1]))
    wide[:, : takes.shape[1]] = takes
    low = np.append(low_limits, np.full(len(most), -np.inf))
    high = np.append(high_limits, most)
    return csr_array(vstack([matrix, csr_array(wide)])), low, high


def _column_worths(proposals: Sequence[Proposal], looking: "Looking") -> Array:
    """Of proposals, and none of groups."""
    worths = [sum(look.value for look in looks) for _, looks in proposals]
    return np.array([*worths, *np.zeros(looking.groups)])


def _rows_of(
    proposals: Sequence[Proposal], passes: int, looking: "Looking", left_limit: Array
) -> tuple[csr_array, Array, Array]:
    """Rows of passes, targets and what groups are ways to do, with their least and greatest sums, a
    column for each proposal and each group: as often as its group a member is looked at."""
    rows = [[number, *(passes + look.target for look in looks)] for number, looks in proposals]
    members = np.flatnonzero(looking.group >= 0)
    column = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
    column = np.concatenate([column, len(rows) + looking.group[members]])
    row = np.concatenate([*rows, passes + members]).astype(np.intp)
    entries = np.ones(len(row))
    entries[len(row) - len(members) :] = -1.0
    things = passes + len(left_limit)
    column = np.concatenate([column, len(rows) + np.arange(looking.groups)])
    row = np.concatenate([row, things + looking.way_to])
    entries = np.concatenate([entries, np.ones(looking.groups)])
    shape = (things + len(looking.way_limit), len(proposals) + looking.groups)
    high = np.concatenate([np.ones(passes), left_limit, looking.way_limit])
    low = np.full(len(high), -np.inf)
    low[passes + members] = high[passes + members] = (left_limit - looking.look_limit)[members]
    return csr_array((entries, (row, column)), shape=shape), low, high
