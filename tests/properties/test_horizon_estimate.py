"""The estimator finds the vertical of rendered horizons, and refuses what is none."""

from dataclasses import replace

import numpy as np
import pytest
from horizon_air import CONDITIONS, cases
from horizon_cases import NEGATIVES, RollingShutter, angle_deg, camera, case, negative, ring
from limb_frames import lowest_points
from scipy.spatial.transform import Rotation

from estimator.check import Verdict, across_axes, check_attitude
from estimator.errors import InvalidCamera, InvalidImage, Reason
from estimator.images import blue_is_sharp
from estimator.limb.geometry import Limb
from estimator.limb.points import ideal_points
from estimator.nadir.fit import Prior, attitude_facing, fit
from estimator.pipeline import estimate_vertical
from estimator.prediction import predict_horizon
from estimator.rendering.atmosphere import Atmosphere
from estimator.rendering.scene import Scene
from estimator.rendering.sensor import Sensor
from estimator.request import PredictedAttitude
from estimator.series import summarise_series
from estimator.surroundings import Surroundings

FOUR_SIGMA = 18.4  # chi-square of two degrees of freedom, one in 10,000
DUSTLESS = Atmosphere(air_scale_m=7.5e3, dust_optical_depth=0.0, haze_optical_depth=0.0, ozone=0.0)


def moved(position, steps):
    """By so many times 1e-9 km along x."""
    x_km, *others_km = position.position_km
    return replace(position, position_km=(x_km + steps * 1e-9, *others_km))


def normalised2(nadir, truth):
    off = nadir.axes_body @ (nadir.nadir_body - truth)
    return float(off @ np.linalg.solve(nadir.covariance_rad2, off))


@pytest.fixture(scope="module")
def pair():
    return case(np.random.default_rng(3001), ring(2))


@pytest.fixture(scope="module")
def found(pair):
    return estimate_vertical(pair.images, pair.request)


@pytest.mark.parametrize(
    "sensor", [Sensor(), Sensor(bits=16), Sensor(jpeg_quality=60)], ids=["8", "16", "JPEG"]
)
def test_ideal_limb_within_a_hundredth_of_a_degree(sensor):
    scene = Scene(constant_limb_m=17.5e3, cloud_cover=0.6)
    one = case(np.random.default_rng(3002), ring(2), scene=scene, sensor=sensor)
    answer = estimate_vertical(one.images, one.request)
    # The 0.010 deg rms; twice that for a single draw.
    assert angle_deg(answer.geocentric.nadir_body, one.geocentric_body) < 0.02


@pytest.mark.parametrize("seed", range(3010, 3012))
def test_real_limb_lies_within_its_stated_error(seed):
    one = case(np.random.default_rng(seed), ring(2), predicted_off_deg=5.0)
    answer = estimate_vertical(one.images, one.request)
    assert answer.verdict is Verdict.CONSISTENT
    assert normalised2(answer.geocentric, one.geocentric_body) < FOUR_SIGMA
    assert normalised2(answer.geodetic, one.geodetic_body) < FOUR_SIGMA
    assert answer.geodetic.sigma_rad < np.deg2rad(0.05)


def test_the_last_digit_of_what_is_known_moves_nothing(pair, found):
    """A micrometre of orbit is 1e-13 rad, and all sums are others; where a pixel is looked up is
    rounded to 3e-5 of it, 5e-8 rad."""
    here = pair.request.position
    for step in range(1, 4):
        one = estimate_vertical(pair.images, replace(pair.request, position=moved(here, step)))
        off = one.geocentric.nadir_body - found.geocentric.nadir_body
        assert np.abs(off).max() < 5e-8


def test_no_prediction_is_needed(pair):
    answer = estimate_vertical(pair.images, replace(pair.request, predicted=None))
    assert answer.verdict is Verdict.MEASURED
    assert normalised2(answer.geodetic, pair.geodetic_body) < FOUR_SIGMA
    assert normalised2(answer.geocentric, pair.geocentric_body) < FOUR_SIGMA


def test_red_towards_the_sun_tells_the_heading(pair):
    blind = replace(pair.request, predicted=None)
    colour = estimate_vertical(pair.images, blind)
    grey = estimate_vertical([np.mean(i, axis=2).astype(np.uint8) for i in pair.images], blind)
    # Geocentric and geodetic nadir are up to 0.19 deg apart, whichever way the craft faces.
    assert colour.geocentric.sigma_rad < grey.geocentric.sigma_rad < np.deg2rad(0.25)
    assert normalised2(grey.geocentric, pair.geocentric_body) < FOUR_SIGMA


