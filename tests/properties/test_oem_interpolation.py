"""Invariants of every ephemeris message, however it is cut, framed or thinned out."""

from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import InvalidMessage, OutsideCoverage
from planner.base.interpolation import hermite
from planner.world.frames.earth_orientation import (
    C_GCRF_FROM_EME2000,
    c_itrf_from_eci,
    c_itrf_from_teme,
    itrf_from_eci_state,
)
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import OemOrbit

DATA = Path(__file__).parents[1] / "data"
CALM = OemOrbit(content=(DATA / "iss_oem_2022-017_excerpt.xml").read_text()).message.segments[0]
REBOOST = OemOrbit(content=(DATA / "iss_oem_2022-038_excerpt.xml").read_text()).message.segments[2]


def kvn(segment, rows_by_segment, frame="EME2000", states=None):
    """The segment's states, or others at its epochs, as a KVN message of one or more segments."""
    states = np.hstack([segment.r_m, segment.v_m_s]) if states is None else states
    lines = ["CCSDS_OEM_VERS = 2.0"]
    for rows in rows_by_segment:
        lines += ["META_START", f"REF_FRAME = {frame}", "TIME_SYSTEM = UTC", "META_STOP"]
        epochs = Instants(segment.epoch_utc, segment.t_s[rows]).utc_text(6)
        lines += [
            " ".join([epoch, *(f"{number / 1e3:.12f}" for number in state)])
            for epoch, state in zip(epochs, states[rows], strict=True)
        ]
    return "\n".join(lines)


def positions_m(orbit, segment, t_s):
    start_utc, stop_utc = (shifted_utc(segment.epoch_utc, float(t)) for t in t_s[[0, -1]])
    ephemeris = orbit.ephemeris(start_utc, stop_utc)
    return ephemeris, ephemeris.states(Instants(segment.epoch_utc, t_s)).r_sat_eci_m


ALL = slice(0, len(CALM.t_s))
T_S = np.linspace(CALM.t_s[8], CALM.t_s[14], 200)


@pytest.mark.parametrize("frame", ["ITRF2014", "TEME", "GCRF"])
def test_the_frame_of_the_message_makes_no_difference(frame):
    nodes = Instants(CALM.epoch_utc, CALM.t_s)
    r_eci_m, v_eci_m_s = CALM.r_m @ C_GCRF_FROM_EME2000.T, CALM.v_m_s @ C_GCRF_FROM_EME2000.T
    if frame == "ITRF2014":
        r_m, v_m_s = itrf_from_eci_state(r_eci_m, v_eci_m_s, nodes)
    elif frame == "TEME":
        c = np.swapaxes(c_itrf_from_teme(nodes), 1, 2) @ c_itrf_from_eci(nodes)
        r_m, v_m_s = np.einsum("nij,nj->ni", c, r_eci_m), np.einsum("nij,nj->ni", c, v_eci_m_s)
    else:
        r_m, v_m_s = r_eci_m, v_eci_m_s
    orbit = OemOrbit(content=kvn(CALM, [ALL], frame, np.hstack([r_m, v_m_s])))
    _, there = positions_m(orbit, CALM, T_S)
    _, here = positions_m(OemOrbit(content=kvn(CALM, [ALL])), CALM, T_S)
    # the message's last digit is 1e-9 m; its epochs are exact
    np.testing.assert_allclose(there, here, rtol=0, atol=1e-6)


@given(st.integers(4, 20))
def test_cutting_a_message_in_two_leaves_the_path(cut):
    halves = [slice(0, cut + 1), slice(cut, len(CALM.t_s))]
    t_s = np.linspace(CALM.t_s[1], CALM.t_s[-2], 300)
    _, joined = positions_m(OemOrbit(content=kvn(CALM, halves)), CALM, t_s)
    _, whole = positions_m(OemOrbit(content=kvn(CALM, [ALL])), CALM, t_s)
    # four nodes on one side instead of six around: up to 0.2 m a component in most cells of
    # the published files, 0.35 m in the worst of this one
    np.testing.assert_allclose(joined, whole, rtol=0, atol=0.5)


def test_sparse_nodes_are_warned_of_then_refused():
    thinned = {
        step: OemOrbit(content=kvn(CALM, [slice(0, len(CALM.t_s) - 1, step)])) for step in (1, 3, 8)
    }
    ephemeris, _ = positions_m(thinned[1], CALM, T_S)
    assert ephemeris.warnings == ()
    ephemeris, sparse_m = positions_m(thinned[3], CALM, T_S)
    (warning,) = ephemeris.warnings
    assert "720 s apart" in warning
    _, dense_m = positions_m(thinned[1], CALM, T_S)
    stated_m = float(warning.rsplit("some ", 1)[1].removesuffix(" m"))
    # the warning must not make the error look smaller than it is
    assert np.max(np.linalg.norm(sparse_m - dense_m, axis=1)) < 2.0 * stated_m
    with pytest.raises(OutsideCoverage, match="send the ephemeris with closer nodes"):
        positions_m(thinned[8], CALM, T_S)


