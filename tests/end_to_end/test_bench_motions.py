"""Every motion on a bench is planned end to end; what can not be followed is refused.

Every target mode is planned in contracts/test_http_views.py, by its worked example.
"""

import pytest
from scenarios import scenario, session

from planner.base.errors import TrackBreaksLimit
from planner.planning.sessions.pipeline import make_plan
from planner.world.targets import (
    BenchMotionTarget,
    GroundPathTarget,
)
from planner.world.targets.axis_signals import Chirp, ConstantRate, Multisine, Sine, Step, Triangle
from planner.world.targets.ground_path import PathPoint

PATH = GroundPathTarget(
    points=(
        PathPoint(latitude_deg=36.0, longitude_deg=-115.4),
        PathPoint(latitude_deg=36.3, longitude_deg=-115.0),
        PathPoint(latitude_deg=36.6, longitude_deg=-115.2),
    ),
    speed_m_s=900.0,
)


@pytest.mark.parametrize(
    "motion",
    [
        Chirp(amplitude_deg=0.5, start_frequency_hz=0.01, stop_frequency_hz=0.2, sweep_s=60.0),
        Step(step_deg=5.0, at_s=10.0, rise_s=20.0),
        Triangle(amplitude_deg=5.0, period_s=60.0, turn_s=10.0),
        Multisine(amplitudes_deg=(0.5, 0.3, 0.1), frequencies_hz=(0.02, 0.05, 0.1)),
    ],
    ids=lambda motion: motion.kind,
)
def test_every_bench_motion_is_flown(motion):
    target = BenchMotionTarget(axes={"alpha": motion, "beta": ConstantRate(rate_deg_s=0.0)})
    plan = make_plan(scenario(session(target, 60.0, 120.0)))
    assert plan.verification.passed
    assert plan.budgets == (None,)


def test_a_motion_too_quick_is_refused_by_axis_and_field():
    target = BenchMotionTarget(
        axes={
            "alpha": Sine(amplitude_deg=10.0, frequency_hz=0.2),
            "beta": ConstantRate(rate_deg_s=0.0),
        }
    )
    with pytest.raises(TrackBreaksLimit) as refused:
        make_plan(scenario(session(target, 60.0, 120.0)))
    assert refused.value.axis == "alpha"
    assert refused.value.field == "sessions.0.target.axes.alpha"


def test_a_session_that_outlasts_its_path_is_refused():
    with pytest.raises(ValueError, match="after the path's end"):
        session(PATH, 100.0, 400.0)
