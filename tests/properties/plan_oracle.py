"""An answered plan against what was asked, by geometry that shares nothing with the planner.

Knows the request and the answer as JSON and nothing else: SGP4 by python-sgp4, Earth and sky by
ERFA and Skyfield, geodesics by GeographicLib, and the table's own cubic Hermite every 5 ms."""

import math
from collections.abc import Iterator
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


STEP_S = 0.2
FINE = 40  # of a row: 5 ms
ANGLE_DEG = 2e-9  # the answer's angles end at 1e-9 deg
# Two angles 1e-9 deg off and rates as far: the cubic's acceleration errs by 6 of the one in
# 0.2 s^2 and 4 of the other in 0.2 s.
ACCELERATION_DEG_S2 = 2e-7
RATE_DEG_S = 3e-8
# A table follows to 0.1 arcsec, and 60 plans were seen to agree to 0.023.  What is ours of it:
# IERS values taken as straight between days (0.1 ms and 1 mas, seen in stars only).
POINTING_ARCSEC = 0.2
INSTANTS = 60  # of a session at which its pointing is looked at, or somewhat more
CONE_DEG = 0.01  # as the Moon of ERFA's series is off by 10 arcsec
ISS_HRC = {
    "outer": {
        "name": "alpha",
        "axis_platform": [0.0, -math.cos(math.radians(5.0)), math.sin(math.radians(5.0))],
    },
    "inner": {"name": "beta", "axis_platform": [1.0, 0.0, 0.0]},
}
for _axis in ISS_HRC.values():
    _axis |= {"angle_min_deg": -175.0, "angle_max_deg": 175.0, "rate_max_deg_s": 3.0}
    _axis |= {"acceleration_max_deg_s2": 1.0, "jerk_max_deg_s3": 1.0}


def faults(request: Fields, answer: Fields) -> list[str]:
    """All that is wrong with a plan; empty for a good one."""
    return [*_grid_faults(request, answer)] or [
        *_limit_faults(request, answer),
        *_pointing_faults(request, answer),
        *_cone_faults(request, answer),
    ]


def _grid_faults(request: Fields, answer: Fields) -> Iterator[str]:
    table, state = answer["table"], request["initial_state"]
    t_s = np.array(table["t_s"])
    if abs(t_s - STEP_S * np.arange(len(t_s))).max() > 1e-9:
        yield "rows are not 0.2 s apart"
    if utc(table["epoch"]) != utc(state["epoch"]):
        yield f"row 0 is at {table['epoch']}"
    if abs(t_s[-1] - seconds(request, answer["segments"][-1]["stop"])) > STEP_S + 1e-6:
        yield "the table ends elsewhere than its last segment"
    for axis, angle_deg in state["angles_deg"].items():
        rate_deg_s = state.get("rates_deg_s", {}).get(axis, 0.0)
        if abs(table[f"{axis}_deg"][0] - angle_deg) > ANGLE_DEG:
            yield f"{axis} begins at {table[f'{axis}_deg'][0]}, not {angle_deg}"
        if abs(table[f"{axis}_rate_deg_s"][0] - rate_deg_s) > ANGLE_DEG:
            yield f"{axis} begins with a rate of {table[f'{axis}_rate_deg_s'][0]}"


def _limit_faults(request: Fields, answer: Fields) -> Iterator[str]:
    """Of the cubics; not of jerk, which is not the plan's, whose acceleration is continuous."""
    for axis in _axes(request):
        angle, rate, acceleration = _motion(answer["table"], axis["name"])
        for what, values, low, high, slack in (
            ("angle", angle, axis["angle_min_deg"], axis["angle_max_deg"], ANGLE_DEG),
            ("rate", rate, -axis["rate_max_deg_s"], axis["rate_max_deg_s"], RATE_DEG_S),
            (
                "acceleration",
                acceleration,
                -axis["acceleration_max_deg_s2"],
                axis["acceleration_max_deg_s2"],
                ACCELERATION_DEG_S2,
            ),
        ):
            if not np.all(np.isfinite(values)):
                yield f"{axis['name']}'s {what} is not finite"
            excess = max(float(values.max()) - high, low - float(values.min()))
            if not excess <= slack:
                yield f"{axis['name']} passes its {what} limit by {excess:.3g}"


def _motion(table: Fields, axis: str) -> tuple[Array, Array, Array]:
    """Angle, rate and acceleration every 5 ms, acceleration from both sides of each row."""
    angle, rate = np.array(table[f"{axis}_deg"]), np.array(table[f"{axis}_rate_deg_s"])
    s = np.linspace(0.0, 1.0, FINE + 1)[:, None]
    a0, a1, v0, v1 = angle[:-1], angle[1:], rate[:-1] * STEP_S, rate[1:] * STEP_S
    rise = a1 - a0
    second, third = 3.0 * rise - 2.0 * v0 - v1, v0 + v1 - 2.0 * rise
    return (
        a0 + s * (v0 + s * (second + s * third)),
        (v0 + s * (2.0 * second + 3.0 * s * third)) / STEP_S,
        (2.0 * second + 6.0 * s * third) / STEP_S**2,
    )


