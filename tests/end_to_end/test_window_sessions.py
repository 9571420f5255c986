"""Windows' sessions can be planned, as likely as told; a refusal knows the window it missed."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from scenarios import HRC, LAS_VEGAS, SALT_LAKE, TLE, advised, at, scenario, session

from app.requests.examples import message
from planner.base.errors import NotVisible, Refusal, Unreachable
from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
    Windows,
    find_opportunities,
)
from planner.planning.opportunities.windows import SESSION_MAX_S
from planner.planning.sessions import window_probability
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.window_probability import probabilities_in_frame
from planner.world.attitude import LvlhAttitude
from planner.world.attitude.aem import AemAttitude
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import OemOrbit, StateVectorOrbit
from planner.world.platforms import PLATFORMS, FieldMask
from planner.world.targets import BodyTarget, GroundTarget, MovingGroundTarget, StarTarget

PLACES = (
    LAS_VEGAS,
    GroundTarget(latitude_deg=42.36, longitude_deg=-71.06, height_m=10.0),
    GroundTarget(latitude_deg=55.75, longitude_deg=37.6, height_m=150.0),
)
ABOVE_DEG = 25.0


@pytest.mark.parametrize("begins_s", [0.0, 0.123])
def test_the_session_of_every_window_plans_as_it_stands(begins_s):
    request = OpportunityRequest(
        orbit=TLE,
        attitude=LvlhAttitude(),
        platform=PLATFORMS["iss-hrc"],
        start=at(begins_s),
        stop=at(43200.0),
        targets=tuple(
            OpportunityTarget(id=str(number), target=place) for number, place in enumerate(PLACES)
        ),
        conditions=OpportunityConditions(min_elevation_deg=ABOVE_DEG),
    )
    found = find_opportunities(request)
    times_s = found.windows.sessions_s(found.start_utc)
    assert len(times_s) >= 3
    for window, (start_s, stop_s) in enumerate(times_s):
        rise_s, set_s = found.windows.rise_s[window], found.windows.set_s[window]
        assert rise_s - 1e-4 <= start_s < rise_s + 0.2
        assert set_s - 0.2 < stop_s <= set_s + 1e-4
        target = replace(PLACES[found.windows.target[window]], min_elevation_deg=ABOVE_DEG)
        start, stop = (shifted_utc(found.start_utc, float(t_s)) for t_s in (start_s, stop_s))
        asked = session_alone(GALLERY, TLE, LvlhAttitude(), target, start, stop, 300)
        assert make_plan(asked).verification.passed


GALLERY = PLATFORMS["iss-hrc"]
NARROW = GALLERY.with_limits(
    (GALLERY.axis_limits[0], replace(GALLERY.axis_limits[1], angle_min_rad=-0.8, angle_max_rad=0.8))
)
ARM = FieldMask(
    name="arm",
    margin_deg=1.0,
    corners_platform=(
        (0.2, 4.0, 1.2), (0.7, 4.0, 1.2), (0.8, 1.5, 2.5),
        (1.7, 0.9, 2.4), (1.6, 0.6, 2.5), (0.5, 1.1, 2.7),
    ),
)  # fmt: skip
QUITO = GroundTarget(latitude_deg=-0.2, longitude_deg=-78.5, height_m=2850.0)
LONG = {"start": at(-21600.0), "conditions": OpportunityConditions()}
PARTLY_FOLLOWED = {
    "a star whose window opens and closes at a stop": (GALLERY, 0.0, StarTarget(hip=32349)),
    "a place the outer axis points straight at": (GALLERY, 80.0, LAS_VEGAS),
    "a place that comes out from behind a mask": (replace(GALLERY, masks=(ARM,)), 30.0, QUITO),
    "a star beside a stop of the inner axis": (NARROW, 0.0, StarTarget(name="Vega")),
}


def session_alone(platform, orbit, attitude, target, start, stop, lead_s=620):
    """From rest at zero some minutes before."""
    alone = scenario(session(target, 0.0, 1.0))
    return replace(
        alone,
        platform=platform,
        orbit=orbit,
        attitude=attitude,
        initial_state=replace(alone.initial_state, epoch=start - timedelta(seconds=lead_s)),
        sessions=(replace(alone.sessions[0], start=start, stop=stop),),
    )


@pytest.mark.parametrize(
    ("platform", "roll_deg", "target"), PARTLY_FOLLOWED.values(), ids=PARTLY_FOLLOWED
)
def test_a_session_is_what_the_axes_can_follow_of_its_window(platform, roll_deg, target):
    """By one pair of angles, within their rates, and braked before a stop: no longer part can."""
    attitude = LvlhAttitude(roll_deg=roll_deg)
    found = find_opportunities(search(target, 1.0, platform=platform, attitude=attitude, **LONG))
    windows = found.windows
    times_s = windows.sessions_s(found.start_utc)
    cut = np.column_stack(
        [times_s[:, 0] - windows.rise_s > 0.2, windows.set_s - times_s[:, 1] > 0.2]
    )
    assert cut.any()
    for window in np.flatnonzero(cut.any(axis=1))[: 1 if platform.masks else 2]:
        start, stop = (shifted_utc(found.start_utc, float(t_s)) for t_s in times_s[window])
        asked = session_alone(platform, TLE, attitude, target, start, stop)
        assert make_plan(asked).verification.passed
        if cut[window, 0] and windows.rise_s[window] < times_s[window, 0] - 1.2:
            earlier = start - timedelta(seconds=1.2)
            with pytest.raises(Refusal):
                make_plan(session_alone(platform, TLE, attitude, target, earlier, stop))


def held(from_s, to_s):
    """Windows of which only the time that is held counts, none of a scan."""
    windows = object.__new__(Windows)
    members = {
        "held_from_s": np.array(from_s),
        "held_to_s": np.array(to_s),
        "scan_parameters": np.full((len(from_s), 7), np.nan),
    }
    for name, value in members.items():
        object.__setattr__(windows, name, value)
    return windows


def test_a_window_of_a_day_has_a_session_that_one_request_may_plan():
    """Ten days' worth of rows are not asked for: from a high orbit the Sun never sets."""

    [[start_s, stop_s]] = Windows.sessions_s(held([0.0], [86400.0]), at(0.0))
    assert stop_s - start_s == SESSION_MAX_S


