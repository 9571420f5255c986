"""Hostile clients get a refusal, quickly, and nothing else."""

import json
import socket
from contextlib import ExitStack, closing, suppress

import pytest
from hostile_cases import CASES, GET, Hostile, head, post
from live_service import live_service
from waiting import eventually

SLOW_S = 1.0
CONNECTIONS = 20
# An answer that takes longer than this would be a hang; how long each takes is not asserted.
PATIENCE_S = 120.0
# Four times the largest body: its bytes, its text, what is built of it, and the allocator's rest.
MEMORY_MIB = 4 * 8 + 100


@pytest.fixture(scope="module")
def at_start(tmp_path_factory):
    """The service, and how large it was when it had answered once."""
    folder = tmp_path_factory.mktemp("hostile")
    with live_service(
        folder,
        SLEWTRACK_BODY_TIMEOUT_S=str(SLOW_S),
        SLEWTRACK_HEAD_TIMEOUT_S=str(SLOW_S),
        SLEWTRACK_MAX_CONNECTIONS=str(CONNECTIONS),
    ) as service:
        with closing(ask(service, head(GET))) as connection:
            assert answer(connection)[0] == 200
        yield service, service.memory_mib()


@pytest.fixture(scope="module")
def service(at_start):
    return at_start[0]


def connected(service) -> socket.socket:
    return socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE_S)


def answer(connection: socket.socket) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of the next answer."""
    with connection.makefile("rb") as lines:
        status = int(lines.readline().split()[1])
        headers = {}
        while line := lines.readline().strip():
            name, _, value = line.decode("latin-1").partition(":")
            headers[name.lower()] = value.strip()
        return status, headers, lines.read(int(headers["content-length"]))


def refused(connection: socket.socket, status: int, says: str = "") -> None:
    got, headers, body = answer(connection)
    problem = json.loads(body)
    assert got == status, problem
    assert headers["content-type"] == "application/problem+json"
    assert headers["x-content-type-options"] == "nosniff"
    assert "server" not in headers
    assert problem["status"] == status
    assert says in problem["detail"]
    assert problem["instance"].endswith(headers["x-request-id"])
    assert "Traceback" not in body.decode()
    assert "/work" not in body.decode()
    assert "site-packages" not in body.decode()


def ask(service, sent: bytes) -> socket.socket:
    connection = connected(service)
    with suppress(BrokenPipeError, ConnectionResetError):  # refused before all was sent
        connection.sendall(sent)
    return connection


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_is_refused(service, case: Hostile):
    with closing(ask(service, case.sent)) as connection:
        refused(connection, case.status, case.says)


def test_the_service_has_stayed_small(at_start):
    """After all of the above, and answers still."""
    service, begun_mib = at_start
    assert service.memory_mib() < begun_mib + MEMORY_MIB
    with closing(ask(service, head(GET))) as connection:
        assert answer(connection)[0] == 200


def test_no_bug_was_met(service):
    text = service.log.read_text()
    assert "Traceback" not in text
    assert "[error" not in text


@pytest.mark.parametrize(
    ("sent", "says"),
    [
        (b"", "head of a request"),
        (b"GET / HT", "head of a request"),
        (post(b"[1]")[:-1], "whole body"),
    ],
    ids=["nothing", "half a head", "half a body"],
)
def test_slow_clients_are_let_go(service, sent, says):
    with closing(ask(service, sent)) as connection:
        refused(connection, 408, f"{says} must come within {SLOW_S:g} s")
        assert connection.recv(1) == b""


def test_a_second_request_on_a_connection_is_timed_too(service):
    with closing(ask(service, head(GET))) as connection:
        assert answer(connection)[0] == 200
        connection.sendall(b"GET / HT")
        assert answer_of_stream(connection) == [408]


def test_half_a_request_sent_on_ahead_holds_no_connection(service):
    with closing(ask(service, head(GET) + b"GET / HT")) as connection:
        assert answer_of_stream(connection) == [200]


def answer_of_stream(connection: socket.socket) -> list[int]:
    """The statuses of all answers until the connection ends."""
    received = b""
    while piece := connection.recv(65536):
        received += piece
    return [int(part[:3]) for part in received.split(b"HTTP/1.1 ")[1:]]


def test_a_smuggled_request_is_not_answered(service):
    """What a proxy that believes Content-Length would take for one body holds a second request."""
    inner = head("GET /healthz HTTP/1.1")
    sent = post(b"0\r\n\r\n" + inner, "Transfer-Encoding: chunked")
    with closing(ask(service, sent)) as connection:
        assert answer_of_stream(connection)[0] == 400


def test_a_connection_beyond_the_cap_is_refused_until_the_silent_are_let_go(service):
    def told() -> list[int]:
        with ExitStack() as held:
            *silent, one_more = [
                held.enter_context(closing(connected(service))) for _ in range(CONNECTIONS + 1)
            ]
            try:
                refused(one_more, 503, f"{CONNECTIONS} connections")
            except AssertionError:  # it took so long that the first were let go
                return []
            return [answer(one)[0] for one in silent]

    assert eventually(told) == CONNECTIONS * [408]
    with closing(ask(service, head(GET))) as later:
        assert answer(later)[0] == 200
