"""Is a way called shut where a closed form says so, and are cells inside that are said to be?"""

import math

import numpy as np
import pytest
from keep_out_cases import LIMITS
from scipy_boresight import scipy_boresight

from planner.detour.barrier import CELLS_RAD, FINE_CELLS_RAD, cones_over, is_barred
from planner.platforms import ISS_HRC
from planner.pointing.keep_out import KeepOutView, MovingCone
from planner.slew import AxisState, SlewProblem

DURATION_S = 100.0
BETA_END_RAD = math.radians(150.0)
# About the outer axis, to which the boresight comes nearest at beta = 85 deg, alpha at will.
HALF_ANGLE_RAD = math.radians(20.0)
GATE_RAD = math.radians(85.0) - HALF_ANGLE_RAD
NODES_S = np.linspace(0.0, DURATION_S, 11)


def gate(opens_s):
    """A slew through a cone that counts until opens_s."""
    cone = MovingCone(
        about="the outer axis",
        half_angle_rad=HALF_ANGLE_RAD,
        t_s=NODES_S,
        axis_platform=np.tile(ISS_HRC.axes_platform[0], (len(NODES_S), 1)),
        counts_rad=opens_s - NODES_S,
    )
    view = KeepOutView(platform=ISS_HRC, cones=(cone,))
    return SlewProblem(
        axis_names=ISS_HRC.axis_names,
        limits=ISS_HRC.axis_limits,
        start=(AxisState(angle_rad=0.0), AxisState(angle_rad=0.0)),
        end=(AxisState(angle_rad=0.5), AxisState(angle_rad=BETA_END_RAD)),
        duration_s=DURATION_S,
        keep_out=view,
    )


def test_a_gate_may_open_as_late_as_the_rest_of_the_way_takes():
    rate, acceleration = LIMITS.rate_max_rad_s, LIMITS.acceleration_max_rad_s2
    braking_s = rate / (2.0 * acceleration) + acceleration / (2.0 * LIMITS.jerk_max_rad_s3)
    last_s = DURATION_S - (BETA_END_RAD - GATE_RAD) / rate - braking_s
    # A cell of 0.3 deg is 0.1 s wide; one on either side of the gate may leak.
    for late_s, is_shut in ((-0.01, False), (0.25, True)):
        problem = gate(last_s + late_s)
        barred = is_barred(problem, problem.keep_out, DURATION_S, FINE_CELLS_RAD[:1])
        assert barred is is_shut


@pytest.mark.parametrize("cell_rad", [*CELLS_RAD, *FINE_CELLS_RAD])
def test_cells_called_inside_are_inside_all_over(cell_rad):
    """Held against sampled boresights by other code than the planner's."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        corner = rng.uniform(-3.0, 3.0, size=2)
        edges = [low + cell_rad * np.arange(41) for low in corner]
        axis = scipy_boresight(corner[None] + rng.uniform(0.0, 40.0 * cell_rad, size=(1, 2)))
        half_angle_rad = 15.0 * cell_rad
        view = KeepOutView(
            platform=ISS_HRC,
            cones=(
                MovingCone(
                    about="a direction",
                    half_angle_rad=half_angle_rad,
                    t_s=np.linspace(0.0, 1.0, 4),
                    axis_platform=np.tile(axis, (4, 1)),
                    counts_rad=np.ones(4),
                ),
            ),
        )
        (cone,) = cones_over(view, np.zeros(1), *edges)
        cells = np.argwhere(cone.inside(0, [slice(0, 40), slice(0, 40)]))
        assert len(cells) > 100
        for _ in range(10):
            angle = corner + cell_rad * (cells + rng.integers(0, 3, size=cells.shape) / 2.0)
            away = np.arccos(np.minimum(scipy_boresight(angle) @ axis[0], 1.0))
            assert away.max() <= half_angle_rad
