"""Unreachable ends are those of closed forms, and cells are inside that are said to be."""

import math

import numpy as np
import pytest
import ruckig
from keep_out_cases import LIMITS, draw_cases
from scipy_boresight import scipy_boresight

from planner.motion.detour.infeasibility_proof import OPTIONS as PROOF_OPTIONS
from planner.motion.detour.infeasibility_proof import angle_tube, cones_over, is_unreachable
from planner.motion.pointing.keep_out import KeepOutView, MovingCone
from planner.motion.slew import AxisState, SlewProblem
from planner.motion.slew.closed_forms import quickest_profile
from planner.motion.slew.solution import obeys
from planner.world.platforms import ISS_HRC

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
    # Cells cut at what is in reach leak no way, but the gate may open between instants 0.1 s apart.
    for late_s, is_shut in ((-0.01, False), (0.1, True)):
        problem = gate(last_s + late_s)
        barred = is_unreachable(
            problem, problem.keep_out, DURATION_S, PROOF_OPTIONS.fine_cells_rad[:1]
        )
        assert barred is is_shut


@pytest.mark.parametrize("cell_rad", [*PROOF_OPTIONS.cells_rad, *PROOF_OPTIONS.fine_cells_rad])
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
        (cone,) = cones_over(view, np.zeros(1), cell_rad, cell_rad)
        cells = np.argwhere(cone.proven_inside(0, edges))
        assert len(cells) > 100
        for _ in range(10):
            angle = corner + cell_rad * (cells + rng.integers(0, 3, size=cells.shape) / 2.0)
            away = np.arccos(np.minimum(scipy_boresight(angle) @ axis[0], 1.0))
            assert away.max() <= half_angle_rad


def reached_by_ruckig(state, t_s):
    """Angle at t_s of the quickest way to the greatest rate, which is then kept."""
    request, trajectory = ruckig.InputParameter(1), ruckig.Trajectory(1)
    request.control_interface = ruckig.ControlInterface.Velocity
    request.current_position = [state.angle_rad]
    request.current_velocity = [state.rate_rad_s]
    request.current_acceleration = [state.acceleration_rad_s2]
    request.target_velocity = [LIMITS.rate_max_rad_s]
    request.target_acceleration = [0.0]
    request.max_acceleration = [LIMITS.acceleration_max_rad_s2]
    request.max_jerk = [LIMITS.jerk_max_rad_s3]
    assert ruckig.Ruckig(1).calculate(request, trajectory) == ruckig.Result.Working
    since_s = np.minimum(t_s, trajectory.duration)
    angle = np.array([trajectory.at_time(at)[0][0] for at in since_s])
    return angle + LIMITS.rate_max_rad_s * (t_s - since_s)


@pytest.mark.parametrize("rate_deg_s", [-3.0, -0.5, 0.0, 2.2])
@pytest.mark.parametrize("acceleration_deg_s2", [-0.4, 0.0, 0.9])
def test_the_farthest_that_can_be_reached_is_what_ruckig_reaches(rate_deg_s, acceleration_deg_s2):
    if rate_deg_s == -3.0:
        acceleration_deg_s2 = abs(acceleration_deg_s2)
    start = AxisState(
        angle_rad=-2.0,
        rate_rad_s=math.radians(rate_deg_s),
        acceleration_rad_s2=math.radians(acceleration_deg_s2),
    )
    t_s = np.linspace(0.0, 40.0, 401)
    low, high = angle_tube(t_s, start, AxisState(angle_rad=-2.0), LIMITS)
    early = t_s < 12.0  # what the end allows comes in later
    reached = reached_by_ruckig(start, t_s)
    np.testing.assert_allclose(high[early], reached[early], rtol=0, atol=1e-9)  # Ruckig's own
    mirrored_low = angle_tube(t_s, start.mirror_image(), AxisState(angle_rad=2.0), LIMITS)[0]
    np.testing.assert_allclose(mirrored_low, -high, rtol=0, atol=1e-12)  # rounding
    backwards = angle_tube(t_s, AxisState(angle_rad=-2.0), start.backwards(), LIMITS)
    np.testing.assert_allclose(backwards[:, ::-1], [low, high], rtol=0, atol=1e-12)


def test_no_slew_leaves_what_is_called_within_reach():
    """Quickest slews come nearest to its edge."""
    rng = np.random.default_rng(3)
    looked_at = 0
    for _ in range(300):
        start, end = (
            AxisState(
                angle_rad=rng.uniform(-2.9, 2.9),
                rate_rad_s=rng.uniform(-1.0, 1.0) * LIMITS.rate_max_rad_s,
                acceleration_rad_s2=rng.uniform(-0.5, 0.5) * LIMITS.acceleration_max_rad_s2,
            )
            for _ in range(2)
        )
        profile = quickest_profile(start, end, LIMITS)
        if profile is None or not obeys(profile, start, end, LIMITS):
            continue
        looked_at += 1
        t_s = np.linspace(0.0, profile.duration_s, 200)
        angle = profile.evaluate(t_s)[0]
        low, high = angle_tube(t_s, start, end, LIMITS)
        assert (low - 1e-9 <= angle).all()  # rounding
        assert (angle <= high + 1e-9).all()
    assert looked_at > 100


def test_a_way_too_narrow_by_a_hundredth_of_a_degree_is_proven_shut():
    """Both axes, as quick as they can be, meet the cone where it leaves least of the angles."""
    *_, case = draw_cases(12, 15)
    problem = case.problem
    assert is_unreachable(problem, problem.keep_out, problem.duration_s, PROOF_OPTIONS.cells_rad)
