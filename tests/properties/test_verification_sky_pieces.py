"""The judge's derivations for the sky keep to closed forms, and to what the planner aims at."""

from datetime import UTC, datetime

import erfa
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from planner.verification import sky
from planner.verification.earth import earth_orientation
from planner.verification.earth_fixed import earth_fixed_sight
from planner.verification.light import bend_by_sun
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets import BodyTarget, GroundTarget, StarTarget

ARCSEC_RAD = np.pi / 648000.0
AU_M = 149597870700.0
WGS84_M = np.array([6378137.0, 6378137.0, 6356752.314245179])
directions = st.tuples(st.floats(0, 2 * np.pi), st.floats(-np.pi / 2, np.pi / 2)).map(
    lambda angles: erfa.s2c(*angles)
)
moments = st.datetimes(datetime(1973, 1, 3), datetime(2050, 1, 1)).map(  # noqa: DTZ001 (UTC below)
    lambda moment: moment.replace(microsecond=0, tzinfo=UTC)
)


def circle(t_s, over, beside, height_m):
    """A circular orbit that begins over `over`."""
    ahead = np.cross(over, beside)
    ahead /= np.linalg.norm(ahead)
    radius_m = 6378e3 + height_m
    rate_s = np.sqrt(3.986e14 / radius_m**3)
    cos, sin = np.cos(rate_s * t_s)[:, None], np.sin(rate_s * t_s)[:, None]
    return OrbitStates(
        radius_m * (cos * over + sin * ahead), radius_m * rate_s * (cos * ahead - sin * over)
    )


@given(source=directions, sun=directions, distance_au=st.floats(0.9, 1.1))
# So near the Sun's centre that the square of the way off it underflows.
@example(
    source=erfa.s2c(3.0510460534636357, -3.8e-213),
    sun=erfa.s2c(3.0510460534636357, 0.0),
    distance_au=1.1,
)
def test_a_star_is_bent_as_erfa_bends_it(source, sun, distance_au):
    expected = erfa.ld(1.0, source, source, -sun, distance_au, 6e-6)
    bent = bend_by_sun(source[None], np.array([np.inf]), (-sun * distance_au * AU_M)[None])[0]
    # the Schwarzschild radii differ by 1e-5 of 1.75 arcsec; ERFA's result isn't normalised
    expected /= np.linalg.norm(expected)
    np.testing.assert_allclose(bent, expected, rtol=0, atol=1e-10)


def test_a_star_at_the_pole_moves_too():
    target = StarTarget(ra_deg=0.0, dec_deg=90.0, pm_ra_cosdec_mas_yr=1000.0)
    at_s = np.array([10.0 * 365.25 * 86400.0])
    seen = sky.towards_star(target, at_s, np.zeros((1, 3)))[0]
    # the tangent of the way gone is the motion's: cubic in 10 arcsec
    expected = [0.0, np.sin(10.0 * erfa.DAS2R), np.cos(10.0 * erfa.DAS2R)]
    np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-13)


@given(years=st.floats(-100.0, 53.0))
def test_tdb_is_erfas(years):
    tt = np.array([years * 365.25 * 86400.0])
    expected_s = erfa.dtdb(2451545.0, tt / 86400.0, 0.0, 0.0, 0.0, 0.0)
    assert sky.tdb_s(tt)[0] - tt[0] == pytest.approx(expected_s[0], abs=6e-5)  # the terms left out


@given(sat=directions, height_m=st.floats(350e3, 36e6), look=directions, raised_m=st.floats(0, 3e5))
def test_clearance_tells_whether_the_line_meets_the_raised_ellipsoid(sat, height_m, look, raised_m):
    r_sat_m = (6378137.0 + height_m) * sat
    semi_axes_m = WGS84_M + raised_m
    clearance = sky.limb_clearance_rad(look[None], r_sat_m[None], raised_m)[0]
    line, start = look / semi_axes_m, r_sat_m / semi_axes_m
    discriminant = (line @ start) ** 2 - (line @ line) * (start @ start - 1.0)
    assume(abs(clearance) > 1e-9)
    assert (discriminant > 0.0 and line @ start < 0.0) == (clearance < 0.0)
    # turning down by the clearance leads onto a tangent: there the discriminant vanishes
    aside = look - (look @ sat) * sat
    assume(np.linalg.norm(aside) > 1e-3)
    aside /= np.linalg.norm(aside)
    limb_rad = np.arctan2(look @ aside, -(look @ sat)) - clearance
    tangent = (np.sin(limb_rad) * aside - np.cos(limb_rad) * sat) / semi_axes_m
    scale = (tangent @ tangent) * (start @ start)
    touching = (tangent @ start) ** 2 - (tangent @ tangent) * (start @ start - 1.0)
    assert touching / scale == pytest.approx(0.0, abs=1e-12)


def test_a_carrier_below_the_grazing_altitude_sees_nothing():
    clearance = sky.limb_clearance_rad(
        np.array([[1.0, 0.0, 0.0]]), np.array([[6.6e6, 0.0, 0.0]]), 3e5
    )
    assert clearance[0] <= 0.0