def test_a_burn_between_distant_nodes_is_warned_of():
    steps_s = np.diff(REBOOST.t_s)
    in_burn = np.flatnonzero(steps_s < 10.0)
    kept = np.r_[: in_burn[0] + 1, in_burn[-1] + 1 : len(REBOOST.t_s)]
    orbit = OemOrbit(content=kvn(REBOOST, [kept]))
    before_s, after_s = REBOOST.t_s[in_burn[0]], REBOOST.t_s[in_burn[-1] + 1]
    t_s = np.linspace(before_s - 30.0, after_s + 30.0, 50)
    ephemeris, thinned_m = positions_m(orbit, REBOOST, t_s)
    warning, planned = ephemeris.warnings
    assert "a burn it plans: 0.26 m/s" in planned
    assert "142 s apart during a burn of 1.8" in warning
    stated_m = float(warning.rsplit("some ", 1)[1].removesuffix(" m"))
    _, full_m = positions_m(OemOrbit(content=kvn(REBOOST, [slice(None)])), REBOOST, t_s)
    assert np.max(np.linalg.norm(thinned_m - full_m, axis=1)) < stated_m
    # away from the burn the same message is good
    ephemeris, _ = positions_m(orbit, REBOOST, np.linspace(before_s - 900.0, before_s - 1.0, 20))
    assert ephemeris.warnings == ()


@pytest.mark.parametrize(
    ("useable", "covered"),
    [
        ("USEABLE_START_TIME = 2022-01-17T12:30:00\n", False),
        ("USEABLE_STOP_TIME = 2022-01-17T13:00:00\n", True),
    ],
)
def test_useable_times_are_honoured(useable, covered):
    orbit = OemOrbit(content=kvn(CALM, [ALL]).replace("META_STOP", useable + "META_STOP"))
    start_utc = CALM.epoch_utc + timedelta(minutes=10)
    stop_utc = start_utc + timedelta(minutes=5)
    if covered:
        assert orbit.ephemeris(start_utc, stop_utc).warnings == ()
    else:
        with pytest.raises(OutsideCoverage, match="it covers 2022-01-17T12:30:00"):
            orbit.ephemeris(start_utc, stop_utc)


@given(
    node=st.integers(9, 13),
    column=st.integers(0, 5),
    size=st.floats(100.0, 3e5),  # beyond, the reader says that it is no satellite's
    sign=st.sampled_from([1.0, -1.0]),
)
def test_a_damaged_node_is_refused_by_its_epoch(node, column, size, sign):
    """Off by 100 m or more in position, or by as much at its neighbours in velocity."""
    states = np.hstack([CALM.r_m, CALM.v_m_s])
    step_s = CALM.t_s[node + 1] - CALM.t_s[node]
    states[node, column] += sign * (size if column < 3 else size / (step_s / 2.0))
    orbit = OemOrbit(content=kvn(CALM, [ALL], states=states))
    with pytest.raises(InvalidMessage) as refusal:
        positions_m(orbit, CALM, T_S)
    assert refusal.value.field == "orbit.content"
    epoch = Instants(CALM.epoch_utc, CALM.t_s[[node]]).utc_text()[0]
    assert f"state at {epoch} lies" in refusal.value.detail


def test_a_node_a_few_milliseconds_late_is_warned_of():
    states = np.hstack([CALM.r_m, CALM.v_m_s])
    states[11, :3] += 4e-3 * states[11, 3:]
    orbit = OemOrbit(content=kvn(CALM, [ALL], states=states))
    ephemeris, _ = positions_m(orbit, CALM, T_S)
    # 4 ms of 7.66 km/s, 31 m, less the 4 m that the gravity felt there may be an engine's
    assert any("lies some 2" in told or "lies some 3" in told for told in ephemeris.warnings)


def test_a_step_between_two_halves_is_refused_at_either_node():
    states = np.hstack([CALM.r_m, CALM.v_m_s])
    states[12:, 0] += 10e3
    orbit = OemOrbit(content=kvn(CALM, [ALL], states=states))
    with pytest.raises(InvalidMessage) as refusal:
        positions_m(orbit, CALM, T_S)
    first, last = Instants(CALM.epoch_utc, CALM.t_s[11:13]).utc_text()
    assert f"states at {first} and {last} lie" in refusal.value.detail


def test_states_of_a_turning_frame_stated_as_inertial_are_refused():
    nodes = Instants(CALM.epoch_utc, CALM.t_s)
    r_eci_m, v_eci_m_s = CALM.r_m @ C_GCRF_FROM_EME2000.T, CALM.v_m_s @ C_GCRF_FROM_EME2000.T
    states = np.hstack(itrf_from_eci_state(r_eci_m, v_eci_m_s, nodes))
    with pytest.raises(InvalidMessage, match=r"1\.1 m/s\^2.*is REF_FRAME the frame"):
        positions_m(OemOrbit(content=kvn(CALM, [ALL], states=states)), CALM, T_S)


@given(
    st.sampled_from([2, 4, 6]),
    st.lists(st.floats(0.1, 10.0), min_size=7, max_size=12),
    st.lists(st.floats(-10.0, 10.0), min_size=12, max_size=12),
)
def test_hermite_reproduces_every_polynomial_it_can(nodes, steps_s, coefficients):
    """Degree 2 m - 1 through m nodes; near the ends four nodes, so degree 7 there."""
    degree = min(2 * nodes - 1, 7)
    node_s = np.cumsum(steps_s)
    middle_s, scale_s = node_s.mean(), np.ptp(node_s)
    curve = np.polynomial.Polynomial(coefficients[: degree + 1], domain=[0, 1], window=[0, 1])

    def at(t_s):
        u = (t_s - middle_s) / scale_s
        return np.stack([curve(u)] * 3, axis=1), np.stack([curve.deriv()(u) / scale_s] * 3, axis=1)

    t_s = np.linspace(node_s[0], node_s[-1], 50)
    value, slope = hermite(node_s, *at(node_s), t_s, nodes)
    expected_value, expected_slope = at(t_s)
    # rounding of divided differences where a step is a hundredth of the window
    np.testing.assert_allclose(value, expected_value, rtol=0, atol=1e-7)
    np.testing.assert_allclose(slope, expected_slope, rtol=0, atol=1e-5)
