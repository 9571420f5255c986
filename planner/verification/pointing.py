"""Pointing errors of the boresight from its target, at the rows and between them."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from planner.base.arrays import Array
from planner.verification.cadence import cadence_findings, cadence_margins
from planner.verification.conditions import condition_findings, condition_margins
from planner.verification.directions import apart_rad
from planner.verification.earth_fixed import EarthFixedSight, earth_fixed_sight
from planner.verification.report import Finding, OffTarget, SessionReport
from planner.verification.session import TableSession
from planner.verification.sky import LIMB_MODEL_SHARE, SkySight, sky_sight
from planner.verification.terrain import terrain_findings
from planner.world.frames.time_scales import utc_text
from planner.world.orbits import Ephemeris
from planner.world.targets import EarthFixedTarget, GroundPathTarget, SkyTarget

EXACT_RAD = math.radians(0.1 / 3600.0)  # a seventh of a pixel of the HRC
ELEVATION_TOLERANCE_RAD = 1e-7  # a carrier, or a limb, 0.1 m lower at 1000 km


def pointing_session(
    flight: TableSession, ephemeris: Ephemeris, target: EarthFixedTarget | SkyTarget
) -> tuple[SessionReport, tuple[Finding, ...]]:
    """The session, its target held.

    Where the air of the limb bends the light, the pointing error may be larger by
    `LIMB_MODEL_SHARE` of the bending, and the clearance smaller.
    """
    instants = flight.at.instants
    states = ephemeris.states(instants)
    boresight_eci = flight.judge.boresight_eci(flight.at, states)
    seen: EarthFixedSight | SkySight
    if isinstance(target, SkyTarget):
        seen = sky = sky_sight(target, instants, states)
        error_rad = apart_rad(sky.apparent_eci, boresight_eci)
        model_rad = LIMB_MODEL_SHARE * sky.bending_rad
        report = _seen_in_the_sky(_report(flight, error_rad, model_rad), flight, sky)
        findings = _sky_findings(flight, sky, target)
    else:
        seen = sight = earth_fixed_sight(target, instants, states)
        error_rad = apart_rad(sight.apparent_eci, boresight_eci)
        model_rad = np.zeros_like(error_rad)
        report = _seen_on_the_earth(
            _report(flight, error_rad, model_rad), flight, sight, boresight_eci, error_rad
        )
        findings = _ground_findings(flight, sight, target)
    pointing = _pointing_findings(flight, error_rad, model_rad, report)
    own = flight.judge.session_findings(flight.number, flight.at, states)
    margins = condition_margins(flight, states, seen)
    cadence = tuple(cadence_margins(flight, states))
    unmet = (*condition_findings(flight, margins), *cadence_findings(flight, cadence))
    report = replace(report, conditions=(*margins, *cadence))
    return report, (*pointing, *findings, *unmet, *own, *_nearness_findings(report))


def _report(flight: TableSession, error_rad: Array, model_rad: Array) -> SessionReport:
    return flight.report(
        error_rad,
        allowed_rad=_allowed_rad(flight),
        off_target=_off_target(flight, error_rad, EXACT_RAD + model_rad),
    )


def _allowed_rad(flight: TableSession) -> float:
    """0.1 arcsec, or the circle inside the frame where the session is content with that."""
    if flight.scenario.sessions[flight.number].keyhole == "nearest":
        return max(EXACT_RAD, min(flight.scenario.platform.frame_half_rad))
    return EXACT_RAD


def _seen_in_the_sky(report: SessionReport, flight: TableSession, sky: SkySight) -> SessionReport:
    lowest, nearest_m = int(np.argmin(sky.clearance_rad)), float(sky.range_m.min())
    return replace(
        report,
        limb_clearance_min_rad=float(sky.clearance_rad[lowest]),
        limb_clearance_min_at_utc=flight.utc(lowest),
        range_min_m=nearest_m if math.isfinite(nearest_m) else None,
        refraction_max_rad=float(sky.bending_rad.max()),
    )


def _seen_on_the_earth(
    report: SessionReport,
    flight: TableSession,
    sight: EarthFixedSight,
    boresight_eci: Array,
    error_rad: Array,
) -> SessionReport:
    lowest, highest = int(np.argmin(sight.elevation_rad)), int(np.argmax(sight.elevation_rad))
    nearest = int(np.argmin(sight.range_m))
    is_up = sight.elevation_rad[lowest] > 0.0
    return replace(
        report,
        ground_max_m=_miss_on_ground_m(sight, boresight_eci) if is_up else None,
        across_max_m=float(np.max(sight.range_m * np.sin(error_rad))),
        elevation_min_rad=float(sight.elevation_rad[lowest]),
        elevation_min_utc=flight.utc(lowest),
        elevation_max_rad=float(sight.elevation_rad[highest]),
        elevation_max_utc=flight.utc(highest),
        range_min_m=float(sight.range_m[nearest]),
        closest_at_utc=flight.utc(nearest),
        range_max_m=float(sight.range_m.max()),
    )


def _miss_on_ground_m(sight: EarthFixedSight, boresight_eci: Array) -> float:
    """To first order: the miss across, carried along the line of sight to the horizontal plane."""
    los, up = sight.apparent_eci, sight.up_eci
    miss = boresight_eci - los
    drop = np.sum(miss * up, axis=1) / np.sum(los * up, axis=1)
    on_ground = miss - drop[:, None] * los
    return float(np.max(sight.range_m * np.linalg.norm(on_ground, axis=1)))


def _pointing_findings(
    flight: TableSession, error_rad: Array, model_rad: Array, report: SessionReport
) -> Iterator[Finding]:
    allowed_rad = report.allowed_rad + model_rad
    worst = int(np.argmax(error_rad - allowed_rad))
    if not error_rad[worst] <= allowed_rad[worst]:
        across = ""
        if report.across_max_m is not None:
            across = f" ({report.across_max_m:.2f} m across the line of sight)"
        yield flight.error(
            "pointing",
            worst,
            f"the boresight is {_arcsec(error_rad[worst]):.3f} arcsec{across} off the target, more "
            f"than {_arcsec(float(allowed_rad[worst])):.1f} arcsec",
        )


def _ground_findings(
    flight: TableSession, sight: EarthFixedSight, target: EarthFixedTarget
) -> Iterator[Finding]:
    lowest = int(np.argmin(sight.elevation_rad))
    elevation_rad = float(sight.elevation_rad[lowest])
    if math.radians(target.min_elevation_deg) - elevation_rad > ELEVATION_TOLERANCE_RAD:
        yield flight.error(
            "elevation",
            lowest,
            f"the carrier stands {math.degrees(elevation_rad):.3f} deg high "
            f"at the target, less than {target.min_elevation_deg:.3f} deg",
        )
    if sight.hidden.any():
        yield flight.error(
            "occlusion",
            int(np.argmax(sight.hidden)),
            "the Earth stands between the carrier and the target",
        )
    if isinstance(target, GroundPathTarget):
        yield from terrain_findings(flight.number, target)


def _sky_findings(flight: TableSession, sky: SkySight, target: SkyTarget) -> Iterator[Finding]:
    short_rad = -sky.clearance_rad - LIMB_MODEL_SHARE * sky.bending_rad
    lowest = int(np.argmax(short_rad))
    if not short_rad[lowest] <= ELEVATION_TOLERANCE_RAD:
        yield flight.error(
            "occlusion",
            lowest,
            f"the target stands {-math.degrees(sky.clearance_rad[lowest]):.3f} deg below the "
            f"Earth's limb, {target.grazing_altitude_km:g} km above the ellipsoid",
        )


def _off_target(flight: TableSession, error_rad: Array, exact_rad: Array) -> tuple[OffTarget, ...]:
    """Where the error (n,) is larger than an exact track's (n,), good to the judged instants."""
    beyond = np.concatenate([[False], error_rad > exact_rad, [False]])
    edges = np.flatnonzero(np.diff(beyond)).reshape(-1, 2)
    last = len(error_rad) - 1
    return tuple(
        OffTarget(
            start_utc=flight.utc(max(int(start) - 1, 0)),
            stop_utc=flight.utc(min(int(stop), last)),
            max_rad=float(error_rad[start:stop].max()),
        )
        for start, stop in edges
    )


def _nearness_findings(report: SessionReport) -> Iterator[Finding]:
    """The warning that a session is tracked only nearly; nothing where it is tracked exactly."""
    if report.allowed_rad <= EXACT_RAD or not report.off_target:
        return
    stretches, share = report.off_target, report.max_rad / report.allowed_rad
    yield Finding(
        detail=(
            f"session {report.session + 1} is tracked as near as the limits allow: from "
            f"{utc_text(stretches[0].start_utc, 1)} to {utc_text(stretches[-1].stop_utc, 1)} the "
            f"boresight is up to {_arcsec(report.max_rad):.3g} arcsec off the target, at "
            f"{utc_text(report.max_at_utc, 1)} {share:.0%} of the way to the frame's nearest edge; "
            f"rms {_arcsec(report.rms_rad):.3g} arcsec over the session"
        ),
        severity="warning",
        limit="pointing",
        t_s=report.max_t_s,
        at_utc=report.max_at_utc,
    )


def _arcsec(angle_rad: float) -> float:
    return math.degrees(angle_rad) * 3600.0
