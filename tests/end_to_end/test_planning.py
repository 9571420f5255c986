"""Does every request end in a table the judge accepts, or in a refusal that helps?"""

from dataclasses import replace

import numpy as np
import pytest
from scenarios import (
    LARAMIE,
    LAS_VEGAS,
    SALT_LAKE,
    at,
    scenario,
    session,
)

from planner.errors import InfeasibleSlew, NotVisible, Refusal
from planner.pipeline import make_plan
from planner.scenario import SlewOptions
from planner.targets import GroundTarget


def replanned(asked, refusal, number=0):
    """The session moved to the times a refusal names."""
    moved = replace(
        asked.sessions[number],
        start=refusal.earliest_feasible_start_utc,
        stop=refusal.feasible_stop_utc,
    )
    sessions = (*asked.sessions[:number], moved, *asked.sessions[number + 1 :])
    return make_plan(replace(asked, sessions=sessions))


@pytest.mark.parametrize("objective", ["smooth", "minimum_time"])
def test_random_requests_on_a_real_pass(objective):
    """Targets within 300 km of Las Vegas, moving starts, any time of the pass."""
    rng = np.random.default_rng(20150227)
    verdicts, refused = [], 0
    for _ in range(40):
        target = GroundTarget(
            latitude_deg=36.1 + rng.uniform(-2.7, 2.7), longitude_deg=-115.2 + rng.uniform(-3, 3)
        )
        start_s = rng.uniform(2.0, 330.0)
        asked = scenario(
            session(target, start_s, start_s + rng.uniform(0.2, 90.0)),
            alpha=(rng.uniform(-150, 150), rng.uniform(-2, 2), rng.uniform(-0.5, 0.5)),
            beta=(rng.uniform(-150, 150), rng.uniform(-2, 2), rng.uniform(-0.5, 0.5)),
            slew=SlewOptions(objective=objective),
        )
        try:
            verdicts.append(make_plan(asked).verification.passed)
        except Refusal as refusal:
            refused += 1
            if refusal.earliest_feasible_start_utc is not None:
                verdicts.append(replanned(asked, refusal).verification.passed)
    assert all(verdicts)
    assert len(verdicts) > 30
    assert 5 < refused < 35


def test_a_refused_slew_names_the_very_first_row_that_works():
    asked = scenario(session(LAS_VEGAS, 140.0, 230.0), epoch_s=135)
    with pytest.raises(InfeasibleSlew) as refused:
        make_plan(asked)
    assert refused.value.axis == "alpha"
    assert refused.value.field == "sessions.0.start"
    start = refused.value.earliest_feasible_start_utc
    assert replanned(asked, refused.value).verification.passed
    earlier = replace(asked.sessions[0], start=start - (at(0.2) - at(0.0)))
    with pytest.raises(InfeasibleSlew):
        make_plan(replace(asked, sessions=(earlier,)))


@pytest.mark.parametrize("start_s", [-600.0, 960.0, 40000.0])
def test_a_target_below_the_horizon_names_a_start_when_it_is_not(start_s):
    asked = scenario(session(LAS_VEGAS, start_s, start_s + 60.0), epoch_s=-3600)
    with pytest.raises(NotVisible) as refused:
        make_plan(asked)
    assert replanned(asked, refused.value).verification.passed


def test_three_sessions_of_one_pass():
    plan = make_plan(
        scenario(
            session(LAS_VEGAS, 140.0, 200.0),
            session(SALT_LAKE, 230.0, 270.0),
            session(LARAMIE, 300.0, 350.0),
        )
    )
    assert [segment.kind for segment in plan.segments] == ["slew", "track"] * 3
    assert plan.verification.passed
    assert plan.warnings == ()


TIGHT = (
    session(LAS_VEGAS, 140.0, 200.0),
    session(SALT_LAKE, 208.0, 270.0),
    session(LARAMIE, 275.0, 350.0),
)


def lost_s(asked, plan):
    """Session time asked for and not flown."""
    return sum(
        ((was.stop - was.start) - (left.stop - left.start)).total_seconds()
        for was, left in zip(asked.sessions, plan.scenario.sessions, strict=True)
    )


def test_a_tight_sequence_is_refused_with_what_each_session_would_give_up():
    asked = scenario(*TIGHT)
    with pytest.raises(InfeasibleSlew) as refused:
        make_plan(asked)
    assert refused.value.field == "sessions.1.start"
    offers = {offer.on_conflict: offer for offer in refused.value.give_up}
    assert set(offers) == {"shorten_later", "shorten_earlier", "least_loss"}
    assert offers["shorten_later"].session == 1
    assert offers["shorten_later"].start_later_s > 0.0
    assert offers["shorten_earlier"].session == 0
    assert offers["shorten_earlier"].stop_earlier_s > 0.0


def test_a_tight_sequence_is_shortened_as_asked():
    losses_s = {}
    for mode in ("shorten_later", "shorten_earlier", "least_loss"):
        asked = scenario(*TIGHT, on_conflict=mode)
        plan = make_plan(asked)
        assert plan.verification.passed
        losses_s[mode] = lost_s(asked, plan)
        assert len(plan.warnings) == 2
    assert 0.0 < losses_s["least_loss"] <= min(losses_s.values())


def test_a_session_off_the_grid_is_enclosed_by_rows():
    plan = make_plan(scenario(session(LAS_VEGAS, 140.137, 140.4371)))
    track = plan.segments[-1]
    assert (track.start_utc, track.stop_utc) == (at(140.0), at(140.6))


def test_minimum_time_joins_the_track_early_and_the_paper_waits():
    quick = make_plan(
        scenario(session(LAS_VEGAS, 140.0, 230.0), slew=SlewOptions(objective="minimum_time"))
    )
    assert quick.segments[1].start_utc < at(40.0)
    # within two rows of what the limits allow to the state it meets
    assert quick.slews[0].duration_s <= quick.slews[0].minimum_s + 0.4
    paper = make_plan(
        scenario(
            session(LAS_VEGAS, 140.0, 230.0),
            slew=SlewOptions(method="spline", objective="minimum_time"),
        )
    )
    assert [segment.kind for segment in paper.segments] == ["wait", "slew", "track"]
    assert not paper.verification.passed
    broken = {finding.limit for finding in paper.verification.findings}
    assert "pointing" in broken  # the filter's lag, 8 arcsec at the join
