"""Every target mode is planned end to end, and accepted by the judge."""

from typing import get_args

import pytest
from scenarios import EPOCH, LAS_VEGAS, scenario, session

from planner.base.errors import NotVisible, TrackBreaksLimit
from planner.planning.sessions.pipeline import make_plan
from planner.world.targets import (
    BenchMotionTarget,
    BodyTarget,
    GroundPathTarget,
    MovingGroundTarget,
    PlaceTarget,
    StarTarget,
    Target,
)
from planner.world.targets.axis_signals import Chirp, ConstantRate, Multisine, Sine, Step, Triangle
from planner.world.targets.ground_path import PathPoint

TARGETS = {
    "ground": LAS_VEGAS,
    "ground_moving": MovingGroundTarget(
        latitude_deg=36.1, longitude_deg=-115.2, epoch=EPOCH, course_deg=45.0, speed_m_s=250.0
    ),
    "ground_path": GroundPathTarget(
        points=(
            PathPoint(latitude_deg=36.0, longitude_deg=-115.4),
            PathPoint(latitude_deg=36.3, longitude_deg=-115.0),
            PathPoint(latitude_deg=36.6, longitude_deg=-115.2),
        ),
        speed_m_s=900.0,
    ),
    "place": PlaceTarget(name="Las Vegas, Nevada, US"),
    "star": StarTarget(hip=91262),
    "body": BodyTarget(name="Moon"),
    "test_motion": BenchMotionTarget(
        axes={
            "alpha": Sine(amplitude_deg=2.0, frequency_hz=0.05),
            "beta": ConstantRate(rate_deg_s=0.1),
        }
    ),
}


def test_every_registered_mode_is_here():
    assert {mode.mode for mode in get_args(get_args(Target)[0])} == set(TARGETS)


@pytest.mark.parametrize("mode", TARGETS)
def test_is_planned(mode):
    for start_s in (140.0, 1500.0, 3000.0, 4500.0):  # some part of the sky is hidden at each
        try:
            plan = make_plan(scenario(session(TARGETS[mode], start_s, start_s + 60.0)))
        except NotVisible:
            continue
        assert plan.verification.passed
        assert plan.table.position.shape[1] == 2
        return
    pytest.fail("seen at none of the times")


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
        session(TARGETS["ground_path"], 100.0, 400.0)
