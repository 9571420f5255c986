"""Reads multipart bodies: the parts that a route names, each so many times and so long."""

import sys
from collections.abc import AsyncGenerator, Sequence
from typing import NamedTuple

from fastapi import Request
from starlette.datastructures import UploadFile
from starlette.formparsers import MultiPartException, MultiPartParser

from planner.base.errors import FieldError, InvalidRequest

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
    """The refusal of a part."""
    return InvalidRequest(FieldError(field=field, detail=detail))
