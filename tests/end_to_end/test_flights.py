"""Disturbed flights miss by what geometry says, whoever flies them; hopeless ones say why."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from scenarios import LAS_VEGAS, SALT_LAKE, STILL, scenario, session

from planner.base.commands import ROWS_PER_S
from planner.base.errors import InvalidInput
from planner.inflight.flights.draws import draw_run, undisturbed
from planner.inflight.flights.frames import EXPOSURE_POINTS, exposures_s, frames_of
from planner.inflight.flights.nominal import ground_view, nominal_session
from planner.inflight.flights.request import MovingObject
from planner.inflight.flights.runs import fly_nominal, fly_runs
from planner.inflight.flights.scene import session_scenes
from planner.inflight.flights.summary import joined, summarise
from planner.inflight.simulation.flight import FlownMotion
from planner.inflight.simulation.platforms.two_axis import TwoAxisFlyer
from planner.motion.pointing.angles import boresight_platform
from planner.motion.pointing.frame import frame_axes, places_in_frame
from planner.motion.pointing.hermite import quintic_motion
from planner.motion.pointing.line_of_sight import line_of_sight
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.platforms.registry import mover_of
from planner.planning.sessions.platforms.two_axis.budget import PointingScene, error_biases
from planner.planning.sessions.uncertainty import OPTIONS as BUDGET_OPTIONS
from planner.world.attitude import AttitudeUncertainty, LvlhAttitude
from planner.world.frames.geodesy import itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.platforms import IDEAL_DRIVE, ISS_HRC, AxisDrive, Camera
from planner.world.targets import BenchMotionTarget, GroundTarget, StarTarget
from planner.world.targets.axis_signals import ConstantRate

ARCSEC = math.radians(1.0 / 3600.0)


class AsCommanded(TwoAxisFlyer):
    """The table itself, by its own interpolation."""

    def fly(self, table, from_s, session, seeds):
        t_s = np.arange(0.0, table.t_s[-1] + 1e-9, 0.02)
        still = np.zeros_like(table.rate_rad_s)
        still[1:-1] = (table.rate_rad_s[2:] - table.rate_rad_s[:-2]) * ROWS_PER_S / 2.0
        angle_rad, *_ = quintic_motion(t_s, table.t_s, table.position, table.rate_rad_s, still)
        return FlownMotion(
            t_s=t_s,
            angle_rad=angle_rad,
            rate_rad_s=angle_rad,
            structure_rad=np.zeros((len(t_s), 3)),
            measured_angle_rad=angle_rad,
            measured_rate_rad_s=angle_rad,
            is_saturated=np.zeros(angle_rad.shape, dtype=bool),
        )


def as_commanded(*scenes):
    return [replace(scene, flyer=AsCommanded(scene.scenario)) for scene in scenes]


@pytest.fixture(scope="module")
def plan():
    """Over Las Vegas, by elements six hours old, with the ISS's swing."""
    return make_plan(replace(scenario(session(LAS_VEGAS, 140, 230)), attitude=LvlhAttitude()))


@pytest.fixture(scope="module")
def scene(plan):
    [found] = session_scenes(plan)
    return found


def test_a_run_is_the_same_whoever_flies_it_and_with_whichever_others(scene):
    scenes = as_commanded(scene)
    whole = fly_runs(scenes, 7, 0, 12)
    parts = [fly_runs(scenes, 7, first, 4)[0] for first in (8, 0, 4)]
    in_order = joined([parts[1], parts[2], parts[0]])
    for name, values in whole[0].columns.items():
        np.testing.assert_array_equal(values, in_order.columns[name])
    assert not np.array_equal(fly_runs(scenes, 8, 0, 4)[0].miss_rad, parts[1].miss_rad)


def test_drives_are_drawn_by_run_and_session_alone(scene):
    sessions = [scene, replace(scene, number=1)]
    once, again = fly_runs(sessions, 3, 0, 4), fly_runs(sessions, 3, 2, 2)
    for whole, part in zip(once, again, strict=True):
        np.testing.assert_array_equal(whole.miss_rad[2:], part.miss_rad)
        np.testing.assert_array_equal(whole.smear_px[2:], part.smear_px)
    assert not np.any(once[0].smear_px == once[1].smear_px)