def test_a_session_no_pair_of_angles_holds_throughout_is_offered_the_longest_part():
    """Polaris from a polar orbit: each pair of angles meets a stop on its way."""
    orbit = StateVectorOrbit(
        frame="GCRF",
        epoch=datetime(2026, 11, 16, 12, tzinfo=UTC),
        position_km=(7158.137, 0.0, 0.0),
        velocity_km_s=(0.0, 1.1, 7.38),
    )
    attitude = LvlhAttitude(yaw_deg=177.0, pitch_deg=-2.0, roll_deg=1.0)
    start = datetime(2026, 11, 16, 15, 13, 20, 400000, tzinfo=UTC)
    stop = datetime(2026, 11, 16, 16, 17, 51, 600000, tzinfo=UTC)
    asked = session_alone(GALLERY, orbit, attitude, StarTarget(name="Polaris"), start, stop)
    with pytest.raises(Unreachable) as refused:
        make_plan(asked)
    better = advised(asked, refused.value)
    [one] = better.sessions
    # Of 64 min either pair of angles follows for 31 and 37, which overlap.
    assert (one.stop - one.start).total_seconds() > 36 * 60.0
    assert make_plan(better).verification.passed


def test_a_window_too_short_for_two_rows_has_no_session():
    times_s = Windows.sessions_s(held([0.05, 0.05], [0.35, 0.45]), at(0.0))
    assert np.isnan(times_s[0]).all()
    assert times_s[1] == pytest.approx([0.2, 0.4])


@pytest.mark.parametrize(
    ("start_s", "stop_s", "is_start_kept"),
    [
        (130.0, 310.0, True),  # 13 s past the window
        (120.0, 330.0, False),  # beyond it on both sides
    ],
)
def test_a_session_that_outlasts_its_window_is_offered_an_earlier_stop(
    start_s, stop_s, is_start_kept
):
    """Las Vegas stands above 30 deg from 124.2 to 297.2 s."""
    target = replace(LAS_VEGAS, min_elevation_deg=30.0)
    asked = scenario(session(target, start_s, stop_s))
    with pytest.raises(NotVisible) as refused:
        make_plan(asked)
    better = advised(asked, refused.value)
    [one] = better.sessions
    assert (one.start == at(start_s)) == is_start_kept
    assert abs((one.stop - at(297.2)).total_seconds()) <= 0.4
    assert make_plan(better).verification.passed


def test_no_start_at_the_horizon_is_offered_to_who_left_the_elevation_out():
    """A session before the pass is moved to where the carrier stands at 10 deg, not at 0."""
    asked = scenario(session(LAS_VEGAS, -300.0, -270.0), epoch_s=-600)
    with pytest.raises(NotVisible) as refused:
        make_plan(asked)
    start = refused.value.earliest_feasible_start_utc
    moment = Instants(start, np.zeros(1))
    states = TLE.ephemeris(start, start + timedelta(seconds=60)).states(moment)
    elevation_rad = LAS_VEGAS.apparent(moment, states).clearance_rad[0]
    assert 10.0 <= np.degrees(elevation_rad) < 10.5


