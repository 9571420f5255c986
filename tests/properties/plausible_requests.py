"""Requests for plans as a planner might send them, at random but the same for the same seed.

A pass of a made-up low orbit; targets the carrier has in view by a rough look at the orbit; a
mount, axes, stops and limits; one to six sessions; cones, modes and ways out of conflicts.
Most can be planned; what can't must be refused in the usual way.
"""

import math
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

import erfa
import numpy as np
from mask_shapes import star
from numpy.typing import NDArray
from sgp4.api import WGS72, Satrec
from sgp4.exporter import export_tle

Array = NDArray[np.float64]
Fields = dict[str, Any]
EARTH_KM = 6371.0
SECOND_DAYS = 1.0 / 86400.0
STAR_ABOVE_LIMB_RAD = math.radians(10.0)


def plausible_request(seed: int, sessions_max: int = 6) -> Fields:
    """The request of that seed, with so many sessions at most."""
    rng = np.random.default_rng(seed)
    orbit = _random_orbit(rng)
    platform, axes = _platform(rng)
    lead_s = _tenths(rng, 30.0, 150.0)
    sessions = _sessions(rng, orbit, axes, lead_s, sessions_max)
    return {
        "name": f"plausible {seed}",
        "platform": platform,
        "orbit": {"source": "tle", "line1": orbit.lines[0], "line2": orbit.lines[1]},
        "attitude": _attitude(rng, orbit),
        "initial_state": _initial_state(rng, orbit, axes),
        "sessions": sessions,
        "slew": _slew(rng),
        "on_conflict": _one_of(rng, "refuse", "shorten_later", "shorten_earlier", "least_loss"),
    }


def with_time_to_spare(request: Fields, seed: int) -> Fields:
    """The same with a lead of its own, perhaps hours before its sessions, and a final state."""
    rng = np.random.default_rng(seed)
    slew, initial = dict(request["slew"]), dict(request["initial_state"])
    match _one_of(rng, "default", "all", "bounded"):
        case "all":
            slew["lead"] = "all"
        case "bounded":
            slew["lead"] = {"max_duration_s": _tenths(rng, 10.0, 600.0)}
    changed = request | {"slew": slew, "initial_state": initial}
    match _one_of(rng, "none", "rest", "angles"):
        case "rest":
            changed["final_state"] = "rest"
        case "angles":
            angles_deg = {axis: _short(rng.uniform(-60, 60)) for axis in initial["angles_deg"]}
            changed["final_state"] = {"angles_deg": angles_deg}
    if rng.random() < 0.5:
        earlier = timedelta(seconds=int(_log(rng, 100.0, 6000.0)))
        initial["epoch"] = _text(datetime.fromisoformat(initial["epoch"]) - earlier)
    return changed


def demanding_request(seed: int) -> Fields:
    """Of all that makes a request dear more, and together: up to eight sessions, mostly in least
    time, cones, masks, modes, short leads, axes whose limits are far from each other."""
    rng = np.random.default_rng([seed, 1])
    request = plausible_request(seed, sessions_max=8)
    if rng.random() < 0.5:
        request = with_time_to_spare(request, seed)
    slew, platform = dict(request["slew"]), request["platform"]
    if rng.random() < 0.6:
        slew["objective"] = "minimum_time"
    if rng.random() < 0.3:
        slew["lead"] = {"max_duration_s": _tenths(rng, 8.0, 60.0)}
    if rng.random() < 0.35:
        slew["avoid_modes"] = [
            {"frequency_hz": _log(rng, 0.05, 4.0)} for _ in range(int(rng.integers(1, 7)))
        ]
    if rng.random() < 0.35:
        slew["keep_out"] = [_cone(rng) for _ in range(int(rng.integers(1, 5)))]
    if isinstance(platform, dict):
        platform = dict(platform)
        for name in ("outer", "inner"):
            limits = {"acceleration_max_deg_s2": _log(rng, 0.2, 15.0)}
            limits["jerk_max_deg_s3"] = _log(rng, 0.1, 50.0)
            platform[name] = platform[name] | limits
        if rng.random() < 0.5:
            platform["masks"] = [_mask(rng, number) for number in range(int(rng.integers(1, 4)))]
    return request | {"slew": slew, "platform": platform}


