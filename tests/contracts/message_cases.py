"""Damaged or mistaken messages, times and targets, and the field at which each is refused."""

import gzip
import json
from typing import Any

from app.requests.examples import message

ATTITUDE = message("attitude.aem")
ATTITUDE_HISTORY = message("attitude_history.aem")
OEM = message("orbit.oem")
OMM = message("elements.json")
OPM = message("state.opm")

Changes = tuple[tuple[str, object], ...]
READ, MESSAGE, UNCOVERED = "invalid-request", "invalid-message", "outside-coverage"
TARGET, STOP = "sessions.0.target", "sessions.0.stop"


def _orbit(source: str, content: str) -> Changes:
    return (("orbit", {"source": source, "content": content}),)


def _omm(**changes: Any) -> Changes:
    return _orbit("omm", json.dumps({**json.loads(OMM)[0], **changes}))


def _oem(old: str, new: str) -> Changes:
    assert old in OEM
    return _orbit("oem", OEM.replace(old, new))


def _opm(old: str, new: str) -> Changes:
    assert old in OPM
    return _orbit("opm", OPM.replace(old, new))


def _aem(old: str, new: str) -> Changes:
    assert old in ATTITUDE
    return (("attitude.content", ATTITUDE.replace(old, new)),)


def _turned(column_a: int, column_b: int) -> str:
    """The OEM with two columns of one node exchanged."""
    lines = OEM.splitlines()
    node = next(n for n, line in enumerate(lines) if line.startswith("2015-02-27T17:36:00"))
    columns = lines[node].split()
    columns[column_a], columns[column_b] = columns[column_b], columns[column_a]
    lines[node] = " ".join(columns)
    return "\n".join(lines)


def _short_history() -> str:
    lines = ATTITUDE_HISTORY.splitlines()
    return "\n".join([*lines[: lines.index("DATA_START") + 2], lines[-2], "DATA_STOP"]).replace(
        lines[lines.index("DATA_START") + 1], lines[-3]
    )


_INERTIAL = "attitude.epoch"
_POINT = {"latitude_deg": 36.05, "longitude_deg": -115.25}
_STATE_EPOCH = "orbit.epoch"

