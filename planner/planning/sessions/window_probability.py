"""The probability in frame of the sessions that windows offer, before any of them is planned."""

from dataclasses import dataclass

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.base.effort import at_most
from planner.planning.opportunities import OpportunityRequest, Windows
from planner.planning.opportunities.scan_windows import scanned_path
from planner.planning.sessions.platforms.registry import HELD
from planner.world.frames.time_scales import Instants, shifted_utc


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

    As the budget of a plan of that session has it, on the branch that the window reports, or by the
    roll rule of a body; errors of the table itself are none.  Shape (windows,).  NaN where the
    camera images nothing, or there is no session, or no pair of angles throughout; and for the
    latest windows where there are more than 500, or fewer of a body whose attitude wanders quickly.
    """
    probability, held = np.full(len(windows), np.nan), HELD[request.platform.kind]
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    sessions_s = windows.sessions_s(request.start)
    with at_most(OPTIONS.most):
        for window in np.argsort(windows.rise_s, kind="stable"):
            row = int(windows.target[window])
            if request.targets[row].target.images and not np.isnan(sessions_s[window, 0]):
                target, roll = request.targets[row].target, request.targets[row].roll
                effort.charge(OPTIONS.window)
                start_s, stop_s = sessions_s[window]
                if windows.are_scans[window]:
                    path = scanned_path(request, windows, window)
                    target = path.starting(shifted_utc(request.start, start_s))
                    roll = request.roll_on_scans(row)
                t_s = np.linspace(start_s, stop_s, OPTIONS.instants)
                probability[window] = held(
                    request.platform,
                    request.law,
                    ephemeris,
                    target,
                    roll,
                    Instants(request.start, t_s),
                    int(windows.branch[window]),
                    OPTIONS.every,
                )
    return probability