@pytest.mark.parametrize("sensors", ["quiet", "noisy"])
def test_a_runs_sessions_share_its_drives_but_not_their_noise(scene, sensors):
    """Friction and cables are the same in all; what the encoders read is drawn anew in each."""
    silent = replace(AxisDrive(), encoder_noise_arcsec=0.0)
    drives = (silent, silent) if sensors == "quiet" else ISS_HRC.drives
    flyer = TwoAxisFlyer(replace(scene.scenario, platform=replace(ISS_HRC, drives=drives)))
    for seeds in (None, {"drive": 5}):
        first, again, second = (flyer.fly(scene.table, 0.0, k, seeds).angle_rad for k in (0, 0, 1))
        np.testing.assert_array_equal(first, again)
        assert np.array_equal(first, second) == (sensors == "quiet")


def test_directions_between_nodes_are_those_of_the_geometry(scene):
    """To 1e-4 arcsec, a seven-thousandth of a pixel."""
    [seen] = scene.seen([undisturbed(scene.modes)])
    t_s = np.linspace(scene.instants.t_s[0], scene.instants.t_s[-1], 1237)
    exact = line_of_sight(
        Instants(scene.instants.epoch_utc, t_s),
        scene.ephemeris,
        scene.scenario.attitude,
        ISS_HRC.q_platform_from_body,
        scene.target,
    )
    apart_rad = np.linalg.norm(seen.directions_at(t_s) - exact.los_base, axis=1)
    assert apart_rad.max() < 1e-4 * ARCSEC
    np.testing.assert_allclose(seen.ranges_m(t_s), exact.range_m, rtol=1e-4)


@pytest.mark.parametrize("cause", [cause for cause in TwoAxisFlyer.causes if cause != "drive"])
def test_small_errors_displace_the_target_as_the_linear_budget_has_it(plan, scene, cause):
    """Each cause drawn small, against the derivatives of the plan's budget; 1 % of them."""
    small = 1e-2
    drawn = draw_run(11, 0, scene.modes, ["drive"])
    drawn = replace(
        drawn,
        orbit_scores=drawn.orbit_scores * small,
        attitude_scores=drawn.attitude_scores * small,
        swing_share=small,
        earth_score=drawn.earth_score * small,
        clock_score=drawn.clock_score * small,
    )
    here = undisturbed(scene.modes)
    [before, after] = scene.seen([here, here.with_cause_of(drawn, cause)])
    at = scene.instants.t_s[::10]
    angle_rad = np.stack([np.interp(at, plan.table.t_s, a) for a in plan.table.position.T], 1)
    sides = frame_axes(ISS_HRC, angle_rad)
    moved = after.directions_at(at) - before.directions_at(at)
    found_rad = np.einsum("nij,nj->ni", sides, moved) / small

    los = line_of_sight(
        Instants(scene.instants.epoch_utc, at),
        scene.ephemeris,
        plan.scenario.attitude,
        ISS_HRC.q_platform_from_body,
        scene.target,
    )
    told = PointingScene(los, plan.scenario.attitude, scene.target, ISS_HRC, angle_rad, len(at))
    errors = plan.scenario.attitude.errors(told.instants)
    biases = error_biases(told, scene.ephemeris, errors, BUDGET_OPTIONS.clock_s)
    mine = [bias for bias in biases if bias.cause.cause == cause]
    orbit = drawn.orbit_scores.copy()
    orbit[1] = scene.errors.along.scores(orbit[1])
    scores = {
        "orbit": orbit / small,
        "attitude": drawn.attitude_scores / small,
        "Earth orientation": np.array([drawn.earth_score]) / small,
        "clock": np.array([-drawn.clock_score]) / small,  # flown late it sees what comes later
    }[cause]
    steady = [bias for bias in mine if bias.quarter_later_rad is None]
    expected_rad = sum(score * bias.offsets_rad for score, bias in zip(scores, steady, strict=True))
    swings = [bias for bias in mine if bias.quarter_later_rad is not None]
    for phase_rad, bias in zip(drawn.phase_rad, swings, strict=False):
        expected_rad = expected_rad + math.sqrt(2.0) * (
            math.cos(phase_rad) * bias.offsets_rad + math.sin(phase_rad) * bias.quarter_later_rad
        )
    if cause == "clock":
        expected_rad = -expected_rad
    size_rad = np.abs(expected_rad).max()
    np.testing.assert_allclose(found_rad, expected_rad, atol=0.01 * size_rad)


