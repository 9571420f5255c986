"""Our frames agree with Skyfield's."""

from datetime import UTC, datetime

import numpy as np
import pytest
from skyfield.framelib import itrs
from skyfield.sgp4lib import TEME

from planner.world.frames.earth_orientation import c_itrf_from_eci, c_itrf_from_teme
from planner.world.frames.solar_system import r_moon_eci_m, r_sun_eci_m
from planner.world.frames.time_scales import Instants

MAS_RAD = np.pi / 648e6
EPOCHS = [
    datetime(1999, 12, 31, 23, 59, 50, tzinfo=UTC),
    datetime(2015, 2, 27, 17, 36, tzinfo=UTC),
    datetime(2016, 12, 31, 23, 59, 55, tzinfo=UTC),
    datetime(2022, 2, 8, 13, 17, tzinfo=UTC),
]


def times(skyfield, instants):
    """Skyfield's Time of each instant, and Skyfield's matrices first index last."""
    jd1, jd2 = instants.tt_jd()
    return skyfield[0].tt_jd(jd1, jd2)


@pytest.mark.parametrize("epoch_utc", EPOCHS)
def test_itrf_and_teme(skyfield, epoch_utc):
    instants = Instants(epoch_utc, np.linspace(0.0, 900.0, 7))
    itrf = c_itrf_from_eci(instants)
    teme = np.swapaxes(c_itrf_from_teme(instants), 1, 2) @ itrf
    for ours, frame in ((itrf, itrs), (teme, TEME)):
        theirs = np.moveaxis(frame.rotation_at(times(skyfield, instants)), -1, 0)
        # Skyfield interpolates UT1 linearly between days (0.05 ms) and leaves out dX, dY (0.3 mas)
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1.5 * MAS_RAD)


def test_sun_and_moon(skyfield):
    instants = Instants(EPOCHS[1], np.linspace(0.0, 86400.0, 5))
    at = times(skyfield, instants)
    kernel = skyfield[1]
    earth = kernel["earth"].at(at).position.m
    sun = (kernel["sun"].at(at).position.m - earth).T
    moon = (kernel["moon"].at(at).position.m - earth).T
    # TT for TDB, 2 ms: 60 m of the Sun's motion, 2 m of the Moon's
    np.testing.assert_allclose(r_sun_eci_m(instants), sun, rtol=0, atol=60.0)
    np.testing.assert_allclose(r_moon_eci_m(instants), moon, rtol=0, atol=2.0)
