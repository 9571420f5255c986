"""The carrier's position and look direction, and where the Sun and the Moon stand."""

import numpy as np

from planner.base.arrays import Array
from planner.output.view.columns import BodyTrack, BoresightTrace, CarrierTrack, FootprintTrace
from planner.output.view.scene import Body, CarrierScene, PlanScene
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.targets.earth_limb import limb_clearance_rad

SUN_RADIUS_M = 695.7e6  # IAU 2015 resolution B3


def carrier_track(scene: CarrierScene) -> CarrierTrack:
    """Of the Sun, the limb a straight edge, no air: the segment of a disk beyond a chord."""
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
    states = scene.states
    q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
    ahead, right, down = q_lvlh.apply(scene.boresight_eci).T
    return BoresightTrace(
        latitude_rad=np.where(on_ground, latitude_rad, np.nan),
        longitude_rad=np.where(on_ground, longitude_rad, np.nan),
        range_m=np.where(on_ground, range_m, np.nan),
        off_nadir_rad=scene.off_nadir_rad(scene.boresight_eci),
        along_track_rad=np.arctan2(ahead, down),
        across_track_rad=np.arcsin(np.clip(right, -1.0, 1.0)),
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
