"""An answered plan against what was asked, by geometry that shares nothing with the planner.

Knows the request and the answer as JSON and nothing else: SGP4 by python-sgp4, Earth and sky by
ERFA and Skyfield, geodesics by GeographicLib, and the table's own cubic Hermite every 5 ms.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from plan_oracle_sky import ARCSEC, Sky, apart, mount, seconds, unit, utc
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
Fields = dict[str, Any]
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
