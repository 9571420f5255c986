"""The id of a request in the log, in the answer's header and in a problem's `instance`."""

import re
import uuid
from collections.abc import Mapping
from typing import Any

HEADER = "X-Request-ID"
# What is safe in a log line, a header and a URN.
_SANE = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
_STATE = "request_id"


def given_or_new(sent: str | None) -> str:
    """The client's own id where it is sane, else a new UUID."""
    return sent if sent is not None and _SANE.fullmatch(sent) else str(uuid.uuid4())


def remember(scope: Mapping[str, Any], request_id: str) -> None:
    """Where `instance` finds it."""
    scope["state"][_STATE] = request_id


def instance(scope: Mapping[str, Any]) -> str:
    """The URN of the request's id, for a problem's `instance`."""
    request_id: str = scope["state"][_STATE]
    try:
        return uuid.UUID(request_id).urn
    except ValueError:
        return f"urn:slewtrack:request:{request_id}"
