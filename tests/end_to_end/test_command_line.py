"""The command behaves as a command should: exit codes, streams, files."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.cli import main
from app.requests.examples import LAS_VEGAS, PLAN_EXAMPLES
from planner.base.errors import VerificationFailed

EXAMPLES = Path(__file__).parents[2] / "examples"
EXAMPLE = EXAMPLES / "las_vegas_2015.json"


def one_line(text: str) -> str:
    [line] = text.splitlines()
    assert line.startswith("slewtrack: ")
    return line


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["plan"], "Missing argument"),
        (["plan", "--nope", "x"], "--nope"),
        (["plan", "a", "b"], "unexpected"),
        (["plan", "a", "--csv"], "--csv"),
        (["scheme"], "scheme"),
        (["serve", "--port", "x"], "whole number"),
        (["serve", "--port", "99999"], "0 to 65535"),
    ],
)
def test_a_command_that_can_not_be_read(words, said):
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 2
    line = one_line(result.stderr)
    assert said in line
    assert "--help" in line


def test_help_where_nothing_is_asked():
    result = CliRunner().invoke(main, [])
    assert result.exit_code == 2
    assert "Usage" in result.stdout


def test_a_place_that_can_not_be_written(tmp_path):
    occupied = tmp_path / "file"
    occupied.write_text("")
    result = CliRunner().invoke(main, ["plan", str(EXAMPLE), "--csv", f"{occupied}/table.csv"])
    assert result.exit_code == 2
    assert str(occupied) in one_line(result.stderr)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nowhere.json"], "nowhere.json"),
        *(([EXAMPLE, "--export", wrong], "netcdf") for wrong in ("table.csv", "csv=", "xlsx=a.x")),
    ],
)
def test_a_file_or_an_export_that_can_not_be_read(words, said):
    result = CliRunner().invoke(main, ["plan", *map(str, words)])
    assert result.exit_code == 2
    assert said in one_line(result.stderr)


def test_a_table_that_failed_its_verification(tmp_path):
    """It is told beside its verdict only, and the exit code says that it isn't good."""
    words = [f"--{name}={tmp_path}/{name}" for name in ("csv", "json")]
    result = CliRunner().invoke(
        main, ["plan", "-", *words], input=json.dumps(PLAN_EXAMPLES["spline"][1])
    )
    assert result.exit_code == 1
    assert "failed its verification" in one_line(result.stderr)
    assert "verification FAILED" in result.stdout
    assert json.loads((tmp_path / "json").read_text())["state"] == "failed"
    assert not (tmp_path / "csv").exists()


@pytest.mark.parametrize("name", ["a $\\frac$ b", "x" * 200])
def test_a_picture_takes_any_name(tmp_path, name):
    document = json.dumps(LAS_VEGAS | {"name": name})
    words = ["plan", "-", "--plot", f"{tmp_path}/plan.png"]
    assert CliRunner().invoke(main, words, input=document).exit_code == 0


@pytest.mark.parametrize(
    "host", ["0.0.0.0", "::", "192.168.1.5", "example.org", "127.0.0.1.nip.io"]
)
def test_serves_this_machine_only(host):
    result = CliRunner().invoke(main, ["serve", "--host", host])
    assert result.exit_code == 2
    assert "127.0.0.1" in one_line(result.stderr)


@pytest.mark.parametrize("words", [["serve"], ["keys", "list"]])
def test_a_setting_that_cannot_be_is_refused_by_its_name(words, monkeypatch):
    monkeypatch.setenv("SLEWTRACK_WORKERS", "0")
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 2
    said = one_line(result.stderr)
    assert said.startswith("slewtrack: SLEWTRACK_WORKERS: ")
    assert "greater than 0, not '0'" in said


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (RuntimeError("a bug"), "slewtrack: internal error"),
        (VerificationFailed("the judge says no"), "slewtrack: the judge says no"),
    ],
)
def test_bugs_and_failures_of_ours_are_one_line_and_exit_code_1(monkeypatch, error, said):
    def broken(*_, **__):
        raise error

    monkeypatch.setattr("planner.planning.sessions.pipeline.make_plan", broken)
    result = CliRunner().invoke(main, ["plan", str(EXAMPLE)])
    assert result.exit_code == 1
    assert one_line(result.stderr).startswith(said)


def test_planning_does_not_load_what_it_does_not_need():
    """Start-up time, told by what is imported rather than by a clock."""
    code = (
        "import sys; from app.cli import main\n"
        f"sys.argv = ['slewtrack', 'plan', {str(EXAMPLE)!r}]\n"
        "try:\n    main()\nexcept SystemExit as done:\n    assert not done.code\n"
        "print({'fastapi', 'uvicorn', 'cv2', 'matplotlib'} & set(sys.modules))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "set()"
