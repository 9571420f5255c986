"""The judgement of a table: does it do what was asked, within the spacecraft's limits.

The judge sees the table and the request: no candidate, no profile, no solver.  Ground points
come from its own intersection of the optical axis with the ellipsoid.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.commands import ROWS_PER_S
from planner.frames.earth_orientation import c_itrf_from_eci
from planner.frames.geodesy import MU_EARTH_M3_S2, WGS84_A_M, WGS84_F, itrf_from_geodetic
from planner.frames.local_orbital import q_lvlh_from_eci
from planner.frames.time_scales import Instants
from planner.orbits import OrbitStates
from planner.spacecraft.requests import AreaRequest, ImagingPlanRequest, Request
from planner.spacecraft.table import TICK_S, AttitudeTable, ImagingWindow
from planner.spacecraft.vehicle.definition import AgileSpacecraft

StatesAt = Callable[[Instants], OrbitStates]
GROUND_TOLERANCE_M = 1.0
SPEED_TOLERANCE = 1e-3
COVERAGE_TOLERANCE = 1e-3  # of the swath: strips of full width side by side on a round Earth
DRIFT_TOLERANCE_RAD = 1e-4  # over 32 TDI lines: 0.003 pixel
KINEMATIC_TOLERANCE_RAD = 5e-6  # 1 arcsec: torque rate steps of 40 N m/s inside a row
MOMENTUM_TOLERANCE_N_M_S = 0.02
LIMIT_TOLERANCE = 2e-3  # relative: planned on rows, the quintic swings between them
ANGLE_TOLERANCE_DEG = 0.2  # the last part of a tick may scan past the arc's end and its limit
UNIT_TOLERANCE = 1e-9  # of a quaternion's length, and
GIMBAL_TOLERANCE_RAD = 1e-9  # of an angle: rounding, summed over a session
BETWEEN = 5  # instants looked at per row for the limits, and
ON_GROUND = 4  # for the line scanned
ENDS = slice(2, -2)  # without the ends, where differences are one-sided


@dataclass(frozen=True, kw_only=True)
class VerifiedWindow:
    """One imaging interval on the ground.

    scan_speed_m_s: mean over ground; speed_spread: largest deviation from the asked speed,
    relative.  drift_rad: largest angle between X and the image's motion.  miss_m: distance of
    the scanned line from the asked one (at its ends and across).  along_deg, across_deg:
    largest angles to the track.  line_time_s: one pixel at nadir resolution over the speed.
    """

    window: ImagingWindow
    scan_speed_m_s: float
    speed_spread: float
    drift_rad: float
    miss_m: float
    along_deg: float
    across_deg: float
    line_time_s: float


@dataclass(frozen=True, kw_only=True)
class TableExtremes:
    """Extremes of a table, between rows too.

    rate_deg_s per axis (3,), torque_n_m, momentum_n_m_s; gimbal_rate_deg_s; gimbal_margin,
    least singular value of D; momentum_mismatch_n_m_s, between what the gimbal angles hold
    and what the attitude needs.
    """

    rate_deg_s: Array
    torque_n_m: float
    momentum_n_m_s: float
    gimbal_rate_deg_s: float
    gimbal_margin: float
    momentum_mismatch_n_m_s: float


@dataclass(frozen=True, kw_only=True)
class SpacecraftVerification(TableExtremes):
    """The verdict; findings say what breaks, in words."""

    passed: bool
    findings: tuple[str, ...]
    windows: tuple[VerifiedWindow, ...]


def verify_table(table: AttitudeTable, request: ImagingPlanRequest) -> SpacecraftVerification:
    """Judge a table against the request it answers."""
    spacecraft = request.definition()
    rows = table.t_s
    fine_s = np.linspace(rows[0], rows[-1], (len(rows) - 1) * BETWEEN + 1)
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    states = ephemeris.states(Instants(table.epoch_utc, rows))
    attitude, motion = table.at(fine_s)
    inertia = np.array(spacecraft.inertia_kg_m2)
    needed = _needed_momentum(table, states, inertia, np.array(request.settings.momentum_n_m_s))
    held = spacecraft.array.momentum(table.gimbal_rad)
    total = Rotation.from_quat(table.eci_from_body_xyzw).apply(
        needed + inertia * table.omega_body_rad_s
    )
    fine_total = np.stack([np.interp(fine_s, rows, total[:, k]) for k in range(3)], axis=1)
    in_body = attitude.inv().apply(fine_total)
    torque = inertia * motion.alpha_body_rad_s2 + np.cross(motion.omega_body_rad_s, in_body)
    stored = in_body - inertia * motion.omega_body_rad_s
    windows = tuple(
        _window(table, window, request, ephemeris.states, spacecraft) for window in table.windows
    )
    extremes = TableExtremes(
        rate_deg_s=np.rad2deg(np.max(np.abs(motion.omega_body_rad_s), axis=0)),
        torque_n_m=float(np.max(np.linalg.norm(torque, axis=1))),
        momentum_n_m_s=float(np.max(np.linalg.norm(stored, axis=1))),
        gimbal_rate_deg_s=float(np.rad2deg(np.max(np.abs(table.gimbal_rate_rad_s)))),
        gimbal_margin=float(np.min(spacecraft.array.singularity_margin(table.gimbal_rad))),
        momentum_mismatch_n_m_s=float(np.max(np.linalg.norm(held - needed, axis=1))),
    )
    findings = (
        *_structure(table),
        *_limits(extremes, spacecraft),
        *(text for window in windows for text in _ground(window, spacecraft)),
        *_coverage(table, request, ephemeris.states),
    )
    return SpacecraftVerification(
        passed=not findings, findings=findings, windows=windows, **vars(extremes)
    )


def _needed_momentum(
    table: AttitudeTable, states: OrbitStates, inertia: Array, start: Array
) -> Array:
    """What the gyros must hold at each row, body axes: conservation of momentum, Simpson's rule
    for the gravity gradient's impulse over pairs of rows, trapezia over the odd one."""
    attitude = Rotation.from_quat(table.eci_from_body_xyzw)
    r = states.r_sat_eci_m
    radius = np.linalg.norm(r, axis=1, keepdims=True)
    nadir = attitude.inv().apply(r / radius)
    torque = attitude.apply(3.0 * MU_EARTH_M3_S2 / radius**3 * np.cross(nadir, inertia * nadir))
    steps = np.cumsum(0.5 * TICK_S * (torque[1:] + torque[:-1]), axis=0)
    total = attitude[0].apply(inertia * table.omega_body_rad_s[0] + start)
    total = total + np.vstack([np.zeros(3), steps])
    return np.asarray(attitude.inv().apply(total) - inertia * table.omega_body_rad_s)


