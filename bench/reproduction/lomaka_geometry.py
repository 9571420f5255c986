"""The horizon of a sphere in a frame, its exact arc and what the paper's chord makes of it.

No picture is taken: what is left is the method's own error, and that of whole pixels.
Source: Lomaka, Ustyugov 2016, p. 467.
"""

import numpy as np
from horizon_cases import camera

from estimator.camera import HorizonCamera
from estimator.limb.geometry import Limb
from planner.base.arrays import Array
from planner.world.frames.geodesy import WGS84_A_M, WGS84_B_M, itrf_from_geodetic

RADIUS_M = 6371e3
AZIMUTHS = 4000


def dip_rad(height_m: float) -> float:
    """How far below the level the horizon is seen."""
    return float(np.arccos(RADIUS_M / (RADIUS_M + height_m)))


def lens(width_deg: float, width_px: int, down_deg: float, azimuth_deg: float) -> HorizonCamera:
    """A 4:3 camera on a body whose +Z is nadir at zero pitch and yaw."""
    height_px = round(0.75 * width_px)
    one = camera(f"c{azimuth_deg:g}", azimuth_deg, width_px, height_px, down_deg)
    focal_px = 0.5 * width_px / np.tan(np.deg2rad(0.5 * width_deg))
    return HorizonCamera(
        name=one.name,
        width_px=width_px,
        height_px=height_px,
        fx_px=focal_px,
        fy_px=focal_px,
        cx_px=one.cx_px,
        cy_px=one.cy_px,
        q_camera_from_body_xyzw=one.q_camera_from_body_xyzw,
        lens_sigma=0.0,
    )


def limb_rays(nadir_body: Array, height_m: float) -> Array:
    """Unit vectors to the horizon all around, (n, 3): the cone of half-angle 90 deg - dip."""
    dip = dip_rad(height_m)
    across = np.linalg.svd(nadir_body[None])[2][1:]
    azimuth = np.linspace(-np.pi, np.pi, AZIMUTHS, endpoint=False)
    around = np.column_stack([np.cos(azimuth), np.sin(azimuth)]) @ across
    return np.asarray(np.sin(dip) * nadir_body + np.cos(dip) * around)


def longest_run(seen: Array) -> Array:
    """Indices of the longest run of True on a ring, in order; empty without any."""
    if np.all(seen):
        return np.arange(len(seen))
    start = int(np.argmin(seen))
    turned = np.roll(np.arange(len(seen)), -start)
    runs = np.split(turned, np.flatnonzero(np.diff(seen[turned].astype(int))) + 1)
    return max((run for run in runs if seen[run[0]]), key=len, default=turned[:0])


def arc_px(camera: HorizonCamera, nadir_body: Array, height_m: float) -> Array:
    """The longest arc of horizon in the frame, pixels (n, 2) in order; n may be 0."""
    xy_px = camera.pixels(limb_rays(nadir_body, height_m))
    edge = [camera.width_px - 1, camera.height_px - 1]
    seen = np.all((xy_px >= 0.0) & (xy_px <= edge), axis=1)
    return np.asarray(xy_px[longest_run(seen)])


def chord_body(camera: HorizonCamera, ends_px: Array, unit_rays: bool) -> Array:
    """What joins the ends (2, 2) of an arc, (3,): between unit rays, or as printed on the image."""
    if unit_rays:
        first, last = camera.rays_body(ends_px)
        return np.asarray(last - first)
    flat = np.append(ends_px[1] - ends_px[0], 0.0)
    return np.asarray(camera.q_camera_from_body.inv().apply(flat))


def nadir_error_deg(
    cameras: tuple[HorizonCamera, HorizonCamera],
    nadir_body: Array,
    height_m: float,
    *,
    unit_rays: bool,
    whole_px: bool = False,
) -> float:
    """Of the cross product of both chords; NaN where a camera has no arc of ten pixels."""
    chords = []
    for one in cameras:
        arc = arc_px(one, nadir_body, height_m)
        if len(arc) < 2 or np.linalg.norm(arc[-1] - arc[0]) < 10.0:
            return float("nan")
        ends = arc[[0, -1]]
        chords.append(chord_body(one, np.rint(ends) if whole_px else ends, unit_rays))
    found = np.cross(*chords)
    across = np.linalg.norm(np.cross(found, nadir_body))
    return float(np.rad2deg(np.arctan2(across, abs(found @ nadir_body))))


def roll_error_deg(
    camera: HorizonCamera, nadir_body: Array, height_m: float, *, unit_rays: bool, whole_px: bool
) -> float:
    """Of one camera's chord about its boresight: how far it is from square to the nadir."""
    arc = arc_px(camera, nadir_body, height_m)
    if len(arc) < 2:
        return float("nan")
    ends = np.rint(arc[[0, -1]]) if whole_px else arc[[0, -1]]
    chord = chord_body(camera, ends, unit_rays)
    across = np.cross(camera.boresight_body, nadir_body)
    return float(np.rad2deg(np.arctan2(chord @ nadir_body, abs(chord @ across))))


def tilted_nadir(pitch_deg: float, yaw_deg: float) -> Array:
    """Nadir in body axes of a craft tilted about +X (yaw here) and +Y (pitch)."""
    yaw, pitch = np.deg2rad([yaw_deg, pitch_deg])
    level = np.array([np.sin(pitch), 0.0, np.cos(pitch)])
    c, s = np.cos(yaw), np.sin(yaw)
    return np.asarray(np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ level)


def printed_circle(axis: Array, corrected: bool) -> Array:
    """The parametric circle (n, 3) in units of its R about the origin, as printed or corrected."""
    a, b, c = axis
    t = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
    ac, abc = np.hypot(a, c), np.linalg.norm(axis)
    third = a if corrected else c
    return np.column_stack(
        [
            (c * np.cos(t) - a * b * np.sin(t) / abc) / ac,
            ac / abc * np.sin(t),
            -(third * np.cos(t) + b * c * np.sin(t) / abc) / ac,
        ]
    )


def geodetic_deg() -> float:
    """Most that geodetic and geocentric nadir differ at 500 km."""
    latitudes = np.deg2rad(np.arange(30.0, 61.0, 1.0))
    limbs = [Limb(itrf_from_geodetic(at, 0.0, 500e3), WGS84_A_M, WGS84_B_M) for at in latitudes]
    sines = [np.linalg.norm(np.cross(one.nadir_itrf, one.nadir_geodetic_itrf)) for one in limbs]
    return float(np.rad2deg(np.arcsin(max(sines))))


def points_needed() -> int:
    """Fewest rays d with d.n = sin(dip) that leave n and the dip no freedom but n's length."""
    rays = limb_rays(tilted_nadir(5.0, 3.0), 500e3)
    for count in range(1, 6):
        some = rays[:: len(rays) // count][:count]
        if np.linalg.matrix_rank(np.column_stack([some, -np.ones(count)])) == 3:
            return count
    raise ValueError("five rays don't fix the nadir")
