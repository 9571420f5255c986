"""Angles of directions from Sun, Moon, limb, glint, nadir and stars, by the judge's own sky."""

import math
from dataclasses import dataclass
from functools import cached_property

import erfa
import numpy as np

from planner.base.arrays import Array
from planner.verification.directions import apart_rad
from planner.verification.earth import earth_orientation
from planner.verification.earth_fixed import WGS84_A_M, WGS84_A_OVER_B
from planner.verification.sky import SkySight, limb_clearance_rad, sky_sight
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms.kept_direction import Celestial, KeptDirection
from planner.world.targets import BodyTarget
from planner.world.targets.body import HIDDEN_RAD


@dataclass(frozen=True, kw_only=True)
class SurroundingsOptions:
    """How nearly sunglint is found, and how large disks are."""

    glint_starts: int = 60  # along the Earth's arc from below the carrier to its horizon
    glint_passes: int = 8  # of Newton's
    glint_step: float = 1e-6  # of the arc, for his slopes
    glint_aside: float = 0.05  # the flattening, 1/298, leads out of the plane a few times as far
    sun_radius_m: float = 695_700e3  # IAU 2015 resolution B3
    moon_radius_m: float = 1_737.4e3  # IAU Working Group on Cartographic Coordinates 2015


OPTIONS = SurroundingsOptions()
RADIUS_M = {"sun": OPTIONS.sun_radius_m, "moon": OPTIONS.moon_radius_m}
SEMI_AXES_M = WGS84_A_M * np.array([1.0, 1.0, 1.0 / WGS84_A_OVER_B])


class Surroundings:
    """As the carrier sees them at n instants."""

    def __init__(self, instants: Instants, states: OrbitStates) -> None:
        self._instants, self._states = instants, states
        self._earth = earth_orientation(instants.epoch_utc, instants.t_s)
        self._r_sat_itrf_m = self._earth.itrf_from_eci(states.r_sat_eci_m)

    def away_rad(self, direction_eci: Array, celestial: Celestial) -> Array:
        """From unit vectors (n, 3) to a disk's edge, to the limb outwards, to the glint, (n,).

        Infinite while there is nothing to keep away from.
        """
        if celestial == "limb":
            return limb_clearance_rad(
                self._earth.itrf_from_eci(direction_eci), self._r_sat_itrf_m, 0.0
            )
        if celestial == "glint":
            return np.where(self._glint[1], apart_rad(direction_eci, self._glint[0]), math.inf)
        seen = self._sun if celestial == "sun" else self._moon
        edge_rad = np.arcsin(RADIUS_M[celestial] / seen.range_m)
        away_rad = apart_rad(direction_eci, seen.apparent_eci) - edge_rad
        return np.where(seen.clearance_rad > -HIDDEN_RAD, away_rad, math.inf)

    def margin_rad(self, kept: KeptDirection, direction_eci: Array) -> Array:
        """By how much unit vectors (n, 3) keep away from it or stay near it, (n,).

        Infinite while there is nothing to keep away from, or to stay near.
        """
        centre_eci = None
        if kept.body == "inertial":
            ra_rad, dec_rad = math.radians(kept.ra_deg or 0.0), math.radians(kept.dec_deg or 0.0)
            centre_eci = np.tile(erfa.s2c(ra_rad, dec_rad), (len(direction_eci), 1))
        elif kept.body == "nadir":
            r_m = self._states.r_sat_eci_m
            centre_eci = -r_m / np.linalg.norm(r_m, axis=1, keepdims=True)
        if centre_eci is not None:
            away_rad = far_rad = apart_rad(direction_eci, centre_eci)
        else:
            away_rad = far_rad = self.away_rad(direction_eci, kept.body)
            if kept.body in RADIUS_M:
                seen = self._sun if kept.body == "sun" else self._moon
                far_rad = away_rad + 2.0 * np.arcsin(RADIUS_M[kept.body] / seen.range_m)
        if kept.max_deg is None:
            return np.asarray(away_rad - math.radians(kept.min_deg or 0.0))
        is_there = np.isfinite(far_rad)
        return np.where(is_there, math.radians(kept.max_deg) - far_rad, math.inf)

    @cached_property
    def _sun(self) -> SkySight:
        return self._disk("sun")

    @cached_property
    def _moon(self) -> SkySight:
        return self._disk("moon")

    def _disk(self, name: str) -> SkySight:
        target = BodyTarget(name=name, grazing_altitude_km=0.0)
        return sky_sight(target, self._instants, self._states)

    @cached_property
    def _glint(self) -> tuple[Array, Array]:
        sun_itrf = self._earth.itrf_from_eci(self._sun.apparent_eci)
        towards_itrf, is_there = mirror_direction(sun_itrf, self._r_sat_itrf_m)
        return self._earth.eci_from_itrf(towards_itrf), is_there


