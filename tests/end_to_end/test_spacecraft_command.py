"""`slewtrack spacecraft` reports, writes files, and refuses in one line."""

import json

from typer.testing import CliRunner

from app.cli import main
from app.requests.examples import FOUR_MODES, SPACECRAFT_EXAMPLES

STRIP = {**SPACECRAFT_EXAMPLES["geojson"][1], "simulation_runs": 1}


def spacecraft(*words, request=None):
    return CliRunner().invoke(
        main, ["spacecraft", "-", *map(str, words)], input=json.dumps(request or STRIP)
    )


def test_report_and_files(tmp_path):
    csv, answer = tmp_path / "out" / "table.csv", tmp_path / "answer.json"
    result = spacecraft("--export", f"csv={csv}", "--json", answer)
    assert result.exit_code == 0, result.stderr
    assert "verification passed" in result.stdout
    assert "steady within 0.001 deg/s in 100% of the intervals of 1 closed-loop" in result.stdout
    rows = [line for line in csv.read_text().splitlines() if not line.startswith("#")]
    assert len(rows) == 1 + 1501  # a heading, and 300 s of rows every 0.2 s
    assert json.loads(answer.read_text())["verification"]["passed"]


def test_refusals_are_one_line():
    beyond = {**FOUR_MODES, "settings": {"momentum_n_m_s": [70.0, 0.0, 0.0]}}
    result = spacecraft(request=beyond)
    assert result.exit_code == 2
    [line] = result.stderr.splitlines()
    assert line.startswith("slewtrack: settings.momentum_n_m_s: ")
    result = spacecraft("--export", "sp=a.sp")
    assert result.exit_code == 2
    assert "csv, json, netcdf, aem" in result.stderr
