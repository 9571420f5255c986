"""Every command of the tutorial runs, in its order, and says what the page shows."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from live_service import live_service

ROOT = Path(__file__).parents[2]
SLEWTRACK = Path(sys.executable).with_name("slewtrack")
BLOCKS = re.findall(r"```console\n(.*?)```", (ROOT / "docs" / "tutorial.md").read_text(), re.DOTALL)
SERVICE = "http://127.0.0.1:8000"


def commands():
    """Each with the lines shown under it."""
    for block in BLOCKS:
        for part in block.split("$ slewtrack ")[1:]:
            command, *shown = part.rstrip("\n").split("\n")
            yield command, [line for line in shown if line != "..."]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("tutorial")
    (where / "examples").symlink_to(ROOT / "examples")
    return where


def run(folder, command):
    """As in a pipe of no width: readline, loaded by pytest, would hand on COLUMNS unseen."""
    words = [SLEWTRACK, *shlex.split(command)]
    told = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    return subprocess.run(words, capture_output=True, text=True, cwd=folder, env=told)


def check(folder, command, shown):
    done = run(folder, command)
    refusal = [line for line in shown if line.startswith("slewtrack: ")]
    assert done.returncode == (2 if refusal else 0), (command, done.stderr)
    told = (done.stderr if refusal else done.stdout).splitlines()
    for line in shown:
        assert line in told, (command, line)
    return done.stdout


def test_every_command_in_order(folder, monkeypatch):
    with live_service(folder) as service:
        monkeypatch.setenv("SLEWTRACK_URL", service.address)
        plan_id = ""
        seen = []
        for command, shown in commands():
            seen.append(command.split()[0])
            if command == "serve":
                continue
            text = command.replace(SERVICE, service.address).replace("$ID", plan_id)
            said = check(folder, text, shown)
            if found := re.search(r"^kept as (\S+)$", said, re.M):
                plan_id = found[1]
    assert {"plan", "windows", "campaign", "serve", "list", "show", "export", "watch"} == set(seen)
    written = {
        path.relative_to(folder / "out").as_posix() for path in (folder / "out").rglob("*.*")
    }
    assert {"plan.png", "map.geojson", "windows.csv", "plan.nc", "plan.aem", "looks.csv"} <= written
    assert {"kept.nc", "kept.kml", "passes/pass-1.json"} <= written