def _mask(rng: np.random.Generator, number: int) -> Fields:
    size_rad, corners = math.radians(rng.uniform(4.0, 30.0)), int(rng.integers(4, 14))
    return {
        "name": f"mask {number}",
        "corners_platform": star(rng, _direction(rng), size_rad, corners).tolist(),
        "margin_deg": _one_of(rng, 0.0, 1.0),
    }


@dataclass(frozen=True)
class _Axis:
    """What the choice of states and test motions must know of an axis."""

    name: str
    low_deg: float
    high_deg: float
    rate_deg_s: float
    acceleration_deg_s2: float
    jerk_deg_s3: float


@dataclass(frozen=True)
class _Pass:
    """A satellite about an epoch, to a kilometre or so."""

    satrec: Satrec
    lines: tuple[str, str]
    epoch_utc: datetime

    def at(self, t_s: float) -> tuple[Array, Array]:
        """Position and velocity in inertial axes, km and km/s."""
        moment = self.satrec.jdsatepochF + self._since_elements_days + t_s * SECOND_DAYS
        error, r_km, v_km_s = self.satrec.sgp4(self.satrec.jdsatepoch, moment)
        assert error == 0
        return np.array(r_km), np.array(v_km_s)

    @property
    def _since_elements_days(self) -> float:
        elements = datetime(2000, 1, 1, 12, tzinfo=UTC)
        julian = self.satrec.jdsatepoch + self.satrec.jdsatepochF
        return (self.epoch_utc - elements) / timedelta(days=1) - (julian - 2451545.0)

    def sidereal_rad(self, t_s: float) -> float:
        """Greenwich's; UT1 is UTC here."""
        days = (self.epoch_utc - datetime(2000, 1, 1, 12, tzinfo=UTC)) / timedelta(days=1)
        return float(erfa.gmst82(2451545.0, days + t_s * SECOND_DAYS))


def _random_orbit(rng: np.random.Generator) -> _Pass:
    elements_utc = datetime(2012, 1, 1, tzinfo=UTC) + timedelta(days=float(rng.uniform(0, 4700)))
    altitude_km = rng.uniform(330.0, 900.0)
    motion_rad_min = 60.0 * math.sqrt(398600.4418 / (6378.137 + altitude_km) ** 3)
    satrec = Satrec()
    days = (elements_utc - datetime(1949, 12, 31, tzinfo=UTC)) / timedelta(days=1)
    satrec.sgp4init(
        WGS72, "i", 25544, days, rng.uniform(1e-5, 2e-4), 0.0, 0.0,
        rng.uniform(1e-4, 5e-3), rng.uniform(0, 2 * math.pi),
        math.radians(rng.uniform(20.0, 100.0)), rng.uniform(0, 2 * math.pi), motion_rad_min,
        rng.uniform(0, 2 * math.pi),
    )  # fmt: skip
    satrec.intldesg = "98067A"
    line1, line2 = export_tle(satrec)
    epoch_utc = elements_utc.replace(microsecond=0) + timedelta(
        seconds=float(rng.integers(-86400, 86400)), microseconds=int(rng.integers(5)) * 200_000
    )
    return _Pass(Satrec.twoline2rv(line1, line2, WGS72), (line1, line2), epoch_utc)


