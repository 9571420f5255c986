"""No figure is cut, however narrow the place a report goes to."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.cli import main
from planner.spacecraft.plan import plan_imaging

EXAMPLES = Path(__file__).parents[2] / "examples"
HORIZON = [str(EXAMPLES / f"horizon_{side}.png") for side in ("ahead", "right")]
LAS_VEGAS = str(EXAMPLES / "las_vegas_2015.json")
REPORTS = {
    "plan": [str(EXAMPLES / "three_sessions.json")],
    "windows": [str(EXAMPLES / "opportunities_gallery.json")],
    "campaign": [str(EXAMPLES / "campaign_cities.json")],
    "spacecraft": [str(EXAMPLES / "spacecraft_four_modes.json")],
    "horizon": [str(EXAMPLES / "horizon_estimate.json"), *HORIZON],
    "fly": [LAS_VEGAS, "--runs", "2"],
    "compare": [LAS_VEGAS, str(EXAMPLES / "las_vegas_telemetry.csv")],
}
# A line of headings at 80 columns, where the whole table is wider.
NARROW = {
    "fly": "session target frames sharp smear px miss m",
    "compare": "axis phase from samples rms max mean lag 1 sigma",
}


@pytest.fixture(autouse=True)
def in_a_pipe(monkeypatch):
    """Which knows no width."""
    monkeypatch.delenv("COLUMNS", raising=False)


def report(verb, words, columns=None):
    environment = {} if columns is None else {"COLUMNS": str(columns)}
    done = CliRunner().invoke(main, [verb, *words], env=environment)
    assert done.exit_code == 0, done.stderr
    return re.sub(r"planned in \d+ ms|[0-9a-f-]{36}", "", done.stdout)


@pytest.fixture
def session_is_planned_once(monkeypatch):
    """Its report is what is wanted at every width."""
    made = []

    def once(*given):
        if not made:
            made.append(plan_imaging(*given))
        return made[0]

    monkeypatch.setattr("planner.spacecraft.plan.plan_imaging", once)


@pytest.mark.usefixtures("session_is_planned_once")
@pytest.mark.parametrize("verb", REPORTS)
def test_every_word_is_there_at_every_width(verb):
    words = REPORTS[verb]
    whole = report(verb, words)
    assert "…" not in whole
    for columns in (80, 30):
        narrow = report(verb, words, columns)
        assert "…" not in narrow
        assert max(map(len, narrow.splitlines())) <= columns
        told = {word.strip(",") for word in narrow.split()}
        figures = {word.strip(",") for word in whole.split() if any(map(str.isdigit, word))}
        # A time may be told to the second.
        assert all(figure in told or figure.partition(".")[0] in told for figure in figures)
        headings = [" ".join(line.split()) for line in narrow.splitlines()]
        assert columns < 80 or NARROW.get(verb, headings[0]) in headings


def test_a_pipe_gets_one_line_a_row():
    document = json.loads((EXAMPLES / "opportunities_gallery.json").read_text())
    for target in document["targets"]:
        target["id"] += " and everything around it as far as the eye can see from above"
    done = CliRunner().invoke(main, ["windows", "-"], input=json.dumps(document))
    assert done.exit_code == 0, done.stderr
    rows = [line for line in done.stdout.splitlines() if line.startswith("Las Vegas and")]
    assert len(rows) > 10
    assert all("from above  2015-" in row for row in rows)
