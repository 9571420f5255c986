"""Invariants of frames and times whatever the input."""

from datetime import UTC, datetime, timedelta

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planner.world.frames.earth_orientation import (
    c_itrf_from_eci,
    eci_from_itrf_state,
    itrf_from_eci_state,
)
from planner.world.frames.geodesy import c_enu_from_itrf, geodetic_from_itrf, itrf_from_geodetic
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import (
    Instants,
    elapsed_s,
    shifted_utc,
    utc_from_text,
    utc_text,
)

LATITUDES = st.one_of(
    st.floats(-np.pi / 2, np.pi / 2), st.sampled_from([np.pi / 2, -np.pi / 2, 0.0])
)
LONGITUDES = st.one_of(st.floats(-np.pi, np.pi), st.sampled_from([np.pi, -np.pi, 0.0]))
EPOCHS = st.one_of(
    st.datetimes(datetime(1973, 2, 1), datetime(2027, 1, 1)),  # noqa: DTZ001 (UTC set below)
    st.sampled_from([datetime(2016, 12, 31, 23, 59, 59), datetime(2012, 7, 1)]),  # noqa: DTZ001
).map(lambda moment: moment.replace(tzinfo=UTC))
VECTORS = st.lists(st.floats(-1e7, 1e7), min_size=3, max_size=3).map(np.array)


@given(LATITUDES, LONGITUDES, st.floats(-500.0, 2e6))
def test_geodetic_coordinates_come_back(latitude, longitude, height_m):
    r_itrf_m = itrf_from_geodetic(latitude, longitude, height_m)
    again = itrf_from_geodetic(*geodetic_from_itrf(r_itrf_m))
    # what the single Halley step of ERFA's closed form leaves at 2000 km; less below
    np.testing.assert_allclose(again, r_itrf_m, rtol=0, atol=2e-5)
    found = geodetic_from_itrf(r_itrf_m)
    assert abs(found[0] - latitude) < 4e-12
    assert abs(found[2] - height_m) < 2e-8


@given(LATITUDES, LONGITUDES)
def test_local_axes_are_a_rotation(latitude, longitude):
    c = c_enu_from_itrf(latitude, longitude)
    np.testing.assert_allclose(c @ c.T, np.eye(3), atol=1e-15 * 4)
    assert np.linalg.det(c) > 0.0


@given(EPOCHS, st.floats(-1e5, 1e5))
def test_shifting_undoes_elapsing(epoch_utc, t_s):
    # a datetime resolves 1 us
    assert abs(elapsed_s(shifted_utc(epoch_utc, t_s), epoch_utc) - t_s) <= 0.5001e-6


@given(EPOCHS, st.floats(-1e5, 1e5))
def test_text_comes_back(epoch_utc, t_s):
    moment = shifted_utc(epoch_utc, t_s)
    assert elapsed_s(utc_from_text(utc_text(moment, 6)), moment) == 0.0


@given(EPOCHS, st.integers(-3, 3))
def test_text_and_elapsed_time_run_on_in_time(epoch_utc, seconds):
    instants = Instants(epoch_utc, seconds + np.arange(0.0, 3.0, 0.25))
    text = instants.utc_text(6)
    assert text == sorted(text)
    assert len(set(text)) == len(text)


@given(EPOCHS, VECTORS, VECTORS)
def test_states_come_back_from_itrf(epoch_utc, r_m, v_m_s):
    instants = Instants(epoch_utc + timedelta(days=1), np.zeros(1))
    there = eci_from_itrf_state(r_m[None], v_m_s[None], instants)
    r_back_m, v_back_m_s = itrf_from_eci_state(*there, instants)
    np.testing.assert_allclose(r_back_m[0], r_m, rtol=0, atol=2e-8)
    np.testing.assert_allclose(v_back_m_s[0], v_m_s, rtol=0, atol=2e-8)


@given(EPOCHS, st.floats(0.0, 1000.0))
def test_the_earth_turns_smoothly(epoch_utc, t_s):
    """The 120 s grid must not show: a short turn is about the axis, at the Earth's rate."""
    step_s = 1e-3
    instants = Instants(epoch_utc, np.array([t_s, t_s + step_s]))
    before, after = c_itrf_from_eci(instants)
    turn = after @ before.T
    # 1e-13 rad of double precision in the time and in the matrix, over 1 ms
    assert abs(turn[0, 1] / step_s - 7.292115e-5) < 1e-9
    np.testing.assert_allclose(before @ before.T, np.eye(3), atol=1e-14)


@given(VECTORS, VECTORS)
def test_lvlh_axes_follow_their_definition(r_m, v_m_s):
    sine = np.linalg.norm(np.cross(r_m, v_m_s))
    if sine < 1e-3 * np.linalg.norm(r_m) * np.linalg.norm(v_m_s) or sine < 1.0:
        return
    q = q_lvlh_from_eci(r_m[None], v_m_s[None])
    r_lvlh, v_lvlh = q.apply(r_m[None])[0], q.apply(v_m_s[None])[0]
    np.testing.assert_allclose(r_lvlh / np.linalg.norm(r_m), [0.0, 0.0, -1.0], atol=1e-12)
    assert v_lvlh[0] > 0.0
    assert abs(v_lvlh[1]) < 1e-12 * np.linalg.norm(v_m_s)
