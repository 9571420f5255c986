"""The carrier's position and look direction, and where the Sun and the Moon stand."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.output.view.scene import Body, CarrierScene, PlanScene
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.targets.earth_limb import limb_clearance_rad

SUN_RADIUS_M = 695.7e6  # IAU 2015 resolution B3


@dataclass(frozen=True, kw_only=True, eq=False)
class CarrierTrack:
    """The point below the carrier, each (n,): geodetic, WGS84, longitude -pi..pi.

    sunlit_share: of the Sun's disk that the Earth doesn't hide; the limb a straight edge, no air.
    """

    latitude_rad: Array
    longitude_rad: Array
    height_m: Array
    sunlit_share: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class BoresightTrace:
    """Where the boresight meets the ellipsoid, each (n,); NaN where it passes the Earth by.

    off_nadir_rad: from the geocentre's direction; this and the separations are always known.
    """

    latitude_rad: Array
    longitude_rad: Array
    range_m: Array
    off_nadir_rad: Array
    sun_separation_rad: Array
    moon_separation_rad: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class FootprintTrace:
    """Corners of the frame on the ellipsoid, in order around it, each (n, 4); NaN beside it."""

    latitude_rad: Array
    longitude_rad: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyTrack:
    """Sun or Moon, each (n,): the place that has it overhead, and its height above the limb.

    latitude_rad: geodetic, of a normal of the ellipsoid that points at it.  above_limb_rad: of its
    centre from the carrier, negative where the Earth hides it; without refraction.
    """

    latitude_rad: Array
    longitude_rad: Array
    above_limb_rad: Array


def carrier_track(scene: CarrierScene) -> CarrierTrack:
    """Source of the hidden share: the segment of a disk beyond a chord."""
    latitude_rad, longitude_rad, height_m = geodetic_from_itrf(scene.r_sat_itrf_m)
    distance_m = np.linalg.norm(scene.r_sun_eci_m - scene.states.r_sat_eci_m, axis=1)
    above = above_limb_rad(scene, "sun") / np.arcsin(SUN_RADIUS_M / distance_m)
    chord = np.clip(above, -1.0, 1.0)
    share = 0.5 + (chord * np.sqrt(1.0 - chord**2) + np.arcsin(chord)) / np.pi
    return CarrierTrack(
        latitude_rad=latitude_rad,
        longitude_rad=longitude_rad,
        height_m=height_m,
        sunlit_share=np.clip(share, 0.0, 1.0),
    )


def boresight_trace(scene: PlanScene) -> BoresightTrace:
    """Ignores refraction and the Earth's turn in the light time, 1.4 m."""
    end_itrf_m, on_ground = scene.sights.end_itrf_m[:, 0], scene.sights.on_ground[:, 0]
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(end_itrf_m)
    range_m = np.linalg.norm(end_itrf_m - scene.r_sat_itrf_m, axis=1)
    return BoresightTrace(
        latitude_rad=np.where(on_ground, latitude_rad, np.nan),
        longitude_rad=np.where(on_ground, longitude_rad, np.nan),
        range_m=np.where(on_ground, range_m, np.nan),
        off_nadir_rad=scene.off_nadir_rad(scene.boresight_eci),
        sun_separation_rad=scene.separation_rad(scene.boresight_eci, "sun"),
        moon_separation_rad=scene.separation_rad(scene.boresight_eci, "moon"),
    )


def footprint_trace(scene: PlanScene) -> FootprintTrace:
    """Corners counter-clockwise as the camera sees them, from +X +Y on."""
    end_itrf_m, on_ground = scene.sights.end_itrf_m[:, 1:], scene.sights.on_ground[:, 1:]
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(end_itrf_m)
    return FootprintTrace(
        latitude_rad=np.where(on_ground, latitude_rad, np.nan),
        longitude_rad=np.where(on_ground, longitude_rad, np.nan),
    )


def body_track(scene: CarrierScene, body: Body) -> BodyTrack:
    """Of its centre."""
    toward_itrf = scene.in_itrf(scene.r_body_eci_m(body))
    toward_itrf /= np.linalg.norm(toward_itrf, axis=1, keepdims=True)
    return BodyTrack(
        latitude_rad=np.arcsin(toward_itrf[:, 2]),
        longitude_rad=np.arctan2(toward_itrf[:, 1], toward_itrf[:, 0]),
        above_limb_rad=above_limb_rad(scene, body),
    )


def above_limb_rad(scene: CarrierScene, body: Body) -> Array:
    """Of a body's centre, without refraction, (n,)."""
    to_body_itrf_m = scene.in_itrf(scene.r_body_eci_m(body)) - scene.r_sat_itrf_m
    direction = to_body_itrf_m / np.linalg.norm(to_body_itrf_m, axis=1, keepdims=True)
    return limb_clearance_rad(direction, scene.r_sat_itrf_m, 0.0)
