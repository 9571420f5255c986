"""The carrier and what it sees, for the oracle of plans: by SGP4, ERFA, Skyfield, GeographicLib."""

import math
from datetime import UTC, datetime, timedelta
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import erfa
import numpy as np
import skyfield_data
from astropy_iers_data import IERS_A_FILE
from geographiclib.geodesic import Geodesic
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from sgp4.api import WGS72, Satrec
from skyfield.api import load
from skyfield.jpllib import SpiceKernel

Array = NDArray[np.float64]
Fields = dict[str, Any]
ARCSEC = math.pi / 648000.0
C_KM_S = 299792.458
SUN_EDGE = 1e-6  # of 1 + cos, within which ERFA bends light no more: 5 arcmin from the centre


class Sky:
    """The carrier and what it sees at instants of a plan."""

    def __init__(self, request: Fields, t_s: Array) -> None:
        self.request = request
        epoch_utc = utc(request["initial_state"]["epoch"])
        self.t_s = t_s
        midnight = epoch_utc.replace(hour=0, minute=0, second=0, microsecond=0)
        self._mjd = float(erfa.cal2jd(epoch_utc.year, epoch_utc.month, epoch_utc.day)[1])
        utc_s = (epoch_utc - midnight).total_seconds() + t_s
        ahead_s = erfa.dat(epoch_utc.year, epoch_utc.month, epoch_utc.day, 0.0)
        ut1_utc_s, xp, yp = _earth_orientation(self._mjd + utc_s / 86400.0)
        self.utc = utc_s / 86400.0
        self.tt = (utc_s + ahead_s + 32.184) / 86400.0
        ut1 = (utc_s + ut1_utc_s) / 86400.0
        wobble = erfa.pom00(xp, yp, 0.0)
        theta = erfa.gmst82(2400000.5 + self._mjd, ut1)
        teme_to_itrf = wobble @ _z(theta)
        self.itrf_from_eci = erfa.c2t06a(
            2400000.5 + self._mjd, self.tt, 2400000.5 + self._mjd, ut1, xp, yp
        )
        eci_from_teme = np.swapaxes(self.itrf_from_eci, 1, 2) @ teme_to_itrf
        satrec = Satrec.twoline2rv(request["orbit"]["line1"], request["orbit"]["line2"], WGS72)
        error, r_km, v_km_s = satrec.sgp4_array(np.full(len(t_s), 2400000.5 + self._mjd), self.utc)
        assert not error.any()
        self.r_km = np.einsum("nij,nj->ni", eci_from_teme, r_km)
        self.v_km_s = np.einsum("nij,nj->ni", eci_from_teme, v_km_s)

    def towards(self, target: Fields, session: Fields) -> Array:
        """Apparent directions, (n, 3): light time and aberration."""
        if target["mode"] in ("star", "body"):
            return _aberrated(self._beyond(target), self.v_km_s)
        light_s = np.zeros(len(self.t_s))
        for _ in range(2):
            r_itrf_km = self._ground(target, session, self.t_s - light_s)
            r_km = np.einsum("nji,nj->ni", self.itrf_from_eci, r_itrf_km)
            light_s = np.linalg.norm(r_km - self.r_km, axis=1) / C_KM_S
        spin = 7.292115e-5 * self.itrf_from_eci[:, 2, :]
        r_km = r_km - light_s[:, None] * np.cross(spin, r_km)
        return _aberrated(unit(r_km - self.r_km), self.v_km_s)

    def cone(self, cone: Fields) -> tuple[Array, NDArray[np.bool_]]:
        """Its axis in inertial axes, (n, 3), and where it counts."""
        always = np.ones(len(self.t_s), bool)
        if "direction_platform" in cone:
            to_platform = mount(self.request) * self.body_from_eci()
            return to_platform.inv().apply(unit(np.array(cone["direction_platform"]))), always
        if "direction_lvlh" in cone:
            return self._lvlh().inv().apply(unit(np.array(cone["direction_lvlh"]))), always
        if "ra_deg" in cone:
            axis = erfa.s2c(math.radians(cone["ra_deg"]), math.radians(cone["dec_deg"]))
            return np.broadcast_to(axis, (len(self.t_s), 3)), always
        axis = self.towards({"mode": "body", "name": cone["body"]}, {})
        distance = np.linalg.norm(self.r_km, axis=1)
        limb = np.arcsin(6400.0 / distance)  # the least that is surely not behind the Earth
        return axis, apart(axis, -self.r_km) > limb

    def body_from_eci(self) -> Rotation:
        attitude = self.request["attitude"]
        if attitude["law"] == "inertial":
            since_s = self.t_s - seconds(self.request, attitude["epoch"])
            turned = np.outer(since_s, np.radians(attitude["omega_body_deg_s"]))
            known = Rotation.from_quat(attitude["q_body_from_eci_xyzw"])
            return Rotation.from_rotvec(turned).inv() * known
        yaw, pitch, roll = (attitude.get(f"{n}_deg", 0.0) for n in ("yaw", "pitch", "roll"))
        turned = Rotation.from_euler("ZYX", [yaw, pitch, roll], degrees=True)
        return turned.inv() * self._lvlh()

    def _lvlh(self) -> Rotation:
        z = -unit(self.r_km)
        y = -unit(np.cross(self.r_km, self.v_km_s))
        return Rotation.from_matrix(np.stack([np.cross(y, z), y, z], axis=1))

    def _ground(self, target: Fields, session: Fields, seen_s: Array) -> Array:
        """ITRF positions at times since the table's epoch, km."""
        if target["mode"] == "ground":
            return np.tile(_itrf_km(target, target), (len(seen_s), 1))
        if target["mode"] == "ground_path":
            since_s = seen_s - seconds(self.request, session["start"])
            return np.array([_on_path(target, s) for s in since_s])
        since_s = seen_s - seconds(self.request, target["epoch"])
        line = Geodesic.WGS84.Line(
            target["latitude_deg"], target["longitude_deg"], target["course_deg"]
        )
        gone_m = target["speed_m_s"] * since_s
        return np.array([_along(line, m, target["height_m"]) for m in gone_m])

    def _beyond(self, target: Fields) -> Array:
        """Directions from the carrier, aberrated by the Earth's motion but not by the carrier's."""
        helio, bary = erfa.epv00(2400000.5 + self._mjd, self.tt)
        earth_km_s = bary["v"] * erfa.DAU / 1e3 / 86400.0
        sun_au = np.linalg.norm(helio["p"], axis=1)
        if target["mode"] == "star":
            star = erfa.s2c(math.radians(target["ra_deg"]), math.radians(target["dec_deg"]))
            stars = np.tile(star, (len(self.t_s), 1))
            bent = erfa.ldsun(stars, unit(helio["p"]), sun_au)
            return _aberrated(bent, earth_km_s)
        name = target["name"] + (" barycenter" if target["name"] in _GIANTS else "")
        jd = 2400000.5 + self._mjd + self.tt
        earth, body = _ephemeris()["earth"], _ephemeris()[name]
        observer_km = _bary_km(earth, jd) + self.r_km
        light_s = np.zeros(len(self.t_s))
        for _ in range(4):
            away_km = _bary_km(body, jd - light_s / 86400.0) - observer_km
            light_s = np.linalg.norm(away_km, axis=1) / C_KM_S
        towards = unit(away_km)
        if target["name"] not in ("sun", "moon"):
            from_sun = unit(helio["p"] * erfa.DAU / 1e3 + away_km)
            towards = erfa.ld(1.0, towards, from_sun, unit(helio["p"]), sun_au, SUN_EDGE)
        return _aberrated(towards, earth_km_s)