def test_no_heading_is_guessed_under_a_low_sun():
    one = case(np.random.default_rng(3041), ring(2), sun_deg=(5.0, 18.0), predicted_off_deg=None)
    answer = estimate_vertical(one.images, one.request)
    assert answer.reason is Reason.HEADING_UNKNOWN


def test_tone_curves_are_undone():
    seed = 3080
    plain = case(np.random.default_rng(seed), ring(2), sensor=Sensor(colour=True))
    toned = Sensor(colour=True, gamma=2.2, jpeg_quality=85)
    photograph = case(np.random.default_rng(seed), ring(2), sensor=toned)
    light = estimate_vertical(plain.images, plain.request)
    coded = estimate_vertical(photograph.images, photograph.request)
    assert [camera.used for camera in coded.cameras] == [True, True]
    assert normalised2(coded.geocentric, photograph.geocentric_body) < FOUR_SIGMA
    # Grey limbs stand 3.5 km lower than blue ones; as they are stored, 15 km higher.
    assert coded.limb_height_m - light.limb_height_m < 2e3


def test_one_camera_is_enough_and_says_so(pair, found):
    request = replace(pair.request, cameras=pair.request.cameras[:1])
    one = estimate_vertical(pair.images[:1], request)
    assert normalised2(one.geocentric, pair.geocentric_body) < FOUR_SIGMA
    assert one.geocentric.sigma_rad > 1.5 * found.geocentric.sigma_rad


def test_an_unstated_lens_may_be_a_hundredth_off(pair):
    longer = [
        replace(c, fx_px=1.01 * c.fx_px, fy_px=1.01 * c.fy_px, lens_sigma=None)
        for c in pair.request.cameras
    ]
    answer = estimate_vertical(pair.images, replace(pair.request, cameras=tuple(longer)))
    # Taken as calibrated, 6.5 sigma.
    assert normalised2(answer.geocentric, pair.geocentric_body) < FOUR_SIGMA


def test_a_lens_wrongly_stated_as_calibrated_is_found_out():
    """Believed, such a lens leaves a square of 65 over the variance told."""
    one = case(np.random.default_rng(3015), ring(2))
    longer = tuple(replace(c, fx_px=0.99 * c.fx_px, fy_px=0.99 * c.fy_px) for c in ring(2))
    right = estimate_vertical(one.images, one.request)
    wrong = estimate_vertical(one.images, replace(one.request, cameras=longer))
    assert normalised2(wrong.geocentric, one.geocentric_body) < FOUR_SIGMA
    assert [camera.used for camera in wrong.cameras] == [True, True]
    assert any("a lens that is stated" in warning for warning in wrong.warnings)
    assert not right.warnings


def test_a_statement_that_the_frames_bear_out_costs_little(pair, found):
    """One request in ten has another lens than stated: that adds to sigma what nothing shows."""
    unstated = tuple(replace(c, lens_sigma=None) for c in pair.request.cameras)
    doubted = estimate_vertical(pair.images, replace(pair.request, cameras=unstated))
    assert found.geocentric.sigma_rad < 0.9 * doubted.geocentric.sigma_rad


def test_an_unstated_shutter_widens_the_covariance(pair, found):
    """Unless the body hardly turns."""
    unstated = replace(
        pair.request, cameras=tuple(replace(c, readout_s=None) for c in pair.request.cameras)
    )
    slow = replace(unstated, rate_body_deg_s=(0.0, -0.065, 0.0), rate_sigma_deg_s=0.01)
    stated_rad = found.geocentric.sigma_rad
    unstated_rad, slow_rad = (
        estimate_vertical(pair.images, request).geocentric.sigma_rad for request in (unstated, slow)
    )
    assert unstated_rad > 1.05 * stated_rad
    assert slow_rad == pytest.approx(stated_rad, rel=0.01)


def test_a_rolling_shutter_sees_the_limb_from_many_attitudes():
    rate_deg_s = (2.3, -2.3, 2.3)
    rolling = tuple(replace(c, readout_s=0.1) for c in ring(2))
    shutters = [RollingShutter(c, np.array(rate_deg_s)) for c in rolling]
    one = case(np.random.default_rng(3090), rolling, true_cameras=shutters)
    unknown = estimate_vertical(one.images, one.request)
    told = replace(one.request, rate_body_deg_s=rate_deg_s, rate_sigma_deg_s=0.1)
    known = estimate_vertical(one.images, told)
    for answer in (unknown, known):
        assert normalised2(answer.geocentric, one.geocentric_body) < FOUR_SIGMA
    # Rows 0.1 s apart see 0.4 deg of turn, which shares its shape with a tilt.
    assert known.geocentric.sigma_rad < 0.8 * unknown.geocentric.sigma_rad


