"""Does the command behave as a command should: exit codes, streams, files?"""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app import cli
from app.api.examples import LAS_VEGAS
from planner.errors import VerificationFailed

SLEWTRACK = Path(sys.executable).with_name("slewtrack")
EXAMPLE = Path(__file__).parents[2] / "examples" / "las_vegas_2015.json"


def slewtrack(*words: str, **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run([SLEWTRACK, *words], capture_output=True, text=True, **options)


def one_line(text: str) -> str:
    [line] = text.splitlines()
    assert line.startswith("slewtrack: ")
    return line


def test_standard_input_is_a_file_named_dash():
    result = slewtrack("plan", "-", input=json.dumps(LAS_VEGAS))
    assert result.returncode == 0, result.stderr
    assert "Las Vegas" in result.stdout


def test_no_such_file():
    result = slewtrack("plan", "nowhere.json")
    assert result.returncode == 2
    assert "nowhere.json" in one_line(result.stderr)


def test_a_place_that_can_not_be_written(tmp_path):
    occupied = tmp_path / "file"
    occupied.write_text("")
    result = CliRunner().invoke(cli.main, ["plan", str(EXAMPLE), "--csv", f"{occupied}/table.csv"])
    assert result.exit_code == 2
    assert str(occupied) in one_line(result.stderr)


def test_an_unknown_picture_format(tmp_path):
    result = CliRunner().invoke(cli.main, ["plan", str(EXAMPLE), "--plot", f"{tmp_path}/a.bmp"])
    assert result.exit_code == 2
    assert "png" in one_line(result.stderr)


@pytest.mark.parametrize("suffix", ["svg", "pdf"])
def test_pictures_in_vectors(tmp_path, suffix):
    picture = tmp_path / f"plan.{suffix}"
    assert (
        CliRunner().invoke(cli.main, ["plan", str(EXAMPLE), "--plot", str(picture)]).exit_code == 0
    )
    assert picture.stat().st_size > 10_000


@pytest.mark.parametrize(
    "host", ["0.0.0.0", "::", "192.168.1.5", "example.org", "127.0.0.1.nip.io"]
)
def test_serves_this_machine_only(host):
    result = CliRunner().invoke(cli.main, ["serve", "--host", host])
    assert result.exit_code == 2
    assert "127.0.0.1" in one_line(result.stderr)


def test_a_bug_is_one_line_and_exit_code_1(monkeypatch):
    def broken(_scenario):
        raise RuntimeError("a bug")

    monkeypatch.setattr("planner.pipeline.make_plan", broken)
    result = CliRunner().invoke(cli.main, ["plan", str(EXAMPLE)])
    assert result.exit_code == 1
    assert "internal error" in one_line(result.stderr)


def test_our_failures_are_exit_code_1(monkeypatch):
    def rejected(_scenario):
        raise VerificationFailed("the judge says no")

    monkeypatch.setattr("planner.pipeline.make_plan", rejected)
    result = CliRunner().invoke(cli.main, ["plan", str(EXAMPLE)])
    assert result.exit_code == 1
    assert one_line(result.stderr) == "slewtrack: the judge says no"


@pytest.mark.parametrize("heavy", ["fastapi", "uvicorn", "cv2", "matplotlib"])
def test_planning_does_not_load_what_it_does_not_need(heavy):
    """Start-up time, told by what is imported rather than by a clock."""
    code = (
        "import sys; from app.cli import main\n"
        f"sys.argv = ['slewtrack', 'plan', {str(EXAMPLE)!r}]\n"
        "try:\n    main()\nexcept SystemExit as done:\n    assert not done.code\n"
        f"assert {heavy!r} not in sys.modules"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
