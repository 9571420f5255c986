"""Clients that don't read their answers are let go, and take no more than their share."""

import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from http.client import HTTPConnection
from pathlib import Path

import pytest
from hostile_cases import head
from live_service import Service, live_service
from waiting import eventually

CONNECTIONS = 40
PIPELINE = 20 * head("GET /openapi.json HTTP/1.1")
NEVER_S = "3600"
LISTENS = "0A"  # in /proc/net/tcp


@contextmanager
def small_service(folder: Path, **settings: str) -> Iterator[Service]:
    with live_service(
        folder, SLEWTRACK_DATABASE_URL="", SLEWTRACK_MAX_CONNECTIONS=str(CONNECTIONS), **settings
    ) as service:
        yield service


def slow_reader(service: Service) -> socket.socket:
    """Asks for 8 MB of answers and reads nothing."""
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.connect(("127.0.0.1", service.port))
    connection.sendall(PIPELINE)
    return connection


def status(service: Service) -> int:
    with closing(HTTPConnection("127.0.0.1", service.port, timeout=60)) as connection:
        connection.request("GET", "/v1/platforms")
        return connection.getresponse().status


def connections(service: Service) -> int:
    """How many clients' the service holds; its children's pipes are no TCP."""
    folder = Path(f"/proc/{service.pid}/fd")
    held = set()
    for name in os.listdir(folder):
        with suppress(FileNotFoundError):  # closed in between
            held.add(os.readlink(folder / name))
    lines = Path(f"/proc/{service.pid}/net/tcp").read_text().splitlines()[1:]
    states = {f"socket:[{line.split()[9]}]": line.split()[3] for line in lines}
    return sum(states.get(name, LISTENS) != LISTENS for name in held)


def test_all_places_are_free_again_when_they_are_cut_off(tmp_path):
    with small_service(tmp_path, SLEWTRACK_WRITE_TIMEOUT_S="1") as service, ExitStack() as held:
        readers = [held.enter_context(closing(slow_reader(service))) for _ in range(CONNECTIONS)]
        eventually(lambda: service.log.read_text().count("/openapi.json") >= len(readers))
        eventually(lambda: status(service) == 200)
        eventually(lambda: connections(service) == 0)
        for reader in readers:
            assert len(received(reader)) < 1_000_000


@pytest.fixture(scope="module")
def patient(tmp_path_factory):
    """A service that waits for whoever doesn't read, as long as that takes little memory."""
    folder = tmp_path_factory.mktemp("service")
    limits = {"SLEWTRACK_WRITE_TIMEOUT_S": NEVER_S, "SLEWTRACK_MAX_UNSENT_BYTES": "2000000"}
    with small_service(folder, **limits) as made:
        yield made


def test_who_reads_gets_all_answers_of_a_pipeline(patient):
    with closing(slow_reader(patient)) as reader:
        reader.sendall(head("GET /healthz HTTP/1.1", "Connection: close"))
        got = received(reader)
        assert got.count(b"HTTP/1.1 200 OK") == 21
        assert got.endswith(b"}")


def test_beyond_the_memory_for_all_of_them_the_slowest_are_cut_first(patient):
    """An answer of 0.7 MB each, of which the kernel takes some: two or three may wait."""
    eventually(lambda: connections(patient) == 0)  # those who left are gone
    with ExitStack() as held:
        readers, before = [], answered(patient)
        for number in range(1, 7):
            readers.append(held.enter_context(closing(slow_reader(patient))))
            # One after the other, so that it is known who has waited longest.
            eventually(lambda: answered(patient) >= before + number)  # noqa: B023
        eventually(lambda: 2 <= connections(patient) <= 4)
        for reader in readers[:2]:
            assert len(received(reader)) < 1_000_000
        readers[-1].sendall(head("GET /healthz HTTP/1.1", "Connection: close"))
        assert received(readers[-1]).count(b"HTTP/1.1 200 OK") == 21


def answered(service: Service) -> int:
    """How many answers have been begun, of which each slow reader holds up one."""
    return service.log.read_text().count("/openapi.json")


def received(reader: socket.socket) -> bytes:
    """Until the connection ends."""
    reader.settimeout(60)
    pieces = []
    try:
        while piece := reader.recv(65536):
            pieces.append(piece)
    except ConnectionResetError:  # cut off
        pass
    return b"".join(pieces)