def _columns(table: AttitudeTable) -> tuple[Array, ...]:
    return (
        table.eci_from_body_xyzw,
        table.omega_body_rad_s,
        table.alpha_body_rad_s2,
        table.gimbal_rad,
        table.gimbal_rate_rad_s,
    )


def _structure(table: AttitudeTable) -> Sequence[str]:
    found = []
    if not all(np.isfinite(column).all() for column in _columns(table)):
        found.append("a value is not a finite number")
    if np.max(np.abs(np.linalg.norm(table.eci_from_body_xyzw, axis=1) - 1.0)) > UNIT_TOLERANCE:
        found.append("a quaternion is not of unit length")
    attitude = Rotation.from_quat(table.eci_from_body_xyzw)
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec()
    omega, alpha = table.omega_body_rad_s, table.alpha_body_rad_s2
    mean = 0.5 * (omega[1:] + omega[:-1]) + TICK_S / 12.0 * (alpha[:-1] - alpha[1:])
    # The rotation vector of a short step: the mean rate plus half the rates' coning.
    expected = TICK_S * mean + TICK_S**2 / 12.0 * np.cross(omega[:-1], omega[1:])
    miss = float(np.max(np.linalg.norm(turned - expected, axis=1)))
    if miss > KINEMATIC_TOLERANCE_RAD:
        found.append(
            f"attitude and rate disagree by {np.rad2deg(miss) * 3600:.3f} arcsec over one row"
        )
    stepped = table.gimbal_rad[:-1] + TICK_S * table.gimbal_rate_rad_s[:-1]
    if np.max(np.abs(stepped - table.gimbal_rad[1:])) > GIMBAL_TOLERANCE_RAD:
        found.append("gimbal angles and rates disagree")
    rows = [(window.first_row, window.last_row) for window in table.windows]
    ends = [0] + [last for _, last in rows]
    if any(first < end or last <= first for (first, last), end in zip(rows, ends, strict=False)):
        found.append("imaging intervals overlap or run backwards")
    return found


