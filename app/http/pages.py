"""The planner's page, which `make web` builds from web/, and the pages that document the API.

The same for everyone, without a network and under a strict content policy.
"""

import hashlib
import json
import re
from functools import lru_cache
from http import HTTPStatus
from pathlib import Path

import anyio.to_thread
from fastapi import APIRouter, FastAPI, HTTPException, Request, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from app.http.admission.access import BUILT_FILES, PAGE_FILES, PAGE_ROOMS
from app.http.headers import PAGE_CONTENT_POLICY, PLANNERS_PAGE_CONTENT_POLICY
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
# Addresses are relative, so that the pages also work under a proxy's path.
_PAGE = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
{head}<link rel="stylesheet" href="page-files/pages.css">
</head>
<body>
{body}
</body>
</html>
"""
_NOT_BUILT = _PAGE.format(
    title="slewtrack",
    head="",
    body=f"""\
<h1>slewtrack</h1>
<p>{_HOW_TO_BUILD.replace("`make web`", "<code>make web</code>").capitalize()}.</p>
<p>For programs: <a href="openapi.json">the API's schema</a></p>""",
)
_DOCUMENTATION = """\
<div id="page"></div>
<script src="{published}{script}"></script>
<script src="page-files/{start}"></script>"""


def serve(app: FastAPI) -> None:
    """The API's pages, the planner's rooms, each the one document, and what both load."""
    app.include_router(router)
    app.mount(PAGE_FILES.rstrip("/"), StaticFiles(directory=_OURS), name="page-files")
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
    return (BUILT / "index.html").exists()


def not_built() -> Response:
    return Response(_NOT_BUILT, headers=_page_headers(), media_type=_HTML)


def _room(request: Request) -> Response:
    document = _document(request)
    if document is None:
        raise HTTPException(HTTPStatus.NOT_FOUND, _HOW_TO_BUILD)
    return document


def _document(request: Request) -> Response | None:
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


router = APIRouter(include_in_schema=False)

_OURS = Path(__file__).parent / "static"
# Swagger UI and ReDoc, which `make web` puts among the planner's page's files.
_PUBLISHED = f"{BUILT_FILES.lstrip('/')}documentation/"


@router.get("/openapi.json")
async def get_openapi(request: Request) -> Response:
    # Half a second the first time, in which others are answered.
    document = await anyio.to_thread.run_sync(_openapi_json, request.app)
    return Response(document, media_type=JSON)


@lru_cache(maxsize=1)
def _openapi_json(app: FastAPI) -> bytes:
    return json.dumps(app.openapi(), ensure_ascii=False, separators=(",", ":")).encode()


@router.get("/docs")
async def get_docs() -> Response:
    style = f'<link rel="stylesheet" href="{_PUBLISHED}swagger-ui.css">\n'
    return _page("swagger-ui-bundle.js", "docs.js", style)


@router.get("/redoc")
async def get_redoc() -> Response:
    return _page("redoc.standalone.js", "redoc.js")


def _page(script: str, start: str, style: str = "") -> Response:
    if not is_built():
        return not_built()
    icon = f'<link rel="icon" href="{_PUBLISHED}icon.svg" type="image/svg+xml">\n'
    body = _DOCUMENTATION.format(published=_PUBLISHED, script=script, start=start)
    html = _PAGE.format(title="slewtrack: the API", head=icon + style, body=body)
    headers = {"Content-Security-Policy": PAGE_CONTENT_POLICY, "Cache-Control": "no-cache"}
    return Response(html, headers=headers, media_type="text/html")
