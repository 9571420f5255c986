"""Each limit is kept, for each caller apart, and the refusal states it."""

import asyncio
import json
import threading
from datetime import UTC, datetime

import pytest
from databases import own_settings
from fastapi.testclient import TestClient
from starlette.exceptions import HTTPException

from app.http.admission.access import LIST_AGE_MAX_S, Access, Caller, KeyLookup
from app.http.admission.admission import Admission
from app.http.admission.limits import CALLERS_KEPT, ConcurrencyLimit, RateLimit, network_of
from app.http.app import create_app
from app.http.metrics import Metrics
from app.requests.json_reader import DEPTH_MAX, VALUES_MAX, beyond_bounds
from app.requests.plan import read_plan_request
from app.settings import Settings
from app.store.api_keys import Key, digest, new_secret
from app.store.keys import KeyStore
from planner.base.errors import InvalidRequest

SOME_KEY = Key(id="1", name="", secret_sha256="", scopes=("read",), created_utc=datetime.now(UTC))


class Clock:
    def __init__(self) -> None:
        self.now_s = 1000.0

    def __call__(self) -> float:
        return self.now_s


def refusal(limit: RateLimit, caller: str, per_minute: int) -> HTTPException:
    with pytest.raises(HTTPException) as caught:
        limit.charge(caller, per_minute)
    assert caught.value.status_code == 429
    return caught.value


def test_a_minutes_worth_may_come_at_once_and_comes_back_in_a_minute():
    clock = Clock()
    limit = RateLimit(clock_s=clock)
    for _ in range(30):
        limit.charge("a", 30)
    assert refusal(limit, "a", 30).headers == {"Retry-After": "2"}
    limit.charge("b", 30)  # another caller's own
    clock.now_s += 2.0
    limit.charge("a", 30)
    refusal(limit, "a", 30)
    clock.now_s += 60.0
    for _ in range(30):
        limit.charge("a", 30)
    assert "30 requests a minute" in refusal(limit, "a", 30).detail


def test_callers_without_number_take_no_memory_without_limit():
    limit = RateLimit(clock_s=Clock())
    limit.charge("first", 1)
    for number in range(CALLERS_KEPT):
        limit.charge(f"caller {number}", 1)
    limit.charge("first", 1)  # forgotten: the price of a bound


def test_places_are_given_back():
    limit = ConcurrencyLimit()
    with (
        limit.one_more("a", 1),
        limit.one_more("b", 1),
        pytest.raises(HTTPException, match="1 requests at a time"),
        limit.one_more("a", 1),
    ):
        raise AssertionError("a second place was given")
    with limit.one_more("a", 1):
        pass


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("2001:db8::1", "2001:db8::ffff:1", True),
        ("2001:db8::1", "2001:db8:0:1::1", False),
        ("192.0.2.1", "192.0.2.2", False),
        ("::ffff:192.0.2.1", "::ffff:192.0.2.2", False),
    ],
)
def test_whom_an_address_belongs_to(one, other, same):
    assert (network_of(one) == network_of(other)) is same


def test_requests_a_minute_over_http(tmp_path):
    with TestClient(create_app(own_settings(tmp_path, rate_per_minute=3))) as client:
        for _ in range(3):
            assert client.get("/v1/platforms").status_code == 200
        answer = client.get("/v1/platforms")
        assert answer.status_code == 429
        assert 1 <= int(answer.headers["retry-after"]) <= 20
        assert client.get("/healthz").status_code == 200


def test_a_key_may_have_limits_of_its_own(tmp_path):
    app = create_app(own_settings(tmp_path))
    with TestClient(app) as client:
        _, secret = KeyStore(app.state.database).create("slow", ["read"], rate_per_minute=1)
        headers = {"Authorization": f"Bearer {secret}"}
        assert client.get("/v1/platforms", headers=headers).status_code == 200
        assert client.get("/v1/platforms", headers=headers).status_code == 429
        assert client.get("/v1/platforms").status_code == 200