def test_a_wrong_prediction_is_found_out(pair):
    told = Rotation.from_quat(pair.request.predicted.q_body_from_eci_xyzw)
    wrong = Rotation.from_euler("x", 0.5, degrees=True) * told
    predicted = PredictedAttitude(
        q_body_from_eci_xyzw=tuple(wrong.as_quat().tolist()), sigma_deg=0.05
    )
    answer = estimate_vertical(pair.images, replace(pair.request, predicted=predicted))
    assert answer.verdict is Verdict.INCONSISTENT
    assert np.rad2deg(answer.check.angle_rad) == pytest.approx(0.5, abs=0.1)  # 4 sigma
    series = summarise_series([answer, answer], np.deg2rad(0.05))
    assert series.verdict is Verdict.INCONSISTENT
    np.testing.assert_allclose(series.scatter_rad, 0.0, atol=1e-12)  # twice the same frame


@pytest.mark.parametrize("turn", [np.s_[::-1, ::-1], np.s_[::-1], np.s_[:, ::-1]])
def test_flipped_frames_never_pass(pair, turn):
    flipped = [np.ascontiguousarray(image[turn]) for image in pair.images]
    answer = estimate_vertical(flipped, pair.request)
    assert answer.verdict in (Verdict.INCONSISTENT, Verdict.NOT_OBSERVABLE)


def test_swapped_cameras_never_pass(pair):
    answer = estimate_vertical(pair.images[::-1], pair.request)
    assert answer.verdict in (Verdict.INCONSISTENT, Verdict.NOT_OBSERVABLE)


def test_a_blind_camera_does_not_spoil_the_other(pair):
    black = np.zeros_like(pair.images[0])
    answer = estimate_vertical([pair.images[0], black], pair.request)
    assert answer.cameras[1].reason is Reason.ALL_BLACK
    assert answer.cameras[0].used
    assert normalised2(answer.geocentric, pair.geocentric_body) < FOUR_SIGMA


@pytest.mark.parametrize("kind", NEGATIVES)
def test_images_without_a_horizon_are_refused(kind):
    image, request = negative(kind, np.random.default_rng(3030))
    answer = estimate_vertical([image], request)
    assert answer.verdict is Verdict.NOT_OBSERVABLE
    plain = {"black": Reason.ALL_BLACK, "white": Reason.SATURATED, "airglow": Reason.GLOWING_LAYER}
    plain |= dict.fromkeys(("ground", "cloud deck"), Reason.NO_SKY)
    plain |= {"red limb": Reason.COLOUR, "aurora": Reason.GLOWING_LAYER}
    assert answer.reason is plain.get(kind, answer.reason) is not None


def test_the_sun_in_the_frame_is_blamed(pair):
    around = Surroundings(pair.request.epoch, pair.request.position, pair.request.body)
    sun_eci = around.c_itrf_from_eci.T @ around.sun_itrf
    camera = pair.request.cameras[0]
    q = Rotation.align_vectors([camera.boresight_body], [sun_eci])[0]
    told = PredictedAttitude(q_body_from_eci_xyzw=tuple(q.as_quat().tolist()), sigma_deg=1.0)
    y, x = np.mgrid[0:480, 0:640]
    veil = 255.0 * np.exp(-np.hypot(x - 320.0, y - 240.0) / 150.0)
    request = replace(pair.request, cameras=(camera,), predicted=told)
    answer = estimate_vertical([veil.astype(np.uint8)], request)
    assert answer.reason is Reason.SUN_IN_FRAME


@pytest.mark.parametrize(
    "options",
    [
        {"sun_deg": (5.0, 15.0)},
        {"sensor": Sensor(), "sun_deg": (8.0, 20.0)},
        {"sensor": Sensor(), "predicted_off_deg": None},
        {"sensor": Sensor(colour=True, exposure=2.5)},
        {"sensor": Sensor(exposure=2.5)},
    ],
    ids=["low Sun", "gray, low Sun", "gray, blind", "overexposed", "gray, overexposed"],
)
def test_what_is_hard_to_measure_says_so(options):
    one = case(np.random.default_rng(3060), ring(2), **options)
    answer = estimate_vertical(one.images, one.request)
    assert answer.geodetic is None or (normalised2(answer.geodetic, one.geodetic_body) < FOUR_SIGMA)