def test_ideal_drives_keep_the_target_in_the_middle(plan):
    """Within 0.2 arcsec of the table, which itself lies within 0.1 arcsec of the target."""
    ideal = replace(ISS_HRC, drives=(IDEAL_DRIVE, IDEAL_DRIVE))
    flown = replace(plan, scenario=replace(plan.scenario, platform=ideal))
    [scene] = session_scenes(flown)
    frames, range_m, _, saturated_s, *_ = fly_nominal(scene)
    assert np.max(frames.error_rad) < 0.3 * ARCSEC
    assert frames.is_sharp.all()
    assert range_m.min() > 400e3
    assert not saturated_s.any()


def test_a_drifting_target_is_smeared_by_what_it_drifts_in_an_exposure():
    camera = Camera(pixel_arcsec=1.0, exposure_s=0.5, frames_per_s=2.0)
    platform = replace(ISS_HRC, camera=camera)
    at_s = exposures_s(camera, 0.0, 10.0)
    assert at_s.shape == (20, EXPOSURE_POINTS)
    angle_rad = np.tile([0.3, -0.2], (at_s.size, 1))
    boresight, sides = boresight_platform(platform, angle_rad), frame_axes(platform, angle_rad)
    drift = (3.0 * ARCSEC * at_s.ravel())[:, None] * (0.6 * sides[:, 0] + 0.8 * sides[:, 1])
    los = boresight + drift
    los /= np.linalg.norm(los, axis=1, keepdims=True)
    still = np.zeros((at_s.size, 3))
    frames = frames_of(platform, at_s, angle_rad, still, los)
    np.testing.assert_allclose(frames.smear_px, 1.5, rtol=6e-3)  # the path's ways: 0.5 %
    np.testing.assert_allclose(frames.error_rad, 3.0 * ARCSEC * at_s[:, -1], rtol=1e-6, atol=1e-12)
    # A structure that turns the camera with the target leaves it where it was.
    turn = np.cross(boresight, drift)
    held = frames_of(platform, at_s, angle_rad, turn, los)
    assert held.smear_px.max() < 1e-3


@pytest.mark.parametrize(("outside", "share"), [(0.999, True), (1.001, False)])
def test_a_frame_holds_what_lies_within_its_sides(outside, share):
    angle_rad = np.tile([0.1, 0.2], (EXPOSURE_POINTS, 1))
    boresight, sides = boresight_platform(ISS_HRC, angle_rad), frame_axes(ISS_HRC, angle_rad)
    half = np.tan(ISS_HRC.frame_half_rad)
    corner = boresight + outside * (half[0] * sides[:, 0] - half[1] * sides[:, 1])
    los = corner / np.linalg.norm(corner, axis=1, keepdims=True)
    still = np.zeros((EXPOSURE_POINTS, 3))
    at_s = np.linspace(0.0, 0.3, EXPOSURE_POINTS)[None, :]
    assert frames_of(ISS_HRC, at_s, angle_rad, still, los).holds.tolist() == [share]
    behind = frames_of(ISS_HRC, at_s, angle_rad, still, -los)
    assert behind.holds.tolist() == [False]


def test_a_session_shorter_than_an_exposure_has_one_frame():
    at_s = exposures_s(Camera(exposure_s=2.0, frames_per_s=0.5), 10.0, 10.2)
    np.testing.assert_allclose(at_s[0, [0, -1]], [10.0, 10.2])
    assert len(at_s) == 1


