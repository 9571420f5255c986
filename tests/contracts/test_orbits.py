"""Duties of every orbit source; a new source needs one row in EXAMPLES."""

import json
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from planner_values import plan_of, read_request

from app.requests.examples import LAS_VEGAS, message
from planner.base.errors import InvalidRequest, OutsideCoverage
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s, utc_from_text
from planner.world.orbits import (
    ORBITS,
    OemOrbit,
    OmmOrbit,
    OpmOrbit,
    OrbitSource,
    StateVectorOrbit,
    TleOrbit,
)

DATA = Path(__file__).parents[1] / "data"
ISS_STATE = {
    "frame": "EME2000",
    "epoch": datetime(2022, 1, 17, 12, tzinfo=UTC),
    "position_km": (545.284043961596, 4217.41745999061, 5288.80993327732),
    "velocity_km_s": (-7.63639664838008, 0.168827885257, 0.65634287389035),
}
OMM, OPM = message("elements.json"), message("state.opm")
SGP4_VELOCITY_ERROR_M_S = 0.02  # SGP4's velocity leaves out slow parts of its own derivative


@dataclass
class Example:
    orbit: object
    start_utc: datetime
    velocity_error_m_s: float  # how far velocity may be from position's derivative


EXAMPLES = {
    "tle": Example(
        TleOrbit(
            line1="1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991",
            line2="2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964",
        ),
        datetime(2015, 2, 27, 17, 36, tzinfo=UTC),
        SGP4_VELOCITY_ERROR_M_S,
    ),
    "omm": Example(
        OmmOrbit(content=OMM), datetime(2015, 2, 27, 17, 36, tzinfo=UTC), SGP4_VELOCITY_ERROR_M_S
    ),
    "opm": Example(OpmOrbit(content=OPM), datetime(2015, 2, 27, 17, 39, tzinfo=UTC), 1e-6),
    "oem": Example(
        OemOrbit(content=(DATA / "iss_oem_2022-017_excerpt.xml").read_text()),
        datetime(2022, 1, 17, 12, 20, tzinfo=UTC),
        1e-6,
    ),
    "state": Example(StateVectorOrbit(**ISS_STATE), datetime(2022, 1, 17, 12, 5, tzinfo=UTC), 1e-6),
    "state, before its epoch": Example(
        StateVectorOrbit(**ISS_STATE), datetime(2022, 1, 17, 11, 50, tzinfo=UTC), 1e-6
    ),
    "state, the paper's model": Example(
        StateVectorOrbit(**ISS_STATE, force_model="j2j4"),
        datetime(2022, 1, 17, 12, 5, tzinfo=UTC),
        3e-5,  # its rows, 1 s apart, leave out the motion of the Earth's axis
    ),
}
SPAN_S = 90.0


def test_every_source_has_an_example():
    assert {type(example.orbit) for example in EXAMPLES.values()} == set(ORBITS.values())
    assert all(ORBITS[example.orbit.source] is type(example.orbit) for example in EXAMPLES.values())


@pytest.fixture(params=EXAMPLES.values(), ids=EXAMPLES.keys())
def example(request):
    return request.param


def ephemeris_of(example):
    return example.orbit.ephemeris(example.start_utc, example.start_utc + timedelta(seconds=SPAN_S))


def test_velocity_is_the_derivative_of_position(example):
    ephemeris = ephemeris_of(example)
    h = 0.25
    t_s = np.arange(1.0, SPAN_S - 1.0, 0.37)

    def r_m(shift_s):
        return ephemeris.states(Instants(example.start_utc, t_s + shift_s)).r_sat_eci_m

    difference = (8.0 * (r_m(h) - r_m(-h)) - (r_m(2 * h) - r_m(-2 * h))) / (12.0 * h)
    velocity = ephemeris.states(Instants(example.start_utc, t_s)).v_sat_eci_m_s
    # double precision of 7e6 m over 0.25 s adds 1e-8 m/s
    np.testing.assert_allclose(velocity, difference, rtol=0, atol=example.velocity_error_m_s)


def test_states_don_t_depend_on_how_they_are_asked_for(example):
    ephemeris = ephemeris_of(example)
    shifted_utc = example.start_utc + timedelta(seconds=30)
    together = ephemeris.states(Instants(example.start_utc, np.array([31.0, 40.0, 89.0])))
    alone = ephemeris.states(Instants(shifted_utc, np.array([10.0])))
    # the time of an instant, to double precision: 1e-11 s
    np.testing.assert_allclose(alone.r_sat_eci_m[0], together.r_sat_eci_m[1], rtol=0, atol=1e-6)


def test_states_in_itrf_axes_are_the_same(example):
    ephemeris = ephemeris_of(example)
    instants = Instants(example.start_utc, np.linspace(0.0, SPAN_S, 7))
    states, c_itrf = ephemeris.states(instants), c_itrf_from_eci(instants)
    r_itrf_m, v_itrf_m_s = ephemeris.states_in_itrf_axes(instants)
    # double precision of 7e6 m and of 8e3 m/s through matrices
    for found, eci, off in (
        (r_itrf_m, states.r_sat_eci_m, 1e-7),
        (v_itrf_m_s, states.v_sat_eci_m_s, 1e-10),
    ):
        by_eci = np.einsum("nij,nj->ni", c_itrf, eci)
        np.testing.assert_allclose(found, by_eci, rtol=0, atol=off)