@pytest.mark.parametrize("seed", [5000, 5001])
def test_clouds_seen_down_to_the_ground_are_not_the_limb(seed):
    thin = Scene(atmosphere=replace(DUSTLESS, air_density=0.6), cloud_cover=0.5, roughness_m=500.0)
    one = case(np.random.default_rng(seed), ring(2), scene=thin, sensor=Sensor())
    answer = estimate_vertical(one.images, one.request)
    assert [camera.used for camera in answer.cameras] == [True, True]
    assert normalised2(answer.geocentric, one.geocentric_body) < FOUR_SIGMA


def test_colours_are_sharp_under_clouds_and_blurred_by_a_jpeg():
    scene = Scene(atmosphere=DUSTLESS, cloud_cover=0.5, roughness_m=500.0)
    little_noise = Sensor(colour=True, full_well_e=100e3, read_noise_e=6.0)
    for sensor, sharp in ((little_noise, True), (replace(little_noise, jpeg_quality=90), False)):
        one = case(np.random.default_rng(5001), ring(2), scene=scene, sensor=sensor)
        assert [blue_is_sharp(image) for image in one.images] == [sharp, sharp]


def test_an_overexposed_camera_weighs_less():
    seed = 3070
    good = case(np.random.default_rng(seed), ring(2), sensor=Sensor(colour=True))
    bright = case(np.random.default_rng(seed), ring(2), sensor=Sensor(colour=True, exposure=2.5))

    def sigma(first, second):
        answer = estimate_vertical([first.images[0], second.images[1]], good.request)
        assert normalised2(answer.geocentric, good.geocentric_body) < FOUR_SIGMA
        return answer.geocentric.sigma_rad

    assert sigma(good, good) < sigma(good, bright) < sigma(bright, bright)


def test_images_that_do_not_fit_are_refused(pair):
    with pytest.raises(InvalidCamera, match="one per camera"):
        estimate_vertical(pair.images[:1], pair.request)
    turned = [np.ascontiguousarray(np.rot90(image)) for image in pair.images]
    with pytest.raises(InvalidImage, match="unrotated"):
        estimate_vertical(turned, pair.request)


