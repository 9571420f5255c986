"""Does the operators' page say what the settings, metrics and limits are?"""

import re
from pathlib import Path

import pytest
from fastapi.testclient import TestClient
from pydantic_core import PydanticUndefined

from app.api.json_bounds import DEPTH_MAX, VALUES_MAX
from app.api.json_reader import OBJECTS_MAX
from app.main import create_app
from app.security.request_form import HEAD_BYTES_MAX, HEADERS_MAX, PATH_BYTES_MAX, QUERY_BYTES_MAX
from app.settings import Settings

PAGE = (Path(__file__).parents[2] / "docs" / "operations.md").read_text()


def row(name: str) -> str:
    field = Settings.model_fields[name]
    default = field.default
    told = "" if default in (PydanticUndefined, "", None) else f"`{default}`"
    return f"| `SLEWTRACK_{name.upper()}` | {told} | {field.description} |"


@pytest.mark.parametrize("name", Settings.model_fields)
def test_every_setting_is_described_as_it_is(name):
    assert row(name) in PAGE, f"docs/operations.md needs the row\n{row(name)}"


def test_no_setting_is_described_that_is_none():
    described = re.findall(r"^\| `SLEWTRACK_(\w+)` \|", PAGE, re.MULTILINE)
    assert {name.lower() for name in described} == set(Settings.model_fields)


def test_caps_are_those_kept():
    for cap in (
        f"{VALUES_MAX:,} values, {DEPTH_MAX} deep, {OBJECTS_MAX:,} objects",
        f"{HEADERS_MAX}, {HEAD_BYTES_MAX // 1024} KiB together",
        f"{PATH_BYTES_MAX // 1024} KiB of path, {QUERY_BYTES_MAX // 1024} KiB of query",
    ):
        assert cap in PAGE


def test_every_metric_is_described(tmp_path):
    with TestClient(create_app(Settings(data_dir=tmp_path))) as client:
        text = client.get("/metrics").text
    for name in re.findall(r"^# TYPE (\w+) ", text, re.MULTILINE):
        assert name.endswith("_created") or f"`{name}`" in PAGE, name
