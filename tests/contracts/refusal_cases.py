"""Bad requests, with the problem and the field of each refusal."""

import copy
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from message_cases import MESSAGE_CASES
from pydantic import TypeAdapter

from app.requests.examples import LAS_VEGAS, PLAN_EXAMPLES
from planner.world.platforms import PLATFORMS, definition_of

Request = dict[str, Any]


@dataclass(frozen=True)
class Refused:
    """The body of a request, and what its refusal must say."""

    name: str
    body: bytes
    slug: str
    field: str | None
    says: str


def request(*changes: tuple[str, object], example: str = "tle") -> Request:
    """A worked example with the values at some dotted paths replaced or added."""
    document = copy.deepcopy(PLAN_EXAMPLES[example][1])
    for path, value in changes:
        *parents, last = path.split(".")
        node: Any = document
        for key in parents:
            node = node[int(key)] if isinstance(node, list) else node[key]
        node[last] = value
    return document


# The first ten seconds of the session, to be quick.
SHORT = request(
    ("initial_state.epoch", "2015-02-27T17:35:00Z"), ("sessions.0.stop", "2015-02-27T17:36:30Z")
)


def _refused(
    name: str, document: Request | str | bytes, slug: str, field: str | None, says: str
) -> Refused:
    if isinstance(document, dict):
        document = json.dumps(document)
    body = document.encode() if isinstance(document, str) else document
    return Refused(name, body, slug, field, says)


def _stiff_platform() -> Any:
    """The ISS platform with stops at which the pass is out of reach."""
    platform = TypeAdapter(object).dump_python(definition_of(PLATFORMS["iss-hrc"]), mode="json")
    for axis in ("outer", "inner"):
        platform[axis] |= {"angle_min_deg": -2.0, "angle_max_deg": 2.0}
    return platform


def _coned(**direction: object) -> Request:
    return request(("slew.keep_out", [{"half_angle_deg": 30.0, **direction}]))


def _masked(corners: list[list[float]]) -> Request:
    return request(("platform.masks.0.corners_platform", corners), example="masks")


def _corrected(turn_y_deg: float, variance_deg2: float) -> Any:
    rows = [[variance_deg2 if i == k else 0.0 for i in range(3)] for k in range(3)]
    return {"law": "lvlh", "corrections": [{
        "epoch": "2015-02-27T17:30:00Z", "turn_body_deg": [0.0, turn_y_deg, 0.0],
        "covariance_deg2": rows}]}  # fmt: skip


def _at(target: Request) -> Request:
    return request((TARGET, target))


def _never_at_zero() -> Request:
    """No initial state, and a platform that can't be at zero."""
    document = request(("platform.inner.angle_min_deg", 10.0), example="platform")
    del document["initial_state"]
    return document


TARGET = "sessions.0.target"
_LINES = (LAS_VEGAS["orbit"]["line1"], LAS_VEGAS["orbit"]["line2"])
_CHECKSUM_OFF = LAS_VEGAS["orbit"]["line1"][:-1] + "2"
_READ, _UNCOVERED = "invalid-request", "outside-coverage"

