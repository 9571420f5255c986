"""The pages that document the API, without a network and under a strict content policy."""

import json
from functools import lru_cache
from pathlib import Path

import anyio.to_thread
from fastapi import APIRouter, FastAPI, Request, Response
from starlette.staticfiles import StaticFiles

from app.http import planners_page
from app.http.admission.access import BUILT_FILES, PAGE_FILES
from app.http.headers import PAGE_CONTENT_POLICY
from app.http.negotiation import JSON

router = APIRouter(include_in_schema=False)

_OURS = Path(__file__).parent / "static"
# Swagger UI and ReDoc, which `make web` puts among the planner's page's files.
_PUBLISHED = f"{BUILT_FILES.lstrip('/')}documentation/"
# Addresses are relative, so that the pages also work under a proxy's path.
_PAGE = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>slewtrack: the API</title>
<link rel="icon" href="{published}icon.svg" type="image/svg+xml">
{style}<link rel="stylesheet" href="page-files/pages.css">
</head>
<body>
<div id="page"></div>
<script src="{published}{script}"></script>
<script src="page-files/{start}"></script>
</body>
</html>
"""


def serve_files(app: FastAPI) -> None:
    """What the pages load beside Swagger UI and ReDoc."""
    app.mount(PAGE_FILES.rstrip("/"), StaticFiles(directory=_OURS), name="page-files")


@router.get("/openapi.json")
async def get_openapi(request: Request) -> Response:
    """For programs."""
    # Half a second the first time, in which others are answered.
    document = await anyio.to_thread.run_sync(_openapi_json, request.app)
    return Response(document, media_type=JSON)


@lru_cache(maxsize=1)
def _openapi_json(app: FastAPI) -> bytes:
    return json.dumps(app.openapi(), ensure_ascii=False, separators=(",", ":")).encode()


@router.get("/docs")
async def get_docs() -> Response:
    """To read and try out."""
    style = f'<link rel="stylesheet" href="{_PUBLISHED}swagger-ui.css">\n'
    return _page("swagger-ui-bundle.js", "docs.js", style)


@router.get("/redoc")
async def get_redoc() -> Response:
    """To read and print."""
    return _page("redoc.standalone.js", "redoc.js")


def _page(script: str, start: str, style: str = "") -> Response:
    if not planners_page.is_built():
        return planners_page.not_built()
    html = _PAGE.format(published=_PUBLISHED, script=script, start=start, style=style)
    headers = {"Content-Security-Policy": PAGE_CONTENT_POLICY, "Cache-Control": "no-cache"}
    return Response(html, headers=headers, media_type="text/html")
