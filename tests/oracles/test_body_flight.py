"""Errors of a body in flight are those of a filter solved by SciPy, and lose what a budget says."""

import math
from dataclasses import replace

import agile_bodies
import numpy as np
import pytest
from agile_bodies import smallsat
from planner_values import plan_of
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.spatial.transform import Rotation
from test_body_plans import PATH, SMALLSAT, body_request

from planner.inflight.flights.frames import EXPOSURE_POINTS, frames_of
from planner.inflight.flights.nominal import nominal_session
from planner.inflight.flights.runs import fly_runs
from planner.inflight.flights.scene import session_scenes
from planner.inflight.flights.summary import summarise
from planner.inflight.simulation.platforms.registry import flyer_of
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants

ARCSEC = math.radians(1.0 / 3600.0)
CAUSES = ("attitude knowledge", "attitude control", "vibration")
VEGA = {"mode": "star", "name": "Vega"}
TIMES = {"start": "2015-05-10T10:36:28Z", "stop": "2015-05-10T10:36:48Z"}


def of_a_star(half_arcsec, **knowledge):
    """The smallsat with a small frame on Vega, where no error of the orbit counts."""
    camera = {
        "type": "frame",
        "field_of_view_deg": [2.0 * half_arcsec / 3600.0] * 2,
        "pixel_arcsec": 1.0,
        "exposure_s": 0.2,
        "frames_per_s": 4.0,
    }
    platform = SMALLSAT | {"camera": camera, "knowledge": knowledge}
    return body_request(platform=platform, sessions=[{"target": VEGA, **TIMES}])


@pytest.fixture(scope="module")
def star():
    return plan_of(of_a_star(60.0, sigma_arcsec=20.0, control_sigma_arcsec=10.0, jitter_arcsec=0.2))


def turned(plan, t_s, runs, *causes):
    """How the body is turned in its own axes by these causes alone, (runs, n, 3)."""
    flyer, table = flyer_of(plan.scenario), plan.table
    names = [f"{word}_arcsec" for word in ("sigma", "control_sigma", "jitter")]
    kept = dict(zip(CAUSES, names, strict=True))
    gone = {name: 0.0 for cause, name in kept.items() if cause not in causes}
    knowledge = replace(flyer.platform.knowledge, **gone)
    flyer.platform = replace(flyer.platform, knowledge=knowledge)
    found = []
    for run in range(runs):
        flown = flyer.fly(table, 0.0, 0, {cause: 10 * run + k for k, cause in enumerate(CAUSES)})
        q_eci_from_body_xyzw, turned_eci_rad = flown.at(t_s)
        found.append(Rotation.from_quat(q_eci_from_body_xyzw).inv().apply(turned_eci_rad))
    return np.array(found)


def test_what_wanders_is_noise_through_a_filter_of_the_second_order(star):
    """x'' + 2 b x' + b^2 x = white noise, by Lyapunov's equation and the matrix exponential.

    Half of it is forgotten in `correlation_s`; b comes from that by bisection.
    """
    half_life_s, sigma_rad = 10.0, 20.0 * ARCSEC

    def kept(decay_per_s, after_s):
        drift = np.array([[0.0, 1.0], [-(decay_per_s**2), -2.0 * decay_per_s]])
        still = solve_continuous_lyapunov(drift, -np.diag([0.0, 1.0]))
        return (expm(drift * after_s) @ still)[0, 0] / still[0, 0], still[1, 1] / still[0, 0]

    low, high = 0.01, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if kept(middle, half_life_s)[0] > 0.5 else (low, middle)
    runs, t_s = 1500, np.array([0.0, 0.05, 3.0, 10.0, 25.0])
    found = turned(star, t_s, runs, "attitude knowledge")
    chance = 4.0 / math.sqrt(3.0 * runs)  # 4 sigma of a correlation of so many numbers
    told = [kept(low, after_s)[0] for after_s in t_s]
    products = np.mean(found * found[:, :1], axis=(0, 2)) / sigma_rad**2
    np.testing.assert_allclose(products, told, atol=math.sqrt(2.0) * chance)
    assert told[3] == pytest.approx(0.5)
    rates_rad_s = (found[:, 1] - found[:, 0]) / 0.05
    rate_share = np.mean(rates_rad_s**2) / (sigma_rad**2 * kept(low, 1.0)[1])
    assert rate_share == pytest.approx(1.0, abs=3.0 * chance)  # its tails are heavier than Gauss's
    across = np.mean(found[:, 0, 0] * found[:, 0, 1]) / sigma_rad**2
    assert abs(across) < 4.0 / math.sqrt(runs)


