"""Reads telemetry from a body: JSON with its columns, or a CSV file and its request as parts."""

import json
from collections.abc import AsyncGenerator
from http import HTTPStatus

from fastapi import HTTPException, Request
from starlette.datastructures import FormData, UploadFile
from starlette.formparsers import MultiPartException, MultiPartParser

from app.http.horizon_upload import MAX_REQUEST_BYTES, MULTIPART
from app.http.negotiation import JSON, whole_body
from app.requests.telemetry import read_comparison_head, read_comparison_request
from app.work.telemetry import SentTelemetry
from planner.base.errors import FieldError, InvalidRequest

_CHUNK_BYTES = 2**18
_FIELDS = ("request", "plan", "epoch")  # a form may give plan and epoch without writing JSON


async def telemetry_body(request: Request) -> tuple[str, bytes]:
    """The media type and the whole body; refused with 415 and 413."""
    media_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    settings = request.app.state.settings
    if media_type == JSON:
        return media_type, await whole_body(
            request,
            settings.max_body_bytes,
            f"; send more samples as CSV by {MULTIPART}, up to {settings.max_upload_bytes} bytes",
        )
    if media_type == MULTIPART:
        return media_type, await whole_body(request, settings.max_upload_bytes)
    raise HTTPException(
        HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
        f"send {JSON} with the samples in it, or {MULTIPART}: the part `request` holds JSON, the "
        f"part `samples` CSV; not {media_type[:80] or 'without a Content-Type'}",
    )


async def sent_telemetry(request: Request, media_type: str, body: bytes) -> SentTelemetry:
    """What was sent; raises InvalidRequest."""
    if media_type == JSON:
        spec, samples = read_comparison_request(body)
        return SentTelemetry(request=spec, samples=samples)

    async def stream() -> AsyncGenerator[bytes, None]:
        for first in range(0, len(body), _CHUNK_BYTES):  # others get their turn in between
            yield body[first : first + _CHUNK_BYTES]

    parser = MultiPartParser(
        request.headers, stream(), max_files=2, max_fields=3, max_part_size=len(body) + 1
    )
    try:
        form = await parser.parse()
    except MultiPartException as error:
        raise _unreadable("", f"the multipart body can't be read: {error.message}") from None
    try:
        return await _of_form(form)
    finally:
        await form.close()


async def _of_form(form: FormData) -> SentTelemetry:
    fields: dict[str, bytes] = {}
    file: bytes | None = None
    for name, part in form.multi_items():
        content = await part.read() if isinstance(part, UploadFile) else part.encode()
        if name in _FIELDS:
            if name in fields:
                raise _unreadable(name, "is needed once")
            if len(content) > MAX_REQUEST_BYTES:
                raise _unreadable(name, f"may have {MAX_REQUEST_BYTES} bytes at most")
            fields[name] = content
        elif name == "samples":
            if file is not None:
                raise _unreadable("samples", "is needed once: one CSV file")
            file = content
        else:
            raise _unreadable(
                name[:80],
                "is no part of this request; send samples, and request "
                "(or plan, and epoch where it isn't the plan's)",
            )
    if file is None:
        raise _unreadable("samples", "is needed: a CSV file")
    return SentTelemetry(request=read_comparison_head(_head(fields)), samples=file)


def _head(fields: dict[str, bytes]) -> bytes:
    if "request" in fields:
        if len(fields) > 1:
            raise _unreadable("plan", "goes into the part request where there is one")
        return fields["request"]
    text = {name: content.decode("utf-8", "replace") for name, content in fields.items()}
    if "plan" not in text:
        raise _unreadable("request", "is needed: JSON with the id of the plan")
    head: dict[str, object] = {"plan": text["plan"]}
    if "epoch" in text:
        head["samples"] = {"epoch": text["epoch"]}
    return json.dumps(head).encode()


def _unreadable(field: str, detail: str) -> InvalidRequest:
    return InvalidRequest(FieldError(field=field, detail=detail))
