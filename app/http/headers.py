"""Headers of every answer: its request's id, and what keeps a browser from more than showing it.

The id stands in the log and in a problem's `instance`, too.
"""

import re
import uuid
from collections.abc import Mapping
from typing import Any

from starlette.datastructures import MutableHeaders

REQUEST_ID = "X-Request-ID"
# What is safe in a log line, a header and a URN.
_SANE = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
_STATE = "request_id"

# An answer of the API is data: nothing in it may run, load or be framed.
API_CONTENT_POLICY = "default-src 'none'; frame-ancestors 'none'; base-uri 'none'"
# The pages run their own vendored scripts and ask this service only.  Both bring their styles
# by script, hence 'unsafe-inline' for styles; ReDoc searches in a worker it makes of a blob.
PAGE_CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self'; worker-src blob:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
# The planner's page: Cesium compiles WebAssembly and starts workers from blobs.
PLANNERS_PAGE_CONTENT_POLICY = (
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; "
    "img-src 'self' data: blob:; style-src 'self'; object-src 'none'; "
    "frame-ancestors 'none'; base-uri 'self'; form-action 'none'"
)

_ALWAYS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}
_UNLESS_SET = {"Content-Security-Policy": API_CONTENT_POLICY, "Cache-Control": "no-store"}


def harden(headers: MutableHeaders) -> None:
    """Add what every answer carries; a policy an answer brings itself stays."""
    for name, value in _ALWAYS.items():
        headers[name] = value
    for name, value in _UNLESS_SET.items():
        headers.setdefault(name, value)


def request_id_of(header: str | None) -> str:
    """The client's own id where it is sane, else a new UUID."""
    return header if header is not None and _SANE.fullmatch(header) else str(uuid.uuid4())


def remember_request_id(scope: Mapping[str, Any], request_id: str) -> None:
    scope["state"][_STATE] = request_id


def instance(scope: Mapping[str, Any]) -> str:
    """The URN of the request's id, for a problem's `instance`."""
    request_id: str = scope["state"][_STATE]
    try:
        return uuid.UUID(request_id).urn
    except ValueError:
        return f"urn:slewtrack:request:{request_id}"
