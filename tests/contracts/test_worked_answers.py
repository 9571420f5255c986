"""Are the answers on the API's pages those that the service gives, all of them, and documented?"""

import json
import math
import re

import pytest
from api_document import api_document
from openapi_schema_validator import OAS31Validator
from worked_answers import WITHOUT_TEXT, all_answers

from app.http.openapi.schema import ANSWERS

# What no two runs share: identities, times of now (the requests' own lie before 2025), durations.
OF_THE_RUN = re.compile(
    r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}|(202[5-9]|20[3-9]\d)-\d\d-\d\d(T[\d:.]+Z?)?"
)
# Durations, versions, when a flat curve is at its extreme, a file's bytes, what is measured, and
# how much is said of what goes on.
BY_CHANCE = {
    "wall_s",
    "solve_s",
    "stages_wall_s",
    "version",
    "versions",
    "t_s",
    "at",
    "max_at",
    "image_png",
    "/readyz",
    "/metrics",
    "text/event-stream",
}
# Of simulated drives, whose encoders turn another processor's rounding into another count.
OF_DRIVES = {"error_arcsec", "error_m", "smear_px", "miss_m", "misses", "contributors"}
NUMBER = re.compile(r"[-+]?\d+\.\d+(?:[eE][-+]?\d+)?")


@pytest.fixture(scope="module")
def document():
    return api_document()


@pytest.fixture(scope="module")
def answered(tmp_path_factory):
    return all_answers(tmp_path_factory.mktemp("answers"))


def differences(shown, given, where="", by_chance=False):
    """Where two answers differ in more than chance."""
    if isinstance(shown, dict) and isinstance(given, dict) and list(shown) == list(given):
        for name in shown:
            chance = by_chance or name in OF_DRIVES
            # There it is also of a plan's id.
            names_a_plan = "/flights" in where or "/comparisons" in where
            chance = chance or (name == "input_sha256" and names_a_plan)
            chance = chance or (name in BY_CHANCE and not isinstance(shown[name], list))
            yield from differences(shown[name], given[name], f"{where} {name}", chance)
    elif isinstance(shown, list) and isinstance(given, list) and len(shown) == len(given):
        for row, pair in enumerate(zip(shown, given, strict=True)):
            yield from differences(*pair, f"{where} {row}", by_chance)
    elif type(shown) is not type(given) or not (by_chance or alike(shown, given)):
        yield f"{where}: {shown!r} is shown, {given!r} answered"


def alike(shown, given):
    """A thousandth, and a millionth of a degree, arcsecond or metre: much more than another
    processor's rounding and a solver's last step change, less than any part of the model left
    out would (aberration alone is 5 arcsec of a slew of 20 deg)."""
    if isinstance(shown, str):
        shown, given = OF_THE_RUN.sub("chance", shown), OF_THE_RUN.sub("chance", given)
        return NUMBER.sub("0", shown) == NUMBER.sub("0", given) and all(
            alike(float(one), float(other))
            for one, other in zip(NUMBER.findall(shown), NUMBER.findall(given), strict=True)
        )
    if isinstance(shown, float):
        return math.isclose(shown, given, rel_tol=1e-3, abs_tol=1e-6)
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
        ("-54.0332", "-54.1332"),
        ("17:36:20.0Z", "17:36:21.0Z"),
        ("NORAD 25544", "NORAD 25545"),
    ):
        assert one in text
        assert list(differences(shown, json.loads(text.replace(one, other))))


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
