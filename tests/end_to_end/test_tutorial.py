"""Every command of the tutorial runs, in its order, and says what the page shows."""

import re
import shlex
from pathlib import Path
from zipfile import ZipFile

import pytest
from live_service import live_service
from typer.testing import CliRunner

from app.cli import main

ROOT = Path(__file__).parents[2]
TUTORIAL = (ROOT / "docs" / "tutorial.md").read_text()
SECTIONS = TUTORIAL.split("\n## ")
# Its commands need none before them, and take minutes together.
[BY_ITSELF] = [one for one in SECTIONS if one.startswith("A day on one battery")]
IN_ORDER = "".join(one for one in SECTIONS if one is not BY_ITSELF)
SERVICE = "http://127.0.0.1:8000"


def commands(text=TUTORIAL):
    """Each with the lines shown under it."""
    for block in re.findall(r"```console\n(.*?)```", text, re.DOTALL):
        for part in block.split("$ slewtrack ")[1:]:
            command, *shown = part.rstrip("\n").split("\n")
            yield command, [line for line in shown if line != "..."]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("tutorial")
    (where / "examples").symlink_to(ROOT / "examples")
    return where


def check(command, shown):
    done = CliRunner().invoke(main, shlex.split(command))
    refusal = [line for line in shown if line.startswith("slewtrack: ")]
    assert done.exit_code == (2 if refusal else 0), (command, done.stderr)
    assert "was left out" not in done.output, command  # what a campaign chooses can be planned
    told = (done.stderr if refusal else done.stdout).splitlines()
    for line in shown:
        assert line in told, (command, line)
    return done.stdout


@pytest.mark.parametrize(("command", "shown"), list(commands(BY_ITSELF)))
def test_commands_by_themselves(command, shown, folder, monkeypatch):
    monkeypatch.chdir(folder)
    check(command, shown)


def test_every_command_in_order(folder, monkeypatch):
    with live_service(folder) as service:
        monkeypatch.chdir(folder)
        monkeypatch.setenv("SLEWTRACK_URL", service.address)
        monkeypatch.delenv("COLUMNS", raising=False)  # as in a pipe, which knows no width
        plan_id = ""
        seen = []
        for command, shown in commands(IN_ORDER):
            seen.append(command.split()[0])
            if command == "serve":
                continue
            text = command.replace(SERVICE, service.address).replace("$ID", plan_id)
            said = check(text, shown)
            if found := re.search(r"^kept as (\S+)$", said, re.M):
                plan_id = found[1]
    assert set(seen) == {
        "plan", "windows", "campaign", "fly", "serve", "list", "show", "export", "watch",
    }  # fmt: skip
    written = {
        path.relative_to(folder / "out").as_posix() for path in (folder / "out").rglob("*.*")
    }
    assert {"plan.png", "map.geojson", "windows.csv", "plan.nc", "plan.aem", "looks.csv"} <= written
    with ZipFile(folder / "out" / "fleet.zip") as fleet:
        assert any(name.endswith(".csv") for name in fleet.namelist())
    assert len((folder / "out" / "fleet.csv").read_text().splitlines()) > 10
    assert {"kept.nc", "kept.kml", "passes/pass-1.json"} <= written
    assert {f"{name}.{kind}" for name in ("axes", "body", "gyros") for kind in ("png", "aem")} <= (
        written
    )
