"""A body and its telemetry, written for tests alone: it knows only the table's columns.

Nothing here comes from the planner: SciPy's rotation spline goes through the rows, whose rates are
its own; the attitude is moved by delays, a wander and biases, and measured by a tracker and gyros.
"""

import csv
import io
import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation, RotationSpline

ARCSEC = math.radians(1.0 / 3600.0)
EXAMPLE = Path(__file__).parents[1] / "examples" / "three_sessions.json"
PLATFORM = {
    "kind": "body",
    "name": "smallsat",
    "agility": {
        "limits": "magnitude",
        "rate_max_deg_s": 3.0,
        "acceleration_max_deg_s2": 0.5,
        "jerk_max_deg_s3": 0.3,
        "settle_s": 4.0,
    },
    "off_nadir_max_deg": 60.0,
    "camera": {"type": "frame", "field_of_view_deg": [2.0, 1.5]},
}


def body_request(sessions=2):
    """So many of the example's cities, of which each takes a slew."""
    request = json.loads(EXAMPLE.read_text())
    del request["attitude"]
    request["initial_state"] = {"epoch": request["initial_state"]["epoch"]}
    return request | {"platform": PLATFORM, "sessions": request["sessions"][:sessions]}


@dataclass(frozen=True, kw_only=True)
class Flown:
    """By body axes x, y, z where there are three."""

    offset_s: float = 0.37
    drift: float = 20e-6
    late_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bias_arcsec: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gyro_bias_arcsec_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    noise_arcsec: float = 5.0
    gyro_noise_arcsec_s: float = 1.0
    wander_arcsec: float = 0.0
    half_life_s: float = 5.0
    rate_hz: float = 5.0


def written(columns, flown, seed, order="xyzw of eci_from_body"):
    """CSV of telemetry with q_1 to q_4 and rates; columns: of the table, by their names.

    order: "wxyz" for the scalar first; "body_from_eci" for the turn the other way.
    """
    chance = np.random.default_rng(seed)
    q = np.transpose([columns[f"q_eci_from_body_{part}"] for part in "xyzw"])
    rows_s = np.array(columns["t_s"])
    spline = RotationSpline(rows_s, Rotation.from_quat(q))
    t_s = np.arange(0.05, rows_s[-1] - 0.05, 1.0 / flown.rate_hz)
    # The spline's rates are about the body's axes.
    omega, alpha = spline(t_s, 1), spline(t_s, 2)
    kept = 0.5 ** (1.0 / flown.rate_hz / flown.half_life_s)
    shocks = chance.normal(0.0, math.sqrt(1.0 - kept**2), (len(t_s), 3))
    shocks[0] /= math.sqrt(1.0 - kept**2)
    wander = flown.wander_arcsec * lfilter([1.0], [1.0, -kept], shocks, axis=0)
    noise = chance.normal(0.0, flown.noise_arcsec, (len(t_s), 3))
    turn = ARCSEC * (wander + noise + flown.bias_arcsec) - omega * flown.late_s
    told = (spline(t_s) * Rotation.from_rotvec(turn)).as_quat()
    if "body_from_eci" in order:
        told = told * [-1.0, -1.0, -1.0, 1.0]
    if "wxyz" in order:
        told = np.roll(told, 1, axis=1)
    rates_deg_s = np.degrees(omega - alpha * flown.late_s)
    rates_deg_s += np.array(flown.gyro_bias_arcsec_s) / 3600.0
    rates_deg_s += chance.normal(0.0, flown.gyro_noise_arcsec_s / 3600.0, (len(t_s), 3))
    tag_s = flown.offset_s + (1.0 + flown.drift) * t_s
    names = ["t_s", "q_1", "q_2", "q_3", "q_4", *(f"omega_body_deg_s_{one}" for one in "xyz")]
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow(names)
    table = np.column_stack([tag_s, told, rates_deg_s]).tolist()
    writer.writerows([f"{value:.12f}" for value in row] for row in table)
    return out.getvalue().encode()
