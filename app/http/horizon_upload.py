"""Reads a request and its images from one multipart body."""

from collections.abc import AsyncGenerator
from dataclasses import dataclass
from http import HTTPStatus

from fastapi import HTTPException, Request
from starlette.datastructures import FormData
from starlette.formparsers import MultiPartException, MultiPartParser

from app.http.negotiation import whole_body
from estimator.request import MAX_CAMERAS
from planner.base.errors import FieldError, InvalidRequest

MULTIPART = "multipart/form-data"
MAX_REQUEST_BYTES = 2**20
_CHUNK_BYTES = 2**18


@dataclass(frozen=True, kw_only=True)
class HorizonUpload:
    """The part `request` and the parts `images` as they were sent."""

    request: bytes
    images: tuple[bytes, ...]


async def horizon_upload(request: Request) -> HorizonUpload:
    """The parts of a multipart body; refused when others are missing, too many or too long."""
    media_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if media_type != MULTIPART:
        raise HTTPException(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
            f"send {MULTIPART}: the part `request` holds JSON, parts `images` one file per "
            f"camera; not {media_type[:80] or 'without a Content-Type'}",
        )
    body = await whole_body(request, request.app.state.settings.max_upload_bytes)

    async def stream() -> AsyncGenerator[bytes, None]:
        for first in range(0, len(body), _CHUNK_BYTES):  # others get their turn in between
            yield body[first : first + _CHUNK_BYTES]

    parser = MultiPartParser(
        request.headers,
        stream(),
        max_files=MAX_CAMERAS + 1,  # clients may send the request as a file, too
        max_fields=1,
        max_part_size=MAX_REQUEST_BYTES,
    )
    try:
        form = await parser.parse()
    except MultiPartException as error:
        raise _unreadable("", f"the multipart body can't be read: {error.message}") from None
    try:
        return await _upload(form)
    finally:
        await form.close()


async def _upload(form: FormData) -> HorizonUpload:
    found: dict[str, list[bytes]] = {"request": [], "images": []}
    for name, part in form.multi_items():
        if name not in found:
            raise _unreadable(name[:80], "is no part of this request; send request and images")
        if isinstance(part, str):
            found[name].append(part.encode())
        else:
            found[name].append(await part.read())
    if len(found["request"]) != 1:
        raise _unreadable("request", f"is needed once, not {len(found['request'])} times")
    if not found["images"]:
        raise _unreadable("images", "are needed, one part per camera in the cameras' order")
    [request] = found["request"]
    if len(request) > MAX_REQUEST_BYTES:
        raise _unreadable("request", f"may have {MAX_REQUEST_BYTES} bytes at most")
    return HorizonUpload(request=request, images=tuple(found["images"]))


def _unreadable(field: str, detail: str) -> InvalidRequest:
    return InvalidRequest(FieldError(field=field, detail=detail))
