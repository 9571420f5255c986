"""Headers that keep a browser from doing more with our answers than show them."""

from starlette.datastructures import MutableHeaders

# An answer of the API is data: nothing in it may run, load or be framed.
API_CONTENT_POLICY = "default-src 'none'; frame-ancestors 'none'; base-uri 'none'"
# The pages run their own vendored scripts and ask this service only.  Both bring their styles
# by script, hence 'unsafe-inline' for styles; ReDoc searches in a worker it makes of a blob.
PAGE_CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; font-src 'self' data:; connect-src 'self'; worker-src blob:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
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