def _platform(rng: np.random.Generator) -> tuple[str | Fields, tuple[_Axis, _Axis]]:
    if rng.random() < 0.45:
        axes = (_Axis(name, -175.0, 175.0, 3.0, 1.0, 1.0) for name in ("alpha", "beta"))
        return "iss-hrc", tuple(axes)  # type: ignore[return-value]  # two of them
    outer_axis = _direction(rng)
    inner_axis = _across(rng, outer_axis, math.radians(90.0 - rng.choice([0.0, 0.0, 5.0, 25.0])))
    zero = _across(rng, inner_axis, math.radians(90.0 - rng.choice([0.0, 0.0, 3.0, 20.0])))
    mount = rng.normal(size=4)
    outer, inner = (_axis(rng, name) for name in ("alpha", "beta"))
    platform = {
        "name": "at random",
        "outer": _written(outer) | {"axis_platform": outer_axis.tolist()},
        "inner": _written(inner) | {"axis_platform": inner_axis.tolist()},
        "zero_direction_platform": zero.tolist(),
        "q_platform_from_body_xyzw": (mount / np.linalg.norm(mount)).tolist(),
    }
    return platform, (outer, inner)


def _axis(rng: np.random.Generator, name: str) -> _Axis:
    low, high = {
        "wide": (-175.0, 175.0),
        "turns": (-540.0, 540.0),
        "narrow": (-rng.uniform(60.0, 170.0), rng.uniform(60.0, 170.0)),
    }[_one_of(rng, "wide", "wide", "turns", "narrow")]
    rate = _log(rng, 1.0, 20.0)
    acceleration = _log(rng, 0.4, 6.0)
    return _Axis(name, _short(low), _short(high), rate, acceleration, _short(_log(rng, 0.4, 6.0)))


def _written(axis: _Axis) -> Fields:
    return {
        "name": axis.name,
        "angle_min_deg": axis.low_deg,
        "angle_max_deg": axis.high_deg,
        "rate_max_deg_s": axis.rate_deg_s,
        "acceleration_max_deg_s2": axis.acceleration_deg_s2,
        "jerk_max_deg_s3": axis.jerk_deg_s3,
    }


def _attitude(rng: np.random.Generator, orbit: _Pass) -> Fields:
    if rng.random() < 0.12:
        q = rng.normal(size=4)
        return {
            "law": "inertial",
            "epoch": _text(orbit.epoch_utc),
            "q_body_from_eci_xyzw": (q / np.linalg.norm(q)).tolist(),
            "omega_body_deg_s": rng.uniform(-0.07, 0.07, 3).tolist(),
        }
    size = _one_of(rng, 0.0, 3.0, 3.0, 40.0)
    yaw, pitch, roll = (_short(float(rng.uniform(-size, size))) for _ in range(3))
    return {"law": "lvlh", "yaw_deg": yaw, "pitch_deg": pitch, "roll_deg": roll}


def _initial_state(rng: np.random.Generator, orbit: _Pass, axes: tuple[_Axis, ...]) -> Fields:
    state: Fields = {"epoch": _text(orbit.epoch_utc), "angles_deg": {}}
    moving = rng.random() < 0.4
    if moving:
        state |= {"rates_deg_s": {}, "accelerations_deg_s2": {}}
    for axis in axes:
        middle, half = (axis.high_deg + axis.low_deg) / 2.0, (axis.high_deg - axis.low_deg) / 2.0
        half = min(0.8 * half, 170.0)
        state["angles_deg"][axis.name] = _short(float(rng.uniform(middle - half, middle + half)))
        if moving:
            rate = float(rng.uniform(-0.5, 0.5)) * min(axis.rate_deg_s, 4.0)
            state["rates_deg_s"][axis.name] = _short(rate)
            acceleration = float(rng.uniform(-0.3, 0.3)) * axis.acceleration_deg_s2
            state["accelerations_deg_s2"][axis.name] = _short(acceleration)
    return state


def _sessions(
    rng: np.random.Generator, orbit: _Pass, axes: tuple[_Axis, ...], lead_s: float, most: int
) -> list[Fields]:
    sessions = []
    at_s = lead_s
    for _ in range(min(int(rng.choice([1, 1, 1, 1, 2, 2, 3, 4, 5, 6])), most)):
        lasts_s = _tenths(rng, 5.0, 40.0)
        session: Fields = {
            "target": _target(rng, orbit, axes, at_s, lasts_s),
            "start": _text(orbit.epoch_utc + timedelta(seconds=at_s)),
            "stop": _text(orbit.epoch_utc + timedelta(seconds=at_s + lasts_s)),
        }
        if rng.random() < 0.1:
            session["keyhole"] = "nearest"
        sessions.append(session)
        at_s += lasts_s + _tenths(rng, 6.0, 80.0)
    return sessions