def _pointing_faults(request: Fields, answer: Fields) -> Iterator[str]:
    if request["slew"].get("method") == "spline":  # which promises a way there and no more
        return
    held = {told["session"]: told for told in answer["pointing"]}
    for segment in answer["segments"]:
        if segment["kind"] != "track":
            continue
        number = segment["session"]
        session = request["sessions"][number]
        start_s, stop_s = (seconds(request, segment[end]) for end in ("start", "stop"))
        first, last = math.ceil(start_s / STEP_S - 1e-6), math.floor(stop_s / STEP_S + 1e-6)
        halves = np.arange(2 * first, 2 * last + 1)
        # An odd stride meets rows and the middles between them alike.
        halves = halves[:: len(halves) // INSTANTS // 2 * 2 + 1] * (STEP_S / 2.0)
        allowed = max(POINTING_ARCSEC, 1.05 * held[number]["max_arcsec"])
        if session.get("keyhole") != "nearest" and held[number]["max_arcsec"] > 0.1:
            yield f"session {number} is answered as {held[number]['max_arcsec']} arcsec off"
        off = _off_arcsec(request, answer, session, halves)
        if not off.max() <= allowed:
            yield f"session {number} points {off.max():.3f} arcsec off"


def _off_arcsec(request: Fields, answer: Fields, session: Fields, t_s: Array) -> Array:
    target = session["target"]
    angles = _angles(request, answer, t_s)
    if target["mode"] == "test_motion":
        since_s = t_s - seconds(request, session["start"])
        return np.max(
            [
                np.abs(_moved_deg(target["axes"][axis["name"]], since_s) - angles[:, k]) * 3600.0
                for k, axis in enumerate(_axes(request))
            ],
            axis=0,
        )
    sky = Sky(request, t_s)
    return apart(sky.towards(target, session), _boresight_eci(request, sky, angles)) / ARCSEC


def _cone_faults(request: Fields, answer: Fields) -> Iterator[str]:
    cones = request["slew"].get("keep_out", [])
    if not cones or request["slew"].get("method") == "spline":
        return
    t_s = np.array(answer["table"]["t_s"])
    sky = Sky(request, t_s)
    boresight = _boresight_eci(request, sky, _angles(request, answer, t_s))
    for number, cone in enumerate(cones):
        axis, counts = sky.cone(cone)
        depth = cone["half_angle_deg"] - np.degrees(apart(axis, boresight))
        if np.any(depth[counts] > CONE_DEG):
            yield f"cone {number} is entered by {depth[counts].max():.3f} deg"


def _angles(request: Fields, answer: Fields, t_s: Array) -> Array:
    """Degrees, (n, 2), at instants on rows or halfway."""
    columns = []
    for axis in _axes(request):
        fine, _, _ = _motion(answer["table"], axis["name"])
        rows, halves = np.append(fine[0], fine[-1, -1]), fine[FINE // 2]
        both = np.empty(2 * len(rows) - 1)
        both[::2], both[1::2] = rows, halves
        columns.append(both[np.rint(t_s / (STEP_S / 2.0)).astype(int)])
    return np.column_stack(columns)


def _boresight_eci(request: Fields, sky: Sky, angle_deg: Array) -> Array:
    outer, inner = (np.array(axis["axis_platform"]) for axis in _axes(request))
    platform = request["platform"]
    named = isinstance(platform, str)
    zero = [0.0, 0.0, 1.0] if named else platform.get("zero_direction_platform", [0.0, 0.0, 1.0])
    turned = Rotation.from_rotvec(np.outer(np.radians(angle_deg[:, 0]), unit(outer)))
    turned *= Rotation.from_rotvec(np.outer(np.radians(angle_deg[:, 1]), unit(inner)))
    return (mount(request) * sky.body_from_eci()).inv().apply(turned.apply(zero))


def _axes(request: Fields) -> tuple[Fields, Fields]:
    """Outer and inner, with the jerk limit asked for."""
    platform = ISS_HRC if isinstance(request["platform"], str) else request["platform"]
    jerk = request["slew"].get("jerk_max_deg_s3")
    outer, inner = (
        dict(platform[side]) | ({} if jerk is None else {"jerk_max_deg_s3": jerk})
        for side in ("outer", "inner")
    )
    return outer, inner


def _moved_deg(motion: Fields, since_s: Array) -> Array:
    centre = motion.get("angle_deg", 0.0)
    if motion["kind"] == "constant_rate":
        return np.asarray(centre + motion["rate_deg_s"] * since_s)
    phase = 2.0 * math.pi * motion["frequency_hz"] * since_s + math.radians(motion["phase_deg"])
    return np.asarray(centre + motion["amplitude_deg"] * np.sin(phase))