def mirror_direction(sun_itrf: Array, r_sat_itrf_m: Array) -> tuple[Array, Array]:
    """Where the ellipsoid mirrors the Sun, unit vectors (n, 3), and whether it does, (n,).

    Light takes the shortest way: of the points whose normals lie on the arc from the carrier's
    zenith towards the Sun the one with the shortest way starts Newton's search for where normal
    and half vector agree, in both coordinates across the arc's.
    """
    zenith = r_sat_itrf_m / np.linalg.norm(r_sat_itrf_m, axis=1, keepdims=True)
    across = np.cross(zenith, sun_itrf)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    ahead = np.cross(across, zenith)
    horizon_rad = np.arccos(WGS84_A_M / np.maximum(np.linalg.norm(r_sat_itrf_m, axis=1), WGS84_A_M))

    def normal(along_rad: Array, aside_share: Array) -> Array:
        n = zenith + np.tan(along_rad)[:, None] * ahead + aside_share[:, None] * across
        return np.asarray(n / np.linalg.norm(n, axis=1, keepdims=True))

    def point_m(along_rad: Array, aside_share: Array) -> Array:
        n = normal(along_rad, aside_share)
        return np.asarray(
            n * SEMI_AXES_M**2 / np.linalg.norm(n * SEMI_AXES_M, axis=1, keepdims=True)
        )

    def way_m(along_rad: Array, aside_share: Array) -> Array:
        point = point_m(along_rad, aside_share)
        to_sat_m = np.linalg.norm(r_sat_itrf_m - point, axis=1)
        return np.asarray(to_sat_m - np.sum(sun_itrf * point, axis=1))

    def off(along_rad: Array, aside_share: Array) -> tuple[Array, Array]:
        to_sat = r_sat_itrf_m - point_m(along_rad, aside_share)
        half = sun_itrf + to_sat / np.linalg.norm(to_sat, axis=1, keepdims=True)
        miss = half / np.linalg.norm(half, axis=1, keepdims=True) - normal(along_rad, aside_share)
        return np.sum(miss * ahead, axis=1), np.sum(miss * across, axis=1)

    zero = np.zeros(len(zenith))
    shares = np.linspace(0.0, 1.0, OPTIONS.glint_starts)
    ways = np.stack([way_m(share * horizon_rad, zero) for share in shares])
    along_rad, aside_share = shares[np.argmin(ways, axis=0)] * horizon_rad, zero
    for _ in range(OPTIONS.glint_passes):
        f, g = off(along_rad, aside_share)
        f_along, g_along = (
            (b - a) / OPTIONS.glint_step
            for a, b in zip((f, g), off(along_rad + OPTIONS.glint_step, aside_share), strict=True)
        )
        f_aside, g_aside = (
            (b - a) / OPTIONS.glint_step
            for a, b in zip((f, g), off(along_rad, aside_share + OPTIONS.glint_step), strict=True)
        )
        size = f_along * g_aside - f_aside * g_along
        with np.errstate(divide="ignore", invalid="ignore"):  # where nothing mirrors
            ahead_rad = along_rad - (f * g_aside - g * f_aside) / size
            aside_share = aside_share - (g * f_along - f * g_along) / size
        along_rad = np.clip(np.nan_to_num(ahead_rad), 0.0, horizon_rad)
        aside_share = np.clip(np.nan_to_num(aside_share), -OPTIONS.glint_aside, OPTIONS.glint_aside)
    los_m = point_m(along_rad, aside_share) - r_sat_itrf_m
    n = normal(along_rad, aside_share)
    is_seen = np.sum(los_m * n, axis=1) < 0.0
    is_lit = np.sum(sun_itrf * n, axis=1) > 0.0
    return los_m / np.linalg.norm(los_m, axis=1, keepdims=True), is_seen & is_lit
