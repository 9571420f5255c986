"""A refused command states what would work, and that works."""

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.cli import main
from app.cli.changes import with_settings
from app.requests.examples import LAS_VEGAS

SLEWTRACK = Path(sys.executable).with_name("slewtrack")
EXAMPLES = Path(__file__).parents[2] / "examples"
LAS_VEGAS_FILE = str(EXAMPLES / "las_vegas_2015.json")
ERASED_LINE = "\x1b[2K"
SOON = f"--set=sessions.0.start={'2015-02-27T17:34:02Z'}"


def run(*words, **options):
    return CliRunner().invoke(main, [*map(str, words)], **options)


def commands(stderr):
    """Those offered, without the program's name."""
    return [shlex.split(line)[1:] for line in re.findall(r"^  (?:try|or): (.*)$", stderr, re.M)]


@pytest.fixture
def conflict(tmp_path):
    """Two sessions with no time between them."""
    document = json.loads((EXAMPLES / "three_sessions.json").read_text()) | {
        "on_conflict": "refuse"
    }
    document["sessions"][1]["start"] = document["sessions"][0]["stop"]
    file = tmp_path / "conflict.json"
    file.write_text(json.dumps(document))
    return file


def test_every_command_offered_plans(conflict):
    for words in (["plan", LAS_VEGAS_FILE, SOON], ["plan", conflict]):
        refused = run(*words)
        assert refused.exit_code == 2
        offered = commands(refused.stderr)
        assert len(offered) >= 2
        for command in offered:
            done = run(*command)
            assert done.exit_code == 0, (command, done.stderr)
            assert "verification passed" in done.stdout


def test_flights_of_a_plan_that_is_refused_are_offered_as_well():
    refused = run("fly", LAS_VEGAS_FILE, "--runs", "2", SOON)
    assert refused.exit_code == 2
    command = commands(refused.stderr)[0]
    done = run(*command)
    assert done.exit_code == 0, (command, done.stderr)
    assert done.stdout.startswith("2 flights")


def test_every_field_at_fault_is_told():
    document = LAS_VEGAS | {"nmae": "x", "platform": "hubble"}
    refused = run("plan", "-", input=json.dumps(document))
    assert refused.exit_code == 2
    assert "nmae: " in refused.stderr
    assert "platform: " in refused.stderr


def test_a_refusal_lists_what_each_way_costs_and_json_holds_its_problem(conflict):
    refused = run("plan", conflict, "--json", "-")
    first, *rest = refused.stderr.splitlines()
    assert first.startswith("slewtrack: sessions.1.start: ")
    [earlier] = [line for line in rest if "shorten_earlier," in line]
    assert re.fullmatch(
        r"  with on_conflict shorten_earlier, session 1 stops [\d.]+ s earlier", earlier
    )
    problem = json.loads(refused.stdout)
    assert problem["type"] == "urn:slewtrack:problem:infeasible-slew"
    assert {offer["on_conflict"] for offer in problem["relaxations"]} == {
        "shorten_later", "shorten_earlier", "least_loss",
    }  # fmt: skip


def test_a_dash_is_standard_output_and_the_report_goes_beside_it():
    done = run("plan", LAS_VEGAS_FILE, "--csv", "-")
    assert done.stdout.startswith("utc,t_s,alpha_deg")
    assert len(done.stdout.splitlines()) == 1152
    assert "verification passed" in done.stderr
    refused = run("plan", LAS_VEGAS_FILE, "--csv", "-", "--json", "-")
    assert refused.exit_code == 2
    assert "only one output" in refused.stderr


def test_the_next_pass_is_found_and_planned(tmp_path):
    """Of a request whose session has no times yet; Skyfield has this pass culminate at 17:37:30."""
    document = LAS_VEGAS | {"sessions": [{"target": LAS_VEGAS["sessions"][0]["target"]}]}
    document.pop("initial_state")
    words = ["plan", "-", "--next-pass", "--start", "2015-02-27T12:00:00Z", "--json"]
    done = run(*words, tmp_path / "plan.json", input=json.dumps(document))
    assert done.exit_code == 0, done.stderr
    assert done.stdout.startswith("next pass: 2015-02-27T17:34:18")
    plan = json.loads((tmp_path / "plan.json").read_text())
    [session] = plan["pointing"]
    assert session["elevation_min_deg"] == pytest.approx(10.0, abs=0.02)  # 0.2 s of a rise
    assert session["closest_at"].startswith("2015-02-27T17:37:3")


