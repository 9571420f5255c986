"""The judge of a session: whether its table images what was asked; limits are the body's judge's.

It sees the table, the verdict on it and the request: no candidate, no slew, no solver.  Ground
points come from its own intersection of the optical axis with the ellipsoid.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from planner.base.answer_members import HalfTurn, Internal, Member, NotNegative, Signed, answer
from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.base.rotation import Rotation
from planner.base.table_motion import motion_at
from planner.spacecraft.requests import (
    AreaRequest,
    ImagingPlanRequest,
    ImagingWindow,
    Request,
    StereoRequest,
)
from planner.spacecraft.vehicle import AgileSpacecraft
from planner.verification.report import VerificationReport
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import WGS84_A_M, WGS84_F
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants, RowUtc, elapsed_s, shifted_utc
from planner.world.orbits import Ephemeris
from planner.world.targets.geojson import Position
from planner.world.targets.strips import places_itrf_m


@dataclass(frozen=True, kw_only=True)
class Tolerances:
    """By how much a table may differ from what was asked for and promised."""

    ground_m: float = 1.0  # of where a line lies on the ground
    speed: float = 1e-3  # of the scan's speed: 0.03 pixel over 32 TDI lines
    # of the swath: strips of full width side by side on a round Earth
    coverage: float = 1e-3
    drift_rad: float = 1e-4  # over 32 TDI lines: 0.003 pixel
    # the last part of a tick may scan past the arc's end and its limit
    angle_deg: float = 0.2
    row: float = 1e-6  # of times that lie on one


TOLERANCES = Tolerances()

SCANNED_PER_ROW = 4  # instants looked at for the line scanned
SCAN_END = 3 * SCANNED_PER_ROW  # instants among which the scan passes the line's end
INNER = slice(2, -2)  # without the ends, where differences are one-sided
OPTICAL_AXIS_BODY = (0.0, -1.0, 0.0)


@answer
class VerifiedWindow(ImagingWindow):
    """One stretch with the camera on, as the judge finds it on the ground.

    start_utc: first row; UTC.
    stop_utc: last row; UTC.
    scan_speed_m_s: of the scanned line over the ground, mean.
    speed_spread: largest deviation from the speed asked for, relative.
    drift_rad: largest angle between the detector's columns and the image's motion.
    miss_m: of the scanned line from that asked for, at its ends and across.
    along_deg: farthest the camera looks ahead or behind.
    across_deg: farthest the camera looks to the side.
    """

    start_utc: RowUtc
    stop_utc: RowUtc
    scan_speed_m_s: NotNegative
    speed_spread: NotNegative
    drift_rad: HalfTurn
    miss_m: NotNegative
    along_deg: Signed
    across_deg: Signed
    passing_s: Internal[float]  # in which as much ground is scanned as the camera is away


@answer
class SpacecraftVerification:
    """The verdict of a judge that sees the table and the request only; extremes between rows.

    Those of the motion and of the gyros are the plan's.

    passed: true when the table may be flown.
    findings: limits that break, in words. E.g.
    `["gimbal rate, deg/s: 58.1 exceeds 57.3"]`.
    rate_max_deg_s: largest rate about each body axis.
    torque_max_n_m: largest torque.
    momentum_max_n_m_s: largest momentum in the gyros.
    gimbal_rate_max_deg_s: of the fastest gimbal.
    gimbal_margin: least distance from a singularity of the gyros: the smallest singular value of
    their torque directions.
    momentum_mismatch_n_m_s: largest difference between what the gimbal angles hold and what the
    attitude needs.
    """

    passed: bool
    findings: tuple[str, ...]
    rate_max_deg_s: Annotated[Array, Member(least=0.0)]
    torque_max_n_m: NotNegative
    momentum_max_n_m_s: NotNegative
    gimbal_rate_max_deg_s: NotNegative
    gimbal_margin: NotNegative
    momentum_mismatch_n_m_s: NotNegative
    windows: Internal[tuple[VerifiedWindow, ...]]  # answers have them beside the verdict


def verify_table(
    table: CommandTable,
    report: VerificationReport,
    windows: tuple[ImagingWindow, ...],
    request: ImagingPlanRequest,
) -> SpacecraftVerification:
    """Judge whether a table of a body with gyros images what was asked.

    report: the verdict on the plan that has the table.
    """
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    session = _Session(table, windows, request, request.definition(), ephemeris)
    off_span = _span_findings(session)
    verified = () if off_span else tuple(_verified_window(session, window) for window in windows)
    findings = (
        *(finding.detail for finding in report.findings if finding.severity == "error"),
        *off_span,
        *(finding for window in verified for finding in _ground_findings(window, session)),
        *(() if off_span else _coverage_findings(session)),
    )
    rates_rad_s = [margin.extreme for margin in report.limits if margin.kind == "rate"]
    gyros = {margin.name: margin.extreme for margin in report.gyros}
    return SpacecraftVerification(
        passed=not findings,
        findings=findings,
        rate_max_deg_s=np.degrees(np.abs(rates_rad_s)),
        torque_max_n_m=gyros["torque"],
        momentum_max_n_m_s=gyros["momentum"],
        gimbal_rate_max_deg_s=gyros["gimbal_rate"],
        gimbal_margin=gyros["singularity"],
        momentum_mismatch_n_m_s=gyros["momentum_mismatch"],
        windows=verified,
    )


class _Session(NamedTuple):
    """A table, and what it is judged by."""

    table: CommandTable
    windows: tuple[ImagingWindow, ...]
    request: ImagingPlanRequest
    spacecraft: AgileSpacecraft
    ephemeris: Ephemeris


def _span_findings(session: _Session) -> tuple[str, ...]:
    """Whether the table holds the session, from its start to its last whole cycle."""
    request, table = session.request, session.table
    late_s = elapsed_s(table.epoch_utc, request.start)
    needed = int(elapsed_s(request.stop, request.start) * ROWS_PER_S + TOLERANCES.row)
    last = len(table.position) - 1
    if late_s == 0.0 and last == needed:
        return ()
    return (
        f"the table's rows 0 to {last} begin {late_s:+g} s from the session's start, which needs "
        f"rows 0 to {needed} from then on",
    )


class _View(NamedTuple):
    """The camera at n instants, (n, 3) each.

    r_ground_itrf_m: where the optical axis meets the ellipsoid raised by the ground's height.
    x_itrf, y_itrf: body axes.  los_lvlh: the optical axis.
    """

    r_sat_itrf_m: Array
    r_ground_itrf_m: Array
    x_itrf: Array
    y_itrf: Array
    los_lvlh: Array


def _view_at(session: _Session, t_s: Array, height_m: float) -> _View:
    instants = Instants(session.table.epoch_utc, t_s)
    states = session.ephemeris.states(instants)
    q_eci_from_body = Rotation.from_quat(motion_at(session.table, t_s).position)
    los_eci = q_eci_from_body.apply(OPTICAL_AXIS_BODY)
    q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
    c_itrf = c_itrf_from_eci(instants)
    r_sat_itrf_m, los_itrf, x_itrf = (
        np.einsum("nij,nj->ni", c_itrf, of_eci)
        for of_eci in (states.r_sat_eci_m, los_eci, q_eci_from_body.apply([1.0, 0.0, 0.0]))
    )
    scale = 1.0 / _semi_axes_m(height_m)  # the ellipsoid is scaled to a sphere
    o, d = r_sat_itrf_m * scale, los_itrf * scale
    dd, od = np.sum(d * d, axis=1), np.sum(o * d, axis=1)
    discriminant = np.maximum(od**2 - dd * (np.sum(o * o, axis=1) - 1.0), 0.0)
    range_m = (-od - np.sqrt(discriminant)) / dd
    r_ground_itrf_m = r_sat_itrf_m + range_m[:, None] * los_itrf
    return _View(r_sat_itrf_m, r_ground_itrf_m, x_itrf, -los_itrf, q_lvlh.apply(los_eci))


def _verified_window(session: _Session, window: ImagingWindow) -> VerifiedWindow:
    request = next(one for one in session.request.requests if one.name == window.request)
    instants = np.arange(window.first_row * SCANNED_PER_ROW, window.last_row * SCANNED_PER_ROW + 1)
    t_s = instants / (SCANNED_PER_ROW * ROWS_PER_S)
    view = _view_at(session, t_s, request.height_m)
    v_ground_m_s = np.gradient(view.r_ground_itrf_m, t_s, axis=0, edge_order=2)
    speed_m_s = np.linalg.norm(v_ground_m_s, axis=1)
    range_m = np.linalg.norm(view.r_ground_itrf_m - view.r_sat_itrf_m, axis=1)
    drift_rad = _drift_rad(view, v_ground_m_s)
    x, y, z = view.los_lvlh.T
    return VerifiedWindow(
        request=window.request,
        look=window.look,
        first_row=window.first_row,
        last_row=window.last_row,
        start_utc=shifted_utc(session.table.epoch_utc, window.first_row * COMMAND_STEP_S),
        stop_utc=shifted_utc(session.table.epoch_utc, window.last_row * COMMAND_STEP_S),
        scan_speed_m_s=float(np.mean(speed_m_s)),
        speed_spread=float(np.max(np.abs(speed_m_s[INNER] / request.scan_speed_m_s - 1.0))),
        drift_rad=float(np.max(drift_rad[INNER])),
        miss_m=_miss_m(request, window, view.r_ground_itrf_m),
        along_deg=float(np.rad2deg(np.max(np.abs(np.arctan2(x, z))))),
        across_deg=float(np.rad2deg(np.max(np.abs(np.arctan2(y, z))))),
        passing_s=float(np.mean(range_m) / np.mean(speed_m_s)),
    )


def _drift_rad(view: _View, v_ground_m_s: Array) -> Array:
    """Angle between X and the image's motion, seen across the optical axis, (n,)."""
    down = view.y_itrf * np.sum(v_ground_m_s * view.y_itrf, axis=1, keepdims=True)
    across_m_s = v_ground_m_s - down
    turned = np.linalg.norm(np.cross(view.x_itrf, across_m_s), axis=1)
    return np.asarray(np.arctan2(turned, np.abs(np.sum(view.x_itrf * across_m_s, axis=1))))


