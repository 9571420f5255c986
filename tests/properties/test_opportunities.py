"""Invariants of windows whatever the request."""

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from planner_values import plan_of
from plausible_requests import plausible_request

from planner.base import effort
from planner.base.errors import SearchEnded
from planner.base.interpolation import UniformTable
from planner.motion.pointing.reach import off_masks, reach_of
from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
    find_opportunities,
    opportunities_however_many,
)
from planner.planning.opportunities.carrier import carrier_over
from planner.planning.opportunities.looks import in_platform
from planner.planning.opportunities.platforms.registry import lookout_of
from planner.planning.opportunities.sights import sights_of
from planner.planning.sessions.platforms.two_axis.mover import TwoAxisMover
from planner.verification.earth_fixed import earth_fixed_sight
from planner.verification.field_masks import Region
from planner.world.attitude.inertial import InertialAttitude
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import itrf_from_geodetic, up_itrf
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import OrbitStates, StateVectorOrbit, TleOrbit
from planner.world.platforms import PLATFORMS, FieldMask
from planner.world.targets import BodyTarget, GroundTarget, MovingGroundTarget, StarTarget

HRC = PLATFORMS["iss-hrc"]
START = datetime(2016, 12, 31, 18, 0, tzinfo=UTC)  # six hours before a leap second
ISS = TleOrbit(
    line1="1 25544U 98067A   17001.10660880  .00001073  00000-0  23630-4 0  9997",
    line2="2 25544  51.6423 151.2131 0007045  39.8224 315.5565 15.53964187 35761",
)


def request(targets, days=1.0, **fields):
    return OpportunityRequest(
        **{
            "orbit": ISS,
            "platform": HRC,
            "start": START,
            "stop": START + timedelta(days=days),
            "targets": targets,
            **fields,
        }
    )


def ground(number, latitude_deg, longitude_deg, **fields):
    return OpportunityTarget(
        id=str(number),
        target=GroundTarget(latitude_deg=latitude_deg, longitude_deg=longitude_deg, **fields),
    )


def test_order_and_number_of_targets_change_nothing():
    one = tuple(ground(n, -50.0 + 10.0 * n, 36.0 * n) for n in range(10))
    asked = OpportunityConditions(min_elevation_deg=15.0, sun_elevation_min_deg=0.0)
    forward = find_opportunities(request(one, conditions=asked)).windows
    backward = find_opportunities(request(one[::-1], conditions=asked)).windows
    order = np.lexsort((backward.rise_s, 9 - backward.target))
    np.testing.assert_array_equal(forward.rise_s, backward.rise_s[order])
    np.testing.assert_array_equal(forward.set_s, backward.set_s[order])
    np.testing.assert_array_equal(forward.closest.angle_rad, backward.closest.angle_rad[order])


def test_day_and_night_make_the_whole():
    """Sunlight splits each pass: the parts above and below the limit are all of it."""
    targets = tuple(ground(n, 60.0 - 12.0 * n, 36.0 * n) for n in range(10))

    def total_s(**limits):
        windows = find_opportunities(
            request(targets, conditions=OpportunityConditions(min_elevation_deg=5.0, **limits))
        ).windows
        return np.sum(windows.set_s - windows.rise_s)

    day_s = total_s(sun_elevation_min_deg=-6.0)
    night_s = total_s(sun_elevation_max_deg=-6.0)
    assert day_s > 0.0
    assert night_s > 0.0
    # a microsecond per edge
    assert day_s + night_s == pytest.approx(total_s(), abs=1e-3)


def test_windows_are_cut_by_the_interval():
    """A window under way at the start or stop is kept, and says so."""
    wanted = (ground(0, 40.0, 10.0),)
    whole = find_opportunities(request(wanted)).windows
    middle_s = 0.5 * (whole.rise_s[1] + whole.set_s[1])
    start = shifted_utc(START, round(middle_s))  # over the leap second
    cut = find_opportunities(
        request(wanted, start=start, stop=start + timedelta(seconds=5400))
    ).windows
    assert cut.opened_by[0] == "interval"
    assert cut.rise_s[0] == 0.0
    assert cut.closed_by[0] == "elevation"
    # another grid of rows: centimetres of the orbit in between
    assert cut.set_s[0] + round(middle_s) == pytest.approx(whole.set_s[1], abs=1e-4)


