"""Each method of slewing keeps the promises both make."""

import math
import time

import numpy as np
import pytest

from planner.motion.baseline import paper_slew
from planner.motion.slew import optimal_slew
from planner.motion.slew.problem import AxisState, SlewProblem
from planner.motion.slew.solution import violations
from planner.world.platforms import ISS_HRC
from planner.world.scenario import SlewOptions

LIMITS = ISS_HRC.outer_limits
METHODS = {"ocp": optimal_slew, "spline": lambda problem: paper_slew(problem, SlewOptions())}


def problem(duration_s=60.0):
    return SlewProblem(
        axis_names=ISS_HRC.axis_names,
        limits=ISS_HRC.axis_limits,
        start=(AxisState(angle_rad=0.1, rate_rad_s=0.01), AxisState(angle_rad=-0.4)),
        end=(
            AxisState(angle_rad=1.3, rate_rad_s=0.005, acceleration_rad_s2=1e-4),
            AxisState(angle_rad=0.2, rate_rad_s=-0.002),
        ),
        duration_s=duration_s,
    )


@pytest.mark.parametrize("method", METHODS)
def test_solution_spans_the_duration_and_starts_where_it_must(method):
    solution = METHODS[method](problem())
    assert len(solution.profiles) == len(solution.status) == 2
    assert solution.duration_s == pytest.approx(60.0, abs=1e-9)
    angle, rate, _, _ = solution.motion(np.array([0.0]))
    np.testing.assert_allclose(angle[0], [0.1, -0.4], rtol=0, atol=1e-9)
    np.testing.assert_allclose(rate[0], [0.01, 0.0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("duration_s", [28.0, 60.0])
def test_violations_are_never_hidden(method, duration_s):
    solution = METHODS[method](problem(duration_s))
    found = tuple(
        violation
        for axis, profile in zip(solution.problem.axis_names, solution.profiles, strict=True)
        for violation in violations(axis, profile, LIMITS)
    )
    assert solution.violations == found
    if SlewOptions(method=method).keeps_limits:
        assert found == ()
        assert max(map(abs, solution.end_error_rad)) < math.radians(0.1 / 3600)


@pytest.mark.parametrize("method", METHODS)
def test_a_solution_tells_how_long_it_took(method):
    began_s = time.perf_counter()
    solution = METHODS[method](problem())
    assert 0.0 < solution.wall_s <= time.perf_counter() - began_s
    if method == "spline":
        assert solution.iterations == 0  # a cubic needs no solver


@pytest.mark.parametrize(
    ("field", "change"),
    [
        ("duration_s", {"duration_s": 0.0}),
        ("limits", {"limits": (LIMITS,)}),
        (
            "end.beta.rate_rad_s",
            {"end": (AxisState(angle_rad=0.0), AxisState(angle_rad=0.0, rate_rad_s=1.0))},
        ),
    ],
)
def test_problems_that_make_no_sense_are_refused_by_name(field, change):
    fields = {name: getattr(problem(), name) for name in problem().__dataclass_fields__}
    with pytest.raises(ValueError, match=field):
        SlewProblem(**{**fields, **change})
