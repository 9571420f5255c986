"""All text of a request is short and visible, and little of it is repeated in refusals."""

import json
import re
from collections.abc import Callable, Iterator
from copy import deepcopy

import pytest

from app.answers.problem import problem_of
from app.requests import examples
from app.requests.campaign import read_campaign_request
from app.requests.plan import read_plan_request
from app.requests.spacecraft import read_spacecraft_request
from app.work.horizon import PREDICTION_READER
from app.work.searches import read_opportunity_request
from planner.base.errors import InvalidInput, Refusal

OEM = examples.message("orbit.oem")

MOST = 200
READERS: dict[Callable[[bytes], object], dict] = {
    read_plan_request: examples.PLAN_EXAMPLES,
    read_campaign_request: examples.CAMPAIGN_EXAMPLES,
    read_opportunity_request: examples.OPPORTUNITY_EXAMPLES,
    read_spacecraft_request: examples.SPACECRAFT_EXAMPLES,
}
EXAMPLES = [
    pytest.param(read, example, id=f"{read.__name__}-{name}")
    for read, examples in READERS.items()
    for name, (_, example) in examples.items()
]
HIDDEN = {
    "null": "a\u0000b",
    "bell": "a\u0007b",
    "newline": "a\nb",
    "delete": "a\u007fb",
    "next line": "a\u0085b",
    "right to left": "a\u202eb",
    "isolate": "a\u2066b",
    "mark": "a\u200fb",
    "no width": "a\ufeffb",
    "separator": "a\u2028b",
    "half a pair": "a\ud800b",
}


def texts(node: object, path: tuple = ()) -> Iterator[tuple]:
    """Where a document has a text that a request may choose, or the name of an axis."""
    if isinstance(node, dict):
        for name, value in node.items():
            if name != "type":  # which GeoJSON says and nobody reads
                yield from texts(value, (*path, name))
    elif isinstance(node, list):
        for place, value in enumerate(node[:2]):
            yield from texts(value, (*path, place))
    elif isinstance(node, str):
        yield path


def with_text(document: dict, path: tuple, text: str) -> bytes:
    changed = deepcopy(document)
    node = changed
    for step in path[:-1]:
        node = node[step]
    node[path[-1]] = text
    return json.dumps(changed).encode()


def refusal_of(read, body: bytes) -> str:
    with pytest.raises(Refusal) as caught:
        read(body)
    return json.dumps(problem_of(caught.value))


CITIES, STRIP = examples.CAMPAIGN_EXAMPLES["cities"][1], examples.SPACECRAFT_EXAMPLES["geojson"][1]
NAMES = [
    *(
        (read_plan_request, examples.LAS_VEGAS, path)
        for path in ("name", "sessions.0.id", "sessions.0.name")
    ),
    *((read_campaign_request, CITIES, path) for path in ("name", "targets.1.id")),
    (read_opportunity_request, examples.OPPORTUNITY_EXAMPLES["cities"][1], "name"),
    (read_spacecraft_request, STRIP, "name"),
    (read_spacecraft_request, STRIP, "requests.features.0.properties.name"),
    (PREDICTION_READER.read, examples.PREDICTION_EXAMPLES["pass"][1], "cameras.0.name"),
]


@pytest.mark.parametrize(("read", "example"), EXAMPLES)
@pytest.mark.parametrize("text", ["x" * (MOST + 1), "a\u0000b"], ids=["long", "null"])
def test_every_text_of_every_request_is_bounded(read, example, text):
    for path in texts(example):
        told = refusal_of(read, with_text(example, path, text))
        assert "x" * (MOST + 1) not in told, path


@pytest.mark.parametrize("text", [*HIDDEN.values(), "x" * (MOST + 1)], ids=[*HIDDEN, "long"])
def test_what_can_not_be_seen_or_is_long_is_no_name(text):
    for read, example, name in NAMES:
        path = [int(part) if part.isdecimal() else part for part in name.split(".")]
        problem = json.loads(refusal_of(read, with_text(example, path, text)))
        if text != HIDDEN["half a pair"]:  # which is no JSON, wherever it stands
            assert problem["field"].endswith(path[-1]), problem
            assert re.search("can't be seen|at most 200", problem["detail"]), problem
    axes = deepcopy(examples.LAS_VEGAS)
    axes["initial_state"]["angles_deg"] = {text: 0.0}
    refusal_of(read_plan_request, json.dumps(axes).encode())


@pytest.mark.parametrize("name", ["x" * MOST, "Лас-Вегас", "می‌خواهم", "👩‍🚀", "café", ""])
def test_names_of_all_languages_are_names(name):
    body = json.dumps(examples.LAS_VEGAS | {"name": name}).encode()
    assert read_plan_request(body).name == name


BIG = "x" * 5_000_000


@pytest.mark.parametrize(
    "change",
    [
        {"name": BIG},
        {BIG: 1},
        {"platform": BIG},
        {"orbit": {"source": BIG}},
        {"orbit": {"source": "tle", "line1": BIG, "line2": BIG}},
        {"orbit": {"source": "oem", "content": BIG}},
        {"orbit": {"source": "oem", "content": OEM.replace("EME2000", BIG)}},
        {"orbit": {"source": "oem", "content": OEM.replace("= UTC", f"= {BIG[:1000]}")}},
        {"initial_state": examples.LAS_VEGAS["initial_state"] | {"epoch": BIG}},
        {"initial_state": examples.LAS_VEGAS["initial_state"] | {"angles_deg": {BIG: 0.0}}},
        {"initial_state": examples.LAS_VEGAS["initial_state"] | {BIG: {BIG: BIG}}},
        {"slew": {"method": BIG}},
        {"slew": {"keep_out": [{"body": BIG, "half_angle_deg": 5.0}]}},
        {"on_conflict": BIG},
    ],
    ids=lambda change: "-".join(str(name)[:10] for name in change),
)
def test_little_is_repeated(change):
    told = refusal_of(read_plan_request, json.dumps(examples.LAS_VEGAS | change).encode())
    assert len(told) < 10 * MOST
    assert max(len(run) for run in re.findall("x+", told + "x")) <= MOST


def test_long_numbers_are_not_repeated():
    body = json.dumps(examples.LAS_VEGAS).replace('"Las Vegas"', "9" * 4000).encode()
    assert "9" * (MOST + 1) not in refusal_of(read_plan_request, body)


def test_a_refusal_is_cut_where_it_is_made():
    quoted = InvalidInput(f"it can't be {'a b' * 1000!r}; isn't that so?", field="a." * 1000)
    assert len(quoted.detail) < 2 * MOST
    assert quoted.detail.endswith("...'; isn't that so?")
    assert len(quoted.field) <= MOST + len("...")


@pytest.mark.parametrize("text", ["%00", "a%E2%80%AEb", "%0A", "x" * (MOST + 1)])
@pytest.mark.parametrize("path", ["/v1/plans", "/v1/campaigns", "/v1/spacecraft/plans"])
def test_names_that_are_looked_for(client, path, text):
    answer = client.get(f"{path}?name={text}")
    assert answer.status_code == 422, answer.text
    assert answer.json()["field"] == "query.name"
    assert client.get(f"{path}?name=%D0%9B").status_code == 200


def test_a_query_that_is_no_text(client):
    answer = client.get("/v1/plans?name=%ff")
    assert answer.status_code == 422
    assert answer.json()["field"] == "query"