def _miss_m(request: Request, window: ImagingWindow, scanned_itrf_m: Array) -> float:
    """Largest of: the scan's start from the line's, the line's end from the scan, and off the
    plane of the arc.  Nothing for areas, whose coverage is looked at instead."""
    if isinstance(request, AreaRequest):
        return 0.0
    leg = window.look if request.mode == "corridor" else 0
    ends = request.geometry.coordinates[leg : leg + 2]
    start_itrf_m, end_itrf_m = places_itrf_m(ends, request.height_m)
    if np.dot(end_itrf_m - start_itrf_m, scanned_itrf_m[-1] - scanned_itrf_m[0]) < 0.0:
        start_itrf_m, end_itrf_m = end_itrf_m, start_itrf_m
    normal_itrf = np.cross(start_itrf_m, end_itrf_m)
    normal_itrf /= np.linalg.norm(normal_itrf)
    # The plane through the ellipsoid's centre isn't exactly that of the heights' ends: 0.1 m.
    off_plane_m = float(np.max(np.abs(scanned_itrf_m @ normal_itrf)))
    end_m = float(np.min(np.linalg.norm(scanned_itrf_m[-SCAN_END:] - end_itrf_m, axis=1)))
    spacing_m = request.scan_speed_m_s * COMMAND_STEP_S / SCANNED_PER_ROW
    start_m = float(np.linalg.norm(scanned_itrf_m[0] - start_itrf_m))
    return max(start_m, off_plane_m, end_m - spacing_m)


