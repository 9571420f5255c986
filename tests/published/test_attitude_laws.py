"""The attitude laws are the paper's kinematics and NASA's angles."""

from datetime import UTC, datetime

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from planner.world.attitude.inertial import InertialAttitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants
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