_BY_FIELD: list[tuple[str, Callable[[], Request], str, str | None, str]] = [
    ("NaN", lambda: request((f"{TARGET}.latitude_deg", float("nan"))), _READ,
     f"{TARGET}.latitude_deg", "finite"),
    ("Infinity", lambda: request(("initial_state.angles_deg.beta", float("-inf"))), _READ,
     "initial_state.angles_deg.beta", "finite"),
    ("true for a number", lambda: request((f"{TARGET}.height_m", True)), _READ,
     f"{TARGET}.height_m", "a number"),
    ("unknown field", lambda: request((f"{TARGET}.heigth_m", 610.0)), _READ,
     f"{TARGET}.heigth_m", "remove it"),
    ("missing field", lambda: request((TARGET, {"mode": "ground", "latitude_deg": 1.0})), _READ,
     f"{TARGET}.longitude_deg", "required"),
    ("unknown kind", lambda: request(("orbit", {"source": "kepler"})), _READ,
     "orbit.source", "tle"),
    ("unknown kind of motion",
     lambda: request((TARGET, {"mode": "test_motion", "axes": {"alpha": {"kind": "jump"}}})), _READ,
     f"{TARGET}.axes.alpha.kind", "constant_rate"),
    ("no kind", lambda: request(("attitude", {"yaw_deg": 0.0})), _READ, "attitude.law", "lvlh"),
    ("unknown platform", lambda: request(("platform", "hubble")), _READ, "platform", "iss-hrc"),
    ("unknown method", lambda: request(("slew.method", "magic")), _READ, "slew.method", "ocp"),
    ("naive time", lambda: request(("sessions.0.start", "2015-02-27T17:36:20")), _READ,
     "sessions.0.start", "append Z"),
    ("no such day", lambda: request(("sessions.0.stop", "2015-02-29T17:37:50Z")), _READ,
     "sessions.0.stop", "no time"),
    ("no such leap second", lambda: request(("sessions.0.stop", "2015-02-27T23:59:60Z")), _READ,
     "sessions.0.stop", "leap second"),
    ("time as a number", lambda: request(("sessions.0.stop", 1425058670)), _READ,
     "sessions.0.stop", "string"),
    ("stop before start", lambda: request(("sessions.0.stop", "2015-02-27T17:36:10Z")), _READ,
     "sessions.0.stop", "after start"),
    ("too short", lambda: request(("sessions.0.stop", "2015-02-27T17:36:20.1Z")), _READ,
     "sessions.0.stop", "0.2 s, after start, not 0.1 s"),
    ("no session", lambda: request(("sessions", [])), _READ, "sessions", "at least one"),
    ("overlap", lambda: request(("sessions", LAS_VEGAS["sessions"] * 2)), _READ,
     "sessions.1.start", "must not come before sessions.0.stop"),
    ("too many", lambda: request(("sessions", LAS_VEGAS["sessions"] * 201)), _READ, "sessions",
     "must hold at most 200 entries"),
    ("too long", lambda: request(("sessions.0.stop", "2015-03-01T17:36:20Z")), _READ,
     "sessions", "86400 s"),
    ("state after a plan nobody kept",
     lambda: request(("initial_state", {"after": "no-plan"})), "invalid-input",
     "initial_state.after", "plan"),
    ("motion without an epoch", lambda: request(("initial_state", {
        "angles_deg": {"alpha": 0.0, "beta": 0.0}, "rates_deg_s": {"alpha": 1.0, "beta": 0.0}})),
     _READ, "initial_state.epoch", "required"),
    ("zero outside the stops", lambda: _never_at_zero(),
     _READ, None, "initial_state.angles_deg.tilt is 0, outside its limits 10..175"),
    ("no such town", lambda: _at({"mode": "place", "name": "Ljublana"}), _READ,
     f"{TARGET}.name", "do you mean 'Ljubljana, SI'"),
    ("a town's name without letters", lambda: _at({"mode": "place", "name": ", SI"}), _READ,
     f"{TARGET}.name", "known here; give latitude_deg"),
    ("many towns", lambda: _at({"mode": "place", "name": "Portland"}), _READ,
     f"{TARGET}.name", "'Portland, Oregon, US' (45.52, -122.68) or 'Portland, Maine, US'"),
    ("a town in another country", lambda: _at({"mode": "place", "name": "Ljubljana, AT"}), _READ,
     f"{TARGET}.name", "do you mean 'Ljubljana, SI'"),
    ("no such star", lambda: _at({"mode": "star", "name": "Sirus"}), _READ,
     f"{TARGET}.name", "do you mean Sirius"),
    ("a star by name and number", lambda: _at({"mode": "star", "name": "Vega", "hip": 91262}),
     _READ, f"{TARGET}.name", "already says hip"),
    ("two sets of elements", lambda: request(("orbit", {"source": "tle", "content": "\n".join(
        [*_LINES, *_LINES])})), _READ, "orbit.content", "lines sent: 4"),
    ("elements twice", lambda: request(("orbit.content", "\n".join(_LINES))), _READ,
     "orbit.content", "leave out line1 and line2"),
    ("half a set of elements", lambda: request(("orbit", {"source": "tle", "line1": _LINES[0]})),
     _READ, "orbit.line2", "required"),
    ("elements as a list of two",
     lambda: request(("orbit", {"source": "omm", "content": [{}, {}]})),
     _READ, "orbit.content", "one satellite"),
    ("elements as a number", lambda: request(("orbit", {"source": "omm", "content": 25544})), _READ,
     "orbit.content", "must be a string"),
    ("latitude", lambda: request((f"{TARGET}.latitude_deg", 90.5)), _READ,
     f"{TARGET}.latitude_deg", "-90..90"),
    ("angle at start", lambda: request(("initial_state.angles_deg.beta", 180.0)), _READ,
     "initial_state.angles_deg.beta", "-175..175"),
    ("rate at start", lambda: request(("initial_state.rates_deg_s.alpha", -3.5)), _READ,
     "initial_state.rates_deg_s.alpha", "-3..3"),
    ("axis of another platform", lambda: request(("initial_state.angles_deg", {"azimuth": 0.0})),
     _READ, "initial_state.angles_deg", "alpha, beta"),
    ("TLE checksum", lambda: request(("orbit.line1", _CHECKSUM_OFF)), _READ,
     "orbit.line1", "checksum"),
    ("OEM of nothing", lambda: request(("orbit.content", "hello"), example="oem"), _READ,
     "orbit.content", "line 1"),
    ("AEM of nothing", lambda: request(("attitude", {"law": "aem", "content": "x"})), _READ,
     "attitude.content", "line 1"),
    ("no history", lambda: request(("attitude", {"law": "harmonic", "content": "x"})), _READ,
     "attitude.content", "line 1"),
    ("a correction beyond belief", lambda: request(("attitude", _corrected(0.5, 1e-4))),
     "invalid-input", "attitude.corrections", "sigma from the law"),
    ("an exact correction", lambda: request(("attitude", _corrected(0.0, 0.0))), _READ,
     "attitude.corrections.0.covariance_deg2", "no measurement is exact"),
    ("OMM of nothing", lambda: request(("orbit", {"source": "omm", "content": "x"})), _READ,
     "orbit.content", "OMM"),
    ("OPM of nothing", lambda: request(("orbit", {"source": "opm", "content": "x"})), _READ,
     "orbit.content", "OPM"),
    ("no such star", lambda: request((TARGET, {"mode": "star", "hip": 200_000})), _READ,
     f"{TARGET}.hip", "catalogue"),
    ("no such body", lambda: request((TARGET, {"mode": "body", "name": "pluton"})), _READ,
     f"{TARGET}.name", "jupiter"),
    ("no such way out", lambda: request(("on_conflict", "drop")), _READ,
     "on_conflict", "least_loss"),
    ("a star behind the Earth", lambda: request((TARGET, {"mode": "star", "hip": 32349})),
     "not-visible", "sessions.0.start", "limb"),
    ("test motion beyond a limit",
     lambda: request(("sessions.0.target.axes.alpha.amplitude_deg", 20.0), example="test_motion"),
     "track-breaks-limit", f"{TARGET}.axes.alpha", "-3..3"),
    ("test motion of another platform",
     lambda: request(("sessions.0.target.axes", {"tilt": {"kind": "constant_rate",
                                                        "rate_deg_s": 0.0}}),
                     example="test_motion"),
     "invalid-input", f"{TARGET}.axes", "alpha, beta"),
    ("a lead of a word", lambda: request(("slew.lead", "some")), _READ, "slew.lead", "'all'"),
    ("a lead of a number", lambda: request(("slew.lead", 60)), _READ, "slew.lead", "an object"),
    ("no final angle", lambda: request(("final_state", {"angles_deg": {"alpha": 1.0}})), _READ,
     "final_state.angles_deg", "alpha, beta"),
    ("final angle",
     lambda: request(("final_state", {"angles_deg": {"alpha": 0.0, "beta": 176.0}})), _READ,
     "final_state.angles_deg.beta", "-175..175"),
    ("no such park", lambda: request(("final_state", {"park": "harbour"})), _READ,
     "final_state.park", "zero"),
    ("final_by alone", lambda: request(("final_by", "2015-02-27T18:00:00Z")), _READ, "final_by",
     "final_state be given"),
    ("no final state", lambda: request(("final_state", {})), _READ, "final_state", "either"),
    ("park of other axes",
     lambda: request(("platform.park_positions_deg", {"stowed": {"alpha": 0.0}}),
                     example="platform"), _READ,
     "platform.park_positions_deg.stowed", "azimuth, tilt"),
    ("park beyond a stop",
     lambda: request(("platform.park_positions_deg", {"stowed": {"azimuth": 0.0, "tilt": 176.0}}),
                     example="platform"), _READ,
     "platform.park_positions_deg.stowed.tilt", "-175..175"),
    ("a cone without direction", lambda: request(("slew.keep_out", [{"half_angle_deg": 9.0}])),
     _READ, "slew.keep_out.0", "one direction"),
    ("a cone of two directions", lambda: _coned(body="sun", ra_deg=1.0, dec_deg=2.0),
     _READ, "slew.keep_out.0", "one direction"),
    ("a cone of half a direction", lambda: _coned(ra_deg=1.0),
     _READ, "slew.keep_out.0.ra_deg", "belong together"),
    ("a cone about a star by name", lambda: _coned(body="sirius"),
     _READ, "slew.keep_out.0.body", "must be one of"),
    ("a cone about nothing", lambda: _coned(direction_lvlh=[0.0, 0.0, 0.0]),
     _READ, "slew.keep_out.0.direction_lvlh", "at least 0.001 long"),
    ("a mask of two corners", lambda: _masked([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
     _READ, "platform.masks.0.corners_platform", "3 to 64 corners"),
    ("a mask whose sides cross",
     lambda: _masked([[1, 0, 3], [0, 1, 3], [1, 1, 3], [0, 0, 3]]),
     _READ, "platform.masks.0.corners_platform", "the side from 0 crosses the side from 2"),
    ("a mask of a hemisphere", lambda: _masked([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]),
     _READ, "platform.masks.0.corners_platform", "within 85 deg of their middle"),
    ("a mask with a corner twice", lambda: _masked([[1, 0, 3], [1, 0, 3], [1, 1, 3], [0, 0, 3]]),
     _READ, "platform.masks.0.corners_platform", "0 and 1 are 0 deg apart"),
    ("a mask that encloses nothing", lambda: _masked([[1, 0, 3], [0, 0, 3], [-1, 0, 3]]),
     _READ, "platform.masks.0.corners_platform", "0.01 deg wide or more everywhere"),
    ("a mask from behind the platform's base", lambda: _masked([[1, 0, 0], [0, 0, 0], [1, 1, 3]]),
     _READ, "platform.masks.0.corners_platform.1", "at least 0.001 long"),
    ("a mask without a name", lambda: request(("platform.masks.0.name", ""), example="masks"),
     _READ, "platform.masks.0.name", "must not be empty"),
    ("two masks of one name",
     lambda: request(("platform.masks", 2 * request(example="masks")["platform"]["masks"]),
                     example="masks"),
     _READ, "platform.masks.1.name", "must be its own"),
    ("too many masks",
     lambda: request(("platform.masks", [{**request(example="masks")["platform"]["masks"][0],
                                          "name": str(number)} for number in range(9)]),
                     example="masks"),
     _READ, "platform.masks", "at most 8"),
    ("a target behind a mask", lambda: _masked([[9, 1, 9], [-9, 1, 9], [-9, -1, 9], [9, -1, 9]]),
     "not-visible", "sessions.0.target", "inside the mask"),
    ("too many cones",
     lambda: request(("slew.keep_out", [{"half_angle_deg": 1.0, "body": "sun"}] * 9)), _READ,
     "slew.keep_out", "at most 8"),
    ("TLE of another month",
     lambda: json.loads(json.dumps(request(("orbit", {}))).replace("2015-02-27", "2015-04-05"))
     | {"orbit": LAS_VEGAS["orbit"]},
     _UNCOVERED, "orbit.line1", "30 days"),
    ("OEM ends before the session",
     lambda: request(("sessions.0.stop", "2015-02-27T17:45:00Z"), example="oem"), _UNCOVERED,
     "orbit.content", "17:44"),
    ("below the horizon", lambda: request((f"{TARGET}.latitude_deg", -36.1147)), "not-visible",
     "sessions.0.start", "elevation"),
    ("below the elevation asked for", lambda: request((f"{TARGET}.min_elevation_deg", 89.0)),
     "not-visible", "sessions.0.start", "89 deg"),
    ("out of reach", lambda: request(("platform", _stiff_platform())), "unreachable",
     "sessions.0.start", "its stop at -2 deg"),
    ("a sliver of time", lambda: request(("initial_state.epoch", "2015-02-27T17:36:19.4Z")),
     "infeasible-slew", "sessions.0.start", "earliest"),
    ("too short a slew", lambda: request(("slew.lead", {"max_duration_s": 5.0})),
     "infeasible-slew", "sessions.0.start", "the 5 s of slew.lead.max_duration_s"),
    ("too short a slew to rest",
     lambda: request(("slew.lead", {"max_duration_s": 25.0}),
                     ("final_state", {"angles_deg": {"alpha": -120.0, "beta": 0.0}})),
     "infeasible-slew", "slew.lead.max_duration_s", "final_state"),
    ("too little time to rest",
     lambda: request(("final_by", "2015-02-27T17:36:00Z"), ("final_state", "rest")),
     "infeasible-slew", "final_by", "leaves 0 s"),
]  # fmt: skip

BY_TEXT = [
    _refused("empty", "", _READ, None, "JSON"),
    _refused("cut off", '{"name": "Las', _READ, None, "JSON"),
    _refused("not an object", "[]", _READ, None, "object"),
    _refused("not UTF-8", b'{"name": "\xff"}', _READ, None, "UTF-8"),
    _refused("lone surrogate", b'{"name": "\\ud800"}', _READ, None, "JSON"),
    _refused("nested", "[" * 100_000, _READ, None, "nested"),
    _refused("field twice", '{"name": "a", "name": "b"}', _READ, None, "'name'"),
    _refused("number of 5000 digits", '{"name": ' + "1" * 5000 + "}", _READ, None, "JSON"),
    _refused("50,001 objects", json.dumps([{}] * 50_001), _READ, None, "more than 50000"),
    _refused(
        "1001 fields", json.dumps({str(n): n for n in range(1001)}), _READ, None, "more than 1000"
    ),
]

CASES = (
    BY_TEXT
    + [_refused(name, make(), slug, field, says) for name, make, slug, field, says in _BY_FIELD]
    + [
        _refused(name, request(*changes, example=example), slug, field, says)
        for name, example, changes, slug, field, says in MESSAGE_CASES
    ]
)
