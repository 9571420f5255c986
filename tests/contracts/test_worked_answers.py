"""The answers on the API's pages are those that the service gives, all of them, and documented."""

import json
import math
import re

import pytest
from api_document import api_document
from openapi_schema_validator import OAS31Validator
from worked_answers import WITHOUT_TEXT, all_answers

from app.http.openapi.schema import ANSWERS

# What no two runs share: identities, times of now (the requests' own lie before 2025), durations,
# and of how many lines a drawn curve is made.
OF_THE_RUN = re.compile(
    r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}|(202[5-9]|20[3-9]\d)-\d\d-\d\d(T[\d:.]+Z?)?"
    r"|(?<=lines of )\d+"
    r"|(?<=DTSTAMP:)\w+|(?<=UID:)\w+"
)
# Durations, versions, when a flat curve is at its extreme, a file's bytes, what is measured, and
# how much is said of what goes on.
BY_CHANCE = {
    "wall_s", "solve_s", "stages_wall_s", "version", "versions", "t_s", "at", "max_at",
    "image_png", "/readyz", "/metrics", "text/event-stream",
}  # fmt: skip
# What two processors agree to, relative and absolute, as docs/conventions.md tells.
AGREED = 1e-4, 1e-6
# Of flights: an encoder's count that rounding turned is another flight of drives as good.
FRAMES = 0.0, 3.0  # of the 270 of one flight, half of which are near the limit of a pixel
SMEAR_SHARE = 0.0, 0.5  # of 20 runs, whose own sigmas are 0.3
AGREED_OF_FLIGHTS = {
    "held": FRAMES,
    "sharp": FRAMES,
    "frames_held": (0.0, 0.005),
    "frames_sharp": (0.0, 0.005),
    "error_arcsec": (0.0, 0.3),
    "error_m": (0.0, 1.0),
    "smear_px": (0.0, 0.3),
    **dict.fromkeys(("share", "share_sigma", "alone_share", "alone_sigma"), (0.0, 0.001)),
    "smear_share": SMEAR_SHARE,
    "smear_share_sigma": SMEAR_SHARE,
    "smear_alone_share": SMEAR_SHARE,
    "smear_alone_sigma": SMEAR_SHARE,
}
# Of the spacecraft's slews: the jerk is flat about its least, so that a last digit moves a slew's
# extremes, and how its end shakes the structure, by a percent or two.
AGREED_OF_SLEWS = 0.05, 2e-4
AGREED_OF_SMEAR_PX = 0.05, 0.005  # less than any image shows
NUMBER = re.compile(r"[-+]?\d+\.\d+(?:[eE][-+]?\d+)?")


@pytest.fixture(scope="module")
def document():
    return api_document()


@pytest.fixture(scope="module")
def answered(tmp_path_factory):
    return all_answers(tmp_path_factory.mktemp("answers"))


def differences(shown, given, where="", agreed=AGREED):
    """Where two answers differ in more than chance; agreed: None where all is chance."""
    if isinstance(shown, dict) and isinstance(given, dict) and list(shown) == list(given):
        for name in shown:
            of_flights = AGREED_OF_FLIGHTS.get(name, agreed) if "/flights" in where else agreed
            if name.startswith("/v1/spacecraft/plans"):
                of_flights = AGREED_OF_SLEWS
            elif name == "smear_px" and "/v1/spacecraft" in where:
                of_flights = AGREED_OF_SMEAR_PX
            # There it is also of a plan's id.
            names_a_plan = "/flights" in where or "/comparisons" in where
            chance = agreed is None or (name == "input_sha256" and names_a_plan)
            chance = chance or (name in BY_CHANCE and not isinstance(shown[name], list))
            # Whether a job that is cancelled at once had begun.
            chance = chance or (name in ("started", "attempts") and " delete " in where)
            inside = None if chance else of_flights
            yield from differences(shown[name], given[name], f"{where} {name}", inside)
    elif isinstance(shown, list) and isinstance(given, list) and len(shown) == len(given):
        for row, pair in enumerate(zip(shown, given, strict=True)):
            yield from differences(*pair, f"{where} {row}", agreed)
    elif agreed is not None and (type(shown) is not type(given) or not alike(shown, given, agreed)):
        yield f"{where}: {shown!r} is shown, {given!r} answered"


def alike(shown, given, agreed=AGREED):
    """Numbers as agreed: more than rounding and a solver's last step change, less than any part
    of the model left out would (aberration alone is 5 arcsec of a slew of 20 deg)."""
    if isinstance(shown, str):
        shown, given = (
            OF_THE_RUN.sub("chance", text.replace("\r\n ", "")) for text in (shown, given)
        )
        return NUMBER.sub("0", shown) == NUMBER.sub("0", given) and all(
            alike(float(one), float(other), agreed)
            for one, other in zip(NUMBER.findall(shown), NUMBER.findall(given), strict=True)
        )
    if isinstance(shown, float) or agreed is FRAMES:
        relative, absolute = agreed
        return math.isclose(shown, given, rel_tol=relative, abs_tol=absolute)
    return shown == given


def test_answers_on_the_pages_are_those_given(answered):
    shown = json.loads(ANSWERS.read_text())
    assert list(differences(shown, answered)) == []


def test_a_changed_answer_is_noticed():
    shown = json.loads(ANSWERS.read_text())["/v1/plans"]["post"]["201"]
    text = json.dumps(shown)
    for one, other in (
        ('"state": "done"', '"state": "failed"'),
        ('"margins": {', '"margin": {'),
        ("-55.648", "-55.748"),
        ("17:36:20.0Z", "17:36:21.0Z"),
        ("NORAD 25544", "NORAD 25545"),
    ):
        assert one in text
        assert list(differences(shown, json.loads(text.replace(one, other))))


@pytest.mark.parametrize(
    ("name", "more"),
    [("frames_sharp", 0.01), ("error_arcsec", 0.5), ("smear_px", 0.5), ("share", 0.01)],
)
def test_a_changed_flight_is_noticed(name, more):
    shown = json.loads(ANSWERS.read_text())["/v1/flights/{id}"]
    changed = json.loads(json.dumps(shown), object_hook=lambda one: _raised(one, name, more))
    found = list(differences(shown, changed, " /v1/flights"))
    assert found
    assert all(f" {name}" in one for one in found)


def _raised(members, name, more):
    match members.get(name):
        case float(value):
            return members | {name: value + more}
        case [float(), *_] as values:
            return members | {name: [value + more for value in values]}
    return members


def contents(document):
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            for status, answer in operation["responses"].items():
                if status < "300":
                    for media_type, content in answer.get("content", {}).items():
                        yield f"{method} {path} {status} {media_type}", media_type, content


def test_every_answer_in_text_is_shown(document):
    missing = [
        where
        for where, media_type, content in contents(document)
        if "examples" not in content and media_type not in WITHOUT_TEXT
    ]
    assert missing == []


def test_answers_shown_are_as_documented(document):
    seen = 0
    for where, _, content in contents(document):
        for example in content.get("examples", {}).values():
            if "schema" in content:
                seen += 1
                schema = {**content["schema"], "components": document["components"]}
                found = OAS31Validator(schema).iter_errors(example["value"])
                assert [error.message for error in found] == [], where
    assert seen > 20