def test_the_view_scales_the_ground_as_its_own_points_are_seen(scene):
    """A place 100 m to the east and 200 m to the north, seen by its own coordinates."""
    t_s = np.array([150.0, 185.0, 220.0])
    [seen] = scene.seen([undisturbed(scene.modes)])
    angle_rad = np.stack(
        [np.interp(t_s - scene.from_s, scene.table.t_s, a) for a in scene.table.position.T], 1
    )
    view = ground_view(scene, t_s, angle_rad)
    latitude, longitude = (
        math.radians(LAS_VEGAS.latitude_deg),
        math.radians(LAS_VEGAS.longitude_deg),
    )
    step = 1e-6
    per_rad_m = [
        np.linalg.norm(
            itrf_from_geodetic(latitude + dlat, longitude + dlon, 610.0)
            - itrf_from_geodetic(latitude, longitude, 610.0)
        )
        / step
        for dlat, dlon in ((step, 0.0), (0.0, step))
    ]
    beside = GroundTarget(
        latitude_deg=LAS_VEGAS.latitude_deg + math.degrees(200.0 / per_rad_m[0]),
        longitude_deg=LAS_VEGAS.longitude_deg + math.degrees(100.0 / per_rad_m[1]),
        height_m=610.0,
    )
    [other] = replace(scene, target=beside).seen([undisturbed(scene.modes)])
    places = [
        places_in_frame(ISS_HRC, angle_rad, which.directions_at(t_s)) for which in (seen, other)
    ]
    expected = view.scale @ np.array([100.0, 200.0])
    moved = places[1] - places[0]
    np.testing.assert_allclose(moved, expected, rtol=0, atol=2e-3 * np.abs(moved).max())


def test_told_and_flown_probabilities_agree():
    """Three plans with the table flown as commanded, by attitudes known as they are by default, by
    sensors and exactly: the sum of squares of three standard scores is above 16.3 by chance once
    in a thousand times."""
    squares = 0.0
    sensors = AttitudeUncertainty(sigma_body_deg=(0.08, 0.15, 0.1))
    for number, (target, start_s, attitude) in enumerate(
        (
            (LAS_VEGAS, 140, LvlhAttitude()),
            (LAS_VEGAS, 160, LvlhAttitude(uncertainty=sensors)),
            (SALT_LAKE, 220, LvlhAttitude(uncertainty=STILL)),
        )
    ):
        made = make_plan(
            replace(scenario(session(target, start_s, start_s + 20)), attitude=attitude)
        )
        runs = 250
        flown = summarise(fly_runs(as_commanded(*session_scenes(made)), number, 0, runs))
        told = made.budgets[0].probability_in_frame
        assert 0.05 < told < 0.998  # some are lost, some are not
        squares += (flown.in_frame.value - told) ** 2 / (told * (1.0 - told) / runs)
        [one] = flown.sessions
        assert one.in_frame == flown.in_frame
        assert 0.0 <= one.frames_sharp <= one.frames_held <= 1.0
    assert squares < 16.3


def test_causes_share_what_varies(plan, scene):
    """Nothing but clock and Earth varies where orbit and attitude are exact; all together make
    the whole, for errors that nearly add up."""
    found = summarise(fly_runs(as_commanded(scene), 1, 0, 100))
    by_cause = {one.cause: one for one in found.contributors}
    assert by_cause["drive"].share == 0.0  # the same table each time
    whole = sum(one.share for one in found.contributors)
    spread = math.sqrt(sum(one.share_sigma**2 for one in found.contributors))
    assert abs(whole - 1.0) < 4.0 * spread
    assert by_cause["orbit"].smear_share > 0.5  # which moves the target along
    budget = mover_of(plan.scenario).budget(scene.ephemeris, plan.table, 0)
    assert not found.sessions[0].in_frame.differs_from(budget.probability_in_frame)


def test_sessions_of_one_plan_share_their_errors():
    """A run that misses one by its orbit misses the next: not the product of both."""
    made = make_plan(
        replace(
            scenario(session(LAS_VEGAS, 140, 160), session(SALT_LAKE, 200, 220)),
            attitude=LvlhAttitude(uncertainty=STILL),
        )
    )
    outcomes = fly_runs(as_commanded(*session_scenes(made)), 4, 0, 80)
    both = summarise(outcomes)
    first, second = (one.in_frame.value for one in both.sessions)
    assert both.in_frame.value <= min(first, second)
    correlation = np.corrcoef(outcomes[0].miss_rad, outcomes[1].miss_rad)[0, 1]
    assert correlation > 0.8


