"""Clients that don't read their answers keep nobody out, and take no more than their share."""

import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from http.client import HTTPConnection
from pathlib import Path

import pytest
from hostile_cases import head
from live_service import Service, live_service
from typer.testing import CliRunner
from waiting import eventually

from app.cli import main
from app.http.admission.connections import connections_to_cut, to_give_way

CONNECTIONS = 40
PIPELINE = 20 * head("GET /openapi.json HTTP/1.1")
NEVER_S = "3600"
LISTENS = "0A"  # in /proc/net/tcp


@contextmanager
def service_with_key(folder: Path, **settings: str) -> Iterator[tuple[Service, str]]:
    environment = {"SLEWTRACK_DATA_DIR": str(folder), "SLEWTRACK_DATABASE_URL": ""}
    made = CliRunner().invoke(main, ["keys", "create", "good", "--scope", "read"], env=environment)
    with live_service(
        folder,
        SLEWTRACK_REQUIRE_KEYS="true",
        SLEWTRACK_DATABASE_URL="",
        SLEWTRACK_MAX_CONNECTIONS=str(CONNECTIONS),
        **settings,
    ) as service:
        yield service, made.stdout.strip()


def slow_reader(service: Service) -> socket.socket:
    """Asks for 8 MB of answers and reads nothing."""
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.connect(("127.0.0.1", service.port))
    connection.sendall(PIPELINE)
    return connection


def status(service: Service, path: str, secret: str | None = None) -> int:
    headers = {} if secret is None else {"Authorization": f"Bearer {secret}"}
    with closing(HTTPConnection("127.0.0.1", service.port, timeout=60)) as connection:
        connection.request("GET", path, headers=headers)
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


@pytest.fixture(scope="module")
def patient(tmp_path_factory):
    """A service that waits for whoever doesn't read, and its key."""
    folder = tmp_path_factory.mktemp("service")
    with service_with_key(folder, SLEWTRACK_WRITE_TIMEOUT_S=NEVER_S) as made:
        yield made


def test_they_keep_nobody_out(patient):
    service, secret = patient
    with ExitStack() as held:
        for _ in range(2 * CONNECTIONS):
            held.enter_context(closing(slow_reader(service)))
        for _ in range(5):
            assert status(service, "/v1/platforms", secret) == 200
            assert status(service, "/healthz") == 200


def test_they_are_cut_off(tmp_path):
    with (
        service_with_key(tmp_path, SLEWTRACK_WRITE_TIMEOUT_S="1") as (service, _),
        ExitStack() as held,
    ):
        readers = [held.enter_context(closing(slow_reader(service))) for _ in range(5)]
        eventually(lambda: service.log.read_text().count("/openapi.json") >= len(readers))
        eventually(lambda: connections(service) == 0)
        for reader in readers:
            assert len(received(reader)) < 1_000_000


def test_who_reads_gets_all_answers_of_a_pipeline(patient):
    service, _ = patient
    eventually(lambda: connections(service) == 0)  # those who left are gone
    with closing(slow_reader(service)) as reader:
        reader.sendall(head("GET /healthz HTTP/1.1", "Connection: close"))
        got = received(reader)
        assert got.count(b"HTTP/1.1 200 OK") == 21
        assert got.endswith(b"}")


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


@dataclass
class Place:
    """A connection, as far as it matters who gives way."""

    has_key: bool = False
    is_let_in: bool = True
    network: str = "a"
    since_s: float = 0.0
    stuck_since_s: float = 0.0
    waits_for_client: bool = True
    unsent_bytes: int = 0


def test_known_clients_and_those_served_never_give_way():
    assert to_give_way([Place(has_key=True), Place(waits_for_client=False)]) is None
    assert to_give_way([]) is None


def test_who_showed_nothing_gives_way_after_those_that_keep_us_waiting():
    unknown = Place(is_let_in=False, waits_for_client=False, since_s=0.0)
    waited_for = Place(since_s=1.0)
    assert to_give_way([unknown, waited_for]) is waited_for
    assert to_give_way([unknown, Place(waits_for_client=False)]) is unknown
    assert to_give_way([Place(has_key=True, is_let_in=False)]) is None


def test_of_the_network_that_holds_most_the_oldest_gives_way():
    oldest = Place(network="b", since_s=0.0)
    many = [Place(network="a", since_s=since_s) for since_s in (3.0, 2.0, 4.0)]
    assert to_give_way([oldest, *many]) is many[1]
    assert to_give_way([oldest, many[0]]) is oldest


@pytest.mark.parametrize(("most", "left"), [(100, 4), (60, 3), (59, 2), (10, 1), (0, 1)])
def test_the_slowest_without_a_key_are_cut_first(most, left):
    places = [
        Place(has_key=True, stuck_since_s=0.0, unsent_bytes=20),
        Place(stuck_since_s=2.0, unsent_bytes=20),
        Place(stuck_since_s=1.0, unsent_bytes=20),
        Place(stuck_since_s=0.0, unsent_bytes=20),
        Place(has_key=True, unsent_bytes=0),
    ]
    order = [places[3], places[2], places[1]]
    assert connections_to_cut(places, most) == order[: 4 - left]
