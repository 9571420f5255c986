"""Angles between directions of a body and the Sun, the Moon, the Earth's limb and sunglint."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, angle_rad
from planner.base.rotation import Rotation
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import WGS84_A_M, geodetic_from_itrf, itrf_from_geodetic, up_itrf
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms.body import BodyPlatform
from planner.world.platforms.kept_direction import Celestial, KeptDirection, unit_vector
from planner.world.targets.body import HIDDEN_RAD, BodyTarget
from planner.world.targets.earth_limb import limb_clearance_rad

# IAU 2015 resolution B3; IAU Working Group on Cartographic Coordinates 2015
RADIUS_M = {"sun": 695_700e3, "moon": 1_737.4e3}
TITLES = {
    "sun": "the Sun",
    "moon": "the Moon",
    "limb": "the Earth's limb",
    "glint": "sunglint",
    "nadir": "the nadir",
    "inertial": "its direction among the stars",
}


def unkept_told(kept: KeptDirection) -> str:
    """In words, what a direction that isn't kept does."""
    if kept.near is None:
        return f"{kept.name} is nearer to {TITLES[kept.body]} than its {kept.min_deg:g} deg"
    return f"{kept.name} is farther from {TITLES[kept.body]} than its {kept.max_deg:g} deg"


@dataclass(frozen=True, kw_only=True)
class GlintOptions:
    """How nearly the point that mirrors the Sun is found."""

    passes: int = 4  # each leaves 1/100 of the error
    halvings: int = 32  # of the angle to the horizon: 1e-10 rad


GLINT = GlintOptions()


class ExclusionMargin(NamedTuple):
    """By how much a body keeps one exclusion at n instants.

    name: the exclusion's, or "star_trackers".  title: what it keeps away from, for a sentence.
    imaging_only: whether it counts only while the camera images.  margin_rad: (n,), negative where
    it is broken, pi where there is nothing to keep away from.  side: where it stands when broken.
    """

    name: str
    title: str
    imaging_only: bool
    margin_rad: Array
    side: str = "nearer to"


class Surroundings:
    """What a spacecraft sees around it at n instants, each looked up when first asked for."""

    def __init__(self, instants: Instants, states: OrbitStates) -> None:
        self.instants, self.states = instants, states
        self.c_itrf_from_eci = c_itrf_from_eci(instants)
        self._disks: dict[str, tuple[Array, Array, Array]] = {}
        self._glint: tuple[Array, Array] | None = None

    def disk(self, body: str) -> tuple[Array, Array, Array]:
        """Of Sun or Moon: where its centre is seen, unit vectors (n, 3); half its size, rad, (n,);
        and by how much it counts, rad, (n,), not positive while the Earth hides all of it."""
        if body not in self._disks:
            seen = BodyTarget(name=body, grazing_altitude_km=0.0).apparent(
                self.instants, self.states
            )
            half_rad = np.arcsin(RADIUS_M[body] / seen.range_m)
            self._disks[body] = seen.direction_eci, half_rad, seen.clearance_rad + HIDDEN_RAD
        return self._disks[body]

    def glint(self) -> tuple[Array, Array]:
        """Where a calm sea would mirror the Sun, unit vectors (n, 3); and by how much it counts,
        rad, (n,), not positive where the Sun's light doesn't come that way."""
        if self._glint is None:
            direction_itrf, counts_rad = glint_direction(
                self._itrf(self.disk("sun")[0]), self._itrf(self.states.r_sat_eci_m)
            )
            direction_eci = np.einsum("nji,nj->ni", self.c_itrf_from_eci, direction_itrf)
            self._glint = np.asarray(direction_eci), counts_rad
        return self._glint

    def cone(self, about: Celestial | Array) -> tuple[Array, Array, Array]:
        """Its middle, unit vectors (n, 3), half its size, rad, (n,), and by how much it counts.

        The limb's is the least that holds all of the Earth.
        """
        r_m = np.linalg.norm(self.states.r_sat_eci_m, axis=1)
        point_rad, always_rad = np.zeros_like(r_m), np.full(len(r_m), math.pi)
        if not isinstance(about, str):
            return np.tile(about, (len(r_m), 1)), point_rad, always_rad
        if about == "glint":
            centre_eci, counts_rad = self.glint()
            return centre_eci, point_rad, counts_rad
        if about in ("limb", "nadir"):
            half_rad = np.arcsin(WGS84_A_M / r_m) if about == "limb" else point_rad
            return -self.states.r_sat_eci_m / r_m[:, None], half_rad, always_rad
        return self.disk(about)

    def apart_rad(self, direction_eci: Array, about: Celestial | Array) -> Array:
        """Angle of unit vectors (n, 3) from it, (n,): from a disk's edge, from the limb outwards.

        Negative inside; pi while it doesn't count.  The limb is the ellipsoid's, in the plane of
        direction and geocentre.
        """
        if isinstance(about, str) and about == "limb":
            r_sat_itrf_m = self._itrf(self.states.r_sat_eci_m)
            return limb_clearance_rad(self._itrf(direction_eci), r_sat_itrf_m, 0.0)
        centre_eci, half_rad, counts_rad = self.cone(about)
        apart_rad = angle_rad(direction_eci, centre_eci) - half_rad
        return np.where(counts_rad > 0.0, apart_rad, math.pi)

    def kept_margin_rad(self, kept: KeptDirection, direction_eci: Array) -> Array:
        """By how much unit vectors (n, 3) keep away, or stay near, (n,); pi while it doesn't
        count."""
        margin_rad = self.margin_rad(kept.away(direction_eci), kept.about, kept.kept_deg)
        return -margin_rad if kept.near == "limb" else margin_rad

    def margin_rad(self, direction_eci: Array, about: Celestial | Array, least_deg: float) -> Array:
        """By how much unit vectors (n, 3) are farther from it, (n,); pi while it doesn't count."""
        apart_rad = self.apart_rad(direction_eci, about)
        return np.where(apart_rad < math.pi, apart_rad - math.radians(least_deg), math.pi)

    def _itrf(self, vector_eci: Array) -> Array:
        return np.asarray(np.einsum("nij,nj->ni", self.c_itrf_from_eci, vector_eci))


