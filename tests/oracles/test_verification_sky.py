"""The judge passes exact tables on stars and bodies, and finds what is left out of others.

The tables are made with ERFA's astrometry and, for bodies, jplephem's reading of DE421.
"""

import dataclasses
from datetime import UTC, datetime, timedelta
from importlib.resources import files

import erfa
import numpy as np
import pytest
from jplephem.spk import SPK
from judged_tables import (
    ARCSEC_RAD,
    EPOCH_UTC,
    SPEED_OF_LIGHT_M_S,
    OrbitFacing,
    changed,
    erfa_times,
    only,
    scenario_of,
    table_along,
)

from planner.base.errors import OutsideCoverage
from planner.verification import verify
from planner.verification.sky import EARTH, MOON, r_body_bary_m, v_earth_bary_m_s
from planner.world.frames.time_scales import Instants
from planner.world.targets import BodyTarget, SkyTarget, StarTarget

AU_M = 149597870700.0
KERNEL = SPK.open(str(files("skyfield_data") / "data" / "de421.bsp"))
CHAINS = {
    "earth": ((0, 3), (3, 399)),
    "sun": ((0, 10),),
    "moon": ((0, 3), (3, 301)),
    "mercury": ((0, 1), (1, 199)),
    "venus": ((0, 2), (2, 299)),
    "mars": ((0, 4), (4, 499)),
    "jupiter": ((0, 5),),
    "saturn": ((0, 6),),
    "uranus": ((0, 7),),
    "neptune": ((0, 8),),
}
# TT stands for TDB here, 1.6 ms that day: 1 mas of the Moon.  Earth by epv00: 5 km.
ORACLE_RAD = 0.002 * ARCSEC_RAD

# Proxima Centauri, Gaia DR3 moved to J2000: the nearest star, with 3.9 arcsec a year
PROXIMA = StarTarget(
    ra_deg=217.42894,
    dec_deg=-62.67949,
    pm_ra_cosdec_mas_yr=-3781.741,
    pm_dec_mas_yr=769.465,
    parallax_mas=768.0665,
    radial_velocity_km_s=-22.2,
)


def star_eci(orbit, star, t_s, *, aberration=1.0, parallax=1.0, motion=1.0):
    """ERFA's quick astrometry for an observer in orbit, each part times a factor."""
    states = orbit.states(Instants(EPOCH_UTC, t_s))
    tt, _, _ = erfa_times(t_s)
    heliocentric, barycentric = erfa.epv00(*tt)
    pv = np.zeros(len(t_s), erfa.dt_pv)
    pv["p"], pv["v"] = states.r_sat_eci_m, states.v_sat_eci_m_s
    astrom = erfa.apcs(*tt, pv, barycentric, heliocentric["p"])
    if aberration != 1.0:
        astrom["v"] *= aberration
        astrom["bm1"] = np.sqrt(1.0 - np.sum(astrom["v"] ** 2, axis=-1))
    dec_rad = np.deg2rad(star.dec_deg)
    return erfa.s2c(
        *erfa.atciq(
            np.deg2rad(star.ra_deg),
            dec_rad,
            motion * star.pm_ra_cosdec_mas_yr * erfa.DMAS2R / np.cos(dec_rad),
            motion * star.pm_dec_mas_yr * erfa.DMAS2R,
            parallax * star.parallax_mas / 1e3,
            motion * star.radial_velocity_km_s,
            astrom,
        )
    )


def r_bary_m(name, jd, fraction):
    return 1e3 * sum(KERNEL[pair].compute(jd, fraction) for pair in CHAINS[name]).T


