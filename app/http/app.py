"""The HTTP service, put together from its parts."""

import asyncio
import os
from collections.abc import AsyncIterator, Iterable, Iterator
from contextlib import asynccontextmanager, closing, contextmanager
from itertools import chain
from threading import Lock
from typing import Any

import anyio
import anyio.to_thread
from fastapi import APIRouter, Depends, FastAPI
from fastapi.routing import APIRoute
from starlette.middleware.cors import CORSMiddleware
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES, GZipMiddleware

from app.http import pages
from app.http import problems as errors
from app.http.admission.access import Access, KeyLookup
from app.http.admission.admission import Admission
from app.http.metrics import Metrics
from app.http.openapi.schema import DESCRIPTION, TAGS, complete
from app.http.query import require_sound_query
from app.http.readiness import (
    Readiness,
    database_takes_writes,
    earth_orientation_covers_now,
    solver_answers,
)
from app.http.request_log import HeadAsGet, RequestLog
from app.http.routes import (
    campaigns,
    flights,
    horizon,
    names,
    opportunities,
    plans,
    system,
    telemetry,
)
from app.ids import JobState
from app.jobs.dispatcher import Dispatcher
from app.jobs.worker_process import RunTask, run_here, spare_children, start_server
from app.settings import Settings, settings_of_environment
from app.store import jobs
from app.store.database import Database, open_database
from app.store.keys import KeyStore
from app.store.migrate import upgrade
from app.versions import VERSION

# Of pages of other origins, and for them: Fetch standard, section 3.2 (CORS protocol).
_HEADERS_TAKEN = (
    "Authorization",
    "Idempotency-Key",
    "If-None-Match",
    "Last-Event-ID",
    "Prefer",
    "X-Request-ID",
)
_HEADERS_TO_READ = (
    "Allow",
    "Content-Disposition",
    "ETag",
    "Link",
    "Location",
    "Preference-Applied",
    "Retry-After",
    "WWW-Authenticate",
    "X-Request-ID",
)

_OF_API = (
    plans.router,
    opportunities.router,
    opportunities.of_orbits,
    campaigns.router,
    flights.of_plan,
    flights.router,
    horizon.router,
    telemetry.router,
    plans.of_spacecraft,
    names.router,
    system.router,
)


def create_app(settings: Settings | None = None) -> FastAPI:
    settings = settings or settings_of_environment()
    app = FastAPI(
        title="slewtrack",
        version=VERSION,
        description=DESCRIPTION,
        redirect_slashes=False,
        lifespan=_ready_for_children,
        separate_input_output_schemas=False,
        generate_unique_id_function=_operation_id,
        openapi_tags=TAGS,
        docs_url=None,  # our own work without a CDN
        redoc_url=None,
        openapi_url=None,  # pages.py answers it without building it anew each time
        dependencies=[Depends(require_sound_query)],
    )
    app.state.settings = settings
    app.state.stopping = asyncio.Event()  # set as soon as the service is told to
    app.state.end_outdated = lambda: None  # how the program ends when its database has moved on
    app.state.methods = {}
    routers: tuple[APIRouter, ...] = _OF_API
    if settings.stapi_products is not None:
        from app.requests.stapi import read_products, require_package

        require_package()
        from app.http.routes import stapi  # a quarter of a second that others needn't wait

        app.state.stapi = read_products(settings.stapi_products)
        routers = (*_OF_API, stapi.router)
    for route in _routes(routers):
        app.state.methods.setdefault(route.path, set()).update(route.methods)
    app.state.children = anyio.CapacityLimiter(os.cpu_count() or 1)
    app.state.solves = app.state.children
    if settings.dask_scheduler:
        app.state.solves = anyio.CapacityLimiter(settings.workers)
    for router in routers:
        app.include_router(router)
    pages.serve(app)
    errors.install(app)
    _guard_and_watch(app, settings)
    _describe(app)
    return app


