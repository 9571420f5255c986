"""The client raises a ServiceError, soon and within bounds, whatever answers it."""

import asyncio
import contextlib
import inspect
import json
import socket
import threading
import time
import tracemalloc

import httpx
import pytest

import slewtrack
from slewtrack.client import asking, calls

REQUEST = {"sessions": []}  # what it says doesn't matter: no service reads it
ID = "01a203fd-cbae-73f8-8276-319f76b8842c"
ENDS = {"timeout_s": 0.2}
PLAN_CALLS = {
    "plan": lambda client: client.plan(REQUEST, **ENDS),
    "plan with progress": lambda client: client.plan(REQUEST, progress=lambda _: None, **ENDS),
    "check": lambda client: client.check(REQUEST),
    "submit": lambda client: client.submit(REQUEST),
    "wait": lambda client: client.wait(ID, progress=lambda _: None, **ENDS),
    "get": lambda client: client.get(ID),
    "request": lambda client: client.request(ID),
    "plans": lambda client: client.plans(limit=500),
    "table": lambda client: client.table(ID),
    "export": lambda client: client.export(ID, "csv"),
    "view": lambda client: client.view(ID, step_s=1.0),
    "delete": lambda client: client.delete(ID),
}
CALLS = PLAN_CALLS | {
    "opportunities": lambda client: client.opportunities(REQUEST),
    "searches": lambda client: client.searches(),
    "get_search": lambda client: client.get_search(ID),
    "windows": lambda client: client.windows(ID),
    "search_request": lambda client: client.search_request(ID),
    "delete_search": lambda client: client.delete_search(ID),
    "next_pass": lambda client: client.next_pass({"sessions": [{}]}, **ENDS),
    "campaign": lambda client: client.campaign(REQUEST, **ENDS),
    "export_campaign": lambda client: client.export_campaign(ID, "csv"),
    "wait_for_campaign": lambda client: client.wait_for_campaign(ID, **ENDS),
    "campaigns": lambda client: client.campaigns(),
    "fly": lambda client: client.fly(ID, REQUEST, **ENDS),
    "wait_for_flights": lambda client: client.wait_for_flights(ID, **ENDS),
    "flights": lambda client: client.flights(ID),
    "delete_flights": lambda client: client.delete_flights(ID),
    "estimate_vertical": lambda client: client.estimate_vertical([b"image"], REQUEST),
    "compare": lambda client: client.compare(REQUEST, b"csv"),
    "draw_comparison": lambda client: client.draw_comparison(REQUEST),
    "platforms": lambda client: client.platforms(),
    "places": lambda client: client.places("a"),
    "stars": lambda client: client.stars("a"),
}


def test_every_call_is_among_those_tried():
    known = {name.split()[0] for name in CALLS}
    there = {name for name, _ in inspect.getmembers(slewtrack.Client, inspect.isfunction)}
    assert {name for name in there if not name.startswith("_")} - known == {"close"}


JOB = {"id": ID, "state": "done", "name": "", "revision": 1, "warnings": [], "problem": None}
TABLE = {"epoch": "2015-02-27T17:34:00Z", "t_s": [0.0]}
LISTS = (
    "plans", "campaigns", "flights", "opportunities", "windows", "platforms", "places", "stars",
)  # fmt: skip
DEEP = 100_000
HUGE = "9" * 5000
ODD = [
    '"../../admin?x="', '"a\\r\\nX: y"', '"\\ud800"', '".."', "7", "null", "{}", "[[]]", '""',
    HUGE,
]  # fmt: skip
BODIES = {
    "nothing": "",
    "a page": "<html>",
    "a list": "[]",
    "a text": '"x"',
    "no UTF-8": b"\xff\xfe{",
    "no members": "{}",
    "a deep list": "[" * DEEP + "]" * DEEP,
    "a deep member": '{"a":' * DEEP + "1" + "}" * DEEP,
    "a huge number": f'{{"id": {HUGE}}}',
    **{f"id {odd[:20]}": json.dumps(JOB)[:-1] + f', "id": {odd}}}' for odd in ODD},
    **{f"state {odd[:20]}": json.dumps(JOB)[:-1] + f', "state": {odd}}}' for odd in ODD},
    **{
        f"{member} {odd[:20]}": json.dumps(JOB | {"table": TABLE, "choice": {}})[:-1]
        + f', "{member}": {odd}}}'
        for member in ("table", "choice", "problem", "warnings", "verification", "passes", "name")
        for odd in ODD
    },
    **{
        f"{column} {odd[:20]}": json.dumps(JOB | TABLE)[:-1] + f', "{column}": {odd}}}'
        for column in ("epoch", "t_s", "alpha_deg")
        for odd in (*ODD, f"[{HUGE}]", '["a"]', "[[0.0]]", '[{"b": 1}]')
    },
    **{
        f"lists of {odd[:20]}": json.dumps(
            {name: [1] for name in LISTS} | {"unseen": [], "next": None} | JOB
        ).replace("[1]", odd)
        for odd in (*ODD, f"[{HUGE}]", "[{}]", '["a"]')
    },
    "lists of jobs": json.dumps({name: [JOB] for name in LISTS} | {"next": [{}]}),
    "no end of empty pages": json.dumps({name: [] for name in LISTS} | {"next": "on"}),
    "refused": json.dumps(JOB | {"state": "refused", "problem": {"status": "text", "field": [1]}}),
    "running": json.dumps(JOB | {"state": "running"}),
    "a problem": json.dumps({"type": 5, "status": "text", "detail": {"a": 1}, "field": 9}),
    "a problem with lists": json.dumps({"errors": [1], "relaxations": 7, "costs_sessions": 1.5}),
    "events": "event: state\ndata: {}\n\n" * 9,
    "deep events": f"event: progress\ndata: {'[' * DEEP}\n\n",
}
STATUSES = (200, 202, 204, 302, 404, 409, 422, 429, 500, 503)