def body_eci(orbit, name, t_s, *, light_time=1.0, aberration=1.0, carrier=1.0):
    """Where jplephem puts it, bent and aberrated by ERFA, each part times a factor."""
    states = orbit.states(Instants(EPOCH_UTC, t_s))
    (jd, fraction), _, _ = erfa_times(t_s)
    observer_m = r_bary_m("earth", jd, fraction) + carrier * states.r_sat_eci_m
    light_s = np.zeros(len(t_s))
    for _ in range(4):
        seen_m = r_bary_m(name, jd, fraction - light_time * light_s / 86400.0) - observer_m
        light_s = np.linalg.norm(seen_m, axis=1) / SPEED_OF_LIGHT_M_S
    towards = seen_m / np.linalg.norm(seen_m, axis=1, keepdims=True)
    from_sun_m = observer_m - r_bary_m("sun", jd, fraction)
    from_sun_au = np.linalg.norm(from_sun_m, axis=1) / AU_M
    if name != "sun":
        behind = seen_m + from_sun_m
        behind /= np.linalg.norm(behind, axis=1, keepdims=True)
        outward = from_sun_m / from_sun_au[:, None] / AU_M
        towards = erfa.ld(1.0, towards, behind, outward, from_sun_au, 6e-6)
    _, barycentric = erfa.epv00(jd, fraction)
    v_m_s = barycentric["v"] * AU_M / 86400.0 + states.v_sat_eci_m_s
    beta = aberration * v_m_s / SPEED_OF_LIGHT_M_S
    return erfa.ab(towards, beta, from_sun_au, np.sqrt(1.0 - np.sum(beta**2, axis=1)))


def facing(name, from_nadir_deg=82.0):
    (jd, fraction), _, _ = erfa_times(np.array([85.0]))
    towards = r_bary_m(name, jd, fraction)[0] - r_bary_m("earth", jd, fraction)[0]
    return OrbitFacing(towards_eci=tuple(towards), from_nadir_deg=from_nadir_deg)


def facing_proxima(from_nadir_deg=82.0):
    towards = erfa.s2c(np.deg2rad(PROXIMA.ra_deg), np.deg2rad(PROXIMA.dec_deg))
    return OrbitFacing(towards_eci=tuple(towards), from_nadir_deg=from_nadir_deg)


@pytest.fixture(scope="module")
def starry():
    return scenario_of(orbit=facing_proxima(), target=PROXIMA)


def test_a_star_followed_with_erfa_passes(starry):
    report = verify(table_along(starry, lambda t_s: star_eci(starry.orbit, PROXIMA, t_s)), starry)
    assert report.passed, report.findings
    assert report.taken_as_given == ("orbit",)
    session = report.sessions[0]
    assert session.max_rad < ORACLE_RAD
    assert session.limb_clearance_min_rad is not None
    assert session.range_min_m is None
    assert session.refraction_max_rad == 0.0
    # nearest to the limb first: the carrier turns the star up by 0.0647 deg/s, 25 s before 82 deg;
    # the ellipsoid's limb, 80 km up, stands 69.3 (pole) to 72.2 deg (equator) from nadir
    clearance_deg = np.rad2deg(session.limb_clearance_min_rad)
    assert 82.0 - 25 * 0.0647 - 72.2 < clearance_deg < 82.0 - 25 * 0.0647 - 69.3
    assert session.limb_clearance_min_at_utc == EPOCH_UTC + timedelta(seconds=60)


def test_a_star_given_at_another_epoch_is_the_same_star(starry):
    """Proxima moves 3.9 arcsec a year; ERFA takes it to the epoch of Hipparcos, J1991.25."""
    ra_rad, dec_rad, pm_ra, pm_dec, parallax_arcsec, radial_velocity_km_s = erfa.pmsafe(
        np.deg2rad(PROXIMA.ra_deg),
        np.deg2rad(PROXIMA.dec_deg),
        PROXIMA.pm_ra_cosdec_mas_yr * erfa.DMAS2R / np.cos(np.deg2rad(PROXIMA.dec_deg)),
        PROXIMA.pm_dec_mas_yr * erfa.DMAS2R,
        PROXIMA.parallax_mas / 1e3,
        PROXIMA.radial_velocity_km_s,
        *(2451545.0, 0.0),
        *(2451545.0, -8.75 * 365.25),
    )
    earlier = StarTarget(
        epoch_jyear=1991.25,
        ra_deg=float(np.rad2deg(ra_rad)),
        dec_deg=float(np.rad2deg(dec_rad)),
        pm_ra_cosdec_mas_yr=float(pm_ra * np.cos(dec_rad) / erfa.DMAS2R),
        pm_dec_mas_yr=float(pm_dec / erfa.DMAS2R),
        parallax_mas=float(1e3 * parallax_arcsec),
        radial_velocity_km_s=float(radial_velocity_km_s),
    )
    table = table_along(starry, lambda t_s: star_eci(starry.orbit, PROXIMA, t_s))
    report = verify(table, scenario_of(orbit=starry.orbit, target=earlier))
    assert report.sessions[0].max_rad < ORACLE_RAD


