"""Azimuth, elevation, Sun and solar time of the pass table are Skyfield's."""

import numpy as np
from opportunity_requests import iss_request, oco3_targets
from skyfield.api import wgs84
from test_opportunities_skyfield import at

from planner.planning.opportunities import OpportunityTarget, find_opportunities
from planner.world.frames.time_scales import DAY_S
from planner.world.targets import BodyTarget, GroundTarget, MovingGroundTarget

# What the API promises: 0.001 deg.  Skyfield's frames differ by milliarcseconds, its SGP4 state
# by none: 3e-7 deg are left, of the polynomial through the orbit's rows (3 mm).
ANGLE_DEG = 1e-5
SOLAR_S = 15e-3  # the Sun's 15 arcsec a second, by milliarcseconds

PLACES = (
    *oco3_targets(every=100),
    # The south, the antimeridian, a high place, near the pole of the orbit's inclination.
    OpportunityTarget(id="s", target=GroundTarget(latitude_deg=-51.0, longitude_deg=-70.0)),
    OpportunityTarget(
        id="fiji", target=GroundTarget(latitude_deg=-17.0, longitude_deg=180.0, height_m=3000.0)
    ),
)


def off_deg(angle_rad, reference_deg):
    """Their difference, whole turns aside."""
    return (np.rad2deg(angle_rad) - reference_deg + 180.0) % 360.0 - 180.0


def test_rise_culmination_and_set(skyfield):
    timescale, kernel, satellite = skyfield
    request = iss_request(3.0, targets=PLACES)
    windows = find_opportunities(request).windows
    compared = 0
    for number, wanted in enumerate(PLACES):
        place = wgs84.latlon(
            wanted.target.latitude_deg, wanted.target.longitude_deg, wanted.target.ground_height_m
        )
        mine = windows.select(windows.target == number)
        instants = at(timescale, mine.sky.t_s.ravel())
        shape = mine.sky.t_s.shape
        altitude, azimuth, _ = (satellite - place).at(instants).altaz()
        sky = mine.sky
        off_elevation = off_deg(sky.elevation_rad, altitude.degrees.reshape(shape))
        assert np.abs(off_elevation).max() < ANGLE_DEG
        # Near the zenith azimuths run together.
        across = off_deg(sky.azimuth_rad, azimuth.degrees.reshape(shape))
        assert np.abs(across * np.cos(sky.elevation_rad)).max() < ANGLE_DEG
        sun = (kernel["earth"] + place).at(instants).observe(kernel["sun"]).apparent()
        altitude, azimuth, _ = sun.altaz()
        off_sun = off_deg(sky.sun_elevation_rad, altitude.degrees.reshape(shape))
        assert np.abs(off_sun).max() < ANGLE_DEG
        off_azimuth = off_deg(sky.sun_azimuth_rad, azimuth.degrees.reshape(shape))
        assert np.abs(off_azimuth * np.cos(sky.sun_elevation_rad)).max() < ANGLE_DEG
        hour_angle, _, _ = sun.hadec()
        solar_s = (hour_angle.hours.reshape(shape) * 3600.0 + 0.5 * DAY_S) % DAY_S
        off_s = (sky.solar_time_s - solar_s + 0.5 * DAY_S) % DAY_S - 0.5 * DAY_S
        assert np.abs(off_s).max() < SOLAR_S
        assert (np.diff(sky.t_s, axis=1) >= 0.0).all()  # the last is cut by the interval
        compared += sky.t_s.size
    assert compared > 200
    np.testing.assert_array_equal(windows.sky.t_s[:, 1], windows.highest_s)
    np.testing.assert_allclose(windows.sky.elevation_rad[:, 1], windows.highest_rad, atol=1e-9)


def test_where_the_target_is():
    start = iss_request(1.0, targets=PLACES[:1]).start
    ship = MovingGroundTarget(
        epoch=start, latitude_deg=10.0, longitude_deg=20.0, course_deg=90.0, speed_m_s=10.0
    )
    moon = BodyTarget(name="moon")
    targets = [OpportunityTarget(id=str(n), target=target) for n, target in enumerate((ship, moon))]
    windows = find_opportunities(iss_request(1.0, targets=(*PLACES, *targets))).windows
    for number, wanted in enumerate(PLACES):
        sky = windows.select(windows.target == number).sky
        np.testing.assert_allclose(
            off_deg(sky.latitude_rad, wanted.target.latitude_deg), 0, atol=1e-9
        )
        off = off_deg(sky.longitude_rad, wanted.target.longitude_deg)
        np.testing.assert_allclose(off, 0, atol=1e-9)
        np.testing.assert_allclose(sky.height_m, wanted.target.ground_height_m, atol=1e-6)
    sky = windows.select(windows.target == len(PLACES)).sky
    # Eastward on the equator's side of 10 deg north: 109.6 km a degree there.
    east_deg = sky.t_s * 10.0 / 109_640.0
    np.testing.assert_allclose(off_deg(sky.longitude_rad, 20.0), east_deg, rtol=2e-3)
    sky = windows.select(windows.target == len(PLACES) + 1).sky
    assert len(sky.t_s)
    assert np.isnan(sky.azimuth_rad).all()
    assert np.isnan(sky.solar_time_s).all()
