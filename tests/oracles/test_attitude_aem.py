"""The curve flown from an attitude message is true to it, smooth, and inside its coverage."""

from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from planner.base.errors import InvalidMessage, OutsideCoverage
from planner.world.attitude import AemAttitude, LvlhAttitude
from planner.world.attitude.aem import OPTIONS as ATTITUDE_MESSAGE_OPTIONS
from planner.world.frames.earth_orientation import C_GCRF_FROM_EME2000, c_itrf_from_eci
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants, utc_from_text, utc_text
from planner.world.orbits import TleOrbit

DATA = Path(__file__).parents[1] / "data"
ARCSEC = np.pi / 648000.0
START = utc_from_text("2015-02-27T17:30:00Z")
ORBIT = TleOrbit(
    line1="1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991",
    line2="2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964",
)
EPHEMERIS = ORBIT.ephemeris(START, START + timedelta(seconds=1200))
TRUE = LvlhAttitude(yaw_deg=-4.1, pitch_deg=-2.0, roll_deg=0.7)


def at(t_s):
    instants = Instants(START, np.asarray(t_s, dtype=float))
    return instants, EPHEMERIS.states(instants)


def message(t_s, q_body_from_frame, frame="EME2000", **metadata):
    q_xyzw = q_body_from_frame.inv().as_quat()
    rows = "\n".join(
        f"{utc_text(START + timedelta(seconds=float(t)), 6)} "
        + " ".join(f"{value:.12f}" for value in q)
        for t, q in zip(t_s, q_xyzw, strict=True)
    )
    more = "".join(f"{key} = {value}\n" for key, value in metadata.items())
    return (
        f"META_START\nREF_FRAME_A = {frame}\nREF_FRAME_B = SC_BODY_1\nTIME_SYSTEM = UTC\n"
        f"ATTITUDE_TYPE = QUATERNION\n{more}META_STOP\nDATA_START\n{rows}\nDATA_STOP\n"
    )


def aem(*segments):
    return AemAttitude(content="CCSDS_AEM_VERS = 2.0\n" + "".join(segments))


def true_against_eme2000(t_s):
    return TRUE.q_body_from_eci(*at(t_s)) * Rotation.from_matrix(C_GCRF_FROM_EME2000)


def miss_rad(law, t_s):
    instants, states = at(t_s)
    turn = law.q_body_from_eci(instants, states) * TRUE.q_body_from_eci(instants, states).inv()
    return turn.magnitude()


def accelerations_rad_s2(law, t_s):
    """Second differences of the attitude against LVLH at 0.2 s, as the line of sight takes them."""
    instants, states = at(t_s)
    moved = law.q_body_from_eci(instants, states) * TRUE.q_body_from_eci(instants, states).inv()
    return np.linalg.norm(np.diff(moved.as_rotvec(), 2, axis=0), axis=1) / 0.2**2


@pytest.mark.parametrize("step_s", [1.0, 10.0, 60.0, 120.0])
def test_a_predicted_attitude_is_met_between_its_rows(step_s):
    """LVLH written against EME2000: 4 deg a minute.  A table's own error is 0.1 arcsec."""
    rows_s = np.arange(0.0, 1200.5, step_s)
    law = aem(message(rows_s, true_against_eme2000(rows_s)))
    assert miss_rad(law, np.linspace(0.0, 1200.0, 997)).max() < 0.1 * ARCSEC
    assert law.warnings == ()


@pytest.mark.parametrize("frame", ["LVLH", "RTN", "GCRF", "ITRF2014"])
def test_every_frame_leads_to_the_same_attitude(frame):
    """RTN built from its definition here; the other frames have their own tests."""
    rows_s = np.arange(0.0, 1200.5, 30.0)
    instants, states = at(rows_s)
    r, v = states.r_sat_eci_m, states.v_sat_eci_m_s
    radial = r / np.linalg.norm(r, axis=1, keepdims=True)
    normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v), axis=1, keepdims=True)
    c_rtn_from_eci = np.stack([radial, np.cross(normal, radial), normal], axis=1)
    q_frame_from_eci = {
        "LVLH": q_lvlh_from_eci(r, v),
        "RTN": Rotation.from_matrix(c_rtn_from_eci),
        "GCRF": Rotation.identity(len(rows_s)),
        "ITRF2014": Rotation.from_matrix(c_itrf_from_eci(instants)),
    }[frame]
    law = aem(
        message(rows_s, TRUE.q_body_from_eci(instants, states) * q_frame_from_eci.inv(), frame)
    )
    assert miss_rad(law, np.linspace(0.0, 1200.0, 331)).max() < 0.1 * ARCSEC


def test_noise_is_smoothed_and_said():
    """2 arcsec an axis at 1 s: a curve through the rows would accelerate by some 10 arcsec/s2."""
    rows_s = np.arange(0.0, 1200.5, 1.0)
    noise = np.random.default_rng(1).normal(0.0, 2.0 * ARCSEC, (len(rows_s), 3))
    law = aem(message(rows_s, Rotation.from_rotvec(noise) * true_against_eme2000(rows_s)))
    instants_s = np.arange(20.0, 1180.0, 0.2)
    rms = np.sqrt(np.mean(miss_rad(law, instants_s) ** 2))
    assert rms < 0.5 * np.sqrt(3.0) * 2.0 * ARCSEC  # at least four rows are averaged
    assert accelerations_rad_s2(law, instants_s).max() < 0.5 * ARCSEC
    assert law.residual_rad == pytest.approx(np.sqrt(3.0) * 2.0 * ARCSEC, rel=0.1)
    assert "noisy and were smoothed" in law.warnings[0]