def test_the_next_pass_over_a_place_by_its_name():
    """10 deg high where nothing else is asked, as for a point on the ground."""
    place = '--set=sessions.0.target={"mode":"place","name":"Las Vegas, US"}'
    done = run("plan", LAS_VEGAS_FILE, place, "--next-pass", "--start", "2015-02-27T12:00:00Z")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.startswith("next pass: 2015-02-27T17:34:1")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--next-pass", "--start", "yesterday"], "--start"),
        (["--start", "now"], "--next-pass"),
        (["--set", "name"], "FIELD=VALUE"),
        (["--set", "sessions.7.start=x"], "nothing at"),
        (
            ["--next-pass", '--set=sessions.0.target={"mode":"place","name":"Springfield"}'],
            "sessions.0.target.name: 'Springfield' may be",
        ),
        (["--next-pass"], "days"),  # of elements from 2015, now
    ],
)
def test_changes_that_can_not_be_made(words, said):
    refused = run("plan", LAS_VEGAS_FILE, *words)
    assert refused.exit_code == 2
    assert said in refused.stderr


@pytest.mark.parametrize(
    ("text", "targets"),
    [
        (
            "id,priority,target.mode,target.latitude_deg\n007,2,ground,1.5\nlate,,ground,-3\n",
            [
                {"id": "007", "priority": 2, "target": {"mode": "ground", "latitude_deg": 1.5}},
                {"id": "late", "target": {"mode": "ground", "latitude_deg": -3}},
            ],
        ),
        ("id,priority\nshort\n", None),
        ("id,id.of\n1,2\n", None),
        ("", None),
    ],
)
def test_targets_of_a_file(tmp_path, text, targets):
    (tmp_path / "targets.csv").write_text(text)
    setting = f"targets=@{tmp_path / 'targets.csv'}"
    if targets is None:
        refused = run("campaign", EXAMPLES / "campaign_ten.json", "--set", setting)
        assert (refused.exit_code, refused.stderr.count("\n")) == (2, 1)
        assert "must be CSV" in refused.stderr
    else:
        assert json.loads(with_settings(b"{}", [setting])) == {"targets": targets}


def test_several_sessions_have_no_next_pass():
    refused = run("plan", EXAMPLES / "three_sessions.json", "--next-pass")
    assert refused.exit_code == 2
    assert "slewtrack campaign" in refused.stderr


def test_a_dry_run_writes_nothing(tmp_path):
    done = run("plan", LAS_VEGAS_FILE, "--dry-run", "--csv", tmp_path / "table.csv")
    assert done.exit_code == 0
    assert "flies: 1151 rows" in done.stdout
    assert run("plan", LAS_VEGAS_FILE, "--dry-run", SOON).exit_code == 2
    words = ["campaign", EXAMPLES / "campaign_cities.json", "--dry-run"]
    done = run(*words, "--plans", tmp_path / "plans")
    assert "4 looks in 2 passes" in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_version_help_and_completion():
    assert re.fullmatch(r"slewtrack \d+\.\d+\.\d+\n", run("--version").stdout)
    assert "Usage" in run("-h").stdout
    assert "Usage" in run("plan", "-h").stdout
    done = subprocess.run(
        [SLEWTRACK],
        env={
            "_SLEWTRACK_COMPLETE": "complete_bash",
            "COMP_WORDS": "slewtrack wi",
            "COMP_CWORD": "1",
        },
        capture_output=True,
        text=True,
    )
    assert done.stdout.split() == ["windows"]


def test_who_has_read_enough_is_told_no_more(tmp_path):
    command = shlex.join([str(SLEWTRACK), "plan", LAS_VEGAS_FILE, "--csv", "-"])
    done = subprocess.run(
        ["bash", "-c", f"{command} 2>errors | head -1; cat errors >&2"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.stdout.startswith("utc,t_s")
    assert "ipe" not in done.stderr


def test_progress_is_for_terminals():
    """A pipe gets none of it; a terminal does, and keeps none."""
    done = run("plan", LAS_VEGAS_FILE)
    assert done.stderr == ""
    words = [SLEWTRACK, "plan", LAS_VEGAS_FILE, "--csv=/dev/null"]
    as_terminal = os.environ | {"FORCE_COLOR": "1"}
    told = subprocess.run(words, env=as_terminal, capture_output=True, text=True, check=True)
    assert "planning" in told.stderr or "orbit" in told.stderr
    assert told.stderr.endswith(ERASED_LINE)
    assert "verification" in told.stdout
