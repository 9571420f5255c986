"""The drag an ephemeris holds is found from its states."""

from datetime import UTC, datetime

import numpy as np
import pytest

from planner.world.messages.oem import OemSegment
from planner.world.orbits.decay import UNKNOWN_DRAG_IN_A_DAY_M, drag_in_a_day_m

GM_M3_S2 = 3.986004418e14
STEP_S = 240.0


def spiral(lost_m_day, days, raised_m=0.0):
    """A circular orbit about a point mass, inclined by 51.6 deg, that shrinks steadily, raised by a
    burn halfway: a = a0 - lost t, and the angle is the integral of its mean motion.
    """
    t_s = np.arange(0.0, days * 86400.0, STEP_S)
    a_m = 6.79e6 - lost_m_day * t_s / 86400.0 + raised_m * (t_s > t_s[-1] / 2.0)
    n = np.sqrt(GM_M3_S2 / a_m**3)
    u = np.concatenate([[0.0], np.cumsum(0.5 * (n[1:] + n[:-1]) * STEP_S)])
    c, s, tilt = np.cos(u), np.sin(u), np.deg2rad(51.6)
    r_m = a_m[:, None] * np.stack([c, s * np.cos(tilt), s * np.sin(tilt)], axis=1)
    v_m_s = (a_m * n)[:, None] * np.stack([-s, c * np.cos(tilt), c * np.sin(tilt)], axis=1)
    return OemSegment(
        epoch_utc=datetime(2024, 2, 15, tzinfo=UTC),
        t_s=t_s,
        useable_s=(0.0, float(t_s[-1])),
        object_name="TEST",
        frame="EME2000",
        r_m=r_m,
        v_m_s=v_m_s,
    )


@pytest.mark.parametrize("raised_m", [0.0, 3000.0])
def test_a_spirals_drag_is_half_the_angular_acceleration_times_a_day_squared(raised_m):
    lost_m_day = 160.0
    mean_motion_rad_s = np.sqrt(GM_M3_S2 / 6.79e6**3)
    # n' = 1.5 n a'/a; the arc a n' t^2 / 2
    expected_m = 0.75 * mean_motion_rad_s * 86400.0 * lost_m_day
    found_m = drag_in_a_day_m((spiral(lost_m_day, 10.0, raised_m),))
    # the flattening, which this orbit doesn't feel, leaves some metres of an orbit's mean axis
    assert found_m == pytest.approx(expected_m, rel=0.05)


def test_an_arc_of_a_day_says_nothing_of_its_drag():
    assert drag_in_a_day_m((spiral(160.0, 1.0),)) == UNKNOWN_DRAG_IN_A_DAY_M
