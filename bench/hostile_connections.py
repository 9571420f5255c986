"""Connections that are held, keys that are wrong, a stop in the middle: who still gets in?"""

import json
import signal
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import httpx2 as httpx
from hostile_siege import PATIENCE_S, Siege, Toll

from app.requests.examples.plan import LAS_VEGAS
from app.requests.examples.spacecraft import SPACECRAFT_EXAMPLES

_HOLDERS = 512
_PIPELINED = 20
_HELD_S = 10.0
_WRONG_KEYS = 600


def held_connections(siege: Siege) -> Toll:
    """Clients without a key that ask much, read nothing and stay."""
    toll = Toll()
    pipeline = b"GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n" * _PIPELINED
    holders = []
    try:
        for _ in range(_HOLDERS):
            holder = socket.socket()
            holder.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            holder.settimeout(5.0)
            try:
                holder.connect(("127.0.0.1", siege.port))
                holder.send(pipeline)
            except OSError:
                holder.close()
                continue
            holders.append(holder)
        until_s = time.monotonic() + _HELD_S
        while time.monotonic() < until_s:
            _ask_anew(siege, toll)
    finally:
        for holder in holders:
            holder.close()
    return toll


def _ask_anew(siege: Siege, toll: Toll) -> None:
    """On a connection of its own each time."""
    began_s = time.monotonic()
    try:
        answer = httpx.get(
            f"{siege.address}/v1/plans",
            headers={"Authorization": f"Bearer {siege.secret}"},
            timeout=10.0,
        )
    except httpx.TransportError as error:
        toll.tried += 1
        toll.complain(f"a good key is shut out: {error!r}")
        return
    toll.count(answer, time.monotonic() - began_s)
    toll.require(answer, 200)


def lock_out(siege: Siege) -> Toll:
    """Wrong and missing keys from the address that a good key comes from, too."""
    toll = Toll()
    over = threading.Event()

    def guess() -> None:
        with httpx.Client(base_url=siege.address, timeout=PATIENCE_S) as stranger:
            for number in range(_WRONG_KEYS // 4):
                if over.is_set():
                    return
                key = {"Authorization": f"Bearer slewtrack_{number:012x}_canary"}
                answer = stranger.get("/v1/plans", headers=key if number % 2 else {})
                toll.tried += 1
                toll.require(answer, 401, 429)

    with ThreadPoolExecutor(4) as threads:
        guesses = [threads.submit(guess) for _ in range(4)]
        try:
            while not all(each.done() for each in guesses):
                toll.require(siege.get("/v1/platforms", toll), 200)
        finally:
            over.set()
        for each in guesses:
            each.result()
    for _ in range(20):
        _ask_anew(siege, toll)
    return toll


def stops_in_the_middle(siege: Siege) -> Toll:
    """Everybody who waits is told where it will be, or when to ask again."""
    toll = Toll()
    slow = json.dumps(next(iter(SPACECRAFT_EXAMPLES.values()))[1]).encode()
    plan = json.dumps(LAS_VEGAS | {"name": "canary-body"}).encode()
    asked = [("/v1/spacecraft/plans", slow)] * 6 + [("/v1/plans", plan)] * 6
    headers = {
        "Authorization": f"Bearer {siege.secret}",
        "Prefer": "wait=60",
        "Content-Type": "application/json",
    }

    def ask(path: str, body: bytes) -> httpx.Response | Exception:
        try:
            return httpx.post(siege.address + path, content=body, headers=headers, timeout=60.0)
        except httpx.TransportError as error:
            return error

    with ThreadPoolExecutor(len(asked)) as threads:
        waiting = [threads.submit(ask, *each) for each in asked]
        time.sleep(1.0)
        siege.process.send_signal(signal.SIGTERM)
        for answer in (each.result() for each in waiting):
            toll.tried += 1
            if isinstance(answer, Exception):
                toll.complain(f"cut off: {answer!r}")
                continue
            is_problem = answer.headers["Content-Type"] == "application/problem+json"
            if answer.status_code == 503 and is_problem and "Retry-After" in answer.headers:
                continue
            toll.broken += answer.status_code >= 500
            if not (
                answer.status_code == 201
                or (answer.status_code == 202 and answer.headers["Location"])
            ):
                toll.complain(f"{answer.status_code} {answer.text[:200]}")
            if "X-Request-ID" not in answer.headers:
                toll.complain("an answer without X-Request-ID")
    if siege.process.wait(timeout=60) != -signal.SIGTERM:  # as uvicorn ends when told to
        toll.complain(f"exit code {siege.process.returncode}")
    if "Traceback" in siege.log.read_text():
        toll.complain("a stop that was asked for prints a traceback")
    return toll
