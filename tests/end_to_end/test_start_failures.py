"""A start that fails is one line on stderr and exit code 2; what is kept is the owner's alone."""

import os
import socket
import sqlite3
import stat
import subprocess

import pytest
from live_service import ROOT, SLEWTRACK
from typer.testing import CliRunner

from app.cli import main
from app.store.database import FILE, open_database
from app.store.migrate import upgrade

COMMANDS = (["serve", "--port", "0"], ["keys", "list"])


def refused(folder, *words: str, url: str = "") -> str:
    environment = {"SLEWTRACK_DATA_DIR": str(folder), "SLEWTRACK_DATABASE_URL": url}
    ran = CliRunner().invoke(main, words, env=environment)
    return line_of(ran.exit_code, ran.stderr)


def line_of(code: int, stderr: str) -> str:
    assert code == 2, stderr
    [line] = stderr.splitlines()
    assert line.startswith("slewtrack: ")
    return line


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
@pytest.mark.parametrize(
    ("url", "why"),
    [("", "SQLITE_NOTADB"), ("postgresql+psycopg://u:canary@127.0.0.1:1/x", "does its server run")],
)
def test_one_line_whoever_else_could_write(tmp_path, words, url, why):
    """Seen from outside, where Python writes what is logged and nobody takes."""
    (tmp_path / FILE).write_bytes(b"\xa5" * 8192)
    environment = os.environ | {"SLEWTRACK_DATA_DIR": str(tmp_path), "SLEWTRACK_DATABASE_URL": url}
    ran = subprocess.run(
        [SLEWTRACK, *words], capture_output=True, text=True, cwd=ROOT, env=environment
    )
    assert why in line_of(ran.returncode, ran.stderr)


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_file_where_the_folder_should_be(tmp_path, words):
    occupied = tmp_path / "file"
    occupied.write_text("")
    assert str(occupied) in refused(occupied, *words)
    assert str(occupied) in refused(occupied / "deeper", *words)


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_folder_nobody_may_write(words):
    assert "/proc/slewtrack" in refused("/proc/slewtrack", *words)  # not even root


@pytest.mark.parametrize(
    "url",
    [
        "nonsense",
        "mysql://a:canary@b/c",
        "postgresql+psycopg://u:canary@127.0.0.1:1/none",
        "postgresql+psycopg://u:canary@no-such-host.invalid/none",
        "postgresql+psycopg://u:canary@127.0.0.1:x/none",
        "postgresql+psycopg://u:canary@127.0.0.1:1/none?canary=canary",
        "sqlite:////proc/slewtrack/file",
    ],
)
@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_wrong_url(tmp_path, words, url):
    assert "canary" not in refused(tmp_path, *words, url=url)


def test_a_port_in_use(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        said = refused(tmp_path, "serve", "--port", str(port))
    assert f"port {port}" in said


def test_a_locked_database(tmp_path, monkeypatch):
    """It is waited for, as others may be migrating, but not for ever."""
    monkeypatch.setattr("app.store.migrate._OTHERS_S", 0.0)
    database = open_database("", tmp_path)
    upgrade(database)
    other = sqlite3.connect(tmp_path / FILE, isolation_level=None)
    other.execute("BEGIN EXCLUSIVE")
    with pytest.raises(Exception, match="SQLITE_BUSY"):
        upgrade(database)
    other.close()


@pytest.mark.parametrize("url", ["", "sqlite:///{folder}/" + FILE])
def test_files_are_the_owners_alone(tmp_path, url):
    tmp_path.chmod(0o755)
    (tmp_path / FILE).touch(0o644)
    database = open_database(url.format(folder=tmp_path), tmp_path)
    upgrade(database)
    modes = {file.name: stat.S_IMODE(file.stat().st_mode) for file in tmp_path.iterdir()}
    database.close()
    assert modes == {f"{FILE}{suffix}": 0o600 for suffix in ("", "-wal", "-shm")}