def test_who_joins_early_is_offered_a_start_after_the_stop_that_opens_the_window():
    """Asked for 5 s before the star leaves the outer axis's stop, in least time."""
    star = StarTarget(hip=32349)
    asked = search(star, 1.0, platform=GALLERY, attitude=LvlhAttitude(), **LONG)
    found = find_opportunities(asked)
    row = int(np.flatnonzero(found.windows.opened_by == "reach")[0])
    start, stop = (
        shifted_utc(found.start_utc, float(t_s))
        for t_s in found.windows.sessions_s(found.start_utc)[row]
    )
    asked = session_alone(GALLERY, TLE, LvlhAttitude(), star, start - timedelta(seconds=5), stop)
    asked = replace(asked, slew=replace(asked.slew, objective="minimum_time"))
    with pytest.raises(Unreachable) as refused:
        make_plan(asked)
    advised_start = refused.value.earliest_feasible_start_utc
    assert abs((advised_start - start).total_seconds()) <= 0.6
    assert refused.value.feasible_stop_utc >= stop


COLOGNO = GroundTarget(latitude_deg=45.53, longitude_deg=9.28, height_m=130.0)  # 46 h later
SIRIUS = StarTarget(ra_deg=101.287, dec_deg=-16.716)
BOAT = MovingGroundTarget(
    latitude_deg=36.0, longitude_deg=-115.0, epoch=at(0.0), course_deg=90.0, speed_m_s=10.0
)
NEARLY = 0.02


def search(target, hours, *, above_deg=20.0, **more):
    return OpportunityRequest(
        **{
            "orbit": TLE,
            "attitude": LvlhAttitude(yaw_deg=-4.0, pitch_deg=-2.0, roll_deg=1.0),
            "platform": HRC,
            "targets": (OpportunityTarget(id="it", target=target),),
            "start": at(-600.0),
            "stop": at(3600.0 * hours),
            "conditions": OpportunityConditions(min_elevation_deg=above_deg),
        }
        | more
    )


def planned_probability(request, found, window):
    """Of a plan of the window's session, as it stands."""
    start, stop = (
        shifted_utc(found.start_utc, float(t_s))
        for t_s in found.windows.sessions_s(found.start_utc)[window]
    )
    target = request.targets[found.windows.target[window]].target
    flown_by = request.platform, request.orbit, request.law
    plan = make_plan(session_alone(*flown_by, target, start, stop, 120))
    return plan.budgets[0].probability_in_frame


CASES = {
    "a city today": search(LAS_VEGAS, 2.0),
    "a city low in the north": search(SALT_LAKE, 12.0, above_deg=5.0),
    "a city two days on": search(COLOGNO, 52.0),
    "a star": search(SIRIUS, 1.5, above_deg=0.0),
    "the Moon": search(BodyTarget(name="moon"), 1.0, above_deg=0.0),
    "a boat": search(BOAT, 1.0, above_deg=10.0),
    "messages of the mission": search(
        LAS_VEGAS,
        0.16,
        orbit=OemOrbit(content=message("orbit.oem")),
        attitude=AemAttitude(content=message("attitude.aem")),
        start=at(0.0),
    ),
}


@pytest.mark.parametrize("request_", CASES.values(), ids=CASES)
def test_a_window_and_the_plan_of_its_session_agree(request_):
    found = find_opportunities(request_)
    probability = probabilities_in_frame(request_, found.windows)
    known = np.flatnonzero(np.isfinite(probability))
    assert len(known) >= 1
    for window in {known[0], known[-1]}:
        expected = planned_probability(request_, found, window)
        assert probability[window] == pytest.approx(expected, abs=NEARLY)


def test_older_elements_make_it_less_likely():
    """A city low at first and high two days on: the soonest is the likelier all the same."""
    request = search(COLOGNO, 52.0)
    found = find_opportunities(request)
    probability = probabilities_in_frame(request, found.windows)
    today = found.windows.rise_s < 86_400.0
    assert probability[today].max() > 2.0 * probability[~today].max()


def test_the_soonest_windows_are_told_where_there_are_too_many(monkeypatch):
    options = replace(window_probability.OPTIONS, most=2.5 * window_probability.OPTIONS.window)
    monkeypatch.setattr(window_probability, "OPTIONS", options)
    places = [LAS_VEGAS, SALT_LAKE]
    request = search(
        LAS_VEGAS,
        30.0,
        targets=tuple(
            OpportunityTarget(id=str(number), target=place) for number, place in enumerate(places)
        ),
    )
    found = find_opportunities(request)
    told = np.isfinite(probabilities_in_frame(request, found.windows))
    assert 2 <= told.sum() < len(told)
    assert found.windows.rise_s[told].max() < found.windows.rise_s[~told].min()
