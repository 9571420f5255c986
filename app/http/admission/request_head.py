"""Refuses a request whose head has a shape we never answer, before anyone reads on."""

from collections import Counter
from http import HTTPStatus

from starlette.exceptions import HTTPException
from starlette.types import Scope

HEADERS_MAX = 100
HEAD_BYTES_MAX = 32 * 1024
QUERY_BYTES_MAX = 8192
PATH_BYTES_MAX = 2048
_ONCE = (b"authorization", b"content-length", b"content-type", b"host", b"transfer-encoding")


def require_valid_head(scope: Scope) -> None:
    """Raise 400, 414, 415, 431 or 505, each with the cap."""
    if not scope["http_version"].startswith("1."):
        raise HTTPException(HTTPStatus.HTTP_VERSION_NOT_SUPPORTED, "HTTP/1.1 is spoken here")
    headers: list[tuple[bytes, bytes]] = scope["headers"]
    if len(headers) > HEADERS_MAX:
        raise HTTPException(
            HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE,
            f"a request may have {HEADERS_MAX} header fields; send fewer",
        )
    if sum(len(name) + len(value) for name, value in headers) > HEAD_BYTES_MAX:
        raise HTTPException(
            HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE,
            f"the header fields of a request may have {HEAD_BYTES_MAX} bytes",
        )
    for part, most in ((_path(scope), PATH_BYTES_MAX), (scope["query_string"], QUERY_BYTES_MAX)):
        if len(part) > most:
            raise HTTPException(
                HTTPStatus.REQUEST_URI_TOO_LONG,
                f"an address may have {PATH_BYTES_MAX} bytes of path and {QUERY_BYTES_MAX} of "
                "query; send large things in the body",
            )
    if "\0" in scope["path"]:
        raise _bad("the address holds a null byte; remove %00")
    _require_one_meaning(headers)


def _path(scope: Scope) -> bytes:
    raw: bytes | None = scope.get("raw_path")
    return raw or scope["path"].encode()


def _require_one_meaning(headers: list[tuple[bytes, bytes]]) -> None:
    """Two readers of one connection, a proxy and we, must see the same requests in it."""
    times = Counter(name for name, _ in headers)
    for name in _ONCE:
        if times[name] > 1:
            raise _bad(f"the header {name.decode()} is given {times[name]} times; send it once")
    if times[b"content-length"] and times[b"transfer-encoding"]:
        raise _bad("send Content-Length or Transfer-Encoding, not both")
    coding = dict(headers).get(b"content-encoding", b"identity").strip().lower()
    if coding not in (b"identity", b""):
        raise HTTPException(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
            "compressed requests are not read; send the body without Content-Encoding",
            {"Accept-Encoding": "identity"},  # RFC 9110, section 12.5.3
        )


def _bad(detail: str) -> HTTPException:
    # Where the request ends is in doubt: nothing more is read from this connection.
    return HTTPException(HTTPStatus.BAD_REQUEST, detail, {"Connection": "close"})