def bearer(secret: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {secret}"}


@pytest.mark.parametrize(
    "failing",
    [{}, bearer("slewtrack_000000000000_wrong"), {"Authorization": "Basic eDp5"}],
    ids=["no key", "a wrong key", "no bearer"],
)
def test_failures_shut_out_those_who_fail_and_nobody_else(tmp_path, failing):
    app = create_app(own_settings(tmp_path, require_keys=True, failures_per_minute=5))
    with TestClient(app) as client:
        good_id, secret = _made(app)
        for _ in range(5):
            assert client.get("/v1/platforms", headers=failing).status_code == 401
        answer = client.get("/v1/platforms", headers=failing)
        assert answer.status_code == 429
        assert "5 requests a minute from one address may come without a good key" in answer.text
        assert 1 <= int(answer.headers["retry-after"]) <= 12
        assert answer.headers["connection"] == "close"
        assert client.get("/v1/platforms", headers=bearer(secret)).status_code == 200
        KeyStore(app.state.database).revoke(good_id)
        assert client.get("/v1/platforms", headers=bearer(secret)).status_code == 429
        elsewhere = TestClient(app, client=("192.0.2.9", 1))
        assert elsewhere.get("/v1/platforms", headers=failing).status_code == 401


def test_who_needs_no_key_is_not_shut_out_by_wrong_ones(tmp_path):
    with TestClient(create_app(own_settings(tmp_path, failures_per_minute=1))) as client:
        for status in (401, 429):
            assert client.get("/v1/platforms", headers=bearer("x")).status_code == status
        assert client.get("/v1/platforms").status_code == 200


def test_wrong_keys_cost_no_more_than_their_share_of_look_ups():
    """Beyond it the database is asked once a second, and a good key is found all the same."""
    secret, looked, good, clock = new_secret()[1], [], set(), Clock()
    key = SOME_KEY

    async def find_key(sought: str) -> Key | None:
        looked.append(sought)
        return key if digest(sought) in good else None

    async def list_digests() -> frozenset[str]:
        looked.append("all")
        return frozenset(good)

    ring = KeyLookup(find_key, list_digests, clock)
    access = Access(ring, require_keys=True, hosts=(), failures_per_minute=5, clock_s=clock)

    async def asked(sought: str) -> int:
        scope = {"type": "http", "method": "GET", "path": "/v1/platforms"}
        scope["headers"] = [(b"authorization", b"Bearer " + sought.encode())]
        try:
            await access.caller(scope, "192.0.2.1")
        except HTTPException as refusal:
            return refusal.status_code
        return 200

    async def attack() -> None:
        wrong = await asyncio.gather(*(asked(f"slewtrack_0_{number}") for number in range(1000)))
        assert wrong == [401] * 5 + [429] * 995
        assert len(looked) == 5 + 1
        good.add(digest(secret))
        assert await asked(secret) == 429  # made within the second
        clock.now_s += LIST_AGE_MAX_S
        assert await asked(secret) == 200
        assert looked[-2:] == ["all", secret]

    asyncio.run(attack())


def _made(app) -> tuple[str, str]:
    key, secret = KeyStore(app.state.database).create("good", ["read"])
    return key.id, secret


def test_requests_at_a_time(tmp_path, monkeypatch):
    entered, leave = threading.Event(), threading.Event()

    def waiting(_metrics):
        entered.set()
        assert leave.wait(timeout=60)
        return b""

    monkeypatch.setattr(Metrics, "text", waiting)
    app = create_app(own_settings(tmp_path, concurrency_per_key=1))
    with TestClient(app) as client:
        first = threading.Thread(target=client.get, args=("/metrics",))
        first.start()
        assert entered.wait(timeout=60)
        answer = client.get("/v1/platforms")
        assert client.get("/healthz").status_code == 200
        leave.set()
        first.join()
        assert answer.status_code == 429
        assert "1 requests at a time" in answer.json()["detail"]
        assert client.get("/v1/platforms").status_code == 200


def test_event_streams_keep_no_request_out():
    """Of the same address, which programs of one machine share; nor a request a stream."""
    leave = asyncio.Event()

    async def service(scope, _receive, send):
        await leave.wait()
        await send({"type": "http.response.start", "status": 200, "headers": []})

    def asked(path):
        return {
            "type": "http", "http_version": "1.1", "method": "GET", "path": path,
            "raw_path": path.encode(), "query_string": b"", "headers": [],
            "state": {"request_id": "1"},
        }  # fmt: skip

    async def statuses_of(gate, path, count):
        told = []

        async def send(message):
            if message["type"] == "http.response.start":
                told.append(message["status"])

        asking = [asyncio.create_task(gate(asked(path), None, send)) for _ in range(count)]
        for _ in range(10 * count):
            await asyncio.sleep(0)
        return told, asking

    async def streams_then_requests():
        settings = Settings(concurrency_per_key=4)
        gate = Admission(service, AccessWithOneKey(), settings, asyncio.Event())
        streams, listening = await statuses_of(gate, "/v1/plans/1/events", 6)
        assert streams == [429] * 4  # 2 are open
        requests, asking = await statuses_of(gate, "/v1/plans", 5)
        assert requests == [429]  # 4 are at work
        leave.set()
        await asyncio.gather(*listening, *asking)
        assert sorted(streams) == [200] * 2 + [429] * 4
        assert sorted(requests) == [200] * 4 + [429]

    asyncio.run(streams_then_requests())


class AccessWithOneKey:
    """Whoever sends any has the key."""

    async def caller(self, scope, _address):
        has_key = any(name == b"authorization" for name, _ in scope["headers"])
        key = SOME_KEY if has_key else None
        return Caller(name="someone", key=key)


def test_a_crowd_without_keys_lets_who_has_one_go_first():
    begun = []

    async def service(scope, _receive, _send):
        begun.append(scope["state"]["key_id"])

    def asked(*headers):
        return {
            "type": "http", "http_version": "1.1", "method": "GET", "path": "/docs",
            "raw_path": b"/docs", "query_string": b"", "headers": list(headers), "state": {},
        }  # fmt: skip

    async def all_at_once():
        settings = Settings(concurrency_per_key=1000)
        gate = Admission(service, AccessWithOneKey(), settings, asyncio.Event())
        crowd = [gate(asked(), None, None) for _ in range(100)]
        known = gate(asked((b"authorization", b"Bearer x")), None, None)
        await asyncio.gather(*crowd, known)

    asyncio.run(all_at_once())
    assert len(begun) == 101
    assert begun.index(SOME_KEY.id) < 3


def test_all_bodies_together(tmp_path):
    with TestClient(create_app(own_settings(tmp_path, max_held_bytes=1000))) as client:
        for _ in range(2):  # the first one's room is given back
            answer = client.post("/v1/plans", json={"name": "x" * 500})
            assert answer.status_code == 422
        answer = client.post("/v1/plans", json={"name": "x" * 1000})
        assert answer.status_code == 503
        assert "1000 bytes together" in answer.json()["detail"]
        assert answer.headers["retry-after"]


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ([0] * (VALUES_MAX - 1), None),
        ([0] * (VALUES_MAX + 1), f"{VALUES_MAX} values"),
        ([["[,{" * 1000] * 1000], None),
        (['\\"[[,,'] * 1000, None),
        ({"a": "\\"}, None),
    ],
    ids=["many", "too many", "marks inside strings", "escapes", "an escaped escape"],
)
def test_values_are_counted_outside_strings(document, says):
    found = beyond_bounds(json.dumps(document).encode())
    assert (found is None) if says is None else (says in found)


@pytest.mark.parametrize(
    ("most", "more", "says"),
    [
        (dict.fromkeys(map(str, range(1000))), {"x": 0}, "1001 fields, more than 1000"),
        ({"x": [{}] * 49_999}, {"y": {}}, "more than 50000 objects"),
        ({"x": int("1" * 80)}, {"y": int("1" * 81)}, "81 digits, more than 80"),
    ],
    ids=["fields", "objects", "digits"],
)
def test_what_one_request_may_hold(most, more, says):
    for document, is_too_much in ((most, False), (most | more, True)):
        with pytest.raises(InvalidRequest) as refusal:  # no plan either way
            read_plan_request(json.dumps(document).encode())
        assert (says in str(refusal.value)) is is_too_much


@pytest.mark.parametrize(("deep", "refused"), [(DEPTH_MAX, False), (DEPTH_MAX + 1, True)])
def test_depth(deep, refused):
    assert (beyond_bounds(b"[" * deep + b"]" * deep) is not None) is refused
    assert beyond_bounds(b"[" + b"[]," * 1000 + b"[]]") is None
