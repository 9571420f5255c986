"""Hostile connections: bytes to send, and the refusal of each."""

import json
import zlib
from dataclasses import dataclass

from app.http.admission.admission import (
    HEAD_BYTES_MAX,
    HEADERS_MAX,
    PATH_BYTES_MAX,
    QUERY_BYTES_MAX,
)
from app.requests.examples import LAS_VEGAS, OPPORTUNITY_EXAMPLES
from app.settings import Settings

MEBIBYTE = 2**20
PLANS = "POST /v1/plans HTTP/1.1"
BODY_MAX = Settings.model_fields["max_body_bytes"].default


@dataclass(frozen=True)
class Hostile:
    """Bytes on the wire; the status of the answer, and what its detail must name."""

    name: str
    sent: bytes
    status: int
    says: str = ""


def head(line: str, *headers: str) -> bytes:
    return "\r\n".join([line, "Host: localhost", *headers, "", ""]).encode("latin-1")


def post(body: bytes, *headers: str, line: str = PLANS) -> bytes:
    told = (f"Content-Length: {len(body)}", "Content-Type: application/json", *headers)
    return head(line, *told) + body


def chunked(*pieces: bytes) -> bytes:
    coding = ("Transfer-Encoding: chunked", "Content-Type: application/json")
    return head(PLANS, *coding) + b"".join(pieces)


