"""Does what the README and the pages of docs/ show really work?"""

import dataclasses
import itertools
import json
import re
import shlex
import subprocess
import sys
import urllib.error
import urllib.request
from contextlib import contextmanager
from pathlib import Path
from typing import Any, get_args

import pytest
from fastapi.testclient import TestClient

from app.api.opportunity_request import read_opportunity_request
from app.api.plan_request import read_plan_request
from app.errors import STATUS_OF_REFUSAL
from app.main import create_app
from planner.attitude import ATTITUDES
from planner.errors import Refusal
from planner.export import EXPORTERS
from planner.opportunities import OpportunityConditions, find_opportunities
from planner.orbits import ORBITS
from planner.pipeline import make_plan
from planner.sequence import CONFLICTS
from planner.slew import BACKENDS
from planner.targets import TARGETS
from planner.targets.test_motion import Motion

ROOT = Path(__file__).parents[2]
SLEWTRACK = Path(sys.executable).with_name("slewtrack")
README = (ROOT / "README.md").read_text()


@contextmanager
def service():
    """`slewtrack serve` on a free port; yields its address."""
    process = subprocess.Popen(
        [SLEWTRACK, "serve", "--port", "0"], stderr=subprocess.PIPE, text=True, cwd=ROOT
    )
    try:
        for line in process.stderr:
            if found := re.search(r"running on (http://127\.0\.0\.1:\d+)", line):
                yield found[1]
                break
        else:
            raise AssertionError("the service said no address")
    finally:
        process.terminate()
        process.wait(timeout=20)


def curl(command: str, address: str) -> tuple[int, Any]:
    """Does what the curl command says, so that no curl need be installed."""
    words = shlex.split(command.replace("\\\n", " "))
    options = dict(itertools.pairwise(words))
    [url] = [word for word in words if word.startswith("http")]
    body = (ROOT / options["--data-binary"].removeprefix("@")).read_bytes()
    name, value = options["-H"].split(": ")
    request = urllib.request.Request(
        url.replace("http://127.0.0.1:8000", address), body, {name: value}, method=options["-X"]
    )
    with urllib.request.urlopen(request) as answer:
        return answer.status, json.load(answer)


def curl_commands(text: str) -> list[str]:
    return [match[0].removeprefix("$ ") for match in re.finditer(r"\$ curl (?:.*\\\n)*.*\n", text)]


def test_curl_examples():
    [in_readme] = curl_commands(README)
    dry_run, czml, opportunities = curl_commands((ROOT / "docs" / "http.md").read_text())
    with service() as address:
        status, plan = curl(in_readme, address)
        assert status == 201
        assert plan["state"] == "done"
        assert plan["verification"]["passed"]
        assert len(plan["table"]["alpha_deg"]) == 1151
        status, answer = curl(dry_run, address)
        assert status == 200
        assert answer["valid"] is True
        status, answer = curl(czml, address)
        assert status == 201
        assert answer[0]["id"] == "document"
        status, answer = curl(opportunities, address)
        assert status == 200
        assert answer["windows"]


FRAGMENTS = [
    json.loads(text)
    for text in re.findall(
        r"```json\n(.*?)```", (ROOT / "docs" / "requests.md").read_text(), re.DOTALL
    )
]
PLANNED = [fragment for fragment in FRAGMENTS if "opportunities" not in fragment]


def example(name: str) -> dict[str, Any]:
    return json.loads((ROOT / "examples" / name).read_text())


@pytest.mark.parametrize("fragment", PLANNED, ids=lambda fragment: json.dumps(fragment)[:60])
def test_every_fragment_of_a_request_is_planned(fragment):
    document = example("las_vegas_2015.json")
    if "target" in fragment:
        document["sessions"][0] |= fragment
    else:
        document |= fragment
    assert make_plan(read_plan_request(json.dumps(document).encode())).verification.passed


