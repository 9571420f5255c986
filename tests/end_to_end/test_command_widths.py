"""Is no figure cut, however narrow the place a report goes to?"""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

SLEWTRACK = Path(sys.executable).with_name("slewtrack")
EXAMPLES = Path(__file__).parents[2] / "examples"
HORIZON = [str(EXAMPLES / f"horizon_{side}.png") for side in ("ahead", "right")]
REPORTS = {
    "plan": [str(EXAMPLES / "three_sessions.json")],
    "windows": [str(EXAMPLES / "opportunities_gallery.json")],
    "campaign": [str(EXAMPLES / "campaign_cities.json")],
    "spacecraft": [str(EXAMPLES / "spacecraft_four_modes.json")],
    "horizon": [str(EXAMPLES / "horizon_estimate.json"), *HORIZON],
}


def report(verb, words, environment):
    done = subprocess.run(
        [SLEWTRACK, verb, *words], capture_output=True, text=True, env=environment, check=True
    )
    return re.sub(r"planned in \d+ ms", "", done.stdout)


@pytest.mark.parametrize("verb", REPORTS)
def test_every_word_is_there_at_every_width(verb, clean_environment):
    words = REPORTS[verb]
    whole = report(verb, words, clean_environment)
    assert "…" not in whole
    for columns in (80, 30):
        narrow = report(verb, words, clean_environment | {"COLUMNS": str(columns)})
        assert "…" not in narrow
        assert max(map(len, narrow.splitlines())) <= columns
        told = {word.strip(",") for word in narrow.split()}
        figures = {word.strip(",") for word in whole.split() if any(map(str.isdigit, word))}
        assert figures <= told


def test_a_pipe_gets_one_line_a_row(clean_environment):
    document = json.loads((EXAMPLES / "opportunities_gallery.json").read_text())
    for target in document["targets"]:
        target["id"] += " and everything around it as far as the eye can see from above"
    done = subprocess.run(
        [SLEWTRACK, "windows", "-"],
        input=json.dumps(document),
        capture_output=True,
        text=True,
        env=clean_environment,
        check=True,
    )
    rows = [line for line in done.stdout.splitlines() if line.startswith("Las Vegas and")]
    assert len(rows) > 10
    assert all("from above  2015-" in row for row in rows)


@pytest.fixture
def clean_environment():
    import os

    return {name: value for name, value in os.environ.items() if name != "COLUMNS"}
