"""Plans of spacecraft that turn as a whole: the request of two axes, with another platform."""

import io
import json
import math
from datetime import timedelta
from importlib.resources import files
from pathlib import Path

import numpy as np
import other_body
import pytest
from other_body import PLATFORM as SMALLSAT
from planner_values import plan_of, read_request
from scipy.io import netcdf_file
from scipy.spatial.transform import Rotation
from skyfield.api import load, load_file

from planner.base.errors import InfeasibleSlew, InvalidRequest, NotForPlatform
from planner.output.export import EXPORTERS
from planner.output.view import VIEW_EXPORTERS, view_plan
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.rules.two_axis import axes_of

TIME_SCALE = load.timescale(builtin=True)
EPHEMERIS = load_file(str(files("skyfield_data") / "data" / "de421.bsp"))
MAPPED = ("swath", "target")
THREE_CITIES = Path(__file__).parents[2] / "examples" / "three_sessions.json"


def body_request(**changes):
    """The example of three cities, with its platform exchanged."""
    return other_body.body_request(sessions=3) | changes


def without_sun(direction_body, min_deg, **more):
    """The platform with a radiator that must not see the Sun."""
    radiator = {"name": "radiator", "direction_body": direction_body, "away_from": "sun"}
    return SMALLSAT | {"exclusions": [radiator | {"min_deg": min_deg} | more]}


@pytest.fixture(scope="module")
def plan():
    platform = without_sun([0.0, 1.0, 0.0], 20.0, when="imaging")
    return plan_of(body_request(platform=platform, final_state="idle"))


def test_three_cities_are_tracked_from_the_idle_attitude_and_back_to_it(plan):
    assert plan.verification.passed
    assert plan.verification.findings == ()
    assert [one.session for one in plan.segments if one.kind == "track"] == [0, 1, 2]
    rates_rad_s = np.linalg.norm(plan.table.rate_rad_s[[0, -1]], axis=1)
    period_s = 86400.0 / 15.557  # of the orbit, by its mean motion: a nadir turns with it
    np.testing.assert_allclose(rates_rad_s, 2.0 * np.pi / period_s, rtol=0.01)


def test_slews_end_settled(plan):
    for one in plan.segments:
        if one.kind == "track":
            start_utc = plan.scenario.sessions[one.session].start
            assert elapsed_s(start_utc, one.start_utc) == pytest.approx(4.0)


def test_the_boresight_stands_on_the_city_as_it_appears(plan):
    """By the table as it is told: quaternions of 13 decimals."""
    session = plan.scenario.sessions[1]
    row = round(elapsed_s(session.start, plan.table.epoch_utc) * 5) + 100
    at = Instants(plan.table.epoch_utc, plan.table.t_s[[row]])
    orbit = plan.scenario.orbit.ephemeris(session.start, session.stop)
    told = {channel.name: value[row] for channel, value in plan.table.columns}
    q_eci_from_body = Rotation.from_quat([told[f"q_eci_from_body_{part}"] for part in "xyzw"])
    seen = session.target.apparent(at, orbit.states(at)).direction_eci[0]
    off_rad = np.linalg.norm(np.cross(q_eci_from_body.apply([0.0, 0.0, 1.0]), seen))
    assert np.degrees(off_rad) * 3600.0 < 0.1


def test_least_time_joins_no_later_than_asked_and_a_star_is_a_target_too():

    times = {"start": "2015-05-10T10:36:28Z", "stop": "2015-05-10T10:36:40Z"}
    request = body_request(sessions=[{"target": VEGA, **times}], slew={"objective": "minimum_time"})
    plan = plan_of(request)
    assert plan.verification.passed
    joined_utc = next(one.start_utc for one in plan.segments if one.kind == "track")
    assert elapsed_s(plan.scenario.sessions[0].start, joined_utc) >= 4.0


def test_least_time_is_sought_to_its_end_for_every_session():
    """Making the solver once took more work than a slew may, and the first fell back to smooth."""
    plan = plan_of(body_request(slew={"objective": "minimum_time"}))
    assert plan.verification.passed
    assert plan.warnings == ()
    assert max(slew.duration_s / slew.minimum_s for slew in plan.slews) < 2.0


@pytest.mark.parametrize("mode", ["shorten_later", "least_loss"])
def test_a_session_cut_short_begins_settled_too(mode):
    slow = SMALLSAT | {"agility": SMALLSAT["agility"] | {"acceleration_max_deg_s2": 0.05}}
    plan = plan_of(body_request(platform=slow, on_conflict=mode))
    assert plan.verification.passed
    joined = [one.start_utc for one in plan.segments if one.kind == "track"]
    starts = [session.start for session in plan.scenario.sessions]
    settled_s = [elapsed_s(*pair) for pair in zip(starts, joined, strict=True)]
    assert min(settled_s) == pytest.approx(4.0)