def test_the_conditions_of_opportunities_leave_windows():
    [fragment] = [fragment for fragment in FRAGMENTS if fragment not in PLANNED]
    document = example("opportunities_gallery.json") | fragment["opportunities"]
    asked = read_opportunity_request(json.dumps(document).encode())
    assert len(find_opportunities(asked).windows) > 10


def test_the_refusal_shown_is_the_one_given():
    [shown] = re.findall(r"```json\n(.*?)```", (ROOT / "docs" / "http.md").read_text(), re.DOTALL)
    told = json.loads(shown)
    [conflict] = [fragment for fragment in PLANNED if "on_conflict" in fragment]
    document = example("las_vegas_2015.json") | conflict | {"on_conflict": "refuse"}
    with TestClient(create_app()) as client:
        problem = client.post("/v1/plans", json=document).json()
    assert problem["detail"].startswith(told.pop("detail").removesuffix("..."))
    assert {name: problem[name] for name in told if name != "instance"} | {
        "instance": told["instance"]
    } == told


def test_every_mode_law_and_condition_is_described():
    page = (ROOT / "docs" / "requests.md").read_text()
    conditions = {field.name for field in dataclasses.fields(OpportunityConditions)}
    motions = {motion.kind for motion in get_args(Motion)}
    for name in {*ORBITS, *ATTITUDES, *CONFLICTS, *BACKENDS, *conditions, *motions}:
        assert f"`{name}`" in page, name
    shown = {fragment["target"]["mode"] for fragment in PLANNED if "target" in fragment}
    assert shown == set(TARGETS)


def test_every_format_is_described():
    page = (ROOT / "docs" / "http.md").read_text()
    for name, exporter in EXPORTERS.items():
        told = "by `format` only" if name == "json" else f"`{exporter.media_type}`"
        assert f"| `{name}` | {told} |" in page


def test_command_line_example(tmp_path):
    [command] = re.findall(r"\$ \.venv/bin/slewtrack (plan .*)\n", README)
    words = shlex.split(command.replace("out/", f"{tmp_path}/"))
    result = subprocess.run([SLEWTRACK, *words], capture_output=True, text=True, cwd=ROOT)
    assert result.returncode == 0, result.stderr
    assert "Las Vegas" in result.stdout
    assert "verification passed" in result.stdout
    assert (tmp_path / "plan.png").read_bytes().startswith(b"\x89PNG")
    plan = json.loads((tmp_path / "plan.json").read_text())
    header, *rows = (tmp_path / "table.csv").read_text().splitlines()
    assert header == "utc,t_s,alpha_deg,beta_deg,alpha_rate_deg_s,beta_rate_deg_s"
    assert len(rows) == len(plan["table"]["t_s"])
    utc, t_s, *values = rows[-1].split(",")
    assert (utc, t_s) == ("2015-02-27T17:37:50.0Z", "230.0")
    for column, value in zip(header.split(",")[2:], values, strict=True):
        assert float(value) == plan["table"][column][-1]


def test_refusal_example():
    [shown] = re.findall(r"\n(slewtrack: .*)\n", README)
    document = json.loads((ROOT / "examples" / "las_vegas_2015.json").read_text())
    document["sessions"][0]["start"] = "2015-02-27T17:36:20"
    result = subprocess.run(
        [SLEWTRACK, "plan", "-"], input=json.dumps(document), capture_output=True, text=True
    )
    assert result.returncode == 2
    assert result.stderr == shown + "\n"


def test_python_example():
    [example] = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    result = subprocess.run(
        [sys.executable, "-c", example], capture_output=True, text=True, cwd=ROOT
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout == "(1151, 2) True\n"


PAGES = ["README.md", *(f"docs/{path.name}" for path in sorted((ROOT / "docs").glob("*.md")))]


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    file = ROOT / page
    for target in re.findall(r"\]\(([^)#]+)\)", file.read_text()):
        assert (file.parent / target).exists(), target


def test_every_refusal_is_explained():
    pages = "".join((ROOT / page).read_text() for page in PAGES)
    for refusal in STATUS_OF_REFUSAL:
        if refusal is not Refusal:
            assert f"`{refusal.slug}`" in pages
