"""Content negotiation: the media types this service reads and writes, their bodies, and ETags."""

import re
import sys
from collections.abc import AsyncGenerator, Mapping, Sequence
from http import HTTPStatus
from typing import Any, NamedTuple

from fastapi import Depends, HTTPException, Request
from starlette.datastructures import UploadFile
from starlette.formparsers import MultiPartException, MultiPartParser

from planner.base.errors import FieldError, InvalidRequest

JSON = "application/json"
MULTIPART = "multipart/form-data"
EVENT_STREAM = "text/event-stream"
_NAME_MAX = 60


def answers(*media_types: str) -> tuple[Any]:
    """Dependencies of a route: it refuses with 406 a client that wants something else."""

    async def accepted(request: Request) -> None:
        preferred_type(request, media_types)

    return (Depends(accepted),)


ONLY_JSON = answers(JSON)


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


def format_of(request: Request, media_type_by_format: Mapping[str, str]) -> str:
    """The format that the Accept header asks for; raises 406."""
    wanted = preferred_type(request, tuple(media_type_by_format.values()))
    return next(name for name, media in media_type_by_format.items() if media == wanted)


def is_known_already(request: Request, tag: str) -> bool:
    """Whether If-None-Match names this ETag.  Source: RFC 9110, section 13.1.2."""
    known = [one.strip() for one in request.headers.get("if-none-match", "").split(",")]
    return "*" in known or tag.removeprefix("W/") in [one.removeprefix("W/") for one in known]


def weak_tag(name: str) -> str:
    """Return the ETag of a content, whether its bytes go out packed or not.

    Source: RFC 9110, section 8.8.1: one strong tag must not name two strings of bytes.
    """
    return f'W/"{name}"'


def revalidated(request: Request, tag: str) -> dict[str, str]:
    """Headers of an answer to keep by a client that asks each time whether it still holds.

    Raises 304 where the client has it.
    """
    headers = {"Cache-Control": "private, no-cache", "Vary": "Accept", "ETag": tag}
    if is_known_already(request, tag):
        raise HTTPException(HTTPStatus.NOT_MODIFIED, headers=headers)
    return headers


def saved_as(name: str, otherwise: str, suffix: str, shown_as: str | None = None) -> dict[str, str]:
    """The header of a file to save, named in letters, digits and hyphens after what it is of.

    shown_as: its media type, where a browser may show it: pictures are.
    """
    words = re.findall(r"[A-Za-z0-9]+", name)
    file = ("-".join(words)[:_NAME_MAX] or otherwise) + suffix
    how = "inline" if shown_as is not None and shown_as.startswith("image/") else "attachment"
    return {"Content-Disposition": f'{how}; filename="{file}"'}


def media_type_of(request: Request) -> str:
    return request.headers.get("content-type", "").split(";")[0].strip().lower()


def unsupported(request: Request, way_out: str) -> HTTPException:
    """The 415 of a body of another media type; way_out: what to send."""
    given = media_type_of(request)[:80] or "without a Content-Type"
    return HTTPException(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"send {way_out}, not {given}")


async def json_body(request: Request) -> bytes:
    """The whole body; refused with 415 when it isn't JSON, with 413 when it is too long."""
    if media_type_of(request) != JSON:
        raise unsupported(request, f"the request with Content-Type: {JSON}")
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


MAX_REQUEST_BYTES = 2**20  # of the part `request`, which others may accompany
_CHUNK_BYTES = 2**18


class FormPart(NamedTuple):
    """A part that a body may have, as a field or a file: at most so often, and of so many bytes.

    otherwise: what is refused with where it is missing; empty where it may be.
    """

    name: str
    otherwise: str = ""
    most: int = 1
    most_bytes: int = sys.maxsize  # but for the whole body


async def read_parts(
    request: Request, body: bytes, parts: Sequence[FormPart]
) -> dict[str, list[bytes]]:
    """The contents of each part in order; raises InvalidRequest where it has others."""

    async def stream() -> AsyncGenerator[bytes, None]:
        for first in range(0, len(body), _CHUNK_BYTES):  # others get their turn in between
            yield body[first : first + _CHUNK_BYTES]

    most = sum(part.most for part in parts)
    parser = MultiPartParser(
        request.headers, stream(), max_files=most, max_fields=most, max_part_size=len(body) + 1
    )
    try:
        form = await parser.parse()
    except MultiPartException as error:
        raise unreadable("", f"the multipart body can't be read: {error.message}") from None
    found: dict[str, list[bytes]] = {part.name: [] for part in parts}
    try:
        for name, content in form.multi_items():
            if name not in found:
                names = ", ".join(found)
                raise unreadable(name[:80], f"is no part of this request; its parts are {names}")
            found[name].append(
                await content.read() if isinstance(content, UploadFile) else content.encode()
            )
    finally:
        await form.close()
    for part in parts:
        if part.otherwise and not found[part.name]:
            raise unreadable(part.name, part.otherwise)
        if len(found[part.name]) > part.most:
            raise unreadable(part.name, f"may be sent {part.most} times at most")
        if any(len(content) > part.most_bytes for content in found[part.name]):
            raise unreadable(part.name, f"may have {part.most_bytes} bytes at most")
    return found


def unreadable(field: str, detail: str) -> InvalidRequest:
    return InvalidRequest(FieldError(field=field, detail=detail))
