"""Content negotiation: the forms this service reads and writes."""

from http import HTTPStatus

from fastapi import HTTPException, Request

JSON = "application/json"


async def accepts_json(request: Request) -> None:
    """Refuse with 406 a client that wants something else than JSON."""
    preferred_type(request, (JSON,))


def preferred_type(request: Request, offered: tuple[str, ...]) -> str:
    """The offered media type the Accept header weighs most, the first of equals.

    Raises 406 when it admits none.  Source: RFC 9110, section 12.5.1.
    """
    range_weights = [_media_range(text) for text in request.headers.get("accept", "*/*").split(",")]
    weights = [_weight(media_type, range_weights) for media_type in offered]
    best = max(weights)
    if best <= 0.0:
        raise HTTPException(
            HTTPStatus.NOT_ACCEPTABLE,
            f"the answer is {' or '.join(offered)}, which the Accept header excludes",
        )
    return offered[weights.index(best)]


def is_known_already(request: Request, tag: str) -> bool:
    """Whether If-None-Match names this ETag.  Source: RFC 9110, section 13.1.2."""
    known = [one.strip() for one in request.headers.get("if-none-match", "").split(",")]
    return "*" in known or tag.removeprefix("W/") in [one.removeprefix("W/") for one in known]


def weak_tag(name: str) -> str:
    """Return the ETag of a content, whether its bytes go out packed or not.

    Source: RFC 9110, section 8.8.1: one strong tag must not name two strings of bytes.
    """
    return f'W/"{name}"'


async def json_body(request: Request) -> bytes:
    """The whole body; refused with 415 when it isn't JSON, with 413 when it is too long."""
    media_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if media_type != JSON:
        raise HTTPException(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
            f"send the request with Content-Type: {JSON}, not {media_type[:80] or 'without one'}",
        )
    return await whole_body(request, request.app.state.settings.max_body_bytes)


async def whole_body(request: Request, limit: int, way_out: str = "") -> bytes:
    """The body; refused with 413 before more than `limit` bytes of it are kept."""
    declared = request.headers.get("content-length", "")
    too_long = HTTPException(
        HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"a request may have {limit} bytes at most{way_out}"
    )
    if declared.isdecimal() and int(declared[:20]) > limit:
        raise too_long
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > limit:
            raise too_long
    return bytes(body)


def _media_range(text: str) -> tuple[str, float]:
    """A media range and its weight; what can't be read as a weight counts as 1."""
    media_range, *parameters = text.replace(" ", "").lower().split(";")
    for parameter in parameters:
        if parameter.startswith("q="):
            try:
                return media_range, float(parameter[2:])
            except ValueError:
                break
    return media_range, 1.0


def _weight(media_type: str, range_weights: list[tuple[str, float]]) -> float:
    """That of the most specific range which admits the type; 0 when none does."""
    for admitting in (media_type, media_type.split("/")[0] + "/*", "*/*"):
        for media_range, weight in range_weights:
            if media_range == admitting:
                return weight
    return 0.0