def _limits(found: TableExtremes, spacecraft: AgileSpacecraft) -> Sequence[str]:
    slew, array = spacecraft.slew, spacecraft.array
    table = (
        (float(np.max(found.rate_deg_s)), math.degrees(slew.rate_axis_rad_s), "body rate, deg/s"),
        (found.torque_n_m, slew.torque_n_m, "control torque, N m"),
        (found.momentum_n_m_s, slew.momentum_sphere_n_m_s, "gyro momentum, N m s"),
        (found.gimbal_rate_deg_s, math.degrees(array.rate_max_rad_s), "gimbal rate, deg/s"),
        (found.momentum_mismatch_n_m_s, MOMENTUM_TOLERANCE_N_M_S, "momentum mismatch, N m s"),
    )
    return [
        f"{what}: {value:.4g} exceeds {limit:.4g}"
        for value, limit, what in table
        if value > limit * (1.0 + LIMIT_TOLERANCE)
    ]


def _footprint(attitude: Rotation, r_sat_eci_m: Array, c_itrf: Array, height_m: float) -> Array:
    """Where the optical axis meets the ellipsoid raised by height_m, ITRF, (n, 3)."""
    origin = np.einsum("nij,nj->ni", c_itrf, r_sat_eci_m)
    axis = np.einsum("nij,nj->ni", c_itrf, attitude.apply([0.0, -1.0, 0.0]))
    a, b = WGS84_A_M + height_m, WGS84_A_M * (1.0 - WGS84_F) + height_m
    scale = 1.0 / np.array([a, a, b])
    o, d = origin * scale, axis * scale
    dd, od = np.sum(d * d, axis=1), np.sum(o * d, axis=1)
    inside = np.maximum(od**2 - dd * (np.sum(o * o, axis=1) - 1.0), 0.0)
    reach = (-od - np.sqrt(inside)) / dd
    return np.asarray(origin + reach[:, None] * axis)


def _asked_line(
    request: Request, window: ImagingWindow, footprint: Array
) -> tuple[Array, Array] | None:
    """The two asked end points (ITRF) in the scanned sense; None for areas (see coverage)."""
    if isinstance(request, AreaRequest):
        return None
    points = request.geometry.coordinates
    leg = window.look if request.mode == "corridor" else 0
    ends = itrf_from_geodetic(
        np.deg2rad([points[leg][1], points[leg + 1][1]]),
        np.deg2rad([points[leg][0], points[leg + 1][0]]),
        request.height_m,
    )
    if np.dot(ends[1] - ends[0], footprint[-1] - footprint[0]) < 0.0:
        ends = ends[::-1]
    return ends[0], ends[1]


def _window(
    table: AttitudeTable,
    window: ImagingWindow,
    session: ImagingPlanRequest,
    states_at: StatesAt,
    spacecraft: AgileSpacecraft,
) -> VerifiedWindow:
    request = next(one for one in session.requests if one.name == window.request)
    count = (window.last_row - window.first_row) * ON_GROUND + 1
    t_s = (window.first_row * ON_GROUND + np.arange(count)) / (ON_GROUND * ROWS_PER_S)
    instants = Instants(table.epoch_utc, t_s)
    states = states_at(instants)
    attitude, _ = table.at(t_s)
    c = c_itrf_from_eci(instants)
    ground = _footprint(attitude, states.r_sat_eci_m, c, request.height_m)
    velocity = np.gradient(ground, t_s, axis=0, edge_order=2)
    speed = np.linalg.norm(velocity, axis=1)
    x_itrf = np.einsum("nij,nj->ni", c, attitude.apply([1.0, 0.0, 0.0]))
    y_itrf = np.einsum("nij,nj->ni", c, attitude.apply([0.0, 1.0, 0.0]))
    across = velocity - y_itrf * np.sum(velocity * y_itrf, axis=1, keepdims=True)
    cosine = np.abs(np.sum(x_itrf * across, axis=1)) / np.linalg.norm(across, axis=1)
    sine = np.linalg.norm(np.cross(x_itrf, across), axis=1) / np.linalg.norm(across, axis=1)
    line = _asked_line(request, window, ground)
    lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
    los = lvlh.apply(attitude.apply([0.0, -1.0, 0.0]))
    return VerifiedWindow(
        window=window,
        scan_speed_m_s=float(np.mean(speed)),
        speed_spread=float(np.max(np.abs(speed[ENDS] / request.scan_speed_m_s - 1.0))),
        drift_rad=float(np.max(np.arctan2(sine, cosine)[ENDS])),
        miss_m=0.0 if line is None else _miss_m(line, ground, request.scan_speed_m_s),
        along_deg=float(np.rad2deg(np.max(np.abs(np.arctan2(los[:, 0], los[:, 2]))))),
        across_deg=float(np.rad2deg(np.max(np.abs(np.arctan2(los[:, 1], los[:, 2]))))),
        line_time_s=float(
            spacecraft.camera.pixel_rad
            * np.mean(np.linalg.norm(ground - np.einsum("nij,nj->ni", c, states.r_sat_eci_m),
                axis=1)) / np.mean(speed)
        ),
    )  # fmt: skip


