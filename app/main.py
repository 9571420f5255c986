"""What does the HTTP service consist of?"""

import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import anyio
from fastapi import FastAPI
from fastapi_offline import FastAPIOffline

from app import errors
from app.api import horizon, opportunities, plans, platforms, spacecraft, system
from app.jobs.disposable import start_server
from app.openapi import complete
from app.settings import Settings
from app.versions import VERSION

# CasADi and the planner's Python hold the interpreter lock: a second thread only adds latency.
SOLVES_AT_ONCE = 1

_DESCRIPTION = """\
Plans how a two-axis platform on a spacecraft points its camera: target and session time in,
a verified command table every 0.2 s out.

Angles are in degrees, times RFC 3339 with an offset, quaternions scalar last. Whatever is
refused is refused as `application/problem+json` with the field, the reason and the way out."""


def create_app(settings: Settings | None = None) -> FastAPI:
    """The service; settings default to the environment's."""
    # FastAPIOffline serves the pages of /docs and /redoc without a CDN.
    app: FastAPI = FastAPIOffline(
        title="slewtrack",
        version=VERSION,
        description=_DESCRIPTION,
        redirect_slashes=False,
        lifespan=_ready_for_children,
        separate_input_output_schemas=False,
        swagger_ui_parameters={
            "tryItOutEnabled": True,
            "defaultModelsExpandDepth": 0,
            "validatorUrl": None,  # else the page asks an outside service to judge the document
        },
    )
    app.state.settings = settings or Settings()
    app.state.solves = anyio.CapacityLimiter(SOLVES_AT_ONCE)
    app.state.children = anyio.CapacityLimiter(os.cpu_count() or 1)
    for resource in (plans, opportunities, horizon, spacecraft, platforms, system):
        app.include_router(resource.router)
    errors.install(app)
    _describe(app)
    return app


@asynccontextmanager
async def _ready_for_children(_: FastAPI) -> AsyncIterator[None]:
    start_server()
    yield


def _describe(app: FastAPI) -> None:
    generate = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = complete(generate())
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]  # FastAPI's documented way
