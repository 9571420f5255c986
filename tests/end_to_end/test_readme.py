"""Everything that the README and the pages of docs/ show works."""

import argparse
import dataclasses
import json
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args, get_type_hints

import httpx2 as httpx
import pytest
from planner_values import plan_of
from refusal_kinds import refusal_kinds
from waiting import PATIENCE_S, PatientClient

from app.http.app import create_app
from app.work.searches import read_opportunity_request
from planner.base.errors import Refusal
from planner.output.export import EXPORTERS
from planner.planning.opportunities import OpportunityConditions, find_opportunities
from planner.planning.sessions.sequence import CONFLICTS
from planner.world.attitude import ATTITUDES
from planner.world.orbits import ORBITS
from planner.world.scenario import SlewOptions
from planner.world.targets import TARGETS
from planner.world.targets.bench_motion import Motion

ROOT = Path(__file__).parents[2]
SLEWTRACK = Path(sys.executable).with_name("slewtrack")
README = (ROOT / "README.md").read_text()


CURL = argparse.ArgumentParser()  # what the pages give it, so that no curl is needed here
CURL.add_argument("url")
for flag in ("-s", "-N"):
    CURL.add_argument(flag, action="store_true")
for flag in ("-X", "-o"):
    CURL.add_argument(flag)
CURL.add_argument("-d", "--data-binary", dest="body")
for flag in ("-H", "-F"):
    CURL.add_argument(flag, action="append", default=[])


def sent(value: str) -> bytes:
    """A body as it is written, or the file that it names."""
    return (ROOT / value[1:]).read_bytes() if value.startswith("@") else value.encode()


def curl(command: str, address: str, **variables: str) -> tuple[int, str, bytes]:
    """Status, address in Location and body of what the curl command gets."""
    for name, value in variables.items():
        command = command.replace(f"${name}", value)
    asked = CURL.parse_args(shlex.split(command.replace("\\\n", " "), comments=True)[1:])
    parts = [(name, sent(value)) for name, value in (part.split("=", 1) for part in asked.F)]
    answer = httpx.request(
        asked.X or ("POST" if asked.body or parts else "GET"),
        re.sub(r"^(http://)?(127\.0\.0\.1|localhost):8000", address, asked.url),
        content=sent(asked.body) if asked.body else None,
        files=parts or None,
        headers=dict(header.split(": ") for header in asked.H),
        timeout=PATIENCE_S,
    )
    assert answer.is_success, (command, answer.text)
    return answer.status_code, answer.headers.get("Location", ""), answer.content


def curl_commands(text: str) -> list[str]:
    return [match[0].removeprefix("$ ") for match in re.finditer(r"\$ curl (?:.*\\\n)*.*\n", text)]


@pytest.fixture(scope="module")
def address(service):
    return service.address


@pytest.fixture(scope="module")
def las_vegas(address):
    """What the README's curl example is answered."""
    [in_readme] = curl_commands(README)
    return curl(in_readme, address)


def test_the_readmes_curl_example(las_vegas):
    status, _, body = las_vegas
    plan = json.loads(body)
    assert status == 201
    assert plan["state"] == "done"
    assert plan["verification"]["passed"]
    assert len(plan["table"]["alpha_deg"]) == 1151


WITH_CURL = {
    path.stem: commands
    for path in sorted((ROOT / "docs").rglob("*.md"))
    if (commands := curl_commands(path.read_text()))
}


@pytest.mark.parametrize("page", WITH_CURL)
def test_every_curl_line_is_answered(page, address, las_vegas):
    """In the page's order, each with the last id of its kind; deleted in the end."""
    ids = {"plan": json.loads(las_vegas[2])["id"]}
    for command in sorted(WITH_CURL[page], key=lambda command: "DELETE" in command):
        command = re.sub(
            r"(plan|campaign|flight)(s?\W+?(?:revises=)?)\$?(?:ID|PLAN)\b",
            lambda found: found[1] + found[2] + ids[found[1]],
            command.replace('"runs": 1000', '"runs": 2'),
        )
        _, location, answer = curl(command, address)
        if location:
            [(kind, made)] = re.findall(r"/(\w+)s/([0-9a-f-]+)$", location)
            ids[kind] = made
        elif "plans?campaign" in command:
            ids["plan"] = json.loads(answer)["plans"][0]["id"]


FRAGMENTS = [
    json.loads(text)
    for text in re.findall(
        r"```json\n(.*?)```", (ROOT / "docs" / "requests.md").read_text(), re.DOTALL
    )
]
PLANNED = [fragment for fragment in FRAGMENTS if "samples" not in fragment]


def example(name: str) -> dict[str, Any]:
    return json.loads((ROOT / "examples" / name).read_text())


@pytest.mark.parametrize("fragment", PLANNED, ids=lambda fragment: json.dumps(fragment)[:60])
def test_every_fragment_of_a_request_is_planned(fragment):
    document = example("las_vegas_2015.json")
    if "target" in fragment:
        document["sessions"][0] |= fragment
    else:
        document |= fragment
    assert plan_of(document).verification.passed


def test_the_conditions_of_opportunities_leave_windows():
    [fragment] = [fragment for fragment in FRAGMENTS if fragment not in PLANNED]
    document = example("opportunities_gallery.json") | fragment
    asked = read_opportunity_request(json.dumps(document).encode())
    assert len(find_opportunities(asked).windows) > 10


def test_the_refusal_shown_is_the_one_given():
    [shown] = re.findall(r"```json\n(.*?)```", (ROOT / "docs" / "http.md").read_text(), re.DOTALL)
    told = json.loads(shown)
    [conflict] = [fragment for fragment in PLANNED if "on_conflict" in fragment]
    document = example("las_vegas_2015.json") | conflict | {"on_conflict": "refuse"}
    with PatientClient(create_app()) as client:
        problem = client.post("/v1/plans", json=document).json()
    assert problem["detail"].startswith(told.pop("detail").removesuffix("..."))
    assert {name: problem[name] for name in told if name != "instance"} | {
        "instance": told["instance"]
    } == told


def test_every_mode_law_and_condition_is_described():
    page = (ROOT / "docs" / "requests.md").read_text()
    conditions = {field.name for field in dataclasses.fields(OpportunityConditions)}
    motions = {motion.kind for motion in get_args(get_args(Motion)[0])}
    methods = get_args(get_type_hints(SlewOptions)["method"])
    for name in {*ORBITS, *ATTITUDES, *CONFLICTS, *methods, *conditions, *motions}:
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
    assert result.stdout == "(1151,) True\n"


PAGES = ["README.md", *(f"docs/{path.name}" for path in sorted((ROOT / "docs").glob("*.md")))]


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    file = ROOT / page
    for target in re.findall(r"\]\((?!https://)([^)#]+)\)", file.read_text()):
        assert (file.parent / target).exists(), target


def test_every_refusal_is_explained():
    pages = "".join((ROOT / page).read_text() for page in PAGES)
    for refusal in refusal_kinds():
        if refusal is not Refusal:
            assert f"`{refusal.slug}`" in pages