def test_nothing_is_said_outside_the_span(example):
    ephemeris = ephemeris_of(example)
    for t_s in (-0.1, SPAN_S + 0.1):
        instants = Instants(example.start_utc, np.array([t_s]))
        for states in (ephemeris.states, ephemeris.states_in_itrf_axes):
            with pytest.raises(OutsideCoverage, match="prepared only from"):
                states(instants)
    assert len(ephemeris.states(Instants(example.start_utc, np.array([]))).r_sat_eci_m) == 0


def test_a_plan_of_no_length_is_possible(example):
    ephemeris = example.orbit.ephemeris(example.start_utc, example.start_utc)
    states = ephemeris.states(Instants(example.start_utc, np.zeros(1)))
    assert 6.5e6 < np.linalg.norm(states.r_sat_eci_m) < 6.9e6


def test_age_grows_a_second_a_second(example):
    ephemeris = ephemeris_of(example)
    ages_s = ephemeris.age_s(Instants(example.start_utc, np.array([0.0, SPAN_S])))
    assert abs(abs(ages_s[1] - ages_s[0])) in (0.0, pytest.approx(SPAN_S))
    assert np.all(ages_s >= 0.0)


def test_every_source_says_its_error_its_name_and_how_far_to_search(example):
    """An abstract member left out is refused where the source is first built."""
    assert isinstance(example.orbit, OrbitSource)
    assert 600.0 <= example.orbit.search_horizon_s <= 86400.0
    assert len(example.orbit.carrier_name) == 2
    sigma = ephemeris_of(example).sigma(Instants(example.start_utc, np.array([0.0, SPAN_S])))
    axes_m = np.array([sigma.radial_m, sigma.along_m, sigma.cross_m])
    assert axes_m.shape == (3, 2)
    assert np.all((axes_m > 1.0) & (axes_m < 1e5))
    assert sigma.basis
    assert sigma.better


def test_age_of_a_state_counts_from_its_epoch():
    example = EXAMPLES["state"]
    ages_s = ephemeris_of(example).age_s(Instants(example.start_utc, np.zeros(1)))
    assert ages_s[0] == elapsed_s(example.start_utc, ISS_STATE["epoch"]) == 300.0


[ELEMENTS] = json.loads(OMM)
LINES = [LAS_VEGAS["orbit"]["line1"], LAS_VEGAS["orbit"]["line2"]]
START, STOP = map(utc_from_text, ("2015-02-27T17:00:00Z", "2015-02-27T18:00:00Z"))


def states(orbit):
    read = read_request({**LAS_VEGAS, "orbit": orbit}).orbit
    return read.ephemeris(START, STOP).states(Instants(START, np.linspace(0.0, 3600.0, 7)))


@pytest.mark.parametrize(
    "content",
    [
        "\n".join(LINES),
        "ISS (ZARYA)\n" + "\n".join(LINES) + "\n",
        "0 ISS (ZARYA)             \r\n" + "  \r\n".join(LINES) + "\r\n\r\n",
        "1 2 3\n" + "\n".join(LINES),  # a name may look like a line
    ],
)
def test_two_and_three_lines_in_one_text(content):
    asked = states({"source": "tle", "content": content})
    assert (asked.r_sat_eci_m == states(LAS_VEGAS["orbit"]).r_sat_eci_m).all()


@pytest.mark.parametrize("form", [dict, lambda found: [found], lambda found: json.dumps([found])])
def test_an_omm_in_json_as_it_is(form):
    asked = states({"source": "omm", "content": form(ELEMENTS)})
    assert (asked.r_sat_eci_m == states({"source": "omm", "content": OMM}).r_sat_eci_m).all()


@pytest.mark.parametrize(
    "content",
    [[], [1], {}, {"EPOCH": {"a": 1}}, {"EPOCH": None}, [[]], True,
     {**ELEMENTS, "MEAN_MOTION": float("nan")},
     {**ELEMENTS, "MEAN_MOTION": 10.0**300},
     {**ELEMENTS, "ECCENTRICITY": True},
     {**ELEMENTS, "OBJECT_NAME": "ISS\u0000"}],
)  # fmt: skip
def test_an_omm_that_is_none_is_refused_at_its_field(content):
    request = {**LAS_VEGAS, "orbit": {"source": "omm", "content": content}}
    with pytest.raises(InvalidRequest) as refusal:
        read_request(request)
    assert all(error.field.startswith("orbit.content") for error in refusal.value.errors)


def test_elements_too_old_are_refused_at_the_text_they_came_in():
    late = {"start": "2015-04-27T17:36:20Z", "stop": "2015-04-27T17:37:20Z"}
    request = {
        **LAS_VEGAS,
        "orbit": {"source": "tle", "content": "\n".join(LINES)},
        "initial_state": {},
        "sessions": [LAS_VEGAS["sessions"][0] | late],
    }
    with pytest.raises(OutsideCoverage) as refusal:
        plan_of(request)
    assert refusal.value.field == "orbit.content"
