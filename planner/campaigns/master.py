"""Picks the paths, one proposed for each pass, that go together best."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array

from planner.arrays import Array
from planner.campaigns.path import Look

Proposal = tuple[int, tuple[Look, ...]]
"""A pass by its number, and looks it could have, in order of time."""

GAP_ENOUGH = 1e-4


def best_together(
    proposals: Sequence[Proposal],
    values: Sequence[float],
    passes: int,
    look_limit: Array,
    time_s: float,
) -> list[Proposal]:
    """At most one per pass, no target looked at too often; the best found in time_s.

    values: of the proposals.  look_limit: (targets,).  An integer programme, solved by HiGHS.
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
        -np.array(values),
        integrality=np.ones(len(proposals), np.intp),
        bounds=Bounds(0.0, 1.0),
        constraints=LinearConstraint(
            csr_array((np.ones(len(row)), (row, place)), shape=shape),
            ub=np.concatenate([np.ones(passes), look_limit]),
        ),
        options={"time_limit": time_s, "mip_rel_gap": GAP_ENOUGH},
    )
    if solved.x is None:
        return []
    return [one for one, share in zip(proposals, solved.x, strict=True) if share > 0.5]