def _guard_and_watch(app: FastAPI, settings: Settings) -> None:
    state = app.state
    state.metrics = Metrics()
    state.readiness = Readiness(
        {
            "database": lambda: database_takes_writes(state.database),
            "solver": solver_answers,
            "earth_orientation": earth_orientation_covers_now,
        }
    )
    access = Access(
        KeyLookup(
            lambda secret: state.database.answer(KeyStore(state.database).find, secret),
            lambda: state.database.answer(KeyStore(state.database).good_digests),
        ),
        require_keys=settings.require_keys,
        hosts=tuple(name.strip() for name in settings.allowed_hosts.split(",")),
        origins=settings.origins,
        failures_per_minute=settings.failures_per_minute,
    )
    app.add_middleware(
        GZipMiddleware,
        minimum_size=1000,  # less goes in one packet as it is
        compresslevel=1,  # windows of 78 MB become 29 MB in 0.6 s of a core (by 4: 26 MB in 1.1 s)
        thread_minimum_size=64 * 1024,  # in a millisecond; more would keep others waiting
        exclude_content_types=(*DEFAULT_EXCLUDED_CONTENT_TYPES, "application/x-netcdf"),
    )
    app.add_middleware(HeadAsGet)
    app.add_middleware(Admission, access=access, settings=settings, stopping=app.state.stopping)
    app.add_middleware(RequestLog, metrics=app.state.metrics)
    # The last added is the outermost: pages may read whatever is answered.
    if settings.origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=sorted(settings.origins),
            allow_methods=["GET", "HEAD", "POST", "DELETE"],
            allow_headers=_HEADERS_TAKEN,
            expose_headers=_HEADERS_TO_READ,
        )


@asynccontextmanager
async def _ready_for_children(app: FastAPI) -> AsyncIterator[None]:
    start_server()
    settings: Settings = app.state.settings
    app.state.database = open_database(settings.database_url, settings.data_dir)
    app.state.database.when_outdated = app.state.end_outdated
    try:
        await anyio.to_thread.run_sync(upgrade, app.state.database)
        with _dispatching(settings, app.state.database, app.state.metrics) as dispatcher:
            app.state.dispatcher = dispatcher
            yield
    finally:
        app.state.database.close()


@contextmanager
def _dispatching(settings: Settings, database: Database, metrics: Metrics) -> Iterator[Dispatcher]:
    """A dispatcher at work as the settings say; at the end it gives back what isn't done."""

    def on_end(kind: str, state: JobState, took_s: float, iterations: int | None) -> None:
        metrics.solve_s.labels(kind, state).observe(took_s)
        if iterations is not None:
            metrics.iterations.labels(kind).observe(iterations)

    def counts() -> dict[tuple[str, str], int]:
        with database.reading() as connection:
            return jobs.counts(connection)

    metrics.count_jobs_by(counts)
    # With a cluster only what is answered at once is done here.
    here = settings.workers if not settings.dask_scheduler else os.cpu_count() or 1
    with spare_children(here), _running_tasks(settings) as run_task:
        dispatcher = Dispatcher(database, run_task, settings, on_end)
        dispatcher.start()
        try:
            yield dispatcher
        finally:
            dispatcher.close()


@contextmanager
def _running_tasks(settings: Settings) -> Iterator[RunTask]:
    if not settings.dask_scheduler:
        yield run_here
        return
    from app.jobs.dask_executor import DaskExecutor  # half a second that others needn't wait

    with closing(DaskExecutor(settings.dask_scheduler)) as executor:
        yield executor.run


def _describe(app: FastAPI) -> None:
    generate = app.openapi
    one_at_a_time = Lock()  # who asks meanwhile must not get it half made
    told = [
        (one.response_model, *(it.get("model") for it in one.responses.values()))
        for one in _routes()
    ]
    answers = [*chain.from_iterable(told)]

    def openapi() -> dict[str, Any]:
        with one_at_a_time:
            if app.openapi_schema is None:
                app.openapi_schema = complete(generate(), answers)
            return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]  # FastAPI's documented way


def _routes(routers: Iterable[APIRouter] = _OF_API) -> Iterator[APIRoute]:
    for router in routers:
        yield from (route for route in router.routes if isinstance(route, APIRoute))


def _operation_id(route: APIRoute) -> str:
    """Method and path in words, such as get_plan_table: names of functions in generated clients."""
    path = route.path.removeprefix("/v1").replace("ies/{id}", "y").replace("s/{id}", "")
    words = path.split("/")
    return "_".join((*(route.methods or ()), *words[1:])).lower()