@pytest.fixture(autouse=True)
def short(monkeypatch):
    for name, value in (("LOOK_S", 0.1), ("PAUSE_S", 0.02), ("ENTRIES_MAX", 5_000)):
        monkeypatch.setattr(calls, name, value)


def clients(answer):
    """Each kind, and what it asked for."""
    asked = []

    def take(request):
        asked.append(request)
        return answer(request)

    async def take_async(request):
        return take(request)

    key, patience = "st_1", {"patience_s": 0.0}
    one = slewtrack.Client("http://s", key, **patience, transport=httpx.MockTransport(take))
    other = slewtrack.AsyncClient(
        "http://s", key, **patience, transport=httpx.MockTransport(take_async)
    )
    return one, other, asked


def carried_out(call, client):
    result = call(client)
    return asyncio.run(result) if inspect.iscoroutine(result) else result


def tried(call, client):
    """Whatever comes of it but ServiceErrors, which are what is promised."""
    with contextlib.suppress(slewtrack.ServiceError):
        carried_out(call, client)


@pytest.mark.parametrize("body", BODIES, ids=str)
def test_any_answer_is_read_or_told_to_be_none(body):
    content = BODIES[body]
    for status in STATUSES if body in ("no members", "a problem", "a deep list") else (200, 422):
        waiting, awaiting, asked = clients(lambda _, s=status: httpx.Response(s, content=content))
        for call in CALLS.values():
            tried(call, waiting)
        for call in PLAN_CALLS.values():
            tried(call, waiting.spacecraft)
        for name in ("plan", "wait", "plans", "windows", "delete"):
            tried(CALLS[name], awaiting)
        for request in asked:
            assert request.url.raw_path.startswith(b"/v1/")
            assert b".." not in request.url.raw_path
            assert b"%" not in request.url.raw_path.partition(b"?")[0]


@pytest.mark.parametrize("odd", ["../../admin?x=", "a\r\nX: y", "..", ".", "", "a/b"])
def test_an_id_is_one_step_of_an_address(odd):
    """Of the caller's, too."""
    waiting, _, asked = clients(lambda _: httpx.Response(404))
    for call in (waiting.get, waiting.table, waiting.delete, waiting.wait, waiting.windows):
        tried(lambda _, call=call: call(odd), waiting)
    assert asked
    for request in asked:
        path = request.url.raw_path.decode()
        assert path.startswith(("/v1/plans/", "/v1/opportunities/"))
        assert "?" not in path.partition("?limit")[0]
        assert "/../" not in path + "/"
        assert "/./" not in path + "/"


def test_pages_without_an_end_come_to_one():
    page = {"windows": [{"target": "a", "rise": "2015-02-27T17:34:00Z", "highest_deg": 1.0,
                         "set": "2015-02-27T17:35:00Z", "session": None}] * 1000}  # fmt: skip
    waiting, _, asked = clients(
        lambda _: httpx.Response(200, json=page | {"next": f"{len(asked)}"})
    )
    with pytest.raises(slewtrack.BadAnswer, match="no end"):
        waiting.windows(ID)
    assert len(asked) == 5


def test_a_damaged_store_is_not_asked_again():
    problem = {"type": "urn:slewtrack:problem:store-damaged", "status": 503, "detail": "restore"}
    asked = []

    def answer(request):
        asked.append(request)
        return httpx.Response(503, json=problem)

    client = slewtrack.Client("http://s", transport=httpx.MockTransport(answer))
    with pytest.raises(slewtrack.Refused, match="restore"):
        client.plans()
    assert len(asked) == 1


HEAD = b"HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n"