def _target(
    rng: np.random.Generator, orbit: _Pass, axes: tuple[_Axis, ...], at_s: float, lasts_s: float
) -> Fields:
    mode = _one_of(
        rng, "ground", "ground", "ground", "ground", "ground_path", "ground_moving", "star",
        "star", "body", "test_motion",
    )  # fmt: skip
    if mode == "test_motion":
        return {"mode": mode, "axes": {axis.name: _motion(rng, axis) for axis in axes}}
    if mode == "star":
        return _star(rng, orbit, at_s + lasts_s / 2.0)
    if mode == "body":
        name = _one_of(rng, "sun", "moon", "venus", "mars", "jupiter", "saturn")
        return {"mode": mode, "name": name}
    place = _place(rng, orbit, at_s + lasts_s / 2.0)
    if mode == "ground_moving":
        epoch_utc = orbit.epoch_utc + timedelta(seconds=_tenths(rng, -600.0, 600.0) + at_s)
        return {
            "mode": mode,
            "epoch": _text(epoch_utc),
            **place,
            "course_deg": _short(float(rng.uniform(0.0, 360.0))),
            "speed_m_s": _short(float(rng.uniform(0.0, 250.0))),
        }
    if mode == "ground_path":
        speed_m_s = _short(float(rng.uniform(20.0, 400.0)))
        return {
            "mode": mode,
            "speed_m_s": speed_m_s,
            "points": _path(rng, place, speed_m_s, lasts_s),
        }
    return {"mode": mode, **place}


def _place(rng: np.random.Generator, orbit: _Pass, at_s: float) -> Fields:
    """Within 50 deg of the nadir, more or less, as the carrier stands then."""
    r_km, _ = orbit.at(at_s)
    height_km = float(np.linalg.norm(r_km)) - EARTH_KM
    away_rad = height_km * math.tan(math.radians(rng.uniform(0.0, 50.0))) / EARTH_KM
    towards = _across(rng, r_km / np.linalg.norm(r_km), away_rad)
    longitude = math.degrees(math.atan2(towards[1], towards[0]) - orbit.sidereal_rad(at_s))
    geocentric = math.asin(towards[2])
    return {
        "latitude_deg": round(math.degrees(math.atan(math.tan(geocentric) / 0.99330562)), 6),
        "longitude_deg": round((longitude + 180.0) % 360.0 - 180.0, 6),
        "height_m": _short(float(rng.uniform(0.0, 2500.0))),
    }


def _path(
    rng: np.random.Generator, place: Fields, speed_m_s: float, lasts_s: float
) -> list[Fields]:
    """Two points or three, reached after the session's end."""
    points = [place]
    course = rng.uniform(0.0, 2.0 * math.pi)
    legs = int(rng.integers(1, 3))
    leg_m = speed_m_s * max(lasts_s * 1.1, 12.0 * legs) / legs
    for _ in range(legs):
        last = points[-1]
        north = math.degrees(leg_m * math.cos(course) / 6.36e6)
        east = math.degrees(leg_m * math.sin(course) / 6.36e6)
        east /= max(math.cos(math.radians(last["latitude_deg"])), 0.05)
        longitude = (last["longitude_deg"] + east + 180.0) % 360.0 - 180.0
        points.append(
            {
                "latitude_deg": round(min(max(last["latitude_deg"] + north, -89.9), 89.9), 6),
                "longitude_deg": round(longitude, 6),
                "height_m": last["height_m"],
            }
        )
        course += rng.uniform(-0.8, 0.8)
    return points