# name, example, changes, slug, field, says
MESSAGE_CASES: list[tuple[str, str, Changes, str, str, str]] = [
    ("OEM node 10 km off", "tle", _oem("2916.692669", "2926.692669"), MESSAGE,
     "orbit.content", "2015-02-27T17:36:00.000Z lies some 9983 m off"),
    ("OEM node 100 m off", "tle", _oem("2916.692669", "2916.792669"), MESSAGE,
     "orbit.content", "2015-02-27T17:36:00.000Z lies some 100 m off"),
    ("OEM velocity digit", "tle", _oem("3.438279501", "3.448279501"), MESSAGE,
     "orbit.content", "2015-02-27T17:36:00.000Z lies some"),
    ("OEM columns exchanged", "tle", _orbit("oem", _turned(1, 2)), MESSAGE,
     "orbit.content", "2015-02-27T17:36:00.000Z lies some"),
    ("OEM in another frame", "tle", _oem("EME2000", "ITRF"), MESSAGE,
     "orbit.content", "REF_FRAME"),
    ("OEM velocities in m/s", "tle",
     _orbit("oem", OEM.replace(" 3.438279501 ", " 3438.279501 ")), READ,
     "orbit.content", "must be in km/s"),
    ("OEM rows before START_TIME", "tle",
     _oem("START_TIME = 2015-02-27", "START_TIME = 2015-02-28"), READ, "orbit.content",
     "START_TIME"),
    ("OEM of the year 9999", "tle", _orbit("oem", OEM.replace("2015-", "9999-")), READ,
     "orbit.content", "1973-01-03..2053-10-08"),
    ("OEM compressed", "tle",
     _orbit("oem", gzip.compress(OEM.encode(), mtime=0).decode("latin-1")), READ,
     "orbit.content", "plain text"),
    ("OMM for SGP4-XP", "tle", _omm(EPHEMERIS_TYPE=4), READ, "orbit.content", "EPHEMERIS_TYPE"),
    ("OMM inclination", "tle", _omm(INCLINATION=999), READ, "orbit.content", "0..180"),
    ("OMM mean motion in rad/min", "tle", _omm(MEAN_MOTION=0.0678), READ, "orbit.content",
     "MEAN_MOTION must lie in 0.1..18"),
    ("OMM of another theory", "tle", _omm(MEAN_ELEMENT_THEORY="DSST"), READ, "orbit.content",
     "DSST"),
    ("OMM in another frame", "tle", _omm(REF_FRAME="EME2000"), READ, "orbit.content", "TEME"),
    ("OMM on another clock", "tle", _omm(TIME_SYSTEM="TAI"), READ, "orbit.content", "UTC"),
    ("OMM about the Moon", "tle", _omm(CENTER_NAME="MOON"), READ, "orbit.content", "EARTH"),
    ("OMM of the year 0001", "tle", _omm(EPOCH="0001-01-01T00:00:00"), READ, "orbit.content",
     "1973"),
    ("OPM in metres", "tle", _opm("2478.460528 [km]", "2478460.528"), READ, "orbit.content",
     "velocity (X_DOT, Y_DOT, Z_DOT)"),
    ("OPM mass", "tle", _opm("410000 [kg]", "0 [kg]"), READ, "orbit.content",
     "MASS must lie in 0.001"),
    ("OPM of two states", "tle", _orbit("opm", OPM + OPM), READ, "orbit.content", "second time"),
    ("history too short", "harmonic",
     (("attitude.content", _short_history()),), READ, "attitude.content", "history is only"),
    ("AEM digit", "aem", _aem("0.002148594", "0.003148594"), MESSAGE, "attitude.content",
     "2015-02-27T17:37:00.000Z lies 413 arcsec"),
    ("AEM sign", "aem", _aem("-0.012004947", "0.012004947"), MESSAGE, "attitude.content",
     "arcsec or more off"),
    ("yaw in arcsec", "tle", (("attitude.yaw_deg", 14760.0),), READ, "attitude.yaw_deg",
     "-360..360"),
    ("a spinning carrier", "inertial", (("attitude.omega_body_deg_s", [0.0, 1e300, 0.0]),), READ,
     "attitude.omega_body_deg_s.1", "-180..180"),
    ("mass in tonnes", "state", (("orbit.mass_kg", 410.0), ("orbit.drag_area_m2", 1600.0)), READ,
     "orbit.mass_kg", "is it in kg?"),
    ("velocity in m/s", "state", (("orbit.velocity_km_s", [3854.3, 4470.0, 4910.9]),), READ,
     "orbit.velocity_km_s", "in km/s"),
    ("attitude of another orbit", "inertial", ((_INERTIAL, "2015-02-27T15:00:00Z"),), UNCOVERED,
     _INERTIAL, "constant body rate"),
    ("ship of another year", "ground_moving", ((f"{TARGET}.epoch", "2005-02-27T17:00:00Z"),),
     READ, f"{TARGET}.epoch", "newer position"),
    ("the last year", "tle", ((STOP, "9999-12-31T23:59:59.9999999Z"),), READ, STOP, "2053"),
    ("the first year", "tle", ((STOP, "0001-01-01T00:00:00+05:00"),), READ, STOP, "1973"),
    ("before leap seconds", "state", ((_STATE_EPOCH, "1969-07-20T20:17:40Z"),), READ,
     _STATE_EPOCH, "1973"),
    ("after the last ephemeris", "inertial", ((_INERTIAL, "2054-01-01T00:00:00Z"),), READ,
     _INERTIAL, "2053"),
    ("one place twice", "ground_path",
     ((f"{TARGET}.points", [_POINT, _POINT]),), READ, f"{TARGET}.points.1", "same place"),
    ("path too short", "ground_path", ((f"{TARGET}.speed_m_s", 1000.0),), READ, STOP,
     "after the path's end"),
    ("just beyond a stop", "tle", (("initial_state.angles_deg.beta", 175.00001),), READ,
     "initial_state.angles_deg.beta", "is 175.00001, outside its limits -175..175"),
]  # fmt: skip
