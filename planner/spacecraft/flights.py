"""The session's table flown closed loop, and the camera's steadiness in each imaging interval."""

from collections.abc import Callable, Sequence

import numpy as np

from planner.base.arrays import Array
from planner.base.at_once import done_at_once
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.inflight.simulation.gyros.dispersed import camera_on, draw_dispersion, fly_table
from planner.inflight.simulation.gyros.report import worst_of
from planner.inflight.simulation.gyros.steadiness import rate_errors, steadiness_figures
from planner.spacecraft.found import ImagingSteadiness, StabilisationReport
from planner.spacecraft.vehicle import AgileSpacecraft
from planner.spacecraft.verification import VerifiedWindow
from planner.world.orbits.ephemeris import OrbitStates

ACROSS_AXES = [0, 2]  # of the body, across the optical axis
ASSUMPTIONS = (
    "gimbal servo 50 rad/s, damping 0.7 (the paper gives the form, no numbers)",
    "flexible modes 2.0, 2.1, 3.4, 5.5, 9.5 Hz with 5, 5, 3, 1, 0.5 % of the inertia, damping "
    "0.005 (the paper: about 2 Hz for the solar arrays, modes up to 10 Hz)",
    "dispersions: frequency +-20 %, coupling x0.5-1.5, damping x0.5-2, inertia +-1 %",
    "gimbal execution error +-(1 % + 0.0069 deg/s), both constant in a run, uniformly drawn",
    "gimbal angles read to 1 arcsec and fed back to the gimbal rates",
    "rotor drives disturb with 1 mN m at 0.3-3 Hz",
    "gyro noise 5e-5 deg/s a sample, bias 1e-5 deg/s, scale 2e-5; star trackers 5 arcsec, "
    "once a second, used between imaging intervals only",
    "control gains 2.0 1/s and 0.5 1/s^2, Butterworth 1.1 Hz on the rate error, feed-forward "
    "from the table; commands act at the tick they are measured at (see gains.delay_ticks)",
    "gravity gradient is the only external torque",
    "32 TDI lines set the exposure the smear is counted over",
    "light time and aberration (16 m on the ground, alike for all points) are left out",
)


def stabilisation(
    spacecraft: AgileSpacecraft,
    table: CommandTable,
    windows: Sequence[VerifiedWindow],
    states: OrbitStates,
    seeds: Sequence[int],
    tell: Callable[[int], None],
) -> StabilisationReport:
    """Fly the table closed loop, a dispersed run a seed, and summarise the runs.

    states: the orbit at the table's rows.  tell: is called with how many are flown.
    """
    craft, camera = spacecraft.craft, spacecraft.body.camera
    assert camera.type == "pushbroom"  # as of the file
    tdi_lines, before_rows = camera.tdi_lines, [0, *(one.last_row for one in windows)]
    spans = [(one.first_row, one.last_row) for one in windows]
    imaging = camera_on(spans, len(table.position))

    def run_figures(seed: int) -> Array:
        """A row for each interval: as `worst_of` reads them, and the smear."""
        log = fly_table(craft, table, imaging, states, draw_dispersion(craft, seed))
        rows = []
        for window, interval, before_row in zip(windows, spans, before_rows, strict=False):
            across_rad_s = np.linalg.norm(rate_errors(log, *interval)[:, ACROSS_AXES], axis=1).max()
            figures = steadiness_figures(
                log, craft.array, table.rate_rad_s, *interval, since_row=before_row
            )
            rows.append(np.append(figures, across_rad_s * window.passing_s * tdi_lines))
        return np.array(rows)

    runs: list[Array] = []
    for one in done_at_once(run_figures, seeds):
        runs.append(one)
        tell(len(runs))
    if not runs or not windows:
        return StabilisationReport(runs=len(runs), windows=(), share_steady=None, worst_rad_s=None)
    numbers = np.array(runs)  # (runs, intervals, figures)
    told = []
    held_n_m_s = spacecraft.gyros.turns.momentum_max_n_m_s
    for k, window in enumerate(windows):
        gyros = worst_of(numbers[:, k, :-1])
        assert gyros is not None  # it has some
        told.append(
            ImagingSteadiness(
                **vars(gyros) | {"steady": gyros.steady == 1.0},
                request=window.request,
                look=window.look,
                settled_s=(window.first_row - before_rows[k]) * COMMAND_STEP_S - gyros.spare_s,
                smear_px=float(numbers[:, k, -1].max()),
                momentum_margin_n_m_s=held_n_m_s - gyros.momentum_max_n_m_s,
            )
        )
    return StabilisationReport(
        runs=len(runs),
        windows=tuple(told),
        share_steady=float(numbers[:, :, 0].mean()),
        worst_rad_s=float(max(np.max(one.rate_error_rad_s) for one in told)),
    )