_TIMESCALE = load.timescale(builtin=True)
_GIANTS = ("mars", "jupiter", "saturn", "uranus", "neptune")


@cache
def _ephemeris() -> SpiceKernel:
    return SpiceKernel(str(Path(skyfield_data.__file__).parent / "data" / "de421.bsp"))


def _bary_km(body: Any, tdb_jd: Array) -> Array:
    """From the solar system's barycentre, TT standing for TDB."""
    time = _TIMESCALE.tdb_jd(tdb_jd)
    return np.asarray(body.at(time).position.km.T)


@cache
def _orientation_days() -> Array:
    """Columns MJD, polar motion x, y (arcsec) and UT1 - UTC (s) of finals2000A."""
    lines = Path(IERS_A_FILE).read_text(encoding="ascii").splitlines()
    columns = (slice(7, 15), slice(18, 27), slice(37, 46), slice(58, 68))
    rows = [[line[column] for column in columns] for line in lines if line[58:68].strip()]
    return np.array(rows, dtype=float)


def _earth_orientation(mjd: Array) -> tuple[Array, Array, Array]:
    """UT1 - UTC (s) and polar motion (rad), straight between days, past a leap second as well."""
    days = _orientation_days()
    xp, yp = (np.interp(mjd, days[:, 0], days[:, k]) for k in (1, 2))
    first = np.searchsorted(days[:, 0], mjd, side="right") - 1
    change = days[first + 1, 3] - days[first, 3]  # of a leap second's day: by a second more
    ut1 = days[first, 3] + (change - np.rint(change)) * (mjd - days[first, 0])
    return ut1, xp * ARCSEC, yp * ARCSEC


