"""Does the boresight stay on the target through a session, at the rows and between them?"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from planner.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.frames.time_scales import Instants, shifted_utc
from planner.scenario import Scenario
from planner.targets import EarthFixedTarget
from planner.verification.carrier import boresight_platform, eci_from_platform
from planner.verification.earth_fixed import EarthFixedSight, earth_fixed_sight
from planner.verification.limits import axis_hermite, slow_stretches
from planner.verification.report import (
    EarthFixedView,
    Finding,
    PointingError,
    SessionReport,
)

POINTS_PER_CELL = 4  # the row, and three: a Hermite errs like u^2 (1-u)^2, most in the middle
POINTING_ERROR_MAX_RAD = math.radians(0.1 / 3600.0)  # a seventh of a pixel of the HRC
ELEVATION_TOLERANCE_RAD = 1e-7  # a carrier 0.1 m lower at 1000 km


@dataclass(frozen=True, eq=False)
class _Judged:
    """A session at n instants, every `POINTS_PER_CELL`th one a row.

    t_s: since the table's epoch; error_rad: between boresight and apparent target: shape (n,).
    boresight_eci: unit vectors, shape (n, 3).
    """

    t_s: NDArray[np.float64]
    error_rad: NDArray[np.float64]
    boresight_eci: NDArray[np.float64]
    sight: EarthFixedSight


def session_report(
    table: CommandTable, scenario: Scenario, number: int, target: EarthFixedTarget, rows: range
) -> tuple[SessionReport, tuple[Finding, ...]]:
    """The session of that number, its target held over rows that the table has."""
    judged = _judged(table, scenario, target, rows)
    epoch_utc = table.epoch_utc
    is_row = np.arange(len(judged.t_s)) % POINTS_PER_CELL == 0
    report = SessionReport(
        number=number,
        start_utc=shifted_utc(epoch_utc, rows[0] / ROWS_PER_S),
        stop_utc=shifted_utc(epoch_utc, rows[-1] / ROWS_PER_S),
        at_rows=_pointing_error(judged, is_row, epoch_utc),
        between_rows=_pointing_error(judged, ~is_row, epoch_utc),
        overall=_pointing_error(judged, np.ones_like(is_row), epoch_utc),
        view=_view(judged, epoch_utc),
        slow_stretches=tuple(
            stretch
            for column, (axis, limits) in enumerate(
                zip(scenario.platform.axis_names, scenario.axis_limits, strict=True)
            )
            for stretch in slow_stretches(
                axis, axis_hermite(table, column), limits.rate_min_rad_s, rows, epoch_utc
            )
        ),
    )
    return report, tuple(_findings(report, judged, target, epoch_utc))


def _judged(
    table: CommandTable, scenario: Scenario, target: EarthFixedTarget, rows: range
) -> _Judged:
    cells = len(rows) - 1
    points = np.arange(POINTS_PER_CELL * cells + 1)
    t_s = (POINTS_PER_CELL * rows[0] + points) / (ROWS_PER_S * POINTS_PER_CELL)
    cell = np.minimum(points // POINTS_PER_CELL, cells - 1)
    u_s = (points - POINTS_PER_CELL * cell) * (COMMAND_STEP_S / POINTS_PER_CELL)
    angle_rad = np.stack(
        [axis_hermite(table, k).angle_at(rows[0] + cell, u_s) for k in range(2)], axis=1
    )

    instants = Instants(table.epoch_utc, t_s)
    ephemeris = scenario.orbit.ephemeris(
        shifted_utc(table.epoch_utc, float(t_s[0])), shifted_utc(table.epoch_utc, float(t_s[-1]))
    )
    states = ephemeris.states(instants)
    sight = earth_fixed_sight(target, instants, states)
    boresight_eci = eci_from_platform(
        boresight_platform(scenario.platform, angle_rad),
        scenario.platform,
        scenario.attitude,
        instants,
        states,
    )
    across = np.linalg.norm(np.cross(sight.apparent_eci, boresight_eci), axis=1)
    along = np.sum(sight.apparent_eci * boresight_eci, axis=1)
    return _Judged(t_s, np.arctan2(across, along), boresight_eci, sight)


def _pointing_error(
    judged: _Judged, chosen: NDArray[np.bool_], epoch_utc: datetime
) -> PointingError:
    error_rad, t_s = judged.error_rad[chosen], judged.t_s[chosen]
    worst = int(np.argmax(error_rad))
    return PointingError(
        max_rad=float(error_rad[worst]),
        rms_rad=float(np.sqrt(np.mean(error_rad**2))),
        max_t_s=float(t_s[worst]),
        max_utc=shifted_utc(epoch_utc, float(t_s[worst])),
    )


def _view(judged: _Judged, epoch_utc: datetime) -> EarthFixedView:
    sight = judged.sight
    lowest, nearest = int(np.argmin(sight.elevation_rad)), int(np.argmin(sight.range_m))
    on_ground_m = _miss_on_ground_m(judged) if sight.elevation_rad[lowest] > 0.0 else None
    return EarthFixedView(
        elevation_min_rad=float(sight.elevation_rad[lowest]),
        elevation_min_utc=shifted_utc(epoch_utc, float(judged.t_s[lowest])),
        range_min_m=float(sight.range_m[nearest]),
        range_min_utc=shifted_utc(epoch_utc, float(judged.t_s[nearest])),
        range_max_m=float(sight.range_m.max()),
        miss_across_max_m=float(np.max(sight.range_m * np.sin(judged.error_rad))),
        miss_on_ground_max_m=on_ground_m,
    )


def _miss_on_ground_m(judged: _Judged) -> float:
    """To first order: the miss across, carried along the line of sight to the horizontal plane."""
    los, up = judged.sight.apparent_eci, judged.sight.up_eci
    miss = judged.boresight_eci - los
    drop = np.sum(miss * up, axis=1) / np.sum(los * up, axis=1)
    on_ground = miss - drop[:, None] * los
    return float(np.max(judged.sight.range_m * np.linalg.norm(on_ground, axis=1)))


def _findings(
    report: SessionReport, judged: _Judged, target: EarthFixedTarget, epoch_utc: datetime
) -> Iterator[Finding]:
    where = f"sessions.{report.number}"
    error = report.overall
    if not error.max_rad <= POINTING_ERROR_MAX_RAD:
        yield Finding(
            severity="error",
            limit="pointing",
            axis=None,
            t_s=error.max_t_s,
            at_utc=error.max_utc,
            detail=(
                f"{where}: the boresight is {math.degrees(error.max_rad) * 3600.0:.3f} arcsec "
                f"({report.view.miss_across_max_m:.2f} m across the line of sight) off the target, "
                f"more than {math.degrees(POINTING_ERROR_MAX_RAD) * 3600.0:.1f} arcsec"
            ),
        )
    view = report.view
    elevation_short_rad = math.radians(target.min_elevation_deg) - view.elevation_min_rad
    if elevation_short_rad > ELEVATION_TOLERANCE_RAD:
        yield Finding(
            severity="error",
            limit="elevation",
            axis=None,
            t_s=float(judged.t_s[np.argmin(judged.sight.elevation_rad)]),
            at_utc=view.elevation_min_utc,
            detail=(
                f"{where}: the carrier stands {math.degrees(view.elevation_min_rad):.3f} deg high "
                f"at the target, less than {target.min_elevation_deg:.3f} deg"
            ),
        )
    if judged.sight.hidden.any():
        hidden_s = float(judged.t_s[np.argmax(judged.sight.hidden)])
        yield Finding(
            severity="error",
            limit="occlusion",
            axis=None,
            t_s=hidden_s,
            at_utc=shifted_utc(epoch_utc, hidden_s),
            detail=f"{where}: the Earth stands between the carrier and the target",
        )
