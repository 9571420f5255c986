"""Sun, Moon, planets and stars from a carrier against Skyfield on the DE421 we use ourselves.

Against DE440 and Hipparcos-2: published/test_sight_golden.py.
"""

from datetime import UTC, datetime
from pathlib import Path

import erfa
import numpy as np
import pytest
import skyfield_data
from skyfield.api import Loader, Star
from skyfield.vectorlib import VectorFunction

from planner.base.errors import OutsideCoverage
from planner.world.frames.solar_system import BODIES
from planner.world.frames.time_scales import Instants
from planner.world.orbits.ephemeris import OrbitStates
from planner.world.targets import BodyTarget, StarTarget

ARCSEC_RAD = np.pi / 180.0 / 3600.0
AU_M = 149597870700.0


def arcsec_apart(direction, expected):
    expected = np.asarray(expected) / np.linalg.norm(expected, axis=-1, keepdims=True)
    return np.linalg.norm(np.cross(direction, expected), axis=-1) / ARCSEC_RAD


class Carrier(VectorFunction):
    """A circular orbit as Skyfield wants it."""

    center = 399
    target = -1

    def __init__(self, epoch_tt_jd):
        self.epoch_tt_jd = epoch_tt_jd

    def states(self, t_s):
        rate = 2.0 * np.pi / 5560.0
        a, b = np.array([0.6, 0.8, 0.0]), np.array([-0.5, 0.375, 0.7806247497997998])
        cos, sin = np.cos(rate * t_s)[:, None], np.sin(rate * t_s)[:, None]
        return 6.79e6 * (cos * a + sin * b), 6.79e6 * rate * (cos * b - sin * a)

    def _at(self, t):
        t_s = (t.whole - self.epoch_tt_jd[0] + t.tt_fraction - self.epoch_tt_jd[1]) * 86400.0
        r_m, v_m_s = self.states(np.atleast_1d(t_s))
        return r_m.T / AU_M, v_m_s.T / AU_M * 86400.0, r_m.T / AU_M, None


@pytest.fixture(scope="module")
def sky():
    """Skyfield's time scale and ephemeris, our instants over an orbit, the same carrier in both."""
    load = Loader(str(Path(skyfield_data.__file__).parent / "data"))
    time_scale = load.timescale(builtin=True)
    instants = Instants(datetime(2015, 2, 27, 17, 36, 20, tzinfo=UTC), np.linspace(0, 5400, 28))
    day, fraction = instants.tt_jd()
    carrier = Carrier((day[0], fraction[0]))
    times = time_scale.tt_jd(day, fraction)
    ephemeris = load("de421.bsp")
    r_m, v_m_s = carrier.states(instants.t_s)
    return instants, OrbitStates(r_m, v_m_s), ephemeris, (ephemeris["earth"] + carrier).at(times)


@pytest.mark.parametrize("name", BODIES)
def test_bodies_match_skyfield_on_the_same_ephemeris(sky, name):
    instants, states, ephemeris, observer = sky
    kernel_name = (
        name if name in ("sun", "moon", "mercury", "venus", "mars") else f"{name} barycenter"
    )
    expected = observer.observe(ephemeris[kernel_name]).apparent()
    seen = BodyTarget(name=name).apparent(instants, states)
    # 1 mas: Skyfield leaves the Earth's deflection out for such a carrier (0.6 mas), and TT
    # stands for TDB with us (2 ms: the Moon moves 1 mas in that).
    assert np.max(arcsec_apart(seen.direction_eci, expected.xyz.au.T)) < 2e-3
    # 10 m: the Moon moves 2 m relative to the Earth in 2 ms, planets up to 60 m.
    np.testing.assert_allclose(seen.range_m, expected.distance().m, rtol=0, atol=80.0)


STARS = {
    # A real nearby star with everything, one 4 arcsec off the pole, one 1 deg off the Sun.
    "Barnard": {
        "ra_deg": 269.4520825,
        "dec_deg": 4.6933909,
        "pm_ra_cosdec_mas_yr": -798.71,
        "pm_dec_mas_yr": 10337.77,
        "parallax_mas": 545.4,
        "radial_velocity_km_s": -110.6,
    },
    "near the pole": {"ra_deg": 123.0, "dec_deg": 89.999, "pm_ra_cosdec_mas_yr": 40.0},
    "at the Sun": {"ra_deg": 340.0, "dec_deg": -9.0},
}


@pytest.mark.parametrize("name", STARS)
def test_stars_match_skyfield_and_sofa(sky, name):
    """SOFA carries the star to the day: Skyfield takes the motion seen for the motion made, which
    for Barnard's star is 0.06 arcsec in 15 years (its light time shortens by 4e-4).
    """
    instants, states, _, observer = sky
    fields = STARS[name]
    day, fraction = instants.tt_jd()
    ra, dec, pm_ra, pm_dec, _, radial = erfa.pmsafe(
        np.radians(fields["ra_deg"]),
        np.radians(fields["dec_deg"]),
        fields.get("pm_ra_cosdec_mas_yr", 0.0)
        * erfa.DMAS2R
        / np.cos(np.radians(fields["dec_deg"])),
        fields.get("pm_dec_mas_yr", 0.0) * erfa.DMAS2R,
        fields.get("parallax_mas", 0.1) / 1e3,  # motion needs some distance
        fields.get("radial_velocity_km_s", 0.0),
        2451545.0,
        0.0,
        day[0],
        fraction[0],
    )
    star = Star(
        ra_hours=np.degrees(ra) / 15.0,
        dec_degrees=np.degrees(dec),
        ra_mas_per_year=pm_ra * np.cos(dec) / erfa.DMAS2R,
        dec_mas_per_year=pm_dec / erfa.DMAS2R,
        parallax_mas=fields.get("parallax_mas", 0.0),
        radial_km_per_s=radial,
        epoch=day[0] + fraction[0],
    )
    seen = StarTarget(**fields).apparent(instants, states)
    visible = seen.clearance_rad > 0.0
    assert visible.any()
    # 1 mas: the Earth's deflection, 0.6 mas at most where visible, which Skyfield leaves out for
    # such a carrier, and the Roemer delay, which SOFA leaves out (500 s of 10 arcsec/yr: 0.2 mas).
    apart = arcsec_apart(seen.direction_eci, observer.observe(star).apparent().xyz.au.T)
    assert np.max(apart[visible]) < 1e-3
    assert np.all(np.isinf(seen.range_m))


def test_outside_the_ephemeris_is_refused(sky):
    _, states, _, _ = sky
    one = OrbitStates(states.r_sat_eci_m[:1], states.v_sat_eci_m_s[:1])
    with pytest.raises(OutsideCoverage, match="2053"):
        BodyTarget(name="sun").apparent(
            Instants(datetime(2054, 1, 1, tzinfo=UTC), np.zeros(1)), one
        )