def test_hipparcos_knows_the_star_that_gaia_saw(starry):
    """Proxima moves 3,859 mas a year; over 24 years the two motions part by 0.17 arcsec."""
    table = table_along(starry, lambda t_s: star_eci(starry.orbit, PROXIMA, t_s))
    report = verify(table, scenario_of(orbit=starry.orbit, target=StarTarget(hip=70890)))
    assert report.sessions[0].max_rad < 0.2 * ARCSEC_RAD


@pytest.mark.parametrize("name", [name for name in CHAINS if name != "earth"])
def test_a_body_followed_with_jplephem_passes(name):
    orbit = facing(name)
    scenario = scenario_of(orbit=orbit, target=BodyTarget(name=name))
    report = verify(table_along(scenario, lambda t_s: body_eci(orbit, name, t_s)), scenario)
    assert report.passed, report.findings
    assert report.sessions[0].max_rad < ORACLE_RAD
    (jd, fraction), _, _ = erfa_times(np.array([100.0]))
    near_m = np.linalg.norm(r_bary_m(name, jd, fraction) - r_bary_m("earth", jd, fraction))
    # the carrier, 6,786 km from the centre, and the body's way while its light travels
    way_m = 6.8e6 + near_m * 1.6e-4
    assert report.sessions[0].range_min_m == pytest.approx(near_m, abs=way_m)


@pytest.mark.parametrize(
    ("left_out", "arcsec"),
    [
        # Proxima's parallax times what the Earth's place that day leaves of it
        ({"parallax": 0.0}, pytest.approx(0.72, abs=0.06)),
        # 15.16 years of 3.859 arcsec
        ({"motion": 0.0}, pytest.approx(58.5, abs=0.1)),
        # the Earth's 30 km/s, at the angle the star makes with it, and the carrier's 7.7
        ({"aberration": 0.0}, pytest.approx(20.0, abs=6.0)),
        ({"aberration": -1.0}, pytest.approx(40.0, abs=12.0)),
    ],
)
def test_what_is_left_out_of_a_stars_direction_is_found(starry, left_out, arcsec):
    table = table_along(starry, lambda t_s: star_eci(starry.orbit, PROXIMA, t_s, **left_out))
    report = verify(table, starry)
    assert "off the target" in only(report, "pointing").detail
    assert report.sessions[0].max_rad / ARCSEC_RAD == arcsec


@pytest.mark.parametrize(
    ("left_out", "moving"), [({"light_time": 0.0}, "moon"), ({"aberration": 0.0}, "carrier")]
)
def test_what_is_left_out_of_the_moons_direction_is_found(left_out, moving):
    orbit = facing("moon")
    scenario = scenario_of(orbit=orbit, target=BodyTarget(name="Moon"))
    table = table_along(scenario, lambda t_s: body_eci(orbit, "moon", t_s, **left_out))
    report = verify(table, scenario)
    only(report, "pointing")
    # to first order v/c of whatever moves, across the line of sight
    t_s = np.arange(60.0, 100.5)
    (jd, fraction), _, _ = erfa_times(t_s)
    hour = 1.0 / 24.0
    v_m_s = {
        name: (r_bary_m(name, jd, fraction + hour) - r_bary_m(name, jd, fraction - hour)) / 7200.0
        for name in ("moon", "earth")
    }
    states = orbit.states(Instants(EPOCH_UTC, t_s))
    v_m_s["carrier"] = v_m_s["earth"] + states.v_sat_eci_m_s
    los = body_eci(orbit, "moon", t_s)
    expected_rad = np.linalg.norm(np.cross(los, v_m_s[moving]), axis=1).max() / SPEED_OF_LIGHT_M_S
    assert expected_rad > 5.0 * ARCSEC_RAD
    # the second order is 1e-4 of it
    assert report.sessions[0].max_rad == pytest.approx(expected_rad, rel=1e-3)