def mount(request: Fields) -> Rotation:
    platform = request["platform"]
    if isinstance(platform, str):
        return Rotation.identity()
    return Rotation.from_quat(platform.get("q_platform_from_body_xyzw", [0.0, 0.0, 0.0, 1.0]))


def _itrf_km(place: Fields, heights: Fields) -> Array:
    xyz = erfa.gd2gc(
        1,
        math.radians(place["longitude_deg"]),
        math.radians(place["latitude_deg"]),
        heights.get("height_m", 0.0),
    )
    return np.asarray(xyz) / 1e3


def _along(line: Any, distance_m: float, height_m: float) -> Array:
    end = line.Position(distance_m)
    place = {"latitude_deg": end["lat2"], "longitude_deg": end["lon2"]}
    return _itrf_km(place, {"height_m": height_m})


def _on_path(target: Fields, since_s: float) -> Array:
    """On the legs; NaN within a corner, whose shape is the planner's to choose."""
    if math.isnan(since_s):
        return np.full(3, np.nan)
    points, speed = target["points"], target["speed_m_s"]
    passed_s = 0.0
    for number, (a, b) in enumerate(pairwise(points)):
        whole = Geodesic.WGS84.Inverse(
            a["latitude_deg"], a["longitude_deg"], b["latitude_deg"], b["longitude_deg"]
        )
        lasts_s = whole["s12"] / speed
        is_last = number == len(points) - 2
        if since_s <= passed_s + lasts_s or is_last:
            to_corner_s = min(
                math.inf if number == 0 else since_s - passed_s,
                math.inf if is_last else passed_s + lasts_s - since_s,
            )
            if not to_corner_s >= 2.0 + 0.01:
                return np.full(3, np.nan)
            line = Geodesic.WGS84.Line(a["latitude_deg"], a["longitude_deg"], whole["azi1"])
            along_m = speed * (since_s - passed_s)
            climbed = (b["height_m"] - a["height_m"]) * along_m / whole["s12"]
            return _along(line, along_m, a["height_m"] + climbed)
        passed_s += lasts_s
    raise AssertionError("a path has a last leg")


def _aberrated(direction: Array, v_km_s: Array) -> Array:
    """Special relativity's, by the velocity of who looks."""
    beta = v_km_s / C_KM_S
    inverse_gamma = np.sqrt(1.0 - np.sum(beta**2, axis=1, keepdims=True))
    along = np.sum(direction * beta, axis=1, keepdims=True)
    return unit(inverse_gamma * direction + beta * (1.0 + along / (1.0 + inverse_gamma)))


def apart(a: Array, b: Array) -> Array:
    """Angles between directions, rad; NaN counts as none."""
    across = np.linalg.norm(np.cross(a, b), axis=-1)
    return np.nan_to_num(np.arctan2(across, np.sum(a * b, axis=-1)))


def unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _z(angle: Array) -> Array:
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.moveaxis(np.array([[c, s, o], [-s, c, o], [o, o, i]]), 2, 0)


def seconds(request: Fields, text: str) -> float:
    """Since the table's epoch."""
    return (utc(text) - utc(request["initial_state"]["epoch"])) / timedelta(seconds=1)


def utc(text: str) -> datetime:
    return datetime.fromisoformat(text.replace("Z", "+00:00")).astimezone(UTC)