def test_shortest_windows_are_left_out():
    wanted = tuple(ground(n, 5.0 * n, 20.0 * n) for n in range(8))
    every = find_opportunities(request(wanted)).windows
    long = find_opportunities(
        request(wanted, conditions=OpportunityConditions(min_duration_s=300.0))
    ).windows
    lasts_s = every.set_s - every.rise_s
    np.testing.assert_array_equal(long.rise_s, every.rise_s[lasts_s >= 300.0])
    assert len(long) < len(every)


def test_numerical_orbit():
    """Another orbit source: the state of the TLE's satellite, a few hours on."""
    states = ISS.ephemeris(START, START + timedelta(hours=1)).states(Instants(START, np.zeros(1)))
    orbit = StateVectorOrbit(
        frame="GCRF",
        epoch=START,
        position_km=tuple(states.r_sat_eci_m[0] / 1e3),
        velocity_km_s=tuple(states.v_sat_eci_m_s[0] / 1e3),
    )
    wanted = tuple(ground(n, 45.0 - 10.0 * n, 40.0 * n) for n in range(9))
    by_tle = find_opportunities(request(wanted, days=0.2)).windows
    by_state = find_opportunities(request(wanted, days=0.2, orbit=orbit)).windows
    np.testing.assert_array_equal(by_state.target, by_tle.target)
    # SGP4's own error of 1-2 km within hours
    np.testing.assert_allclose(by_state.rise_s, by_tle.rise_s, rtol=0, atol=2.0)


@pytest.mark.parametrize("rate_deg_s", [0.01, 0.4, 2.0])
def test_attitude_table_is_as_fine_as_the_attitude_needs(rate_deg_s):
    attitude = InertialAttitude(
        epoch=START,
        q_body_from_eci_xyzw=(0.0, 0.6, 0.0, 0.8),
        omega_body_deg_s=(rate_deg_s, -0.3 * rate_deg_s, 0.5 * rate_deg_s),
    )
    stop = START + timedelta(seconds=2000)
    ephemeris = ISS.ephemeris(START, stop)
    carrier = carrier_over(ephemeris, lookout_of(HRC, attitude), START, stop)
    t_s = np.random.default_rng(1).uniform(0.0, 2000.0, 500)
    instants = Instants(START, t_s)
    direction_itrf = np.tile([0.48, -0.6, 0.64], (500, 1))
    direction_eci = np.einsum("nji,nj->ni", c_itrf_from_eci(instants), direction_itrf)
    q_platform_from_eci = HRC.q_platform_from_body * attitude.q_body_from_eci(
        instants, ephemeris.states(instants)
    )
    tabulated = [in_platform(carrier.tables, (0.48, -0.6, 0.64), at_s) for at_s in t_s.tolist()]
    off_rad = np.array(tabulated) - q_platform_from_eci.apply(direction_eci)
    assert np.abs(off_rad).max() < 5e-7  # 0.1 arcsec


@given(st.lists(st.floats(-10.0, 10.0), min_size=6, max_size=6), st.integers(6, 30))
def test_table_is_exact_for_quintics(coefficients, rows):
    polynomial = np.polynomial.Polynomial(coefficients, domain=[0.0, 29.0], window=[-1.0, 1.0])
    t_s = np.linspace(0.0, 0.5 * (rows - 1), 101)
    table = UniformTable(0.5, polynomial(0.5 * np.arange(rows))[:, None])
    np.testing.assert_allclose(table.at(t_s)[:, 0], polynomial(t_s), rtol=0, atol=1e-10)
    np.testing.assert_allclose(table.rate_at(t_s)[:, 0], polynomial.deriv()(t_s), rtol=0, atol=1e-9)


MASKED = replace(
    HRC,
    masks=(
        FieldMask(
            name="panel",
            corners_platform=((0.2, -0.9, 0.3), (0.9, -0.9, 0.3), (0.9, -0.9, -0.4)),
            margin_deg=2.0,
        ),
        FieldMask(
            name="bracket",
            corners_platform=(
                (-0.2, -0.6, 1.0),
                (-0.6, -0.6, 1.0),
                (-0.6, 0.5, 1.0),
                (-0.5, 0.5, 1.0),
                (-0.5, -0.4, 1.0),
                (-0.2, -0.4, 1.0),
            ),
        ),
    ),
)


@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3))
def test_the_nearest_of_all_masks_counts_with_its_margin(components):
    """By the judge, who shares no code; rounding grows where an arcsine ends."""
    length = math.hypot(*components)
    assume(length > 0.1)
    los = np.array(components) / length
    off_rad = [Region(mask).away_rad(los[None])[0] - mask.margin_rad for mask in MASKED.masks]
    assert off_masks(reach_of(MASKED), tuple(los.tolist())) == pytest.approx(min(off_rad), abs=1e-7)