def _ground_findings(found: VerifiedWindow, session: _Session) -> Iterator[str]:
    spacecraft, off_deg = session.spacecraft, TOLERANCES.angle_deg
    drift_deg, drift_most_deg = np.degrees([found.drift_rad, TOLERANCES.drift_rad])
    for value, most, told in (
        (found.speed_spread, TOLERANCES.speed, "scan speed off by {:.3%}"),
        (drift_deg, drift_most_deg, "the image drifts by {:.4f} deg"),
        (found.miss_m, TOLERANCES.ground_m, "scans {:.2f} m beside the line asked for"),
        (found.along_deg, spacecraft.along_max_deg + off_deg, "{:.2f} deg along the track"),
        (found.across_deg, spacecraft.across_max_deg + off_deg, "{:.2f} deg across the track"),
    ):
        if value > most:
            yield f"{found.request!r} look {found.look}: {told.format(value)}"


def _coverage_findings(session: _Session) -> Iterator[str]:
    """Every request begun is completed: all legs, both looks, all strips of an area."""
    for request in session.request.requests:
        looks = [window for window in session.windows if window.request == request.name]
        if not looks:
            continue
        if isinstance(request, AreaRequest):
            short_m = _uncovered_m(session, looks, request)
            if short_m > TOLERANCES.coverage * session.spacecraft.swath_m:
                yield f"{request.name!r}: its edge lies {short_m:.1f} m outside the strips"
        else:
            count = 2 if request.mode == "stereo" else len(request.geometry.coordinates) - 1
            if len(looks) != count:
                yield f"{request.name!r}: {len(looks)} looks instead of {count}"
            elif isinstance(request, StereoRequest) and request.gap_s is not None:
                gap_s = (looks[1].first_row - looks[0].first_row) / ROWS_PER_S
                if abs(gap_s - request.gap_s) > 0.5 * COMMAND_STEP_S + 1e-6:
                    yield f"{request.name!r}: looks {gap_s:.1f} s apart, not {request.gap_s:g} s"


