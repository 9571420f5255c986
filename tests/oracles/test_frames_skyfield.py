"""Frames are Skyfield's, and the ephemeris and catalogue that are read the published ones."""

import hashlib
import re
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from jplephem.spk import SPK
from skyfield.framelib import itrs
from skyfield.sgp4lib import TEME

from planner.verification import sky as stars
from planner.world.frames.earth_orientation import c_itrf_from_eci, c_itrf_from_teme
from planner.world.frames.hipparcos import hipparcos_star
from planner.world.frames.solar_system import r_moon_eci_m, r_sun_eci_m
from planner.world.frames.time_scales import Instants
from planner.world.targets.star_names import star_names

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


PLANNER = Path(__file__).parents[2] / "planner"
SUMS = re.findall(
    r"\| `(\S+)` \| `(\w{64})` \|",
    (PLANNER / "world/frames/data/README.md").read_text(encoding="utf-8"),
)


def test_every_file_has_its_sum():
    folders = (PLANNER / "world/frames/data", PLANNER / "verification/data")
    there = {path for folder in folders for path in folder.iterdir() if path.suffix != ".md"}
    assert {PLANNER / name for name, _ in SUMS} == there


@pytest.mark.parametrize(("name", "sha256"), SUMS)
def test_the_file_is_the_one_that_was_made(name, sha256):
    assert hashlib.sha256((PLANNER / name).read_bytes()).hexdigest() == sha256


@pytest.mark.parametrize("of", ["world/frames", "verification"])
def test_its_records_are_jpls(of):
    """Bit for bit, by the whole DE421 of skyfield-data."""
    ours = SPK.open(str(PLANNER / of / "data/de421.bsp"))
    jpls = SPK.open(str(files("skyfield_data") / "data" / "de421.bsp"))
    for segment in ours.segments:
        first_jd, step_days, coefficients = segment.load_array()
        whole_first_jd, whole_step_days, whole = jpls[segment.center, segment.target].load_array()
        skipped = int((first_jd - whole_first_jd) / whole_step_days)
        assert (step_days, first_jd) == (whole_step_days, whole_first_jd + skipped * step_days)
        count = coefficients.shape[1]
        assert np.array_equal(coefficients, whole[:, skipped : skipped + count])
        assert segment.start_jd == pytest.approx(2441683.5, abs=1e-9)  # 1973-01-01
        assert segment.end_jd == pytest.approx(2471184.5, abs=1e-9)  # 2053-10-09


def test_planner_and_judge_know_the_same_stars():
    """Each by its own file and reader, named stars and the catalogue's ends and gaps."""
    numbers = {1, 120_404, *(number for _, number in star_names()), *range(500, 120_000, 2000)}
    for number in numbers:
        star = hipparcos_star(number)
        if star is None:
            with pytest.raises(KeyError):
                stars._hipparcos(number)
            continue
        jyear, ra_rad, dec_rad, *rest = stars._hipparcos(number)
        assert (jyear, *rest) == (
            star.epoch_jyear, star.parallax_mas, star.pm_ra_cosdec_mas_yr, star.pm_dec_mas_yr
        )  # fmt: skip
        assert np.degrees([ra_rad, dec_rad]).tolist() == [star.ra_deg, star.dec_deg]


def test_a_star_is_where_the_catalogue_says():
    """Barnard's star, HIP 87937, as van Leeuwen's catalogue prints it (CDS I/311)."""
    star = hipparcos_star(87937)
    assert np.radians([star.ra_deg, star.dec_deg]) == pytest.approx(
        [4.7028598776, 0.0814769927], abs=1e-15
    )
    assert star.parallax_mas == 548.31
    assert (star.pm_ra_cosdec_mas_yr, star.pm_dec_mas_yr) == (-798.58, 10328.12)
