"""The schema states of every field what it is, its unit, its range and an example."""

import json
import re
import sys

from api_document import api_document
from jsonschema import Draft202012Validator

from app.http.openapi.fields import is_number

DOCUMENT = api_document()
SCHEMAS = DOCUMENT["components"]["schemas"]
FIELDS = [
    (schema, name, field)
    for schema in SCHEMAS
    for name, field in SCHEMAS[schema].get("properties", {}).items()
]

# Of names in the project, none of them of a field of the schema yet.
UNITS_NOT_WRITTEN = {"rad", "rad2", "mm", "um", "nm", "us", "ms", "day", "days", "k", "pa"}
UNITS_NOT_WRITTEN |= {"orbits", "bytes", "mib", "m3", "percent"}


def declared(name):
    """Where a schema's class is; None where FastAPI made it."""
    for module in [*sys.modules.values()]:
        kind = vars(module).get(name)
        if isinstance(kind, type) and kind.__module__.split(".")[0] in (
            "app",
            "planner",
            "estimator",
        ):
            return kind
    return None


def place(schema, name):
    kind = declared(schema)
    return f"{name} of class {schema}" + (
        f" in {kind.__module__.replace('.', '/')}.py" if kind else ""
    )


def has_fields(field):
    return "$ref" in json.dumps(field)


def test_the_document_has_fields_of_requests_and_answers():
    assert len(FIELDS) > 700
    assert {"PlanRequest", "PlanResponse", "Problem"} <= set(SCHEMAS)


def untold(field, where):
    """What is missing, and where it is to be written."""
    if not field.get("description"):
        yield (
            f"nothing says what {where} is: add the line\n    {where.split()[0]}: what it is, in "
            "plain words.\nto the class's docstring, in a last paragraph of such lines (the unit "
            "comes from the name's end; for another write [unit] after the text)"
        )
    if not has_fields(field) and "examples" not in field:
        yield (
            f"no example holds {where}: set it in a worked request of app/requests/examples (then "
            "`make answers`), or end its line in the docstring with E.g. `0.5`. (any JSON)"
        )
    if is_number(field) and not has_fields(field):
        if field["x-unit"] == "1" and where.split()[0].split("_")[-1] in UNITS_NOT_WRITTEN:
            yield f"{where} passes for a pure number: add its unit to app/http/openapi/fields.py"
        text = json.dumps(field)
        if not ("imum" in text or "x-range" in text or '"string"' in text):
            yield (
                f"{where} states no range: write its type as Annotated[float, Within(least, "
                "greatest)] in a request, as one of planner/base/answer_members.py in an answer"
            )


def test_every_field_is_told():
    """The text is in its class's docstring: see app/http/openapi/fields.py."""
    missing = [
        fault for schema, name, field in FIELDS for fault in untold(field, place(schema, name))
    ]
    assert not missing, "\n".join(missing)


def test_examples_are_what_the_field_holds():
    for schema, name, field in FIELDS:
        check = Draft202012Validator(field | {"components": DOCUMENT["components"]})
        for example in field.get("examples", ()):
            errors = [error.message for error in check.iter_errors(example)]
            assert errors == [], f"{schema}.{name}"


def test_docstrings_tell_of_no_field_that_there_is_not():
    for schema, one in SCHEMAS.items():
        told = re.findall(r"(?m)^([a-z]\w*(?:, \w+)*): ", one.get("description", ""))
        assert told == [], f"the docstring of {schema} tells of {told}, which it hasn't"


def test_titles_and_operations_are_named_once():
    titles = [schema["title"] for schema in SCHEMAS.values()]
    operations = [
        operation["operationId"]
        for path in DOCUMENT["paths"].values()
        for operation in path.values()
    ]
    assert len({*titles}) == len(titles)
    assert len({*operations}) == len(operations)
    assert {"post_plans", "get_plan", "get_plan_table"} <= {*operations}


def test_no_default_is_an_object():
    """Generators of clients leave out operations with such defaults; the text says it instead."""
    assert [(s, n) for s, n, field in FIELDS if isinstance(field.get("default"), dict)] == []
    conditions = SCHEMAS["OpportunityRequest"]["properties"]["conditions"]
    assert "Left out: `" in conditions["description"]


def test_every_parameter_is_told_and_never_null():
    parameters = [
        (operation["operationId"], parameter)
        for path in DOCUMENT["paths"].values()
        for operation in path.values()
        for parameter in operation.get("parameters", ())
    ]
    for operation, parameter in parameters:
        where = f"{parameter['name']} of {operation}"
        assert parameter.get("description"), f"{where}: give it Field(description=...)"
        assert "null" not in json.dumps(parameter["schema"]), where


def test_pages_offer_files_for_horizon_frames_and_show_pictures():
    """A file chooser needs `binary`; the first kind of answer is the one that pages ask for."""
    horizon = DOCUMENT["paths"]["/v1/horizon/estimates"]["post"]["requestBody"]["content"]
    parts = horizon["multipart/form-data"]["schema"]["properties"]
    assert parts["images"]["items"] == {"type": "string", "format": "binary"}
    assert parts["request"]["examples"]
    picture = DOCUMENT["paths"]["/v1/horizon/images"]["post"]["responses"]["200"]["content"]
    assert list(picture) == ["image/png", "application/json"]
