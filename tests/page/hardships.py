"""Hardships of a service, for real: its workers die or stand still, its disk is full."""

import errno
import os
import resource
import signal
import sqlite3
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, Thread

import httpx2 as httpx
from live_service import Service, children_of

from app.store.database import FILE

_EVERY_S = 0.01  # far less than the least plan takes
_CHUNK = b"\0" * 65536


@contextmanager
def dying_workers(service: Service) -> Iterator[None]:
    """Whoever takes up work is killed at it."""
    with _signalled(service, signal.SIGKILL):
        yield


@contextmanager
def idle_workers(service: Service) -> Iterator[None]:
    """Work is taken up and doesn't go on until the end of this."""
    with _signalled(service, signal.SIGSTOP):
        yield
    for child in children_of(service.pid):
        with suppress(ProcessLookupError):
            os.kill(child, signal.SIGCONT)


@contextmanager
def _signalled(service: Service, number: signal.Signals) -> Iterator[None]:
    is_over = Event()

    def send() -> None:
        while not is_over.wait(_EVERY_S):
            for child in children_of(service.pid):
                with suppress(ProcessLookupError):
                    os.kill(child, number)

    sender = Thread(target=send)
    sender.start()
    try:
        yield
    finally:
        is_over.set()
        sender.join()


@contextmanager
def small_disk(folder: Path) -> Iterator[bool]:
    """A disk of 64 MiB mounted there, if that is permitted; says whether it is."""
    command = ["mount", "-t", "tmpfs", "-o", "size=64m", "tmpfs", str(folder)]
    try:
        is_mounted = subprocess.run(command, capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        is_mounted = False
    try:
        yield is_mounted
    finally:
        if is_mounted:
            subprocess.run(["umount", "--lazy", str(folder)], check=True)


@contextmanager
def full_disk(service: Service, folder: Path, *, is_disk: bool) -> Iterator[None]:
    """No byte more can be stored: the disk is full, or, without one, no file may grow."""
    with sqlite3.connect(folder / FILE) as database:
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    database.close()
    if is_disk:
        filler = folder / "filler"
        _fill(filler)
        try:
            yield
        finally:
            filler.unlink()
    else:
        before = resource.prlimit(service.pid, resource.RLIMIT_FSIZE)
        most = (folder / FILE).stat().st_size
        resource.prlimit(service.pid, resource.RLIMIT_FSIZE, (most, before[1]))
        try:
            yield
        finally:
            resource.prlimit(service.pid, resource.RLIMIT_FSIZE, before)


def _fill(file: Path) -> None:
    """Down to the last byte."""
    with file.open("wb", buffering=0) as opened:
        for chunk in (_CHUNK, b"\0"):
            try:
                while opened.write(chunk) == len(chunk):
                    pass
            except OSError as error:
                if error.errno != errno.ENOSPC:
                    raise


@contextmanager
def spent_rate(service: Service) -> Iterator[None]:
    """Whoever asks from here meanwhile has asked too often, however slow the machine is."""
    over = Event()

    def spend() -> None:
        with httpx.Client(base_url=service.address) as client:
            while not over.is_set():
                client.get("/v1/platforms")

    thread = Thread(target=spend, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def spend_all(service: Service) -> httpx.Response:
    """Asks until the service answers no more; the refusal."""
    with httpx.Client(base_url=service.address) as client:
        while (answer := client.get("/v1/platforms")).status_code == 200:
            pass
    return answer