def test_a_star_is_held_without_metres():
    """Of infinite range: whatever the orbit, it is seen in the same direction."""
    star = StarTarget(ra_deg=182.0, dec_deg=38.4)  # near the orbit's pole, never behind the Earth
    made = make_plan(
        replace(scenario(session(star, 300, 330)), attitude=LvlhAttitude(uncertainty=STILL))
    )
    [scene] = as_commanded(*session_scenes(made))
    shown = nominal_session(scene, None)
    assert shown.error_m is shown.ground_sample_across_m is shown.moving_object_px is None
    assert shown.held == shown.frames == 90
    flown = summarise(fly_runs([scene], 1, 0, 40))
    assert flown.sessions[0].miss_m is None
    assert flown.sessions[0].in_frame.value == pytest.approx(
        made.budgets[0].probability_in_frame, abs=0.25
    )  # 3 sigma of 40 runs at a half


def test_a_plan_without_a_target_is_refused():
    still = ConstantRate(angle_deg=0.0, rate_deg_s=0.0)
    made = make_plan(
        scenario(session(BenchMotionTarget(axes=dict.fromkeys(("alpha", "beta"), still)), 10, 20))
    )
    with pytest.raises(InvalidInput, match="no target"):
        session_scenes(made)


# Each at an end of its range, beyond which a fifth more or less would be drawn.
DRIVES = {
    "held by friction": {"coulomb_deg_s2": 100.0, "breakaway_deg_s2": 100.0},
    "pulled away by cables": {"cable_tension_deg_s2": 100.0},
    "pulled back by cables": {"cable_tension_deg_s2": -100.0, "cable_stiffness_per_s2": 10.0},
    "in syrup": {"viscous_per_s": 100.0},
}


@pytest.fixture(scope="module")
def calm_plan():
    return make_plan(
        replace(scenario(session(LAS_VEGAS, 140, 150)), attitude=LvlhAttitude(uncertainty=STILL))
    )


def found(calm_plan, **changes):
    """The flight as planned, and four that are not."""
    flown = replace(calm_plan, scenario=replace(calm_plan.scenario, **changes))
    [scene] = session_scenes(flown)
    shown = nominal_session(scene, MovingObject(speed_m_s=20.0))
    return shown, summarise(fly_runs([scene], 1, 0, 4))


def numbers(shown, flights):
    for member in fields(shown):
        if member.name not in ("rate_error_rad_s", "gyros"):  # which two axes don't have
            yield member.name, getattr(shown, member.name)
    [one] = flights.sessions
    yield from (("smear", one.smear_px), ("miss", one.miss_m), ("misses", one.misses.edges_rad))
    for cause in flights.contributors:
        yield from ((f"{cause.cause} {name}", x) for name, x in vars(cause).items())


@pytest.mark.parametrize("name", DRIVES)
def test_drives_that_can_not_move_their_axes(calm_plan, name):
    drive = replace(AxisDrive(), **DRIVES[name])
    shown, flights = found(calm_plan, platform=replace(ISS_HRC, drives=(drive, drive)))
    for what, value in numbers(shown, flights):
        assert isinstance(value, str) or np.all(np.isfinite(value)), what
    assert shown.held == flights.in_frame.value == 0
    assert shown.saturated_s.max() == pytest.approx(20.0, abs=0.1)  # the session and its lead


def test_an_attitude_that_nobody_knows(calm_plan):
    lost = AttitudeUncertainty(sigma_body_deg=(90.0, 90.0, 90.0))
    shown, flights = found(calm_plan, attitude=LvlhAttitude(uncertainty=lost))
    for what, value in numbers(shown, flights):
        assert isinstance(value, str) or np.all(np.isfinite(value)), what
    assert shown.held == shown.frames
    assert not shown.saturated_s.any()
    by_cause = {one.cause: one.share for one in flights.contributors}
    assert by_cause["attitude"] > 0.9