def _star(rng: np.random.Generator, orbit: _Pass, at_s: float) -> Fields:
    r_km, _ = orbit.at(at_s)
    distance_km = float(np.linalg.norm(r_km))
    limb_rad = math.asin(EARTH_KM / distance_km) + STAR_ABOVE_LIMB_RAD
    towards = _across(rng, -r_km / distance_km, float(rng.uniform(limb_rad, math.pi)))
    return {
        "mode": "star",
        "ra_deg": round(math.degrees(math.atan2(towards[1], towards[0])) % 360.0, 6),
        "dec_deg": round(math.degrees(math.asin(towards[2])), 6),
    }


def _motion(rng: np.random.Generator, axis: _Axis) -> Fields:
    """Well within the axis's limits, mostly."""
    room = min(axis.high_deg - axis.low_deg, 300.0)
    centre = _short((axis.high_deg + axis.low_deg) / 2.0 + float(rng.uniform(-0.2, 0.2)) * room)
    if rng.random() < 0.4:
        rate = _short(float(rng.uniform(-0.3, 0.3)) * min(axis.rate_deg_s, 2.0))
        return {"kind": "constant_rate", "angle_deg": centre, "rate_deg_s": rate}
    frequency = _log(rng, 0.01, 0.15)
    omega = 2.0 * math.pi * frequency
    largest = min(
        axis.rate_deg_s / omega, axis.acceleration_deg_s2 / omega**2, axis.jerk_deg_s3 / omega**3
    )
    amplitude = _short(float(rng.uniform(0.05, 0.5)) * min(largest, 0.1 * room))
    return {
        "kind": "sine",
        "angle_deg": centre,
        "amplitude_deg": amplitude,
        "frequency_hz": frequency,
        "phase_deg": _short(float(rng.uniform(-180.0, 180.0))),
    }


def _slew(rng: np.random.Generator) -> Fields:
    slew: Fields = {
        "method": "spline" if rng.random() < 0.06 else "ocp",
        "objective": "minimum_time" if rng.random() < 0.3 else "smooth",
    }
    if rng.random() < 0.2:
        slew["jerk_max_deg_s3"] = _log(rng, 0.4, 4.0)
    if rng.random() < 0.25:
        slew["keep_out"] = [_cone(rng) for _ in range(int(rng.integers(1, 3)))]
    if rng.random() < 0.15:
        slew["avoid_modes"] = [
            {"frequency_hz": _log(rng, 0.05, 2.0), "damping": _one_of(rng, 0.0, 0.005, 0.02)}
            for _ in range(int(rng.integers(1, 4)))
        ]
    return slew


def _cone(rng: np.random.Generator) -> Fields:
    half_angle_deg = _short(float(rng.uniform(2.0, 25.0)))
    about: Fields = {
        "body": {"body": _one_of(rng, "sun", "sun", "moon")},
        "sky": {
            "ra_deg": _short(float(rng.uniform(0.0, 360.0))),
            "dec_deg": _short(float(rng.uniform(-80.0, 80.0))),
        },
        "lvlh": {"direction_lvlh": _direction(rng).tolist()},
        "platform": {"direction_platform": _direction(rng).tolist()},
    }[_one_of(rng, "body", "body", "sky", "lvlh", "platform")]
    return {"half_angle_deg": half_angle_deg, **about}


def _direction(rng: np.random.Generator) -> Array:
    vector = rng.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def _across(rng: np.random.Generator, axis: Array, away_rad: float) -> Array:
    """A direction so far from a unit vector, on any side."""
    side = np.cross(axis, _direction(rng))
    side /= np.linalg.norm(side)
    return np.asarray(math.cos(away_rad) * axis + math.sin(away_rad) * side)


def _one_of(rng: np.random.Generator, *choices: Any) -> Any:
    return choices[int(rng.integers(len(choices)))]


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return _short(float(np.exp(rng.uniform(math.log(low), math.log(high)))))


def _tenths(rng: np.random.Generator, low: float, high: float) -> float:
    """On the table's grid of 0.2 s."""
    return float(rng.integers(round(low * 5), round(high * 5))) / 5.0


def _short(number: float) -> float:
    return round(number, 4)


def _text(utc: datetime) -> str:
    return utc.strftime("%Y-%m-%dT%H:%M:%S.") + f"{utc.microsecond // 100_000}Z"