def filled(pattern: bytes) -> bytes:
    """As many repetitions as a body may hold."""
    return pattern * (BODY_MAX // len(pattern))


def million_targets() -> bytes:
    query = OPPORTUNITY_EXAMPLES["cities"][1]
    return json.dumps({**query, "targets": [0] * 1_000_000}).encode()


GET = "GET /v1/platforms HTTP/1.1"
PLAN = json.dumps(LAS_VEGAS)
OPPORTUNITIES = "POST /v1/opportunities HTTP/1.1"
BOMB = zlib.compress(bytes(100 * MEBIBYTE), 9)

BODIES = [
    Hostile("declared too long",
        head(PLANS, "Content-Type: application/json", f"Content-Length: {BODY_MAX + 1}"), 413,
        str(BODY_MAX)),
    Hostile("declared absurdly long",
        head(PLANS, "Content-Type: application/json", "Content-Length: " + "9" * 19), 413,
        str(BODY_MAX)),
    Hostile("longer than declared by chunks",
        chunked(*[b"10000\r\n" + b" " * 65536 + b"\r\n"] * (BODY_MAX // 65536 + 1), b"0\r\n\r\n"),
        413, str(BODY_MAX)),
    Hostile("lists in lists", post(b"[" * 100_000), 422, "50 deep"),
    Hostile("objects in objects", post(b'{"a":' * 100_000), 422, "50 deep"),
    Hostile("only brackets", post(filled(b"[")), 422, "500000 values"),
    Hostile("only names", post(filled(b'{"a":')), 422, "500000 values"),
    Hostile("lists beside lists", post(b"[" + filled(b"[],")[:-3] + b"[]]"), 422, "500000 values"),
    Hostile("a million targets", post(million_targets(), line=OPPORTUNITIES), 422, "values"),
    Hostile("a string without an end", post(b'"' + filled(b'\\"')[:-2]), 422, "JSON"),
    Hostile("a number of megabytes", post(filled(b"9")), 422, "JSON"),
    Hostile("NaN", post(PLAN.replace("-115.1728", "NaN").encode()), 422, "finite"),
    Hostile("Infinity", post(PLAN.replace("-115.1728", "1e999").encode()), 422, "finite"),
    Hostile("no UTF-8", post(b'{"name": "\xff\xfe"}'), 422, "UTF-8"),
    Hostile("a null byte", post(b'{"name": "\0"}'), 422, "JSON"),
    Hostile("a lone surrogate", post(rb'{"name": "\ud800"}'), 422, ""),
    Hostile("compressed", post(BOMB, "Content-Encoding: deflate"), 415, "Content-Encoding"),
    Hostile(
        "a multipart body without its parts",
        head(
            "POST /v1/horizon/estimates HTTP/1.1",
            "Content-Type: multipart/form-data; boundary=x",
            "Content-Length: 4",
        )
        + b"abcd",
        422,
        "multipart",
    ),
    Hostile(
        "XML for JSON", post(b"<!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]>"), 422, "JSON"
    ),
]  # fmt: skip
HEADS = [
    Hostile(
        "many headers", head(GET, *[f"X-{k}: y" for k in range(HEADERS_MAX)]), 431, str(HEADERS_MAX)
    ),
    Hostile("a long header", head(GET, "X: " + "y" * 2 * HEAD_BYTES_MAX), 431, str(HEAD_BYTES_MAX)),
    Hostile(
        "a head without end", b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 20_000, 431, str(HEAD_BYTES_MAX)
    ),
    Hostile("a long query", head(f"GET /v1/platforms?a={'b' * QUERY_BYTES_MAX} HTTP/1.1"), 414,
        str(QUERY_BYTES_MAX)),
    Hostile("a long path", head(f"GET /{'b' * PATH_BYTES_MAX} HTTP/1.1"), 414, str(PATH_BYTES_MAX)),
    Hostile("a null byte in the path", head("GET /docs%00.html HTTP/1.1"), 400, "null byte"),
    Hostile("out of the page's folder", head("GET /page-files/../../etc/passwd HTTP/1.1"), 404),
    Hostile("out of it, encoded", head("GET /page-files/%2e%2e/%2e%2e/main.py HTTP/1.1"), 404),
    Hostile("out of it, by backslashes", head("GET /page-files/..%5c..%5cmain.py HTTP/1.1"), 404),
    Hostile("an absolute path", head("GET /page-files//etc/passwd HTTP/1.1"), 404),
    Hostile("a name longer than any file's", head(f"GET /page-files/{'b' * 300} HTTP/1.1"), 404),
    Hostile("no UTF-8 in the path", head("GET /v1/%ff%fe HTTP/1.1"), 404),
    Hostile("another service's address", head("GET http://example.org/ HTTP/1.1"), 404),
    Hostile("another host", b"GET /v1/platforms HTTP/1.1\r\nHost: example.org\r\n\r\n", 421,
        "ALLOWED_HOSTS"),
    Hostile("no host", b"GET /v1/platforms HTTP/1.1\r\n\r\n", 400, ""),
    Hostile("a tunnel", head("CONNECT example.org:443 HTTP/1.1"), 404),
    Hostile("a trace", head("TRACE /v1/platforms HTTP/1.1"), 405),
    Hostile("a method of its own", head("BREW /v1/platforms HTTP/1.1"), 405),
    Hostile("noise", bytes(range(1, 256)) * 10, 400, "RFC 9112"),
    Hostile("TLS", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(500) + b"\r\n\r\n", 400,
        "RFC 9112"),
    Hostile("HTTP/2", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 505, "HTTP/1.1"),
]  # fmt: skip
TWO_WAYS = [
    Hostile("both lengths", chunked(b"0\r\n\r\n").replace(b"Host:", b"Content-Length: 5\r\nHost:"),
        400, "not both"),
    Hostile("two lengths", post(b"[]", "Content-Length: 3"), 400, ""),
    Hostile("a length with a sign", head(PLANS, "Content-Length: +2") + b"[]", 400, ""),
    Hostile("two hosts", head(GET, "Host: example.org"), 400, ""),
    Hostile("an unknown coding", head(PLANS, "Transfer-Encoding: xchunked") + b"0\r\n\r\n", 501,
        "chunked"),
    Hostile("a coding before the last",
        head(PLANS, "Transfer-Encoding: gzip, chunked") + b"0\r\n\r\n", 501, "chunked"),
    Hostile("a space before the colon", head(PLANS, "Content-Length : 2") + b"[]", 400, ""),
    Hostile("a chunk's size that is none", chunked(b"zz\r\n[]\r\n0\r\n\r\n"), 400, "RFC 9112"),
    Hostile("a negative chunk", chunked(b"-1\r\n[]\r\n0\r\n\r\n"), 400, "RFC 9112"),
    Hostile("a chunk's size without end", chunked(b"0" * 100_000), 431, str(HEAD_BYTES_MAX)),
    Hostile("a chunk longer than said", chunked(b"2\r\n[]]]\r\n0\r\n\r\n"), 400, "RFC 9112"),
]  # fmt: skip
CASES = BODIES + HEADS + TWO_WAYS
