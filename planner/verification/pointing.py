"""Whether the boresight stays on the target, at the rows and between them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planner.arrays import Array
from planner.commands import CommandTable
from planner.frames.time_scales import Instants
from planner.orbits import Ephemeris
from planner.scenario import Scenario
from planner.targets import EarthFixedTarget, SkyTarget
from planner.verification.carrier import payload_eci
from planner.verification.earth_fixed import EarthFixedSight, earth_fixed_sight
from planner.verification.nearness import EXACT_RAD, allowed_rad, nearness_findings, off_target
from planner.verification.report import (
    EarthFixedView,
    Finding,
    Limit,
    SessionReport,
    SkyView,
)
from planner.verification.session import TableSession, session_report, table_session
from planner.verification.sky import LIMB_MODEL_SHARE, SkyDirection, sky_sight

ELEVATION_TOLERANCE_RAD = 1e-7  # a carrier, or a limb, 0.1 m lower at 1000 km


@dataclass(frozen=True, eq=False)
class _Held:
    """boresight_eci: unit vectors, shape (n, 3).  error_rad: off the apparent target, (n,)."""

    boresight_eci: Array
    error_rad: Array


def ground_session(
    table: CommandTable,
    scenario: Scenario,
    ephemeris: Ephemeris,
    number: int,
    target: EarthFixedTarget,
    rows: range,
) -> tuple[SessionReport, tuple[Finding, ...]]:
    """The session of that number, its target held over rows that the table has."""
    flown = table_session(table, number, rows)
    instants = Instants(flown.epoch_utc, flown.t_s)
    states = ephemeris.states(instants)
    sight = earth_fixed_sight(target, instants, states)
    boresight_eci = payload_eci(scenario, flown.angle_rad, instants, states)
    held = _Held(boresight_eci, _apart_rad(sight.apparent_eci, boresight_eci))
    view = _earth_fixed_view(flown, sight, held)
    exact_rad = np.full_like(held.error_rad, EXACT_RAD)
    report = session_report(
        table,
        scenario,
        flown,
        held.error_rad,
        view,
        allowed_rad=allowed_rad(scenario, number),
        off_target=off_target(flown, held.error_rad, exact_rad),
    )
    return report, (
        *_ground_findings(flown, sight, held, report.allowed_rad, view, target),
        *nearness_findings(report),
    )


def sky_session(
    table: CommandTable,
    scenario: Scenario,
    ephemeris: Ephemeris,
    number: int,
    target: SkyTarget,
    rows: range,
) -> tuple[SessionReport, tuple[Finding, ...]]:
    """As `ground_session`.

    Where the air of the limb bends the light, the pointing error may be larger by
    `LIMB_MODEL_SHARE` of the bending, and the clearance smaller.
    """
    flown = table_session(table, number, rows)
    instants = Instants(flown.epoch_utc, flown.t_s)
    states = ephemeris.states(instants)
    sight = sky_sight(target, instants, states)
    boresight_eci = payload_eci(scenario, flown.angle_rad, instants, states)
    error_rad = _apart_rad(sight.apparent_eci, boresight_eci)
    lowest = int(np.argmin(sight.clearance_rad))
    nearest_m = float(sight.range_m.min())
    view = SkyView(
        limb_clearance_min_rad=float(sight.clearance_rad[lowest]),
        limb_clearance_min_utc=flown.utc(lowest),
        range_min_m=nearest_m if math.isfinite(nearest_m) else None,
        refraction_max_rad=float(sight.bending_rad.max()),
    )
    model_rad = LIMB_MODEL_SHARE * sight.bending_rad
    report = session_report(
        table,
        scenario,
        flown,
        error_rad,
        view,
        allowed_rad=allowed_rad(scenario, number),
        off_target=off_target(flown, error_rad, EXACT_RAD + model_rad),
    )
    return report, (
        *_sky_findings(flown, sight, error_rad, report.allowed_rad + model_rad, target),
        *nearness_findings(report),
    )


def _apart_rad(apparent_eci: Array, boresight_eci: Array) -> Array:
    across = np.linalg.norm(np.cross(apparent_eci, boresight_eci), axis=1)
    return np.asarray(np.arctan2(across, np.sum(apparent_eci * boresight_eci, axis=1)))


def _earth_fixed_view(flown: TableSession, sight: EarthFixedSight, held: _Held) -> EarthFixedView:
    lowest, nearest = int(np.argmin(sight.elevation_rad)), int(np.argmin(sight.range_m))
    on_ground_m = _miss_on_ground_m(sight, held) if sight.elevation_rad[lowest] > 0.0 else None
    return EarthFixedView(
        elevation_min_rad=float(sight.elevation_rad[lowest]),
        elevation_min_utc=flown.utc(lowest),
        range_min_m=float(sight.range_m[nearest]),
        range_min_utc=flown.utc(nearest),
        range_max_m=float(sight.range_m.max()),
        miss_across_max_m=float(np.max(sight.range_m * np.sin(held.error_rad))),
        miss_on_ground_max_m=on_ground_m,
    )


def _miss_on_ground_m(sight: EarthFixedSight, held: _Held) -> float:
    """To first order: the miss across, carried along the line of sight to the horizontal plane."""
    los, up = sight.apparent_eci, sight.up_eci
    miss = held.boresight_eci - los
    drop = np.sum(miss * up, axis=1) / np.sum(los * up, axis=1)
    on_ground = miss - drop[:, None] * los
    return float(np.max(sight.range_m * np.linalg.norm(on_ground, axis=1)))


def _ground_findings(
    flown: TableSession,
    sight: EarthFixedSight,
    held: _Held,
    allowed_rad: float,
    view: EarthFixedView,
    target: EarthFixedTarget,
) -> Iterator[Finding]:
    worst = int(np.argmax(held.error_rad))
    if not held.error_rad[worst] <= allowed_rad:
        off = (
            f"{_arcsec(held.error_rad[worst]):.3f} arcsec "
            f"({view.miss_across_max_m:.2f} m across the line of sight)"
        )
        yield _error(flown, "pointing", worst, _off_target(off, allowed_rad))
    elevation_short_rad = math.radians(target.min_elevation_deg) - view.elevation_min_rad
    if elevation_short_rad > ELEVATION_TOLERANCE_RAD:
        yield _error(
            flown,
            "elevation",
            int(np.argmin(sight.elevation_rad)),
            f"the carrier stands {math.degrees(view.elevation_min_rad):.3f} deg high "
            f"at the target, less than {target.min_elevation_deg:.3f} deg",
        )
    if sight.hidden.any():
        yield _error(
            flown,
            "occlusion",
            int(np.argmax(sight.hidden)),
            "the Earth stands between the carrier and the target",
        )


def _sky_findings(
    flown: TableSession,
    sight: SkyDirection,
    error_rad: Array,
    allowed_rad: Array,
    target: SkyTarget,
) -> Iterator[Finding]:
    worst = int(np.argmax(error_rad - allowed_rad))
    if not error_rad[worst] <= allowed_rad[worst]:
        off = f"{_arcsec(error_rad[worst]):.3f} arcsec"
        yield _error(flown, "pointing", worst, _off_target(off, float(allowed_rad[worst])))
    short_rad = -sight.clearance_rad - LIMB_MODEL_SHARE * sight.bending_rad
    lowest = int(np.argmax(short_rad))
    if not short_rad[lowest] <= ELEVATION_TOLERANCE_RAD:
        yield _error(
            flown,
            "occlusion",
            lowest,
            f"the target stands {-math.degrees(sight.clearance_rad[lowest]):.3f} deg below the "
            f"Earth's limb, {target.grazing_altitude_km:g} km above the ellipsoid",
        )


def _off_target(off: str, allowed_rad: float) -> str:
    return f"the boresight is {off} off the target, more than {_arcsec(allowed_rad):.1f} arcsec"


def _error(flown: TableSession, limit: Limit, index: int, what: str) -> Finding:
    return Finding(
        severity="error",
        limit=limit,
        axis=None,
        t_s=float(flown.t_s[index]),
        at_utc=flown.utc(index),
        detail=f"sessions.{flown.number}: {what}",
    )


def _arcsec(angle_rad: float) -> float:
    return math.degrees(angle_rad) * 3600.0
