"""Sequences proposed for the passes, put together by linear and integer programmes (HiGHS)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, linprog, milp
from scipy.sparse import csr_array

from planner.base.arrays import Array
from planner.planning.campaigns.path import Look

Proposal = tuple[int, tuple[Look, ...]]
"""A pass by its number, and looks it could have, in order of time."""

TOGETHER_S = 5.0  # most time for an integer programme; it is one of a part of the passes
GAP_ENOUGH = 1e-4  # of it


@dataclass(frozen=True, kw_only=True, eq=False)
class Mixture:
    """The most that shares of proposals are worth together.

    price: of a look at each target, at which none of the proposals gains, (targets,).
    share: of each proposal, (proposals,).
    """

    value: float
    price: Array
    share: Array


def best_mixture(proposals: Sequence[Proposal], passes: int, look_limit: Array) -> Mixture | None:
    """At most one share in all of each pass, no target looked at too often, (targets,)."""
    found = linprog(  # type: ignore[call-overload]  # its stubs know no sparse arrays
        -_worths(proposals),
        A_ub=_uses(proposals, passes, look_limit),
        b_ub=np.concatenate([np.ones(passes), look_limit]),
        method="highs",
    )
    if found.status != 0:
        return None
    return Mixture(value=-found.fun, price=-found.ineqlin.marginals[passes:], share=found.x)


def best_together(proposals: Sequence[Proposal], passes: int, look_limit: Array) -> list[Proposal]:
    """The same with whole proposals, as far as found in time."""
    found = milp(
        -_worths(proposals),
        integrality=np.ones(len(proposals), np.intp),
        bounds=Bounds(0.0, 1.0),
        constraints=LinearConstraint(
            _uses(proposals, passes, look_limit),
            ub=np.concatenate([np.ones(passes), look_limit]),
        ),
        options={"time_limit": TOGETHER_S, "mip_rel_gap": GAP_ENOUGH},
    )
    if found.x is None:
        return []
    return [one for one, share in zip(proposals, found.x, strict=True) if share > 0.5]


def _worths(proposals: Sequence[Proposal]) -> Array:
    return np.array([sum(look.value for look in looks) for _, looks in proposals])


def _uses(proposals: Sequence[Proposal], passes: int, look_limit: Array) -> csr_array:
    """Rows of passes and targets, a column per proposal."""
    rows = [[number, *(passes + look.target for look in looks)] for number, looks in proposals]
    column = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
    row = np.concatenate(rows).astype(np.intp)
    shape = (passes + len(look_limit), len(proposals))
    return csr_array((np.ones(len(row)), (row, column)), shape=shape)
