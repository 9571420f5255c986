"""The attitude laws are the paper's kinematics and NASA's angles."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from planner.base.errors import OutsideCoverage
from planner.world.attitude import AttitudeCorrection
from planner.world.attitude.inertial import InertialAttitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants
from planner.world.messages.aem import read_aem
from planner.world.orbits import OrbitStates

EPOCH = datetime(2015, 2, 27, 17, 34, tzinfo=UTC)
ALONG_X = OrbitStates(np.array([[7e6, 0.0, 0.0]]), np.array([[0.0, 7.5e3, 0.0]]))


def paper_recursion(q0_xyzw, omega_body_rad_s, duration_s, step_s=0.1):
    """Sumarokov 2016, eq. 1-2, with the squared norm that makes the correction converge."""
    x, y, z, w = q0_xyzw
    q = np.array([w, x, y, z])
    wx, wy, wz = omega_body_rad_s
    for _ in range(round(duration_s / step_s)):
        scale = 1.0 + (1.0 - q @ q) / 2.0 - step_s**2 / 8.0 * (wx**2 + wy**2 + wz**2)
        turned = 0.5 * np.array(
            [
                -(q[1] * wx + q[2] * wy + q[3] * wz),
                q[0] * wx + q[2] * wz - q[3] * wy,
                q[0] * wy + q[3] * wx - q[1] * wz,
                q[0] * wz + q[1] * wy - q[2] * wx,
            ]
        )
        q = q * scale + step_s * turned
    return Rotation.from_quat([q[1], q[2], q[3], q[0]])


@pytest.mark.parametrize("omega_deg_s", [(0.0, -0.065, 0.0), (0.02, -0.06, 0.01)])
def test_inertial_attitude_is_the_papers(omega_deg_s):
    rng = np.random.default_rng(1)
    body_to_eci_xyzw = Rotation.random(random_state=rng).as_quat()
    law = InertialAttitude(
        epoch=EPOCH,
        q_body_from_eci_xyzw=tuple(Rotation.from_quat(body_to_eci_xyzw).inv().as_quat()),
        omega_body_deg_s=omega_deg_s,
    )
    ours = law.q_body_from_eci(Instants(EPOCH, np.array([900.0])), ALONG_X)[0]
    # the paper's quaternion turns body axes into inertial ones, so it is our inverse
    paper = paper_recursion(body_to_eci_xyzw, np.deg2rad(omega_deg_s), 900.0)
    # (omega step)^3/24 a step, 9,000 steps: 6e-10 rad
    assert (ours * paper).magnitude() < 1e-9


def test_lvlh_axes_and_sequence():
    at = Instants(EPOCH, np.zeros(1))
    nadir = LvlhAttitude().q_body_from_eci(at, ALONG_X)
    np.testing.assert_allclose(nadir.apply([-1.0, 0.0, 0.0]), [[0.0, 0.0, 1.0]], atol=1e-15)
    np.testing.assert_allclose(nadir.apply([0.0, 1.0, 0.0]), [[1.0, 0.0, 0.0]], atol=1e-15)
    np.testing.assert_allclose(nadir.apply([0.0, 0.0, -1.0]), [[0.0, 1.0, 0.0]], atol=1e-15)
    # yaw 90: the nose turns right, so flight direction is seen on the left (-Y)
    yawed = LvlhAttitude(yaw_deg=90.0).q_body_from_eci(at, ALONG_X)
    np.testing.assert_allclose(yawed.apply([0.0, 1.0, 0.0]), [[0.0, -1.0, 0.0]], atol=1e-15)
    # pitch 90: the nose goes up, so nadir is seen behind (-X)
    pitched = LvlhAttitude(pitch_deg=90.0).q_body_from_eci(at, ALONG_X)
    np.testing.assert_allclose(pitched.apply([-1.0, 0.0, 0.0]), [[-1.0, 0.0, 0.0]], atol=1e-15)
    # roll 90: the right side goes down, so nadir is seen to the right (+Y)
    rolled = LvlhAttitude(roll_deg=90.0).q_body_from_eci(at, ALONG_X)
    np.testing.assert_allclose(rolled.apply([-1.0, 0.0, 0.0]), [[0.0, 1.0, 0.0]], atol=1e-15)
    # yaw first, then pitch about the turned axis
    both = LvlhAttitude(yaw_deg=90.0, pitch_deg=90.0).q_body_from_eci(at, ALONG_X)
    np.testing.assert_allclose(both.apply([-1.0, 0.0, 0.0]), [[-1.0, 0.0, 0.0]], atol=1e-15)


def test_a_quaternion_off_unit_length_is_refused():
    with pytest.raises(ValueError, match="unit length"):
        InertialAttitude(epoch=EPOCH, q_body_from_eci_xyzw=(0.0, 0.0, 0.5, 0.5))


AFTER_MANOEUVRE = Path(__file__).parents[1] / "data" / "iss_attitude_after_manoeuvre_2018-286.aem"
MANOEUVRE_END = datetime(2018, 10, 13, 0, 33, tzinfo=UTC)
SETTLED_S = 3.0 * 3600.0


def test_hours_after_a_manoeuvre_the_station_is_off_its_mean_as_told():
    """Telemetry of the 4.3 h after the recorded yaw manoeuvre, about the mean of the last of them.

    Mean square of the error about each body axis over what is told: of one manoeuvre, within a
    factor of three.  Without the manoeuvre told it is 80 about pitch.
    """
    segment = read_aem(AFTER_MANOEUVRE.read_text())[0]
    q_body_from_lvlh = Rotation.from_quat(segment.q_body_from_frame_xyzw)
    mean = q_body_from_lvlh[segment.t_s > SETTLED_S].mean()
    turn_rad = (q_body_from_lvlh * mean.inv()).as_rotvec()
    at = Instants(segment.epoch_utc, segment.t_s)

    def squares(law):
        told = law.errors(at)
        return np.mean(turn_rad**2 / (told.sigma_body_rad**2 + told.swing_rms_body_rad**2), axis=0)

    after = LvlhAttitude(manoeuvre_end=MANOEUVRE_END)
    assert (squares(after)[1:] > 1.0 / 3.0).all()
    assert (squares(after) < 3.0).all()
    assert squares(LvlhAttitude())[1] > 50.0
    [warning] = after.warnings_at(at)
    assert "not yet in torque equilibrium" in warning


def test_long_after_a_manoeuvre_the_law_is_as_without():
    at = Instants(MANOEUVRE_END + timedelta(hours=9), np.arange(0.0, 90.0, 9.0))
    after, plain = LvlhAttitude(manoeuvre_end=MANOEUVRE_END), LvlhAttitude()
    assert after.warnings_at(at) == ()
    told, usual = after.errors(at), plain.errors(at)
    np.testing.assert_allclose(told.sigma_body_rad, usual.sigma_body_rad, rtol=1e-4)
    assert (told.basis, told.memory_s) == (usual.basis, usual.memory_s)


def test_an_attitude_before_the_manoeuvres_end_is_refused():
    law = LvlhAttitude(manoeuvre_end=MANOEUVRE_END)
    at = Instants(MANOEUVRE_END - timedelta(seconds=30), np.array([0.0]))
    with pytest.raises(OutsideCoverage, match="before the manoeuvre's end 2018-10-13T00:33") as it:
        law.q_body_from_eci(at, ALONG_X)
    assert it.value.field == "attitude.manoeuvre_end"
    measured = AttitudeCorrection(
        epoch=MANOEUVRE_END - timedelta(hours=1),
        turn_body_deg=(0.1, 0.0, 0.0),
        covariance_deg2=((1e-4, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 1e-4)),
    )
    with pytest.raises(ValueError, match=r"corrections\.0\.epoch .* lies before"):
        LvlhAttitude(manoeuvre_end=MANOEUVRE_END, corrections=(measured,))
    with pytest.raises(ValueError, match="manoeuvre_end"):
        LvlhAttitude(manoeuvre_end=datetime(1901, 1, 1, tzinfo=UTC))