def test_a_moon_seen_from_the_geocentre_is_found():
    orbit = facing("moon")
    scenario = scenario_of(orbit=orbit, target=BodyTarget(name="Moon"))
    report = verify(
        table_along(scenario, lambda t_s: body_eci(orbit, "moon", t_s, carrier=0.0)), scenario
    )
    only(report, "pointing")
    # 6,786 km across at 360,000 to 405,000 km, near 90 deg from nadir
    assert np.rad2deg(report.sessions[0].max_rad) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(("off_arcsec", "passes"), [(0.09, True), (0.11, False)])
def test_a_tenth_of_an_arcsecond_off_a_star_is_the_limit(starry, off_arcsec, passes):
    table = table_along(starry, lambda t_s: star_eci(starry.orbit, PROXIMA, t_s))
    report = verify(changed(table, 1, 401, angle_rad=off_arcsec * ARCSEC_RAD), starry)
    assert report.passed is passes
    if not passes:
        assert only(report, "pointing").t_s == pytest.approx(401 / 5.0)


def test_another_star_is_found(starry):
    table = table_along(starry, lambda t_s: star_eci(starry.orbit, PROXIMA, t_s))
    off = dataclasses.replace(PROXIMA, dec_deg=PROXIMA.dec_deg + 0.2 / 3600.0)
    report = verify(table, scenario_of(orbit=starry.orbit, target=off))
    only(report, "pointing")
    assert report.sessions[0].max_rad == pytest.approx(0.2 * ARCSEC_RAD, abs=ORACLE_RAD)


def test_a_star_behind_the_earth_is_found():
    orbit = facing_proxima(from_nadir_deg=60.0)
    scenario = scenario_of(orbit=orbit, target=PROXIMA)
    report = verify(table_along(scenario, lambda t_s: star_eci(orbit, PROXIMA, t_s)), scenario)
    finding = only(report, "occlusion")
    assert "below the Earth's limb" in finding.detail
    assert finding.t_s == pytest.approx(60.0)
    assert report.sessions[0].max_rad < ORACLE_RAD


@pytest.mark.parametrize(("grazing_altitude_km", "passes"), [(0.0, True), (300.0, False)])
def test_the_grazing_altitude_is_kept(grazing_altitude_km, passes):
    # limbs 70 deg and, 300 km up, 80 deg from nadir; the star climbs from 74 to 77
    orbit = facing_proxima(from_nadir_deg=76.0)
    target = dataclasses.replace(PROXIMA, grazing_altitude_km=grazing_altitude_km)
    scenario = scenario_of(orbit=orbit, target=target)
    table = table_along(scenario, lambda t_s: star_eci(orbit, PROXIMA, t_s))
    assert verify(table, scenario).passed is passes


def test_refraction_asked_for_but_left_out_is_found():
    # some 10 to 60 km above the ground at its lowest: hundreds of arcsec down to one
    orbit = facing_proxima(from_nadir_deg=71.8)
    target = dataclasses.replace(PROXIMA, refraction="standard", grazing_altitude_km=2.0)
    table = table_along(scenario_of(orbit=orbit), lambda t_s: star_eci(orbit, PROXIMA, t_s))
    report = verify(table, scenario_of(orbit=orbit, target=target))
    only(report, "pointing")
    session = report.sessions[0]
    assert session.max_rad == pytest.approx(session.refraction_max_rad, rel=0.01)
    assert session.refraction_max_rad > 100.0 * ARCSEC_RAD


