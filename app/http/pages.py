"""The pages that document the API, without a network and under a strict content policy."""

import json
from functools import lru_cache
from pathlib import Path

import anyio.to_thread
from fastapi import APIRouter, FastAPI, Request, Response
from starlette.staticfiles import StaticFiles

from app.http.door.access import PAGE_FILES
from app.http.door.headers import PAGE_CONTENT_POLICY
from app.http.negotiation import JSON

router = APIRouter(include_in_schema=False)

_OURS = Path(__file__).parent / "static"
# Addresses are relative, so that the pages also work under a proxy's path.
_PAGE = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>slewtrack: the API</title>
<link rel="icon" href="page-files/favicon.png">
{styles}<link rel="stylesheet" href="page-files/pages.css">
</head>
<body>
<div id="page"></div>
{scripts}</body>
</html>
"""


def serve_files(app: FastAPI) -> None:
    """What the pages load: Swagger UI and ReDoc as fastapi-offline packs them, and our own."""
    files = StaticFiles(directory=_OURS, packages=[("fastapi_offline", "static")])
    app.mount(PAGE_FILES.rstrip("/"), files, name="page-files")


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
    return _page(("swagger-ui-bundle.js", "docs.js"), ("swagger-ui.css",))


@router.get("/redoc")
async def get_redoc() -> Response:
    """To read and print."""
    return _page(("redoc.standalone.js", "redoc.js"))


def _page(scripts: tuple[str, ...], styles: tuple[str, ...] = ()) -> Response:
    html = _PAGE.format(
        styles="".join(f'<link rel="stylesheet" href="page-files/{name}">\n' for name in styles),
        scripts="".join(f'<script src="page-files/{name}"></script>\n' for name in scripts),
    )
    headers = {"Content-Security-Policy": PAGE_CONTENT_POLICY, "Cache-Control": "no-cache"}
    return Response(html, headers=headers, media_type="text/html")