def test_prediction_sees_what_the_estimator_then_finds(pair, found):
    around = Surroundings(pair.request.epoch, pair.request.position, pair.request.body)
    q = Rotation.from_quat(pair.request.predicted.q_body_from_eci_xyzw)
    camera = pair.request.cameras[0]
    expected = predict_horizon(camera, around, q)
    seen = found.cameras[0]
    assert expected.reason is None
    assert np.rad2deg(expected.arc_rad) == pytest.approx(seen.arc_deg, abs=3.0)  # outliers
    # 12 km of limb height between them at most, 3 km a pixel.
    middle = seen.limb_px[len(seen.limb_px) // 2]
    assert np.min(np.linalg.norm(expected.limb_px - middle, axis=1)) < 15.0
    up = Rotation.from_euler("x", 180.0, degrees=True) * q
    assert predict_horizon(camera, around, up).reason is Reason.NOT_IN_FRAME


def test_check_has_the_closed_form_of_two_equal_errors():
    nadir = np.array([0.0, 0.0, 1.0])
    turned = Rotation.from_euler("y", 0.01).apply(nadir)
    check = check_attitude(nadir, 0.004**2 * np.eye(2), turned, 0.003)
    # Rayleigh's law: exp(-r^2 / 2 s^2), s = hypot(0.004, 0.003).
    assert check.probability == pytest.approx(np.exp(-0.5 * (0.01 / 0.005) ** 2), rel=1e-6)
    assert check.angle_rad == pytest.approx(0.01, rel=1e-12)
    assert np.hypot(check.along_rad, check.across_rad) == pytest.approx(0.01, rel=1e-12)
    np.testing.assert_allclose(np.cross(*across_axes(nadir)), nadir, atol=1e-15)


LIMB = Limb(np.array([4.9e6, 0.0, 4.9e6]), 6378137.0, 6356752.3142)
HEIGHT_M, ROUGHNESS_M = 17.5e3, 800.0
PRIOR = Prior(
    height_m=HEIGHT_M,
    height_sigma_m=4e3,
    heading_sigma_rad=np.deg2rad(1.0),
    lean_sigma_m=1.0,
    bend_sigma_m=1.0,
    roughness_m=ROUGHNESS_M,
    sun_itrf=None,
)
PATCHES, PER_PATCH = 72, 20


def cost_of_limb(rough_m):
    """Of a limb all round, on patches of 5 deg (72,) so much higher."""
    c_body_from_itrf = attitude_facing(np.array([0.0, 0.0, 1.0]), LIMB)
    step_rad = 2.0 * np.pi / (PATCHES * PER_PATCH)
    azimuth_rad = step_rad * np.arange(PATCHES * PER_PATCH)
    height_m = HEIGHT_M + np.repeat(rough_m, PER_PATCH)
    ray_itrf = np.concatenate(
        [LIMB.directions_itrf(np.array([a]), h) for a, h in zip(azimuth_rad, height_m, strict=True)]
    )
    ray_body = ray_itrf @ c_body_from_itrf.T
    every = np.ones(len(azimuth_rad), dtype=bool)
    # So fine that an edge's own noise, 50 m, is nothing beside the roughness.
    fine = camera("c", 0.0, width=6400, height=4800)
    points = ideal_points(fine, ray_body, azimuth_rad, every, step_rad)
    return fit([points], LIMB, c_body_from_itrf, PRIOR).cost


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_rougher_limb_is_less_likely(seed):
    """By Gauss's law with the scale of the residuals themselves: each of n patches k times as far
    off costs 2 ln k.  Else a heading whose limb fits nowhere were as good as the true one."""
    rough_m = np.random.default_rng(seed).normal(0.0, ROUGHNESS_M, PATCHES)
    dearer = cost_of_limb(4.0 * rough_m) - cost_of_limb(1.2 * rough_m)
    # Tukey's weights and the median, in place of the rms, are good to a tenth of it.
    assert dearer == pytest.approx(2.0 * PATCHES * np.log(4.0 / 1.2), rel=0.1)


@pytest.fixture(scope="module", params=["drawn_2", "tropical", "after_eruption"])
def pair_in_other_air(request):
    """The same frames in colour and in grey."""
    return next(cases(request.param, CONDITIONS["day, noisy, 320 px"], 1, seed=6))


def test_predicted_pair_is_right(pair_in_other_air):
    for one in pair_in_other_air:
        nadir = estimate_vertical(one.images, one.request).geocentric
        assert normalised2(nadir, one.geocentric_body) < FOUR_SIGMA
        # Half a pixel of 0.18 deg: the limb is found to a part of that, whatever lifts it.
        assert np.linalg.norm(nadir.nadir_body - one.geocentric_body) < np.deg2rad(0.09)


def test_heading_from_light_is_as_good_as_told(pair_in_other_air):
    """Taken for ordinary air, an eruption's haze turns the Sun's side around."""
    for one in pair_in_other_air:
        answer = estimate_vertical(one.images, replace(one.request, predicted=None))
        assert normalised2(answer.geocentric, one.geocentric_body) < FOUR_SIGMA
        assert normalised2(answer.geodetic, one.geodetic_body) < FOUR_SIGMA


def test_clouds_in_clean_air_do_not_draw_the_limb_down():
    """Clouds beyond the horizon, seen through air without dust, put this frame 11 sigma off."""
    _, (_, grey) = cases("exponential", CONDITIONS["day"], 2, seed=1)
    alone = replace(grey.request, cameras=grey.request.cameras[:1])
    for answer in (
        estimate_vertical(grey.images[:1], alone),
        estimate_vertical(grey.images, grey.request),
    ):
        assert answer.geocentric is not None
        assert normalised2(answer.geocentric, grey.geocentric_body) < FOUR_SIGMA


def test_frames_have_the_ellipsoids_limb():
    """Seen from 500 km over the equator, rays that touch the ellipsoid: in the equator's plane, at
    cos = a / r; due north, by the tangent to the meridian's ellipse."""
    a_m, b_m, r_m = 6378137.0, 6356752.3142, 6878137.0
    down = np.arccos(a_m / r_m)
    east = np.array([-np.sin(down), np.cos(down), 0.0])
    slope = b_m / np.sqrt(r_m**2 - a_m**2)
    north = np.array([-1.0, 0.0, slope]) / np.hypot(1.0, slope)
    _, _, height_m = lowest_points(np.array([r_m, 0.0, 0.0]), np.stack([east, north]))
    np.testing.assert_allclose(height_m, 0.0, atol=1e-3)
