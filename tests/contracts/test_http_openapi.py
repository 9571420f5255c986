"""The API's pages work without a network and state all there is, from the registries."""

import dataclasses
import json
import re

import pytest
from jsonschema_rs import Draft202012Validator
from openapi_spec_validator import OpenAPIV31SpecValidator

from app.requests import examples
from planner.output.export import EXPORTERS
from planner.world.attitude import ATTITUDES
from planner.world.orbits import ORBITS
from planner.world.platforms import BODIES, PLATFORMS
from planner.world.targets import IMAGING_MODES, TARGETS

WITH_WINDOWS = {name: mode for name, mode in TARGETS.items() if mode.has_windows}
REGISTRIES = [
    ("PlanRequest", "orbit", "source", ORBITS),
    ("PlanRequest", "attitude", "law", ATTITUDES),
    ("Session", "target", "mode", TARGETS | IMAGING_MODES),
    ("OpportunityRequest", "orbit", "source", ORBITS),
    ("OpportunityRequest", "attitude", "law", ATTITUDES),
    ("OpportunityTarget", "target", "mode", WITH_WINDOWS | IMAGING_MODES),
    ("CampaignTarget", "target", "mode", WITH_WINDOWS | IMAGING_MODES),
]
REGISTERED = {(schema, field): registry for schema, field, _, registry in REGISTRIES}
VERBS = {"Cancel", "Check", "Choose", "Compare", "Delete", "Estimate", "Fly", "Get", "List"}
VERBS |= {"Plan", "Predict", "Render", "Search", "Stream", "View"}
INDIRECT_QUESTION = re.compile(r"(What|How|Where|When|Whether|Which|Who|Why)\b")
KINDS = [
    pytest.param(schema, field, member, kind, cls, id=f"{schema}-{field}-{kind}")
    for schema, field, member, registry in REGISTRIES
    for kind, cls in registry.items()
]


@pytest.fixture(scope="module")
def document(client):
    return client.get("/openapi.json").json()


@pytest.mark.parametrize(("schema", "field", "member", "kind", "cls"), KINDS)
def test_every_registered_kind_is_documented(document, schema, field, member, kind, cls):
    schemas = document["components"]["schemas"]
    union = schemas[schema]["properties"][field]
    union = next((one for one in union.get("anyOf", []) if "oneOf" in one), union)
    assert union["discriminator"]["propertyName"] == member
    assert len(union["oneOf"]) == len(REGISTERED[schema, field])
    ref = union["discriminator"]["mapping"][kind]
    assert {"$ref": ref} in union["oneOf"]
    described = schemas[ref.rsplit("/", 1)[1]]
    assert described["properties"][member]["const"] == kind
    assert member in described["required"]
    assert "default" not in described["properties"][member]
    assert list(union["discriminator"]["mapping"]) == list(REGISTERED[schema, field])  # as told
    assert described["additionalProperties"] is False
    assert set(described["properties"]) == {field.name for field in dataclasses.fields(cls)}
    assert described["description"]


def test_every_registered_platform_is_documented(document, client):
    everyone = [*PLATFORMS, *BODIES]
    for request in ("PlanRequest", "OpportunityRequest", "CampaignRequest"):
        platform = document["components"]["schemas"][request]["properties"]["platform"]
        assert platform["oneOf"][0]["enum"] == everyone
    listed = client.get("/v1/platforms").json()["platforms"]
    assert [(entry["kind"], entry["name"]) for entry in listed] == [
        *(("two_axis", name) for name in PLATFORMS),
        *(("body", name) for name in BODIES),
    ]


def test_the_ways_to_slew_are_documented(document):
    options = document["components"]["schemas"]["SlewOptions"]["properties"]
    assert options["method"]["enum"] == ["ocp", "spline"]
    assert set(options["objective"]["enum"]) == {"smooth", "minimum_time"}


def test_every_reference_leads_somewhere(document):
    refs = set(re.findall(r'"\$ref": ?"#/components/schemas/([^"]+)"', json.dumps(document)))
    mapped = set(re.findall(r'"#/components/schemas/([^"]+)"', json.dumps(document)))
    assert refs
    assert refs | mapped <= set(document["components"]["schemas"])
    assert document["openapi"].startswith("3.1")


def test_the_document_is_sound(document):
    OpenAPIV31SpecValidator(document).validate()


def texts_of(part, where=""):
    """Every summary and description, with its place; examples quote requests and answers."""
    if isinstance(part, list):
        for number, item in enumerate(part):
            yield from texts_of(item, f"{where}/{number}")
    elif isinstance(part, dict):
        for name, inner in part.items():
            if name in ("summary", "description") and isinstance(inner, str):
                yield f"{where}/{name}", inner
            elif name not in ("example", "examples"):
                yield from texts_of(inner, f"{where}/{name}")


def test_summaries_are_imperatives(document):
    summaries = {
        f"{method} {path}": operation["summary"]
        for path, operations in document["paths"].items()
        for method, operation in operations.items()
    }
    assert {w: s for w, s in summaries.items() if s.split()[0] not in VERBS} == {}


def test_texts_state_and_do_not_ask(document):
    """Neither a question nor half of one ("How many there are") stands where a text is due."""
    texts = dict(texts_of(document))
    assert len(texts) > 1000
    asking = {w: t for w, t in texts.items() if "?" in t or INDIRECT_QUESTION.match(t)}
    assert asking == {}


