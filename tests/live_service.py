"""A service of the tests' own, reached over a real connection."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from waiting import PATIENCE_S

ROOT = Path(__file__).parents[1]
SLEWTRACK = Path(sys.executable).with_name("slewtrack")


@dataclass(frozen=True)
class Service:
    """A running `slewtrack serve`: its address, its process, the files of its log and output."""

    address: str
    pid: int
    log: Path
    output: Path

    @property
    def port(self) -> int:
        return int(self.address.rsplit(":", 1)[1])

    def memory_mib(self) -> float:
        """Resident memory of the service itself at its largest, its children apart."""
        status = Path(f"/proc/{self.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s+(\d+) kB", status)[1]) / 1024


def children_of(pid: int) -> list[int]:
    """Processes that do the service's work: the children of its fork server."""
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            text = status.read_text()
            parent = int(text.rpartition(")")[2].split()[1])
            found.append((int(status.parent.name), parent))
    servers = {child for child, parent in found if parent == pid}
    return [child for child, parent in found if parent in servers]


@contextmanager
def live_service(folder: Path, *words: str, **settings: str) -> Iterator[Service]:
    """`slewtrack serve` on a free port of loopback; its data and log stay in the folder."""
    log = folder / "service.log"
    environment = os.environ | {
        "SLEWTRACK_ALLOWED_HOSTS": "localhost,127.0.0.1,[::1]",
        "SLEWTRACK_DATA_DIR": str(folder),
        **settings,
    }
    output = folder / "service.out"
    with log.open("wb") as stderr, output.open("wb") as stdout:
        process = subprocess.Popen(
            [SLEWTRACK, "serve", "--port", "0", *words],
            stdout=stdout,
            stderr=stderr,
            cwd=ROOT,
            env=environment,
        )
    try:
        yield Service(_address(process, log), process.pid, log, output)
    finally:
        process.terminate()
        process.wait(timeout=PATIENCE_S)


def _address(process: subprocess.Popen[bytes], log: Path) -> str:
    while process.poll() is None:
        if found := re.search(r"running on (http://[\d.:]+)", log.read_text()):
            return found[1]
        try:
            process.wait(timeout=0.05)
        except subprocess.TimeoutExpired:
            continue
    raise AssertionError(f"the service said no address: {log.read_text()}")