def test_what_is_made_for_axes_alone_says_so(plan):
    with pytest.raises(NotForPlatform, match="kind body"):
        _ = axes_of(plan.scenario)


def test_maps_show_a_footprint_over_each_city(plan):
    features = json.loads(EXPORTERS["geojson"].write(plan, plan.table.epoch_utc))["features"]
    shown = {kind: [f for f in features if f["properties"]["kind"] == kind] for kind in MAPPED}
    assert [len(shown[kind]) for kind in ("swath", "target")] == [3, 3]
    for swath, target in zip(shown["swath"], shown["target"], strict=True):
        ring = np.array(swath["geometry"]["coordinates"][0])
        place = np.array(target["geometry"]["coordinates"][:2])
        assert (ring.min(axis=0) < place).all()
        assert (place < ring.max(axis=0)).all()


def test_views_hold_rates_margins_and_where_the_boresight_looks(plan):
    """The angles along and across the track compose to that off nadir (spherical Pythagoras)."""
    view = view_plan(plan, None, 10.0)
    seen = view.boresight
    cosine = np.cos(seen.along_track_rad) * np.cos(seen.across_track_rad)
    assert cosine == pytest.approx(np.cos(seen.off_nadir_rad), abs=1e-12)
    at_start = [seen.along_track_rad[0], seen.across_track_rad[0]]
    assert at_start == pytest.approx([0.0, 0.0], abs=1e-9)  # idle at the nadir
    row = np.round(view.t_s * 5).astype(int)
    rates = np.stack([view.axes[axis].rate_rad_s for axis in "xyz"], axis=1)
    np.testing.assert_array_equal(rates, plan.table.rate_rad_s[row])
    assert np.isnan(view.axes["x"].angle_rad).all()
    assert view.limits["z"].rate_max_rad_s == pytest.approx(np.radians(3.0))
    inside = ~np.isnan(view.pointing.error_rad)
    assert inside.any()
    assert np.degrees(view.pointing.error_rad[inside].max()) * 3600.0 < 0.1
    squares_rad2 = view.pointing.sigma_major_rad**2 + view.pointing.sigma_minor_rad**2
    largest_arcsec = np.degrees(np.sqrt(np.nanmax(squares_rad2) / 2.0)) * 3600.0
    # Each way its mean is the budget's: 31 instants of each session meet the budget's 11 to 1 %.
    budgeted_arcsec = max(budget.sigma_arcsec for budget in plan.budgets)
    assert largest_arcsec == pytest.approx(budgeted_arcsec, rel=0.01)
    (margin,) = view.exclusions
    sun_body = sun_in_body(plan, int(row[40]))
    away_deg = np.degrees(np.arccos(sun_body[1]))  # of body +Y, from the Sun's centre
    sun_radius_deg, refined_deg = 0.2666, 0.01  # 1 au; +-1.7 % over a year, and aberration
    told_deg = np.degrees(margin.margin_rad[40])
    assert told_deg == pytest.approx(away_deg - sun_radius_deg - 20.0, abs=refined_deg)


@pytest.mark.parametrize("format_name", VIEW_EXPORTERS)
def test_views_are_written_as_files(plan, format_name):
    content = VIEW_EXPORTERS[format_name].write(view_plan(plan, None, 10.0), plan.table.epoch_utc)
    with netcdf_file(io.BytesIO(content)) as file:
        assert file.variables["exclusion_margin_deg"].shape == (1, len(file.variables["time"][:]))


def sun_in_body(plan, row):
    """Unit vector (3,) to the Sun in body axes at a row of the table, by the JPL ephemeris."""
    utc = plan.table.epoch_utc + timedelta(seconds=0.2 * row)
    sun = EPHEMERIS["earth"].at(TIME_SCALE.from_datetime(utc)).observe(EPHEMERIS["sun"])
    sun_eci = sun.apparent().position.m / np.linalg.norm(sun.apparent().position.m)
    return Rotation.from_quat(plan.table.position[row]).inv().apply(sun_eci)


def slew_rows(plan, number):
    """The first and the last row of the slew to a session."""
    [slew] = [one for one in plan.segments if one.kind == "slew" and one.session == number]
    return [
        round(elapsed_s(at_utc, plan.table.epoch_utc) * 5)
        for at_utc in (slew.start_utc, slew.stop_utc)
    ]