def test_the_glossary_names_members_that_there_are(document, request):
    page = (request.config.rootpath / "docs" / "glossary.md").read_text()
    cells = [line.split("|")[3] for line in page.splitlines() if line.count("|") == 4]
    named = {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}
    known = json.dumps(document["components"]["schemas"]) + json.dumps([*document["paths"]])
    parts = {part for name in named for part in re.split(r"[.: ]+", name)}
    assert len(parts) > 60
    assert {part for part in parts if not re.search(rf"(?<!\w){re.escape(part)}(?!\w)", known)} <= {
        "iss-hrc"
    }


def answers_of(document, operation):
    """Refusals that are the same everywhere are described once."""
    shared = document["components"]["responses"]
    return {
        status: shared[answer["$ref"].rsplit("/", 1)[1]] if "$ref" in answer else answer
        for status, answer in operation["responses"].items()
    }


def test_every_operation_documents_its_refusals(document):
    for operations in document["paths"].values():
        for operation in operations.values():
            assert operation["summary"]
            answers = answers_of(document, operation)
            assert {"406", "500"} <= set(answers)
            if "requestBody" in operation:
                assert {"413", "415", "422"} <= set(answers)
            for status, answer in answers.items():
                if int(status) >= 400:
                    assert list(answer["content"]) == ["application/problem+json"]
                elif status in ("204", "304"):
                    assert "content" not in answer
                else:
                    assert answer["content"]


@pytest.mark.parametrize(
    ("status", "asked"),
    [
        (400, {"url": "/v1/plans/a%00"}),
        (403, {"headers": {"Origin": "http://example.org"}}),
        (406, {"headers": {"Accept": "image/png"}}),
        (413, {"method": "POST", "url": "/v1/opportunities", "content": b" " * (8 * 2**20 + 1)}),
        (414, {"url": "/" + "a" * 3000}),
        (415, {"method": "POST", "url": "/v1/opportunities", "content": b"", "type": "text/plain"}),
        (431, {"headers": {f"X-{k}": "" for k in range(144)}}),
    ],
)
def test_refusals_are_shown_as_they_are_given(client, document, status, asked):
    method, url = asked.pop("method", "GET"), asked.pop("url", "/v1/platforms")
    headers = {"Content-Type": asked.pop("type", "application/json")} | asked.pop("headers", {})
    given = client.request(method, url, headers=headers, **asked).json()
    path = "/v1/opportunities" if method == "POST" else "/v1/platforms"
    answers = answers_of(document, document["paths"][path][method.lower()])
    shown = answers[str(status)]["content"]["application/problem+json"]["example"]
    assert given | {"instance": ""} == shown | {"instance": ""}


def test_every_registered_format_is_documented(document):
    post = document["paths"]["/v1/plans"]["post"]
    [parameter] = [found for found in post["parameters"] if found["name"] == "format"]
    assert parameter["schema"]["enum"] == list(EXPORTERS)
    media_types = {exporter.media_type for exporter in EXPORTERS.values()}
    assert set(post["responses"]["201"]["content"]) == media_types


def test_every_registered_kind_has_a_worked_example():
    requests = [request for _, request in examples.PLAN_EXAMPLES.values()]
    assert {request["orbit"]["source"] for request in requests} == set(ORBITS)
    assert {request["attitude"]["law"] for request in requests} == set(ATTITUDES)
    modes = {session["target"]["mode"] for request in requests for session in request["sessions"]}
    assert modes == set(TARGETS)


def faults(document, schema, answer):
    """Where an answer strays from its schema, ranges included."""
    found = Draft202012Validator(
        {"$ref": f"#/components/schemas/{schema}", "components": document["components"]}
    ).iter_errors(answer.json())
    return [(error.instance_path, error.message) for error in found]


@pytest.mark.parametrize("name", examples.OPPORTUNITY_EXAMPLES)
def test_worked_examples_have_windows(client, document, name):
    answer = client.post("/v1/opportunities", json=examples.OPPORTUNITY_EXAMPLES[name][1])
    assert answer.status_code == 200, answer.text
    assert faults(document, "OpportunitiesResponse", answer) == []
    assert answer.json()["windows"]
    assert answer.json()["unseen"] == []


EXAMPLE_FILES = {
    "las_vegas_2015": examples.LAS_VEGAS,
    "spacecraft_four_modes": examples.FOUR_MODES,
    "opportunities_smallsat": examples.OPPORTUNITY_EXAMPLES["smallsat"][1],
    "campaign_smallsat": examples.CAMPAIGN_EXAMPLES["smallsat"][1],
    "opportunities_modes": examples.OPPORTUNITY_EXAMPLES["modes"][1],
    "horizon_estimate": examples.ESTIMATE_EXAMPLE,
    "horizon_prediction": examples.PREDICTION_EXAMPLES["pass"][1],
    "horizon_image": examples.PICTURE_EXAMPLES["ahead"][1],
    "horizon_session": examples.SESSION_EXAMPLE,
}


@pytest.mark.parametrize("name", EXAMPLE_FILES)
def test_an_example_file_is_the_worked_example(pytestconfig, name):
    file = pytestconfig.rootpath / "examples" / f"{name}.json"
    assert json.loads(file.read_text()) == EXAMPLE_FILES[name]
