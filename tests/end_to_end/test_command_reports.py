"""The commands' reports state what was taken for granted, and how near masks come."""

import io
import json
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

from app.cli import main
from app.cli.report_parts import print_rows
from app.requests.examples import LAS_VEGAS, PLAN_EXAMPLES
from app.work import telemetry

EXAMPLES = Path(__file__).parents[2] / "examples"
LJUBLJANA = {"mode": "place", "name": "Ljubljana"}


@pytest.fixture(autouse=True)
def _a_pipe_knows_no_width(monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)


def report(command, document, folder):
    """What it prints, line by line, and its whole answer."""
    words = [command, "-", "--json", str(folder / "answer.json")]
    done = CliRunner().invoke(main, words, input=json.dumps(document))
    assert done.exit_code == 0, done.stderr
    return [line.rstrip() for line in done.stdout.splitlines()], json.loads(
        (folder / "answer.json").read_text()
    )


def taken(lines):
    return [line for line in lines if line.startswith("taken for ")]


def search(name):
    document = json.loads((EXAMPLES / name).read_text())
    document["targets"][0]["target"] = LJUBLJANA
    return document


@pytest.mark.parametrize(
    ("command", "example"),
    [("windows", "opportunities_gallery.json"), ("campaign", "campaign_cities.json")],
)
def test_where_a_place_is_was_looked_up(tmp_path, command, example):
    lines, answer = report(command, search(example), tmp_path)
    [line] = taken(lines)
    [assumed] = answer["assumed"]
    assert line == f"taken for targets.0.target.name: {assumed['detail']}"
    assert "Ljubljana, SI" in line


def test_windows_say_how_likely_the_target_is_in_frame(tmp_path):
    csv = tmp_path / "windows.csv"
    found = json.loads((EXAMPLES / "opportunities_gallery.json").read_text())
    words = ["windows", "-", "--json", str(tmp_path / "found.json"), "--csv", str(csv)]
    done = CliRunner().invoke(main, words, input=json.dumps(found))
    first, *_ = json.loads((tmp_path / "found.json").read_text())["windows"]
    heading, line, *_ = csv.read_text().splitlines()
    told = dict(zip(heading.split(","), line.split(","), strict=True))
    assert float(told["probability_in_frame"]) == first["probability_in_frame"]
    [headings] = [line for line in done.stdout.splitlines() if line.startswith("target ")]
    [row, *_] = [line for line in done.stdout.splitlines() if line.startswith("Las Vegas ")]
    assert headings.split()[-2:] == ["in", "frame"]
    assert row.split()[-1] == f"{first['probability_in_frame']:.2f}"


def test_a_target_without_a_window_says_why(tmp_path):
    """In a search as in a campaign."""
    document = search("opportunities_gallery.json")
    document["targets"][0]["target"] = {"mode": "ground", "latitude_deg": 90.0, "longitude_deg": 0}
    lines, answer = report("windows", document, tmp_path)
    [one] = answer["reasons"]
    assert answer["unseen"] == [one["target"]]
    [line] = [line for line in lines if line.startswith("can't be seen: ")]
    assert line.startswith(f"can't be seen: {one['target']}, {one['because']} (at most ")


def test_a_star_and_the_state_at_the_start(tmp_path):
    """One line each; the state at rest at zero in two, epoch and angles."""
    document = PLAN_EXAMPLES["keyhole"][1] | {}
    document["sessions"] = [
        document["sessions"][0] | {"target": {"mode": "star", "name": "Kochab"}}
    ]
    document.pop("initial_state")
    lines, answer = report("plan", document, tmp_path)
    told = [f"taken for {one['field']}: {one['detail']}" for one in answer["assumed"]]
    assert taken(lines) == told
    assert len(told) == 3
    assert any("72607" in line for line in told)


def test_nothing_is_told_where_nothing_was_left_out(tmp_path):
    lines, answer = report("plan", LAS_VEGAS, tmp_path)
    assert answer["assumed"] == taken(lines) == []


def test_how_near_a_mask_comes(tmp_path):
    lines, answer = report("plan", PLAN_EXAMPLES["masks"][1], tmp_path)
    [mask] = answer["masks"]
    row = lines[lines.index("masks to keep out of") + 2]
    assert row.split() == [
        mask["name"],
        f"{mask['asked_deg']:g}",
        f"{mask['away_min_deg']:.3f}",
        mask["at"][11:-3],
    ]


@pytest.mark.parametrize("width", [80, 10])
def test_no_text_of_an_answer_is_markup(width):
    """Whoever named it: a plan's target, or a service that isn't ours."""
    told = io.StringIO()
    row = {"name": "[red]Denver[/red] :smile:", "seen": {"at": None}}
    columns = (("<target", "name"), ("at", "seen.at", ".1f"))
    print_rows(Console(file=told, width=width, soft_wrap=True), None, [row], *columns)
    assert "[red]Denver[/red] :smile:" in " ".join(told.getvalue().split())


@pytest.mark.parametrize(
    "words",
    [
        ["plan", "las_vegas_2015.json"],
        ["fly", "las_vegas_2015.json"],
        ["compare", "las_vegas_2015.json", "las_vegas_telemetry.csv"],
    ],
    ids=lambda words: words[0],
)
def test_a_picture_that_can_not_be_drawn_is_refused_before_the_work(words, monkeypatch):
    verb, *files = words
    monkeypatch.delattr("planner.planning.sessions.pipeline.make_plan")
    given = [verb, *(str(EXAMPLES / file) for file in files), "--plot", "out/it.gif"]
    done = CliRunner().invoke(main, given)
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr == "slewtrack: --plot: must end in .png, .svg or .pdf, not .gif\n"


def test_numbers_and_picture_are_of_one_comparison(tmp_path, monkeypatch):
    """Which takes half a minute where parameters are identified."""
    made = []
    compare = telemetry.compare_sent
    monkeypatch.setattr(telemetry, "compare_sent", lambda *sent: made.append(1) or compare(*sent))
    files = [EXAMPLES / "las_vegas_2015.json", EXAMPLES / "las_vegas_telemetry.csv"]
    words = ["compare", *files, "--plot", tmp_path / "it.pdf", "--json", tmp_path / "it.json"]
    done = CliRunner().invoke(main, [*map(str, words)])
    assert done.exit_code == 0, done.stderr
    assert (tmp_path / "it.pdf").read_bytes().startswith(b"%PDF")
    assert json.loads((tmp_path / "it.json").read_text())["axes"]
    assert made == [1]
