"""Each session's target as it is seen before, in and after the session."""

import math
from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from planner.base.arrays import Array, Mask, angle_rad
from planner.output.export.description import session_label
from planner.output.view.columns import TargetTrack
from planner.output.view.scene import PlanScene
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S
from planner.world.frames.geodesy import geodetic_from_itrf, up_itrf
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.orbits import OrbitStates
from planner.world.targets import EarthFixedTarget, VisibleTarget
from planner.world.targets.apparent import ApparentDirection, aberrate
from planner.world.targets.ground_sample import sample_along_m

_ON_EDGE_S = 1e-6


_OF_THE_SESSION = ("session", "name", "mode", "start_utc", "stop_utc", "in_session")
_COLUMNS = tuple(field.name for field in fields(TargetTrack) if field.name not in _OF_THE_SESSION)


def target_tracks(scene: PlanScene, pixel_rad: float) -> Iterator[TargetTrack]:
    """Of every session, in order.

    A target with a timetable is seen in its session only; a test motion has no target.
    """
    instants = scene.rows.instants
    for number, session in enumerate(scene.plan.scenario.sessions):
        begins_s, ends_s = (
            elapsed_s(at, instants.epoch_utc) for at in (session.start, session.stop)
        )
        inside = (instants.t_s > begins_s - _ON_EDGE_S) & (instants.t_s < ends_s + _ON_EDGE_S)
        columns = {name: np.full(len(instants), np.nan) for name in _COLUMNS}
        which = np.ones_like(inside) if session.target.has_windows else inside
        if isinstance(session.target, VisibleTarget) and which.any():
            for name, values in _seen(scene, session.target, which, pixel_rad).items():
                columns[name][which] = values
        yield TargetTrack(
            session=number,
            name=session_label(session, number),
            mode=session.target.mode,
            start_utc=session.start,
            stop_utc=session.stop,
            in_session=inside,
            **columns,
        )


def _seen(
    scene: PlanScene, target: VisibleTarget, which: Mask, pixel_rad: float
) -> dict[str, Array]:
    """Columns at the rows `which` (n,) holds."""
    rows = scene.rows
    instants = Instants(rows.instants.epoch_utc, rows.instants.t_s[which])
    states = OrbitStates(rows.states.r_sat_eci_m[which], rows.states.v_sat_eci_m_s[which])
    seen = target.apparent(instants, states)
    direction_eci = np.zeros((len(which), 3))
    direction_eci[which] = seen.direction_eci
    columns = {
        "range_m": np.where(np.isfinite(seen.range_m), seen.range_m, np.nan),
        "elevation_rad": seen.clearance_rad,
        "off_nadir_rad": scene.off_nadir_rad(direction_eci)[which],
        "sun_separation_rad": scene.separation_rad(direction_eci, "sun")[which],
        "moon_separation_rad": scene.separation_rad(direction_eci, "moon")[which],
        "error_rad": angle_rad(direction_eci, scene.boresight_eci)[which],
    }
    if isinstance(target, EarthFixedTarget):
        columns |= _on_earth(scene, target, instants, which, seen, pixel_rad)
    return columns


def _on_earth(
    scene: PlanScene,
    target: EarthFixedTarget,
    instants: Instants,
    which: Mask,
    seen: ApparentDirection,
    pixel_rad: float,
) -> dict[str, Array]:
    r_target_itrf_m = target.r_target_itrf_m(instants)
    latitude_rad, longitude_rad, height_m = geodetic_from_itrf(r_target_itrf_m)
    up = up_itrf(latitude_rad, longitude_rad)
    elevation_rad = seen.clearance_rad + math.radians(target.min_elevation_deg)
    across_m = seen.range_m * pixel_rad
    sine = np.sin(elevation_rad)
    return {
        "latitude_rad": latitude_rad,
        "longitude_rad": longitude_rad,
        "height_m": height_m,
        "elevation_rad": elevation_rad,
        "azimuth_rad": azimuth_rad(
            scene.r_sat_itrf_m[which] - r_target_itrf_m, latitude_rad, longitude_rad
        ),
        "ground_sample_across_m": np.where(sine > 0.0, across_m, np.nan),
        "ground_sample_along_m": sample_along_m(sine, seen.range_m, pixel_rad),
        "sun_elevation_rad": sun_elevation_rad(
            scene.in_itrf(scene.r_sun_eci_m)[which], r_target_itrf_m, up
        ),
    }


def azimuth_rad(vector_itrf: Array, latitude_rad: Array, longitude_rad: Array) -> Array:
    """Of vectors (n, 3) at places (n,), clockwise from north, in [0, 2 pi)."""
    sin_lat, cos_lat = np.sin(latitude_rad), np.cos(latitude_rad)
    sin_lon, cos_lon = np.sin(longitude_rad), np.cos(longitude_rad)
    x, y, z = vector_itrf.T
    east = cos_lon * y - sin_lon * x
    north = cos_lat * z - sin_lat * (cos_lon * x + sin_lon * y)
    return np.asarray(np.arctan2(east, north) % (2.0 * np.pi))


def sun_elevation_rad(r_sun_itrf_m: Array, r_target_itrf_m: Array, up: Array) -> Array:
    """Of the Sun's centre in the sky of places, (n,); parallax and diurnal aberration included.

    r_sun_itrf_m: as seen from the geocentre.  up: unit vectors; all (n, 3).
    """
    to_sun_m = r_sun_itrf_m - r_target_itrf_m
    x, y = r_target_itrf_m[:, 0], r_target_itrf_m[:, 1]
    carried_m_s = OMEGA_EARTH_RAD_S * np.stack([-y, x, np.zeros_like(x)], axis=1)
    direction = aberrate(to_sun_m / np.linalg.norm(to_sun_m, axis=1, keepdims=True), carried_m_s)
    return np.asarray(np.arcsin(np.clip(np.sum(direction * up, axis=1), -1.0, 1.0)))