def exclusion_margins(
    platform: BodyPlatform, q_eci_from_body: Rotation, surroundings: Surroundings
) -> tuple[ExclusionMargin, ...]:
    """Margins of a platform's exclusions in their order, and of its star trackers, if it has any.

    q_eci_from_body: n rotations.  Of star trackers it is the margin of the last one needed: of two
    that must see stars the second best.
    """
    margins = [
        ExclusionMargin(
            exclusion.name,
            TITLES[exclusion.body],
            exclusion.when == "imaging",
            surroundings.kept_margin_rad(
                exclusion,
                q_eci_from_body.apply(
                    unit_vector(exclusion.direction_body or platform.camera.boresight_body)
                ),
            ),
            "nearer to" if exclusion.near is None else "farther from",
        )
        for exclusion in platform.exclusions
    ]
    trackers = platform.star_trackers
    if trackers is not None and trackers.needed:
        each = []
        for tracker in trackers.each:
            direction_eci = q_eci_from_body.apply(unit_vector(tracker.boresight_body))
            aparts_rad = [
                surroundings.margin_rad(direction_eci, celestial, least_deg)
                for celestial, least_deg in tracker.least_deg
            ]
            each.append(np.min(aparts_rad, axis=0))
        of_last_needed = np.sort(each, axis=0)[-trackers.needed]
        title = "Sun, Moon and the Earth's limb"
        margins.append(ExclusionMargin("star_trackers", title, True, of_last_needed))
    return tuple(margins)


def glint_direction(sun_itrf: Array, r_sat_itrf_m: Array) -> tuple[Array, Array]:
    """Where the ellipsoid mirrors the Sun, unit vectors (n, 3); and by how much it counts, (n,).

    sun_itrf: unit vectors (n, 3), the Sun infinitely far.  The second is the angle by which the
    Sun stands above the horizon of the last point that the satellite sees, in the plane of both.
    Each pass mirrors on the sphere that touches the ellipsoid where the last one did.  Without
    air and waves.
    """
    centre_m = np.zeros_like(r_sat_itrf_m)
    radius_m = np.full(len(r_sat_itrf_m), WGS84_A_M)
    for _ in range(GLINT.passes):
        r_m = r_sat_itrf_m - centre_m
        distance_m = np.linalg.norm(r_m, axis=1)
        zenith = r_m / distance_m[:, None]
        sun_rad = angle_rad(zenith, sun_itrf)
        aside = sun_itrf - np.sum(sun_itrf * zenith, axis=1)[:, None] * zenith
        aside /= np.maximum(np.linalg.norm(aside, axis=1), 1e-12)[:, None]
        horizon_rad = np.arccos(np.minimum(radius_m / distance_m, 1.0))
        low_rad, high_rad = np.zeros_like(sun_rad), horizon_rad
        for _ in range(GLINT.halvings):
            middle_rad = 0.5 * (low_rad + high_rad)
            above_m = distance_m * np.cos(middle_rad) - radius_m
            leaving_rad = np.arctan2(distance_m * np.sin(middle_rad), above_m)
            is_before = leaving_rad < sun_rad - middle_rad
            low_rad = np.where(is_before, middle_rad, low_rad)
            high_rad = np.where(is_before, high_rad, middle_rad)
        normal = np.cos(low_rad)[:, None] * zenith + np.sin(low_rad)[:, None] * aside
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(centre_m + radius_m[:, None] * normal)
        point_m = itrf_from_geodetic(latitude_rad, longitude_rad, 0.0)
        # across the meridian, where the sphere's centre is on the axis
        radius_m = np.hypot(point_m[:, 0], point_m[:, 1]) / np.cos(latitude_rad)
        centre_m = point_m - radius_m[:, None] * up_itrf(latitude_rad, longitude_rad)
    los_m = point_m - r_sat_itrf_m
    counts_rad = horizon_rad + math.pi / 2.0 - sun_rad
    return los_m / np.linalg.norm(los_m, axis=1)[:, None], np.asarray(counts_rad)
