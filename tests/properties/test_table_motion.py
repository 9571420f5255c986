"""The planner's motion between a table's rows, against SciPy's curves and differences."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

from planner.base.commands import BODY_CHANNELS, CommandTable, axis_channels
from planner.base.table_motion import motion_at

ROWS = np.arange(6) / 5.0
EPOCH = datetime(2026, 6, 1, tzinfo=UTC)
random = np.random.default_rng(3)
AXES = CommandTable(
    epoch_utc=EPOCH,
    channels=axis_channels(("alpha", "beta")),
    position=random.normal(0.0, 0.1, (6, 2)),
    rate_rad_s=random.normal(0.0, 0.1, (6, 2)),
)
TURN = Rotation.from_rotvec(np.cumsum(random.normal(0.0, 0.01, (6, 3)), axis=0))
BODY = replace(
    AXES,
    channels=BODY_CHANNELS,
    position=TURN.as_quat(),
    rate_rad_s=random.normal(0.0, 0.05, (6, 3)),
    acceleration_rad_s2=random.normal(0.0, 0.05, (6, 3)),
)


def test_axes_fly_the_cubic_hermite_of_scipy():
    t_s = np.linspace(0.0, 1.0, 37)
    curve = CubicHermiteSpline(ROWS, AXES.position, AXES.rate_rad_s)
    found = motion_at(AXES, t_s)
    arrays = (found.position, found.rate_rad_s, found.acceleration_rad_s2)
    for order, array in enumerate(arrays):
        kept = t_s * 5.0 % 1.0 > 1e-9 if order == 2 else slice(None)  # it steps on rows
        np.testing.assert_allclose(array[kept], curve(t_s, order)[kept], rtol=0, atol=1e-12)


@pytest.mark.parametrize("table", [AXES, BODY], ids=["axes", "body"])
def test_rows_are_met_and_kept_outside(table):
    found = motion_at(table, np.array([-1.0, *ROWS, 7.0]))
    rows = [0, *range(6), 5]
    likeness = np.sign(np.sum(found.position * table.position[rows], axis=1))[:, None]
    sign = likeness if table is BODY else 1.0
    np.testing.assert_allclose(sign * found.position, table.position[rows], rtol=0, atol=1e-14)
    np.testing.assert_allclose(found.rate_rad_s, table.rate_rad_s[rows], rtol=0, atol=1e-14)
    if table is BODY:
        np.testing.assert_allclose(
            found.acceleration_rad_s2, BODY.acceleration_rad_s2[rows], rtol=0, atol=1e-13
        )


def test_a_body_turns_at_its_rates():
    t_s, half_s = np.linspace(0.01, 0.99, 30), 1e-4
    before, middle, after = (motion_at(BODY, t_s + one) for one in (-half_s, 0.0, half_s))
    turned = Rotation.from_quat(before.position).inv() * Rotation.from_quat(after.position)
    # Differences over 0.2 ms are off by its square times the jerk's derivative.
    np.testing.assert_allclose(
        turned.as_rotvec() / (2.0 * half_s), middle.rate_rad_s, rtol=0, atol=1e-5
    )
    np.testing.assert_allclose(
        (after.rate_rad_s - before.rate_rad_s) / (2.0 * half_s),
        middle.acceleration_rad_s2,
        rtol=0,
        atol=1e-4,
    )
