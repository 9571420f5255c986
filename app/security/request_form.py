"""Is a request's head of a shape we answer at all, before anyone reads on?"""

from collections import Counter
from http import HTTPStatus

from starlette.exceptions import HTTPException
from starlette.types import Scope

HEADERS_MAX = 100
QUERY_BYTES_MAX = 8192
PATH_BYTES_MAX = 2048
_ONCE = (b"authorization", b"content-length", b"content-type", b"host", b"transfer-encoding")


def require_sound_head(scope: Scope) -> None:
    """Raise 400, 414, 415 or 431, each with the cap."""
    headers: list[tuple[bytes, bytes]] = scope["headers"]
    if len(headers) > HEADERS_MAX:
        raise HTTPException(
            HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE,
            f"a request may have {HEADERS_MAX} header fields, not {len(headers)}",
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
    return HTTPException(HTTPStatus.BAD_REQUEST, detail)
