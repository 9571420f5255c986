"""How do tests reach a service of their own, over a real connection?"""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
SLEWTRACK = Path(sys.executable).with_name("slewtrack")


@dataclass(frozen=True)
class Service:
    """A running `slewtrack serve`: its address, its process, the file its log goes to."""

    address: str
    pid: int
    log: Path

    @property
    def port(self) -> int:
        return int(self.address.rsplit(":", 1)[1])

    def memory_mib(self) -> float:
        """Resident memory of the service itself at its largest, its children apart."""
        status = Path(f"/proc/{self.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s+(\d+) kB", status)[1]) / 1024


@contextmanager
def live_service(folder: Path, *words: str, **settings: str) -> Iterator[Service]:
    """`slewtrack serve` on a free port of loopback; its data and log stay in the folder."""
    log = folder / "service.log"
    environment = os.environ | {
        "SLEWTRACK_ALLOWED_HOSTS": "localhost,127.0.0.1,[::1]",
        "SLEWTRACK_DATA_DIR": str(folder),
        **settings,
    }
    with log.open("wb") as stderr:
        process = subprocess.Popen(
            [SLEWTRACK, "serve", "--port", "0", *words], stderr=stderr, cwd=ROOT, env=environment
        )
    try:
        yield Service(_address(process, log), process.pid, log)
    finally:
        process.terminate()
        process.wait(timeout=20)


def _address(process: subprocess.Popen[bytes], log: Path) -> str:
    while process.poll() is None:
        if found := re.search(r"running on (http://[\d.:]+)", log.read_text()):
            return found[1]
        try:
            process.wait(timeout=0.05)
        except subprocess.TimeoutExpired:
            continue
    raise AssertionError(f"the service said no address: {log.read_text()}")