@dataclasses.dataclass(frozen=True)
class FixedDirection(SkyTarget):
    """A further sky mode, unknown to the judge: Proxima as it stood that day."""

    towards: tuple[float, float, float]
    grazing_altitude_km: float = 80.0
    refraction: str = "none"

    def seen_from(self, instants, r_observer_bary_m):
        return np.tile(self.towards, (len(instants.t_s), 1)), np.full(len(instants.t_s), np.inf)


def test_a_new_sky_mode_needs_no_change_of_the_judge():
    still = StarTarget(
        ra_deg=PROXIMA.ra_deg,
        dec_deg=PROXIMA.dec_deg,
        pm_ra_cosdec_mas_yr=0.0,
        pm_dec_mas_yr=0.0,
        parallax_mas=0.0,
    )
    towards = erfa.s2c(np.deg2rad(still.ra_deg), np.deg2rad(still.dec_deg))
    orbit = facing_proxima()
    scenario = scenario_of(orbit=orbit, target=FixedDirection(towards=tuple(towards)))
    report = verify(table_along(scenario, lambda t_s: star_eci(orbit, still, t_s)), scenario)
    assert report.passed, report.findings
    assert report.taken_as_given == ("orbit", "target")


def test_the_orbit_is_prepared_once_for_all_sessions():
    asked = []

    class Watched(OrbitFacing):
        def ephemeris(self, start_utc, stop_utc):
            asked.append((start_utc, stop_utc))
            return self

    orbit = Watched(towards_eci=facing_proxima().towards_eci)
    scenario = scenario_of(orbit=orbit, target=PROXIMA)
    table = table_along(scenario, lambda t_s: star_eci(orbit, PROXIMA, t_s))
    (session,) = scenario.sessions
    halves = tuple(
        dataclasses.replace(
            session,
            start=EPOCH_UTC + timedelta(seconds=start_s),
            stop=EPOCH_UTC + timedelta(seconds=stop_s),
        )
        for start_s, stop_s in ((60.0, 75.0), (80.0, 100.0))
    )
    report = verify(table, dataclasses.replace(scenario, sessions=halves))
    assert report.passed
    assert len(report.sessions) == 2
    assert asked == [(EPOCH_UTC + timedelta(seconds=60), EPOCH_UTC + timedelta(seconds=100))]


@pytest.mark.parametrize("year", [1973, 1990, 2015, 2053])
def test_de421_is_read_as_jplephem_reads_it(year):
    at_s = (datetime(year, 6, 1, tzinfo=UTC) - datetime(2000, 1, 1, 12, tzinfo=UTC)).total_seconds()
    # across several of the file's records, 4 to 64 days long
    at_s = at_s + np.linspace(0.0, 40 * 86400.0, 200)
    for name, chain in CHAINS.items():
        read_m = r_body_bary_m(chain[-1][1], at_s)
        # 3e9 s in doubles are good to 5e-7 s: 2 cm of Mercury's 50 km/s
        expected_m = r_bary_m(name, 2451545.0, at_s / 86400.0)
        np.testing.assert_allclose(read_m, expected_m, rtol=0, atol=0.03)


def test_the_earths_velocity_is_de421s():
    at_s = 4.78e8 + np.linspace(0.0, 20 * 86400.0, 500)
    expected_m_s = (
        sum(
            KERNEL[pair].compute_and_differentiate(2451545.0, at_s / 86400.0)[1]
            for pair in CHAINS["earth"]
        ).T
        / 86.4
    )
    # Bretagnon and Francou's theory against JPL's, as ERFA's epv00 says: 5 mm/s at most
    np.testing.assert_allclose(v_earth_bary_m_s(at_s), expected_m_s, rtol=0, atol=0.005)


def test_past_the_ephemeris_nothing_is_judged():
    with pytest.raises(OutsideCoverage, match="2053"):
        r_body_bary_m(MOON, np.array([1.75e9]))
    with pytest.raises(OutsideCoverage, match="1973"):
        r_body_bary_m(EARTH, np.array([-8.6e8]))
