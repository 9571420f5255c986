"""The probability in frame of the sessions that windows offer, before any of them is planned."""

from dataclasses import dataclass

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.base.effort import at_most
from planner.motion.pointing.angles import axis_angles
from planner.motion.pointing.line_of_sight import line_of_sight
from planner.planning.opportunities import OpportunityRequest, Windows
from planner.planning.sessions.uncertainty import OPTIONS as BUDGET
from planner.planning.sessions.uncertainty import PointingScene, error_biases, stay_probability
from planner.world.attitude import Attitude
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.platforms import TwoAxisPlatform
from planner.world.targets import VisibleTarget


@dataclass(frozen=True, kw_only=True)
class WindowProbabilityOptions:
    """How a window's probability is found."""

    instants: int = 61  # of a session: 10 s apart in a pass, at which axes turn by 10 deg
    every: int = 4  # one of so many draws: good to 0.006
    window: float = 600.0  # of `effort`
    most: float = 300_000.0  # of `effort`: three seconds beside the search


OPTIONS = WindowProbabilityOptions()


def probabilities_in_frame(request: OpportunityRequest, windows: Windows) -> Array:
    """That the target stays in the camera's frame over the longest session of each window.

    As the budget of a plan of that session has it, on the branch that the window reports; errors of
    the table itself are none.  Shape (windows,).  NaN where there is no session, or no pair of
    angles throughout; for the latest windows where there are more than 500; and of a body, whose
    plan's budget tells it.
    """
    platform, probability = request.platform, np.full(len(windows), np.nan)
    if not isinstance(platform, TwoAxisPlatform):
        return probability
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    sessions_s = windows.sessions_s(request.start)
    with at_most(OPTIONS.most):
        for window in np.argsort(windows.rise_s, kind="stable"):
            if not np.isnan(sessions_s[window, 0]):
                effort.charge(OPTIONS.window)
                start_s, stop_s = sessions_s[window]
                t_s = np.linspace(start_s, stop_s, OPTIONS.instants)
                probability[window] = _session_probability(
                    platform,
                    request.law,
                    ephemeris,
                    request.targets[windows.target[window]].target,
                    Instants(request.start, t_s),
                    int(windows.branch[window]),
                )
    return probability


def _session_probability(
    platform: TwoAxisPlatform,
    attitude: Attitude,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    instants: Instants,
    branch: int,
) -> float:
    los = line_of_sight(instants, ephemeris, attitude, platform.q_platform_from_body, target)
    angle_rad = axis_angles(platform, los.los_platform).angle_rad[branch]
    if not np.isfinite(angle_rad).all():
        return np.nan
    scene = PointingScene(los, attitude, target, platform, angle_rad, BUDGET.samples)
    errors = attitude.errors(scene.instants)
    biases = error_biases(scene, los, ephemeris, errors, BUDGET.clock_s)
    return stay_probability(biases, scene, platform, OPTIONS.every)