def test_real_telemetry_gives_rates_a_platform_can_follow():
    """ISS telemetry every second.  Its solar arrays' and crew's real motion is below 1 arcsec/s2;
    a curve through every row would reach 10."""
    law = AemAttitude(content=(DATA / "iss_attitude_1s_2018-285.aem").read_text())
    arc = law.arcs[0]
    t_s = np.arange(2.0, 440.0, 0.2)
    turned = arc.curve.at(t_s) * arc.curve.at(t_s)[:1].inv()
    acceleration = np.linalg.norm(np.diff(turned.as_rotvec(), 2, axis=0), axis=1) / 0.2**2
    assert acceleration.max() < 1.0 * ARCSEC
    assert law.residual_rad < 1.0 * ARCSEC  # the noise of one row against its neighbours is 0.4


def test_nothing_is_said_outside_the_useable_times_or_across_segments():
    first_s, second_s = np.arange(0.0, 301.0, 10.0), np.arange(300.0, 601.0, 10.0)
    law = aem(
        message(
            first_s,
            true_against_eme2000(first_s),
            USEABLE_START_TIME=utc_text(START + timedelta(seconds=20)),
        ),
        message(second_s, true_against_eme2000(second_s)),
    )
    assert miss_rad(law, np.linspace(20.0, 300.0, 50)).max() < 0.1 * ARCSEC
    assert miss_rad(law, np.linspace(300.0, 600.0, 50)).max() < 0.1 * ARCSEC
    for t_s in ([19.9, 100.0], [290.0, 310.0], [590.0, 600.1]):
        with pytest.raises(OutsideCoverage, match="no one segment") as refusal:
            miss_rad(law, t_s)
        assert refusal.value.field == "attitude.content"


def test_rows_too_far_apart_are_refused():
    rows_s = [0.0, 900.0]
    with pytest.raises(ValueError, match="too far to say how it turned"):
        aem(message(rows_s, true_against_eme2000(rows_s)))


def test_linear_interpolation_asked_for_is_said_when_it_matters():
    rows_s = np.arange(0.0, 1200.5, 100.0)
    still = aem(message(rows_s, true_against_eme2000(rows_s), INTERPOLATION_METHOD="LINEAR"))
    assert still.warnings == ()  # a constant rate: both agree
    zigzag = Rotation.from_rotvec(np.outer(np.arange(13) % 2, [1e-3, 0.0, 0.0]))
    law = aem(message(rows_s, zigzag * true_against_eme2000(rows_s), INTERPOLATION_METHOD="LINEAR"))
    assert "linear interpolation" in law.warnings[-1]


def test_a_gap_in_the_telemetry_is_said():
    rows_s = np.concatenate([np.arange(0.0, 200.0, 2.0), np.arange(300.0, 500.0, 2.0)])
    law = aem(message(rows_s, true_against_eme2000(rows_s)))
    assert "gap of 102 s" in law.warnings[0]


def test_two_rows_turn_at_a_constant_rate():
    """Slerp's own definition."""
    turns = Rotation.from_rotvec(np.outer([0.0, 0.4], [0.0, 0.6, 0.8]))
    law = aem(message([0.0, 100.0], turns, "GCRF"))
    instants, states = at(np.linspace(0.0, 100.0, 21))
    angle = law.q_body_from_eci(instants, states).magnitude()
    np.testing.assert_allclose(angle, np.linspace(0.0, 0.4, 21), atol=0.01 * ARCSEC)


@pytest.mark.parametrize(
    ("step_s", "off_deg"), [(1.0, 0.1), (10.0, 30.0), (60.0, 1.0), (120.0, 0.1)]
)
def test_a_damaged_row_is_refused_where_it_matters(step_s, off_deg):
    """Turns of 4 deg a minute explain a smooth course, not one row beside it."""
    rows_s = np.arange(0.0, 1200.5, step_s)
    row = len(rows_s) // 2
    off = Rotation.from_rotvec(
        np.deg2rad([[0.0, off_deg * (n == row), 0.0] for n in range(len(rows_s))])
    )
    law = aem(message(rows_s, off * true_against_eme2000(rows_s)))
    with pytest.raises(InvalidMessage) as refusal:
        law.q_body_from_eci(*at([rows_s[row] - 0.5 * step_s]))
    assert refusal.value.field == "attitude.content"
    epoch = utc_text(START + timedelta(seconds=float(rows_s[row])))
    assert f"attitude at {epoch} lies" in refusal.value.detail
    if row > 10:
        assert law.warnings_at(at([rows_s[2]])[0]) == law.warnings


@pytest.mark.parametrize("name", ["1s", "manoeuvre", "tea"])
def test_real_telemetry_has_no_damaged_row(name):
    """A yaw manoeuvre between rows 20 s apart included: 21 arcsec at most."""
    law = AemAttitude(content=(DATA / f"iss_attitude_{name}_2018-285.aem").read_text())
    for arc in law.arcs:
        instants = Instants(arc.segment.epoch_utc, arc.segment.t_s)
        assert arc.oddest_near(instants)[1] < ATTITUDE_MESSAGE_OPTIONS.odd_warned_rad
        assert law.warnings_at(instants) == law.warnings
