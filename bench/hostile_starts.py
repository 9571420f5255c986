"""Starts that can't succeed, files that others could read, and a service short of descriptors."""

import os
import resource
import socket
import stat
import subprocess
import time
from collections import Counter
from pathlib import Path

from hostile_siege import SLEWTRACK, SLOW_S, Siege, Toll

_DESCRIPTORS = 64
_CONNECTIONS = 80
_SHORT_S = 10.0


def few_descriptors(siege: Siege) -> Toll:
    """More connections than the service may open: it says so, but no more than once a second."""
    toll = Toll()
    limit = resource.prlimit(siege.process.pid, resource.RLIMIT_NOFILE)
    resource.prlimit(siege.process.pid, resource.RLIMIT_NOFILE, (_DESCRIPTORS, limit[1]))
    before = len(siege.log.read_text().splitlines())
    held = []
    for _ in range(_CONNECTIONS):
        held.append(socket.create_connection(("127.0.0.1", siege.port)))
        toll.tried += 1
    time.sleep(_SHORT_S)
    for connection in held:
        connection.close()
    resource.prlimit(siege.process.pid, resource.RLIMIT_NOFILE, limit)
    lines = siege.log.read_text().splitlines()[before:]
    if len(lines) > 10 * _SHORT_S:
        kinds = Counter(line[30:90] for line in lines).most_common(2)
        toll.complain(f"{len(lines)} lines of log in {_SHORT_S:g} s: {kinds}")
    time.sleep(1.0)
    toll.require(siege.get("/v1/plans", toll), 200)
    return toll


def impossible_starts(siege: Siege) -> Toll:
    """One line on stderr and exit code 2, each; and files that nobody else may read."""
    toll = Toll()
    for path in siege.folder.glob("slewtrack.sqlite3*"):
        toll.tried += 1
        if stat.S_IMODE(path.stat().st_mode) != 0o600:
            toll.complain(f"{path.name} has the mode {path.stat().st_mode:o}")
    file = siege.folder / "file"
    file.write_text("no folder")
    corrupt = siege.folder / "corrupt"
    corrupt.mkdir()
    (corrupt / "slewtrack.sqlite3").write_bytes(b"no database " * 1000)
    settings: dict[str, dict[str, str]] = {
        "a file as data folder": {"SLEWTRACK_DATA_DIR": str(file)},
        "a corrupt database": {"SLEWTRACK_DATA_DIR": str(corrupt)},
        "nobody there": {
            "SLEWTRACK_DATABASE_URL": "postgresql+psycopg://canary:canary-password@127.0.0.1:1/x"
        },
        "no URL": {"SLEWTRACK_DATABASE_URL": "canary-password"},
        "another driver": {"SLEWTRACK_DATABASE_URL": "mysql://canary:canary-password@x/y"},
        "no such folder": {"SLEWTRACK_DATABASE_URL": "sqlite:////proc/nothing/here.sqlite3"},
    }
    for name, setting in settings.items():
        for words in (("serve", "--port", "0"), ("keys", "list")):
            _start(name, words, setting, toll)
    _start("the port is taken", ("serve", "--port", str(siege.port)), {}, toll, siege.folder)
    return toll


def _start(
    name: str, words: tuple[str, ...], setting: dict[str, str], toll: Toll,
    folder: Path = Path("/nonexistent"),
) -> None:  # fmt: skip
    environment = os.environ | {"SLEWTRACK_DATA_DIR": str(folder)} | setting
    began_s = time.monotonic()
    ended = subprocess.run(
        [SLEWTRACK, *words], env=environment, capture_output=True, text=True, timeout=60
    )
    toll.tried += 1
    lines = ended.stderr.strip().splitlines()
    if ended.returncode != 2 or len(lines) != 1:
        toll.complain(
            f"{name}, {words[0]}: exit {ended.returncode}, {len(lines)} lines: {lines[-1:]}"
        )
    if "canary-password" in ended.stderr:
        toll.complain(f"{name}, {words[0]}: says the password")
    # Python and what it imports take their time, on a machine that is busy, too.
    if time.monotonic() - began_s > 10.0 * SLOW_S:
        toll.complain(f"{name}, {words[0]}: took {time.monotonic() - began_s:.0f} s")