def test_slews_lead_around_what_is_always_excluded(plan):
    """A radiator that would face the Sun half-way from one city to the next."""
    first, last = slew_rows(plan, 1)
    radiator = sun_in_body(plan, (first + last) // 2)
    seen = np.array([sun_in_body(plan, row) for row in range(0, len(plan.table.t_s), 5)])
    away_deg = np.degrees(np.arccos(np.clip(seen @ radiator, -1.0, 1.0)))
    seconds = np.arange(len(away_deg))
    tracked = np.zeros(len(away_deg), dtype=bool)
    for one in plan.segments:
        if one.kind == "track":
            begin, end = (
                elapsed_s(at, plan.table.epoch_utc) for at in (one.start_utc, one.stop_utc)
            )
            tracked |= (begin - 1.0 <= seconds) & (seconds <= end + 1.0)
    least_deg = 0.6 * min(away_deg[tracked].min(), away_deg[0])
    assert away_deg.min() < 0.1 * least_deg
    around = plan_of(body_request(platform=without_sun(radiator.tolist(), least_deg)))
    assert around.verification.passed
    seen = np.array([sun_in_body(around, row) for row in range(0, len(around.table.t_s), 5)])
    assert np.degrees(np.arccos(np.max(seen @ radiator))) > least_deg


def test_an_idle_attitude_inside_an_exclusion_is_refused_by_name(plan):
    facing = without_sun(sun_in_body(plan, 0).tolist(), 5.0)
    with pytest.raises(InfeasibleSlew, match=r"radiator: at 2015-05-10T.* nearer to the Sun") as no:
        plan_of(body_request(platform=facing))
    assert (no.value.field, no.value.limit) == ("platform.exclusions", "exclusion")


PATH = {
    "mode": "ground_path",
    "points": [
        {"latitude_deg": 37.9, "longitude_deg": 23.6},
        {"latitude_deg": 38.1, "longitude_deg": 23.9},
    ],
    "speed_m_s": 1000.0,
}
BELOW = {
    "ground_path": PATH,
    "ground_moving": {
        "mode": "ground_moving",
        "epoch": "2015-05-10T10:41:00Z",
        "latitude_deg": 37.9,
        "longitude_deg": 23.6,
        "height_m": 0.0,
        "speed_m_s": 10.0,
        "course_deg": 45.0,
    },
    "body": {"mode": "body", "name": "sun"},
}


def one_session(target, **members):
    times = {"start": "2015-05-10T10:41:08Z", "stop": "2015-05-10T10:41:38Z"}
    return body_request(sessions=[{"target": target, **times, **members}])


@pytest.mark.parametrize("target", BELOW.values(), ids=BELOW.keys())
def test_what_moves_is_a_target_too(target):
    plan = plan_of(one_session(target))
    assert plan.verification.passed
    assert plan.verification.findings == ()


@pytest.mark.parametrize(
    "roll",
    [
        {"rule": "lines_across_motion"},
        {"rule": "lines_across_track"},
        {"rule": "sun_side", "direction_body": [-1.0, 0.0, 0.3]},
        {"rule": "azimuth", "azimuth_deg": 15.0},
        {"rule": "nearest"},
    ],
    ids=lambda roll: roll["rule"],
)
def test_a_session_has_a_roll_of_its_own(roll):
    plan = plan_of(one_session(PATH, roll=roll))
    assert plan.verification.passed
    assert plan.scenario.sessions[0].roll.rule == roll["rule"]


def of_axes(**changes):
    """The example of three cities by two axes."""
    request = json.loads(THREE_CITIES.read_text()) | changes
    return {name: value for name, value in request.items() if value is not None}


VEGA = {"mode": "star", "name": "Vega"}
SESSIONS = json.loads(THREE_CITIES.read_text())["sessions"]
LEFT_OUT = "must be left out for smallsat"


@pytest.mark.parametrize(
    ("request_", "field", "words"),
    [
        (body_request(attitude={"law": "lvlh"}), "attitude", LEFT_OUT),
        (body_request(final_state="rest"), "final_state", LEFT_OUT),
        (body_request(slew={"keep_out": [{"body": "sun", "half_angle_deg": 20.0}]}),
         "slew.keep_out", LEFT_OUT),
        (body_request(slew={"method": "spline"}), "slew.method", LEFT_OUT),
        (of_axes(attitude=None), "attitude", ""),
        (of_axes(sessions=[SESSIONS[0], SESSIONS[1] | {"roll": {"rule": "nearest"}}]),
         "sessions.1.roll", "must be left out for iss-hrc"),
        (one_session(VEGA, roll={"rule": "azimuth", "azimuth_deg": 1.0}), "sessions.0.roll",
         "must "),
        (one_session(BELOW["body"], roll={"rule": "lines_across_motion"}), "sessions.0.roll",
         "must "),
        (one_session(PATH, roll={"rule": "sun_side", "direction_body": [0, 0, 1]}),
         "sessions.0.roll.direction_body", "must "),
    ],
)  # fmt: skip
def test_what_a_kind_of_platform_has_not_is_refused_by_its_field(request_, field, words):
    with pytest.raises(InvalidRequest, match=f"{field}.*: {words}") as refused:
        read_request(request_)
    assert refused.value.field.startswith(field)


def test_the_budget_is_of_orbit_and_what_the_body_knows_and_controls(plan):
    [first, *_] = plan.budgets
    told = {part.cause: part.sigma_arcsec for part in first.contributions}
    assert told["attitude knowledge"] == told["attitude control"] == pytest.approx(10.0)
    assert "attitude" not in told  # of a carrier
    squares = sum(sigma**2 for sigma in told.values())
    assert first.sigma_arcsec == pytest.approx(math.sqrt(squares))
    # the elements are a day old and err by kilometres: degrees from 400 km, in a frame of 2 by 1.5
    assert 0.5 < first.probability_in_frame < 1.0


def test_a_body_that_hardly_knows_its_attitude_hardly_keeps_the_target_in_the_frame():
    lost = SMALLSAT | {"knowledge": {"sigma_arcsec": 7200.0, "correlation_s": 5.0}}
    plan = plan_of(one_session(PATH, roll={"rule": "nearest"}) | {"platform": lost})
    [budget] = plan.budgets
    assert budget.probability_in_frame < 0.05
    assert budget.helps_most == "attitude knowledge"
    assert any("better star trackers would help most" in one for one in plan.warnings)


ASKED = {
    "q_body_from_eci_xyzw": [-0.5, 0.5, 0.5, 0.5],
    "omega_body_deg_s": [0.1, -0.2, 0.3],
    "alpha_body_deg_s2": [0.05, 0.0, -0.02],
}


def from_state(state, **changes):
    request = body_request(**changes)
    request["initial_state"] |= state
    return plan_of(request)


def test_the_table_begins_with_the_motion_asked_for():
    plan = from_state(ASKED)
    assert plan.verification.findings == ()
    turn = Rotation.from_quat(plan.table.position[0])
    # A quaternion that cycles the axes: the body's x is along -y of GCRF, and so on.
    np.testing.assert_allclose(turn.apply([1.0, 0.0, 0.0]), [0.0, -1.0, 0.0], atol=1e-12)
    told = np.degrees([plan.table.rate_rad_s[0], plan.table.acceleration_rad_s2[0]])
    asked = [ASKED["omega_body_deg_s"], ASKED["alpha_body_deg_s2"]]
    np.testing.assert_allclose(told, asked, atol=1e-9)


def test_a_body_that_turns_through_its_idle_attitude_is_brought_to_it_first():
    """The attitude is that of idling, the motion isn't: it may not jump to rest."""
    still = {"law": "inertial", "q_body_from_eci_xyzw": ASKED["q_body_from_eci_xyzw"]}
    lead = {"lead": {"max_duration_s": 60.0}}
    plan = from_state(ASKED, platform=SMALLSAT | {"idle": still}, slew=lead)
    assert plan.verification.findings == ()
    assert [one.kind for one in plan.segments[:4]] == ["brake", "wait", "slew", "track"]


@pytest.mark.parametrize(
    ("state", "field", "says"),
    [
        ({"omega_body_deg_s": [0.0, 0.0, 0.0]}, ".omega_body_deg_s", "on its idle attitude"),
        (ASKED | {"q_body_from_eci_xyzw": [1.0, 1.0, 0.0, 0.0]}, ".q_body_from_eci_xyzw", "1.4142"),
        (ASKED | {"omega_body_deg_s": [3.0, 0.5, 0.0]}, ".omega_body_deg_s", "3.041, beyond the 3"),
        (ASKED | {"alpha_body_deg_s2": [0.0, 0.6, 0.0]}, ".alpha_body_deg_s2", "beyond the 0.5"),
        (
            {
                "q_body_from_eci_xyzw": [0.0, 0.0, 0.0, 1.0],
                "omega_body_deg_s": [2.95, 0.0, 0.0],
                "alpha_body_deg_s2": [0.45, 0.0, 0.0],
            },
            "",
            "can't be braked",
        ),
    ],
)
def test_an_initial_motion_that_cannot_be_flown_is_refused(state, field, says):
    with pytest.raises((InvalidRequest, InfeasibleSlew), match=says) as refused:
        from_state(state)
    assert refused.value.field == f"initial_state{field}"


def test_a_body_that_begins_inside_an_exclusion_is_told_so():
    sun_eci = [0.648, 0.698, 0.303]  # on 10 May, by its declination of 17.6 deg
    sunward = Rotation.from_quat(ASKED["q_body_from_eci_xyzw"]).apply(sun_eci).tolist()
    with pytest.raises(InfeasibleSlew) as refused:
        from_state(ASKED, platform=without_sun(sunward, 10.0, when="always"))
    assert refused.value.field == "initial_state.q_body_from_eci_xyzw"