def _miss_m(line: tuple[Array, Array], ground: Array, speed_m_s: float) -> float:
    """Largest of: start from P0, P1 from the scanned line, and off the plane of the arc."""
    p0, p1 = line
    normal = np.cross(p0, p1)
    normal /= np.linalg.norm(normal)
    # The plane through the ellipsoid's centre isn't exactly that of the heights' ends: 0.1 m.
    off_plane = float(np.max(np.abs(ground @ normal)))
    end = float(np.min(np.linalg.norm(ground[-12:] - p1, axis=1)))
    overscan = end - speed_m_s * TICK_S / ON_GROUND
    return max(float(np.linalg.norm(ground[0] - p0)), off_plane, overscan)


def _ground(window: VerifiedWindow, spacecraft: AgileSpacecraft) -> Sequence[str]:
    camera = spacecraft.camera
    name = f"{window.window.request!r} look {window.window.look}"
    found = []
    if window.speed_spread > SPEED_TOLERANCE:
        found.append(f"{name}: scan speed off by {100 * window.speed_spread:.3f} %")
    if window.drift_rad > DRIFT_TOLERANCE_RAD:
        found.append(f"{name}: the image drifts by {math.degrees(window.drift_rad):.4f} deg")
    if window.miss_m > GROUND_TOLERANCE_M:
        found.append(f"{name}: scans {window.miss_m:.2f} m beside the line asked for")
    if window.along_deg > camera.along_max_deg + ANGLE_TOLERANCE_DEG:
        found.append(f"{name}: {window.along_deg:.2f} deg along the track")
    if window.across_deg > camera.across_max_deg + ANGLE_TOLERANCE_DEG:
        found.append(f"{name}: {window.across_deg:.2f} deg across the track")
    return found


def _coverage(
    table: AttitudeTable, session: ImagingPlanRequest, states_at: StatesAt
) -> Sequence[str]:
    """Every request begun is completed: all legs, both looks, all of an area's corners."""
    found = []
    for request in session.requests:
        looks = [window for window in table.windows if window.request == request.name]
        if not looks:
            continue
        if request.mode == "area":
            short_m = _uncovered_m(table, looks, request, states_at, session)
            if short_m > COVERAGE_TOLERANCE * session.definition().camera.swath_m:
                found.append(f"{request.name!r}: a corner lies {short_m:.1f} m outside the strips")
        else:
            legs = {"strip": 1, "stereo": 2}.get(request.mode, 0)
            legs = legs or len(request.geometry.coordinates) - 1
            if len(looks) != legs:
                found.append(f"{request.name!r}: {len(looks)} looks instead of {legs}")
    return found


def _uncovered_m(
    table: AttitudeTable,
    looks: Sequence[ImagingWindow],
    request: AreaRequest,
    states_at: StatesAt,
    session: ImagingPlanRequest,
) -> float:
    """How far outside the scanned strips the worst corner of an area lies."""
    ring = np.deg2rad([p[:2] for p in request.geometry.coordinates[0]])
    corners = itrf_from_geodetic(ring[:, 1], ring[:, 0], request.height_m)
    half_m = 0.5 * session.definition().camera.swath_m
    worst = np.full(len(corners), np.inf)
    for look in looks:
        t_s = np.array([look.first_row, look.last_row]) / ROWS_PER_S
        instants = Instants(table.epoch_utc, t_s)
        states = states_at(instants)
        attitude, _ = table.at(t_s)
        a, b = _footprint(attitude, states.r_sat_eci_m, c_itrf_from_eci(instants), request.height_m)
        along = (b - a) / np.linalg.norm(b - a)
        up = a / np.linalg.norm(a)
        side = np.cross(up, along)
        position = (corners - a) @ along
        beyond = np.maximum(np.maximum(-position, position - np.linalg.norm(b - a)), 0.0)
        aside = np.maximum(np.abs((corners - a) @ side) - half_m, 0.0)
        worst = np.minimum(worst, np.maximum(beyond, aside))
    return float(np.max(worst))