@pytest.mark.parametrize(
    "target",
    [
        GroundTarget(latitude_deg=-33.0, longitude_deg=151.0, height_m=50.0),
        MovingGroundTarget(
            epoch=START,
            latitude_deg=60.0,
            longitude_deg=-20.0,
            height_m=11e3,
            course_deg=250.0,
            speed_m_s=280.0,
        ),
        StarTarget(name="Sirius"),
        StarTarget(name="Canopus", grazing_altitude_km=10.0, refraction="standard"),
        BodyTarget(name="Moon"),
    ],
    ids=lambda target: target.label,
)
def test_compiled_looks_are_the_targets_own(target):
    stop = START + timedelta(hours=6)
    ephemeris = ISS.ephemeris(START, stop)
    carrier = carrier_over(ephemeris, lookout_of(HRC, None), START, stop)
    ((_, sight),) = sights_of(carrier, [OpportunityTarget(id="it", target=target)], np.zeros(1), 1)
    t_s = np.random.default_rng(3).uniform(600.0, 21000.0, 300)
    seen = sight.sighting(np.zeros(300, np.intp), t_s)
    instants = Instants(START, t_s)
    own = target.apparent(instants, ephemeris.states(instants))
    direction_itrf = np.einsum("nij,nj->ni", c_itrf_from_eci(instants), own.direction_eci)
    # 1 cm of the table's error at 400 km, and the ground's refraction left out
    near = own.clearance_rad > 0.0
    np.testing.assert_allclose(seen.direction_itrf[near], direction_itrf[near], rtol=0, atol=1e-7)
    np.testing.assert_allclose(seen.range_m, own.range_m, rtol=1e-9, atol=0.05)
    np.testing.assert_allclose(seen.elevation_rad, own.clearance_rad, rtol=0, atol=1e-7)


def test_more_work_than_a_request_may_make_is_refused(monkeypatch):
    places = tuple(ground(k, 40.0, 3.0 * k) for k in range(20))
    monkeypatch.setattr(effort, "PLAN", 100)
    with pytest.raises(SearchEnded) as refused:
        find_opportunities(request(places))
    assert refused.value.field == "targets"
    assert opportunities_however_many(request(places)).windows.rise_s.size  # as campaigns do


HEIGHT_M = 4e5


def test_planner_and_judge_see_it_at_90_deg():
    """At 2,000 turns of the Earth, at a quarter of which the sine rounds to more than 1."""
    target = GroundTarget(latitude_deg=36.1147, longitude_deg=-115.1728, height_m=610.0)
    place_rad = np.deg2rad([target.latitude_deg, target.longitude_deg])
    r_sat_itrf_m = itrf_from_geodetic(*place_rad, target.ground_height_m) + HEIGHT_M * up_itrf(
        *place_rad
    )
    instants = Instants(datetime(2015, 2, 27, tzinfo=UTC), np.arange(0.0, 40_000.0, 20.0))
    r_sat_eci_m = np.einsum("nji,j->ni", c_itrf_from_eci(instants), r_sat_itrf_m)
    states = OrbitStates(r_sat_eci_m, np.ones_like(r_sat_eci_m))
    # The target moves by 0.6 m while its light travels: 1.5 microradians off the vertical.
    judged_rad = earth_fixed_sight(target, instants, states).elevation_rad
    assert judged_rad == pytest.approx(np.full(2000, np.pi / 2.0), abs=3e-6)
    planned_rad = target.apparent(instants, states).clearance_rad
    assert planned_rad == pytest.approx(np.full(2000, np.pi / 2.0), abs=3e-6)


@pytest.mark.parametrize("share", [1.0 - 1e-13, 1.0, 1.0 + 1e-13])
def test_an_axis_that_waits_is_not_turned_round_for_the_last_digit(monkeypatch, share):
    """Of seed 1032 alpha's slew takes longest, whichever whole turn beta goes to: by 15 or by 345
    deg, which a sum's last digit decided."""
    least_s = TwoAxisMover.least_s

    def otherwise_rounded(mover, start, end):
        turned = abs(end[1].angle_rad - start[1].angle_rad) > 3.2
        return least_s(mover, start, end) * (share if turned else 1.0)

    monkeypatch.setattr(TwoAxisMover, "least_s", otherwise_rounded)
    request = plausible_request(1032, sessions_max=3)
    plan = plan_of(request)
    assert abs(plan.table.position[310, 1] - plan.table.position[0, 1]) < 0.3