@given(sat=directions, beside=directions, passing_m=st.floats(-20e3, 180e3))
def test_the_lowest_point_is_the_lowest_of_the_line(sat, beside, passing_m):
    r_sat_m = 6.79e6 * sat
    aside = np.cross(sat, beside)
    assume(np.linalg.norm(aside) > 1e-3)
    sine = (6.371e6 + passing_m) / 6.79e6
    look = sine * aside / np.linalg.norm(aside) - np.sqrt(1.0 - sine**2) * sat
    height_m, way_m, up = sky.lowest_point(look[None], r_sat_m[None])
    along_m = way_m[0] + np.linspace(-100e3, 100e3, 2001)
    heights_m = erfa.gc2gd(1, r_sat_m + along_m[:, None] * look)[2]
    assert height_m[0] == pytest.approx(heights_m.min(), abs=1.0)  # as promised
    assert abs(up[0] @ look) < 1e-3


names = st.sampled_from(["star", *sky.NUMBERS])


def star_at(direction, **more):
    ra_rad, dec_rad = erfa.c2s(direction)
    ra_deg, dec_deg = np.rad2deg(ra_rad) % 360.0, float(np.rad2deg(dec_rad))
    return StarTarget(ra_deg=ra_deg, dec_deg=dec_deg, **more)


def sights(target, instants, states, judge=sky.sky_sight):
    """As planned, as judged, and how far apart where the target is seen."""
    planned, judged = target.apparent(instants, states), judge(target, instants, states)
    apart_rad = np.linalg.norm(planned.direction_eci - judged.apparent_eci, axis=1)
    return planned, judged, np.where(planned.clearance_rad > 0.0, apart_rad, 0.0)


@settings(deadline=None, max_examples=100)
@given(
    name=names,
    moment=moments,
    over=directions,
    beside=directions,
    star=directions,
    height_m=st.floats(300e3, 2e6),
)
def test_the_planner_aims_where_the_judge_looks(name, moment, over, beside, star, height_m):
    assume(np.linalg.norm(np.cross(over, beside)) > 1e-2)
    t_s = np.linspace(0.0, 6000.0, 61)
    instants, states = Instants(moment, t_s), circle(t_s, over, beside, height_m)
    if name == "star":
        motion = {"pm_ra_cosdec_mas_yr": 1200.0, "pm_dec_mas_yr": -700.0}
        target = star_at(star, parallax_mas=300.0, **motion)
    else:
        target = BodyTarget(name=name)
    planned, judged, apart_rad = sights(target, instants, states)
    # TT for TDB moves the Moon by 1 mas; the Earth bends light by 0.6 mas, Jupiter by 1 mas
    # six arcminutes off and by 17 mas at its limb
    assert apart_rad.max() < 0.02 * ARCSEC_RAD
    np.testing.assert_allclose(judged.clearance_rad, planned.clearance_rad, rtol=0, atol=1e-7)
    np.testing.assert_allclose(judged.range_m, planned.range_m, rtol=0, atol=100.0)  # 2 ms


@settings(deadline=None, max_examples=60)
@given(moment=moments, over=directions, beside=directions, above_rad=st.floats(-0.03, 0.05))
def test_through_the_limb_the_two_models_differ_by_less_than_the_verdict_allows(
    moment, over, beside, above_rad
):
    assume(np.linalg.norm(np.cross(over, beside)) > 1e-2)
    t_s = np.linspace(0.0, 60.0, 121)
    instants, states = Instants(moment, t_s), circle(t_s, over, beside, 415e3)
    ahead = states.v_sat_eci_m_s[0] / np.linalg.norm(states.v_sat_eci_m_s[0])
    nadir_rad = np.arcsin(6371.0 / 6793.0) + above_rad
    towards = np.sin(nadir_rad) * ahead - np.cos(nadir_rad) * over
    target = star_at(towards, grazing_altitude_km=2.0, refraction="standard")
    planned, judged, apart_rad = sights(target, instants, states)
    seen = planned.clearance_rad > 0.0
    allowed = 0.01 * ARCSEC_RAD + sky.LIMB_MODEL_SHARE * judged.bending_rad
    assert np.all(apart_rad[seen] < allowed[seen])
    assert np.all(np.abs(planned.clearance_rad - judged.clearance_rad)[seen] < allowed[seen])


@settings(deadline=None, max_examples=40)
@given(
    moment=moments,
    over=directions,
    beside=directions,
    aside_rad=st.floats(-0.2, 0.2),
    target_height_m=st.floats(-400.0, 5000.0),
)
def test_through_the_air_above_a_ground_target_the_two_models_agree(
    moment, over, beside, aside_rad, target_height_m
):
    assume(np.linalg.norm(np.cross(over, beside)) > 1e-2)
    t_s = np.arange(0.0, 300.0, 0.5)
    instants, states = Instants(moment, t_s), circle(t_s, over, beside, 415e3)
    halfway = earth_orientation(moment, t_s).itrf_from_eci(states.r_sat_eci_m)[300]
    longitude_rad, latitude_rad = erfa.c2s(halfway)
    target = GroundTarget(
        latitude_deg=float(np.clip(np.rad2deg(latitude_rad + aside_rad), -90.0, 90.0)),
        longitude_deg=float(np.rad2deg(longitude_rad)),
        height_m=target_height_m,
        min_elevation_deg=5.0,
        refraction="standard",
    )
    _, _, apart_rad = sights(target, instants, states, earth_fixed_sight)
    # 48 nodes against 96 across the layers' kinks: 3e-4 of 34 arcsec at 5 deg elevation
    assert apart_rad.max() < 0.012 * ARCSEC_RAD
