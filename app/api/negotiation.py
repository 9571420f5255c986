"""Does the request come in, and accept the answer in, a form this service speaks?"""

from http import HTTPStatus

from fastapi import HTTPException, Request

JSON = "application/json"
_ACCEPTABLE = {JSON, "application/*", "*/*"}


def accepts_json(request: Request) -> None:
    """Refuse with 406 a client that wants something else than JSON."""
    accepted = request.headers.get("accept", "*/*")
    for media_range in accepted.split(","):
        media_type, *parameters = media_range.replace(" ", "").lower().split(";")
        if media_type in _ACCEPTABLE and not _weighs_nothing(parameters):
            return
    raise HTTPException(
        HTTPStatus.NOT_ACCEPTABLE, f"the answer is {JSON}; the Accept header doesn't admit it"
    )


async def json_body(request: Request) -> bytes:
    """The whole body; refused with 415 when it isn't JSON, with 413 when it is too long."""
    media_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if media_type != JSON:
        raise HTTPException(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
            f"send the request with Content-Type: {JSON}, not {media_type[:80] or 'without one'}",
        )
    limit: int = request.app.state.settings.max_body_bytes
    declared = request.headers.get("content-length", "")
    too_long = HTTPException(
        HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"a request may have {limit} bytes at most"
    )
    if declared.isdecimal() and int(declared[:20]) > limit:
        raise too_long
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > limit:
            raise too_long
    return bytes(body)


def _weighs_nothing(parameters: list[str]) -> bool:
    weights = [value[2:] for value in parameters if value.startswith("q=")]
    return bool(weights) and weights[0].rstrip("0") in ("", "0.", ".")