def _uncovered_m(session: _Session, looks: Sequence[ImagingWindow], request: AreaRequest) -> float:
    """How far an area's edge, where every strip ends, lies outside those scanned at most."""
    half_m = 0.5 * session.spacecraft.swath_m
    edge_itrf_m = np.concatenate(
        [_edge_itrf_m(ring, request, half_m / 4.0) for ring in request.geometry.coordinates]
    )
    outside_m = np.full(len(edge_itrf_m), np.inf)
    for look in looks:
        t_s = np.array([look.first_row, look.last_row]) / ROWS_PER_S
        start_itrf_m, end_itrf_m = _view_at(session, t_s, request.height_m).r_ground_itrf_m
        length_m = np.linalg.norm(end_itrf_m - start_itrf_m)
        along_itrf = (end_itrf_m - start_itrf_m) / length_m
        side_itrf = np.cross(start_itrf_m / np.linalg.norm(start_itrf_m), along_itrf)
        along_m = (edge_itrf_m - start_itrf_m) @ along_itrf
        beyond_m = np.maximum(np.maximum(-along_m, along_m - length_m), 0.0)
        aside_m = np.maximum(np.abs((edge_itrf_m - start_itrf_m) @ side_itrf) - half_m, 0.0)
        outside_m = np.minimum(outside_m, np.maximum(beyond_m, aside_m))
    return float(np.max(outside_m))


def _edge_itrf_m(ring: Sequence[Position], request: AreaRequest, step_m: float) -> Array:
    """Places on a ring, (n, 3), no further apart than a step; each side in the plane through its
    ends and the Earth's centre."""
    corners_itrf_m = places_itrf_m(ring, request.height_m)
    sides_m = np.linalg.norm(np.diff(corners_itrf_m, axis=0), axis=1)
    chord_itrf_m = np.concatenate(
        [
            np.linspace(start, end, math.ceil(side_m / step_m) + 1)
            for start, end, side_m in zip(corners_itrf_m, corners_itrf_m[1:], sides_m, strict=False)
        ]
    )
    scaled = chord_itrf_m / _semi_axes_m(request.height_m)
    return np.asarray(chord_itrf_m / np.linalg.norm(scaled, axis=1, keepdims=True))


def _semi_axes_m(height_m: float) -> Array:
    """Of the ellipsoid raised by a height, (3,)."""
    return np.array([WGS84_A_M, WGS84_A_M, WGS84_A_M * (1.0 - WGS84_F)]) + height_m
