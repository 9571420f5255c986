"""The second derivatives given to the detour's solver are those that CasADi finds by itself."""

import casadi
import numpy as np
import pytest

from planner.motion.detour.ocp import DetourOcp
from planner.motion.detour.spline_ocp import graded_ocp

ROUNDING = 1e-9  # of the largest entry


@pytest.mark.parametrize("with_modes", [False, True])
@pytest.mark.parametrize("cones", [1, 2])
def test_given_as_differentiated(with_modes, cones):
    parts = DetourOcp(graded_ocp(8), cones, with_modes=with_modes, start="far")._parts
    lagrangian = parts.cost_weight * parts.cost + casadi.dot(parts.row_weights, parts.cosines)
    inputs = [parts.y, parts.parameters, parts.cost_weight, parts.row_weights]
    differentiated = casadi.triu(casadi.hessian(lagrangian, parts.y)[0])
    both = casadi.Function("both", inputs, [parts.hessian, differentiated])
    rng = np.random.default_rng(20261122)
    symmetric = np.concatenate(
        [np.ravel(m + m.T) for m in rng.normal(size=(2, *[parts.y.numel() // 2] * 2))]
    )
    values = [rng.normal(size=part.numel()) for part in inputs]
    if with_modes:  # a cost's hessian is symmetric
        values[1][parts.y.numel() : parts.y.numel() + symmetric.size] = symmetric
    given, found = (np.asarray(one.full()) for one in both(*values))
    assert np.abs(found).max() > 0.0
    assert np.abs(given - found).max() <= ROUNDING * np.abs(found).max()
