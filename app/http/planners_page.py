"""The planner's page at `/`: files that `make web` builds from web/, the same for everyone."""

import hashlib
import json
import re
from http import HTTPStatus
from pathlib import Path

from fastapi import FastAPI, HTTPException, Request, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from app.http.admission.access import BUILT_FILES, PAGE_ROOMS
from app.http.headers import PLANNERS_PAGE_CONTENT_POLICY
from app.http.negotiation import JSON, is_known_already, preferred_type, weak_tag

BUILT = Path(__file__).parent / "page"
_HTML = "text/html"
# In the built page; what it loads is named relative to it, so that a proxy's path does no harm.
_BASE = b'<base href="./">'
# Vite names a file after its content: such a one never changes.
_NAMED_AFTER_CONTENT = re.compile(r"-[\w-]{8}\.\w+$", re.ASCII)
_FOR_GOOD = "public, max-age=31536000, immutable"
_ASK_AGAIN = "no-cache"
_HOW_TO_BUILD = (
    "the pages aren't built here: `make web` builds them (a wheel and the image bring them)"
)
_NOT_BUILT = f"""\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>slewtrack</title>
<link rel="stylesheet" href="page-files/pages.css">
</head>
<body>
<h1>slewtrack</h1>
<p>{_HOW_TO_BUILD.replace("`make web`", "<code>make web</code>").capitalize()}.</p>
<p>For programs: <a href="openapi.json">the API's schema</a></p>
</body>
</html>
"""


def serve_page(app: FastAPI) -> None:
    """Its rooms, each of which is the one document, and what that loads."""
    app.mount(BUILT_FILES.rstrip("/"), _Files(directory=BUILT / "assets", check_dir=False))
    app.add_route("/", _root)
    for room in sorted(PAGE_ROOMS):
        app.add_route(f"/{room}", _room)
        app.add_route(f"/{room}/{{rest:path}}", _room)


def _root(request: Request) -> Response:
    if preferred_type(request, (_HTML, JSON)) == JSON:
        told = {"page": "built" if is_built() else _HOW_TO_BUILD}
        told |= {"documentation": "docs", "openapi": "openapi.json"}
        return Response(json.dumps(told), media_type=JSON)
    document = _document(request)
    if document is None:
        return not_built()
    return document


def is_built() -> bool:
    """Whether there is more than the schema to look at."""
    return (BUILT / "index.html").exists()


def not_built() -> Response:
    """Says how to build the pages."""
    return Response(_NOT_BUILT, headers=_page_headers(), media_type=_HTML)


def _room(request: Request) -> Response:
    document = _document(request)
    if document is None:
        raise HTTPException(HTTPStatus.NOT_FOUND, _HOW_TO_BUILD)
    return document


def _document(request: Request) -> Response | None:
    """None where the page isn't built."""
    try:
        built = (BUILT / "index.html").read_bytes()
    except FileNotFoundError:
        return None
    depth = request.url.path.count("/") - 1
    html = built.replace(_BASE, b'<base href="%s">' % (b"../" * depth or b"./"))
    tag = weak_tag(hashlib.sha256(html).hexdigest()[:32])
    headers = {**_page_headers(), "ETag": tag}
    if is_known_already(request, tag):
        return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)
    return Response(html, headers=headers, media_type=_HTML)


def _page_headers() -> dict[str, str]:
    return {"Content-Security-Policy": PLANNERS_PAGE_CONTENT_POLICY, "Cache-Control": _ASK_AGAIN}


class _Files(StaticFiles):
    """A worker's own policy is its file's, so that files carry the page's."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        answer = await super().get_response(path, scope)
        answer.headers.update(_page_headers())
        if _NAMED_AFTER_CONTENT.search(path):
            answer.headers["Cache-Control"] = _FOR_GOOD
        return answer
