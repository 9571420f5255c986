"""Every motion on a bench is planned end to end.

Every target mode is planned in contracts/test_http_views.py, by its worked example.
"""

import pytest
from scenarios import scenario, session

from planner.planning.sessions.pipeline import make_plan
from planner.world.targets import BenchMotionTarget
from planner.world.targets.axis_signals import Chirp, ConstantRate, Multisine, Step, Triangle


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