def test_vibration_is_as_large_as_stated_and_faster_than_an_exposure(star):
    t_s = np.linspace(0.0, 0.2, 400)
    found = turned(star, t_s, 400, "vibration")
    assert np.sqrt(np.mean(found**2)) == pytest.approx(0.2 * ARCSEC, rel=0.05)
    # Over an exposure nearly nothing of it stays: a tone of one cycle has a mean of 0.
    assert np.sqrt(np.mean(found.mean(axis=1) ** 2)) < 0.3 * 0.2 * ARCSEC


def test_the_camera_sees_what_a_body_turned_so_would_see(star):
    """A true attitude of commanded times error, against the frame that is told of both."""
    platform, t_s = star.scenario.platform, np.linspace(70.0, 70.2, EXPOSURE_POINTS)
    flyer = flyer_of(star.scenario)
    seeds = dict(zip(CAUSES, (1, 2, 3), strict=True))
    position, turn_rad = flyer.fly(star.table, 0.0, 0, seeds).at(t_s)
    q_eci_from_true = Rotation.from_rotvec(turn_rad) * Rotation.from_quat(position)
    vega_eci = np.array([0.12509597, -0.76941358, 0.62637765])  # any direction near to it will do
    seen_payload = q_eci_from_true.inv().apply(vega_eci) @ platform.camera.c_payload_from_body.T
    at_s, target = t_s[None, :], np.tile(vega_eci, (len(t_s), 1))
    frames = frames_of(platform, at_s, position, turn_rad, target)
    middle = seen_payload[EXPOSURE_POINTS // 2]
    np.testing.assert_allclose(
        frames.place_px[0], middle[:2] / middle[2] / ARCSEC, atol=1e-3 + 1e-4 * abs(middle[0])
    )


@pytest.mark.parametrize(
    ("axis", "off_arcsec", "held"), [(0, 3600.0, True), (1, 1120.0, True), (1, 1130.0, False)]
)
def test_a_line_holds_what_crosses_it(axis, off_arcsec, held):
    """8192 pixels of 0.275 arcsec are 2252.8 long; along the motion a point is seen later."""
    platform = smallsat()
    q_eci_from_body_xyzw = np.tile(Rotation.random(random_state=1).as_quat(), (EXPOSURE_POINTS, 1))
    off = np.zeros(3)
    off[axis] = math.tan(off_arcsec * ARCSEC)
    q = platform.q_payload_from_base(q_eci_from_body_xyzw).inv()
    target = q.apply(np.array([0.0, 0.0, 1.0]) + off)
    target /= np.linalg.norm(target, axis=1, keepdims=True)
    at_s = np.linspace(0.0, platform.camera.exposure_s, EXPOSURE_POINTS)[None, :]
    still = np.zeros((EXPOSURE_POINTS, 3))
    frames = frames_of(platform, at_s, q_eci_from_body_xyzw, still, target)
    assert frames.holds.tolist() == [held]
    assert platform.camera.exposure_s == pytest.approx(64 / 12000.0)


def test_told_and_flown_probabilities_agree():
    """Four plans; the sum of squares of four standard scores is above 18.5 by chance once in a
    thousand times.  Frames are a quarter of a second apart, in which little leaves and returns."""
    squares, runs = 0.0, 80
    for number, (half_arcsec, knowledge) in enumerate(
        (
            (45.0, {"sigma_arcsec": 20.0, "control_sigma_arcsec": 10.0}),
            (60.0, {"sigma_arcsec": 20.0, "control_sigma_arcsec": 20.0, "correlation_s": 30.0}),
            (30.0, {"sigma_arcsec": 15.0, "control_sigma_arcsec": 5.0, "correlation_s": 400.0}),
            (50.0, {"sigma_arcsec": 5.0, "control_sigma_arcsec": 20.0, "correlation_s": 4.0}),
        )
    ):
        made = plan_of(of_a_star(half_arcsec, **knowledge))
        told = made.budgets[0].probability_in_frame
        assert 0.1 < told < 0.9
        flown = summarise(fly_runs(session_scenes(made), number, 0, runs))
        squares += (flown.in_frame.value - told) ** 2 / (told * (1.0 - told) / runs)
    assert squares < 18.5


def test_causes_share_what_varies_by_the_squares_of_their_sigmas(star):
    """Of a star nothing else moves; the indices of what adds up are the variances' shares."""
    found = summarise(fly_runs(session_scenes(star), 1, 0, 100))
    by_cause = {one.cause: one for one in found.contributors}
    assert set(by_cause) == {"orbit", "Earth orientation", "clock", *CAUSES}
    for cause, share in (("attitude knowledge", 0.8), ("attitude control", 0.2), ("orbit", 0.0)):
        one = by_cause[cause]
        assert one.share == pytest.approx(share, abs=4.0 * one.share_sigma + 1e-3), cause
    vibration = by_cause["vibration"]
    assert vibration.smear_share > 0.1 > 100.0 * vibration.share  # it is small and fast


def test_as_planned_a_body_vibrates_and_no_more(star):
    [scene] = session_scenes(star)
    shown = nominal_session(scene, None)
    assert shown.held == shown.frames == 80
    assert shown.error_rad.max() < 1.5 * ARCSEC  # 0.1 of the table, 5 sigma of vibration
    assert not shown.saturated_s.any()


def test_sessions_a_moment_apart_share_an_error_that_lasts(star):
    """The errors' clock is the plan's: rows of a later session go on where the earlier ended."""
    flyer, table = flyer_of(star.scenario), star.table
    seeds = dict(zip(CAUSES, (4, 5, 6), strict=True))
    later = replace(
        table,
        position=table.position[50:],
        rate_rad_s=table.rate_rad_s[50:],
        acceleration_rad_s2=table.acceleration_rad_s2[50:],
    )
    whole = flyer.fly(table, 0.0, 0, seeds).at(np.array([20.0]))
    part = flyer.fly(later, 10.0, 1, seeds).at(np.array([10.0]))
    for one, other in zip(whole, part, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-15)


def test_a_pushbroom_is_flown_line_by_line():
    """Ten of its lines a second, each lasting as long as its TDI takes."""
    camera = {"type": "pushbroom", "pixel_arcsec": 1.0, "pixels": 700, "tdi_lines": 50}
    session = body_request()["sessions"][0] | {"stop": "2015-05-10T10:35:58Z"}
    made = plan_of(body_request(platform=SMALLSAT | {"camera": camera}, sessions=[session]))
    [scene] = session_scenes(made)
    assert scene.at_s[1:, 0] - scene.at_s[:-1, 0] == pytest.approx(0.1, abs=1e-9)
    assert scene.at_s[:, -1] - scene.at_s[:, 0] == pytest.approx(50 / 10e3, abs=1e-9)
    flown = summarise(fly_runs([scene], 1, 0, 60))
    told = made.budgets[0].probability_in_frame
    assert 0.05 < told < 0.95
    assert not flown.in_frame.differs_from(told)


def test_lines_of_a_slow_scan_last_as_long_as_the_ground_takes_to_cross_them():
    """A place on the turning Earth, seen before and after by the attitudes of the table's rows.

    It stands where the path is at a row; the exposure in between is that of its row.
    """
    times = {"start": "2015-05-10T10:41:08Z", "stop": "2015-05-10T10:41:38Z"}
    path = {"target": PATH, "roll": {"rule": "lines_across_motion"}, **times}
    platform = SMALLSAT | {"camera": agile_bodies.SMALLSAT["camera"]}
    [scene] = session_scenes(plan_of(body_request(platform=platform, sessions=[path])))
    camera, table = scene.scenario.platform.camera, scene.table
    shortest_s = camera.tdi_lines / camera.line_rate_max_hz
    lasts_s = scene.at_s[:, -1] - scene.at_s[:, 0]
    assert lasts_s.min() > 5.0 * shortest_s
    assert scene.at_s[-1, -1] <= scene.from_s + table.t_s[-1] + 1e-6
    mount = Rotation.from_matrix(camera.c_payload_from_body)
    for frame in (20, 150, 280):  # two seconds in, and so on: on a row
        middle_s = scene.at_s[frame, 0]
        row = round((middle_s - scene.from_s) / 0.2)
        at_s = middle_s + np.array([0.0, -0.2, 0.2])
        instants = Instants(scene.instants.epoch_utc, at_s)
        place_itrf_m = scene.target.r_target_itrf_m(instants)[0]
        place_eci_m = c_itrf_from_eci(instants)[0].T @ place_itrf_m
        turned = Rotation.from_rotvec(np.outer(at_s - middle_s, [0.0, 0.0, 7.292115e-5]))
        seen_eci_m = turned.apply(place_eci_m) - scene.ephemeris.states(instants).r_sat_eci_m
        q_eci_from_body = Rotation.from_quat(table.position[[row, row - 1, row + 1]])
        x, _, z = (mount * q_eci_from_body.inv()).apply(seen_eci_m).T
        crossed_px = abs(x[2] / z[2] - x[1] / z[1]) / (camera.pixel_arcsec * ARCSEC)
        crossing_s = camera.tdi_lines * 0.4 / crossed_px
        # The angle's curvature over 0.4 s, and aberration, which changes by some arcseconds.
        assert lasts_s[frame] == pytest.approx(crossing_s, rel=5e-3)


def test_a_line_is_never_shorter_than_at_the_largest_rate():
    """200 pixels a second, 20,000 of the 12,000 there may be, and a stare, in which none move."""
    camera = smallsat().camera
    image_rad_s = np.array([200.0, 20e3, 0.0]) * 0.275 * ARCSEC
    assert camera.exposures_s(image_rad_s) == pytest.approx([64 / 200, 64 / 12e3, 64 / 12e3])