class Endless:
    """Answers a request with a head, then this part over and over until nobody listens.

    first: answers one request before it.
    """

    def __init__(
        self, part: bytes, pause_s: float, head: bytes = HEAD + b"\r\n", first: bytes | None = None
    ) -> None:
        self._part, self._pause_s = part, pause_s
        self._heads = (head,) if first is None else (first, head)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            here, _ = self._listener.accept()
            threading.Thread(target=self._answer, args=(here,), daemon=True).start()

    def _answer(self, here: socket.socket) -> None:
        with contextlib.suppress(OSError), here:
            for head in self._heads:
                here.recv(65536)
                here.sendall(head)
            while True:
                here.sendall(self._part)
                time.sleep(self._pause_s)


class Sluggish(Endless):
    """Reads a request little by little, and never answers."""

    def __init__(self) -> None:
        super().__init__(b"", 0.01)

    def _answer(self, here: socket.socket) -> None:
        with contextlib.suppress(OSError), here:
            while here.recv(2**12):
                time.sleep(self._pause_s)


WAITS = ("plan", "plan with progress", "wait", "campaign", "wait_for_campaign", "fly")


@pytest.mark.parametrize("kind", [slewtrack.Client, slewtrack.AsyncClient])
@pytest.mark.parametrize("name", WAITS)
def test_waiting_ends_though_an_answer_does_not(kind, name):
    """Else it would be held by this for ever."""
    client = kind(Endless(b" ", 0.01).url)
    with pytest.raises((slewtrack.NoAnswer, slewtrack.NotFinished)):
        carried_out(CALLS[name], client)


CHUNKED = HEAD + b"Transfer-Encoding: chunked\r\n\r\n"
TRICKLES = {
    "status line": (b"0", b"HTTP/1.1 2"),
    "a header": (b"a", HEAD + b"X-Endless: "),
    "headers": (b"A: b\r\n", HEAD),
    "interim answers": (b"HTTP/1.1 103 Early Hints\r\n\r\n", b""),
    "a chunk's head": (b"0", CHUNKED),
    "chunks": (b"1\r\n \r\n", CHUNKED),
    "trailers": (b"A: b\r\n", CHUNKED + b"0\r\n"),
}


@pytest.mark.parametrize("kind", [slewtrack.Client, slewtrack.AsyncClient])
@pytest.mark.parametrize("trickle", TRICKLES)
def test_waiting_ends_though_what_frames_an_answer_does_not(kind, trickle):
    part, head = TRICKLES[trickle]
    for name in ("plan", "wait"):
        client = kind(Endless(part, 0.01, head).url)
        with pytest.raises((slewtrack.NoAnswer, slewtrack.NotFinished)):
            carried_out(CALLS[name], client)


def test_time_is_kept_on_a_connection_that_served_before(monkeypatch):
    body = json.dumps({"places": []}).encode()
    first = HEAD + b"Content-Length: %d\r\n\r\n%s" % (len(body), body)
    client = slewtrack.Client(Endless(b"a", 0.01, HEAD, first).url, patience_s=0.0)
    assert client.places("a") == []
    monkeypatch.setattr("slewtrack.client.clients.ANSWER_S", 0.3)
    with pytest.raises(slewtrack.NoAnswer):
        client.table(ID)


@pytest.mark.parametrize("kind", [slewtrack.Client, slewtrack.AsyncClient])
def test_sending_ends_though_it_is_read_byte_by_byte(monkeypatch, kind):
    monkeypatch.setattr("slewtrack.client.clients.ANSWER_S", 0.3)
    client = kind(Sluggish().url, patience_s=0.0)
    with pytest.raises(slewtrack.NoAnswer):
        carried_out(lambda one: one.check(b" " * 2**24), client)


@pytest.mark.parametrize("kind", [slewtrack.Client, slewtrack.AsyncClient])
def test_an_answer_that_takes_too_long_is_none(monkeypatch, kind):
    monkeypatch.setattr("slewtrack.client.clients.ANSWER_S", 0.3)
    client = kind(Endless(b" ", 0.01).url, patience_s=0.0)
    with pytest.raises(slewtrack.NoAnswer):
        carried_out(CALLS["table"], client)


@pytest.mark.parametrize("kind", [slewtrack.Client, slewtrack.AsyncClient])
@pytest.mark.parametrize("name", ["table", "export", "wait", "estimate_vertical"])
def test_no_more_is_held_of_an_answer_than_may_be(monkeypatch, kind, name):
    """Neither of a document nor of a line of its events."""
    for bound in ("ANSWER_MAX_BYTES", "LINE_MAX_BYTES"):
        monkeypatch.setattr(asking, bound, 2**20)
    client = kind(Endless(b" " * 2**16, 0.0).url)
    call = (lambda one: one.wait(ID)) if name == "wait" else CALLS[name]
    tracemalloc.start()
    with pytest.raises(slewtrack.BadAnswer, match="1048576 bytes"):
        carried_out(call, client)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 30 * 2**20
