"""The operators' page says what there is, and its ways lead in."""

import os
import re
import subprocess
import sys

import pytest
from databases import own_settings
from fastapi.testclient import TestClient
from live_service import ROOT, SLEWTRACK, live_service
from pydantic_core import PydanticUndefined

from app.http.admission.admission import (
    HEAD_BYTES_MAX,
    HEADERS_MAX,
    PATH_BYTES_MAX,
    QUERY_BYTES_MAX,
)
from app.http.app import create_app
from app.requests.json_reader import DEPTH_MAX, OBJECTS_MAX, VALUES_MAX
from app.settings import Settings

PAGE = (ROOT / "docs" / "operations.md").read_text()


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
    with TestClient(create_app(own_settings(tmp_path))) as client:
        text = client.get("/metrics").text
    for name in re.findall(r"^# TYPE (\w+) ", text, re.MULTILINE):
        assert name.endswith("_created") or f"`{name}`" in PAGE, name


def test_a_key_as_the_page_makes_it_lets_the_python_example_in(tmp_path):
    [create] = re.findall(r"\$ slewtrack (keys create .*)\n", PAGE)
    name, scope = re.fullmatch(r'keys create "(.*)" --scope (\w+)', create).groups()
    environment = os.environ | {"SLEWTRACK_DATA_DIR": str(tmp_path)}
    made = subprocess.run(
        [SLEWTRACK, "keys", "create", name, "--scope", scope],
        capture_output=True,
        text=True,
        env=environment,
    )
    said = re.sub("[0-9a-f]{12}", "3f1c9a52b7e0", made.stderr)
    assert said in PAGE
    [example] = re.findall(r"```python\n(.*?)```", (ROOT / "docs/http.md").read_text(), re.DOTALL)
    with live_service(tmp_path, SLEWTRACK_REQUIRE_KEYS="true") as service:
        known = {"SLEWTRACK_URL": service.address, "SLEWTRACK_KEY": made.stdout.strip()}
        ran = subprocess.run(
            [sys.executable, "-c", example],
            capture_output=True,
            text=True,
            cwd=ROOT,
            env=environment | known,
        )
    assert ran.stdout.splitlines() == [
        "done 1151",
        "Las Vegas",
        "422 platform urn:slewtrack:request:las-vegas-7",
    ], ran.stderr
