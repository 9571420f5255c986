"""Rows of an attitude message that can't be right, seeing their neighbours."""

import numpy as np

from planner.arrays import Array

# Offsets, in rows, of the four rows that foretell a row: from both sides, from before, from
# after.  A manoeuvre that begins or ends leaves one side right; a damaged row fits none.
_STENCILS = ((-2, -1, 1, 2), (-4, -3, -2, -1), (1, 2, 3, 4))
REACH = 2  # rows at either end whose place between neighbours can't be judged


def odd_by_rad(t_s: Array, q_body_from_frame_xyzw: Array) -> Array:
    """How far each row is, at least, from where a cubic through four others leads, shape (n,).

    t_s: shape (n,), increasing.  q_body_from_frame_xyzw: shape (n, 4), unit, neighbours of like
    sign.
    Zero for the first and last REACH rows.
    """
    odd_rad = np.full(len(t_s), np.inf)
    rows = np.arange(len(t_s))
    for stencil in _STENCILS:
        inside = (rows + min(stencil) >= 0) & (rows + max(stencil) < len(t_s))
        at = rows[inside]
        others = at[:, None] + np.array(stencil)
        weights = _lagrange(t_s[others] - t_s[at, None])
        miss = q_body_from_frame_xyzw[at] - np.einsum(
            "nk,nkj->nj", weights, q_body_from_frame_xyzw[others]
        )
        miss_rad = 2.0 * np.linalg.norm(miss, axis=1)
        odd_rad[at] = np.minimum(odd_rad[at], miss_rad)
    odd_rad[:REACH] = odd_rad[len(t_s) - REACH :] = 0.0
    return np.where(np.isfinite(odd_rad), odd_rad, 0.0)


def _lagrange(node_s: Array) -> Array:
    """Weights at zero of four nodes each, both of shape (n, 4)."""
    weights = np.ones_like(node_s)
    for node in range(4):
        for other in range(4):
            if other != node:
                weights[:, node] *= node_s[:, other] / (node_s[:, other] - node_s[:, node])
    return weights
