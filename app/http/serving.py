"""Starts the service on its port."""

import socket
import sys
from ipaddress import ip_address
from typing import ClassVar

import uvicorn
from fastapi import FastAPI
from starlette.types import Receive, Scope, Send

from app.http.admission.access import is_loopback
from app.http.admission.admission import HEAD_BYTES_MAX
from app.http.admission.protocol import GuardedProtocol, answer_guarded
from app.http.app import create_app
from app.jobs.dask_address import check_scheduler
from app.log.logs import configure_logs
from app.settings import Settings
from app.store.database import OUTDATED, Database
from app.store.keys import KeyStore
from app.store.migrate import open_migrated
from planner.base.errors import Refusal

# For requests at work when the service is told to stop: who only waits is answered at once.
_GRACE_S = 5


def serve_on(host: str, port: int, settings: Settings) -> None:
    """Until it is told to stop; raises Refusal where others could reach it without a key.

    And where a Dask scheduler is set that can't be asked.
    """
    if settings.dask_scheduler:
        check_scheduler(settings.dask_scheduler, "client", "SLEWTRACK_DASK_SCHEDULER")
    # What is wrong with it is told before anything starts.
    with open_migrated(settings.database_url, settings.data_dir) as database:
        if not is_loopback(host):
            settings = settings.model_copy(update={"require_keys": True})
            _require_a_key(host, database)
    _require_free(host, port)
    configure_logs(settings.log_level, settings.log_format)
    service = server(host, port, settings)
    service.run()
    if not service.started:
        sys.exit(1)
    if service.is_outdated:
        raise Refusal(OUTDATED)


def _require_free(host: str, port: int) -> None:
    """Raises Refusal where it can't be listened on: uvicorn would start all else first."""
    try:
        for family, kind, _, _, address in socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        ):
            with socket.socket(family, kind) as listener:
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                listener.bind(address)
    except OSError as error:
        detail = f"{host} port {port} can't be listened on: {error.strerror}"
        raise Refusal(detail, field="--port") from None


def server(host: str, port: int, settings: Settings) -> "_Server":
    """Ready to run, with limits on what a connection may do."""

    async def guarded(scope: Scope, receive: Receive, send: Send) -> None:
        await answer_guarded(app, scope, receive, send)

    uvicorns = uvicorn.Config(guarded, http="h11", ws="none", log_config=None)
    uvicorns.load()

    class Protocol(GuardedProtocol):
        by_h11 = uvicorns.http_protocol_class
        held: ClassVar[set[GuardedProtocol]] = set()

    Protocol.settings = settings

    app = create_app(settings)
    service = _Server(
        uvicorn.Config(
            guarded,
            host=host,
            port=port,
            http=Protocol,
            ws="none",
            log_config=None,
            access_log=False,  # our own says more
            server_header=False,
            proxy_headers=bool(settings.trusted_proxies),
            forwarded_allow_ips=settings.trusted_proxies,
            h11_max_incomplete_event_size=HEAD_BYTES_MAX,
            timeout_graceful_shutdown=_GRACE_S,
        ),
        app,
    )
    app.state.end_outdated = service.end_outdated
    return service


class _Server(uvicorn.Server):
    """Says where it listens, and tells the application of the stop before it waits for work."""

    def __init__(self, config: uvicorn.Config, application: FastAPI) -> None:
        super().__init__(config)
        self.application = application
        self.is_outdated = False

    def end_outdated(self) -> None:
        """As told to stop, when another version has migrated the database."""
        self.is_outdated = self.should_exit = True

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started:
            address = _address(*self.servers[0].sockets[0].getsockname()[:2])
            told = f"serving {address}/, the API's pages at {address}/docs; Ctrl+C ends it"
            print(told, flush=True)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self.application.state.stopping.set()
        await super().shutdown(sockets)


def _address(host: str, port: int) -> str:
    """To ask it at from this machine, for whichever addresses it listens."""
    ip = ip_address(host)
    if ip.is_unspecified:
        ip = ip_address("127.0.0.1" if ip.version == 4 else "::1")
    return f"http://{ip}:{port}" if ip.version == 4 else f"http://[{ip}]:{port}"


def _require_a_key(host: str, database: Database) -> None:
    if not KeyStore(database).any_valid():
        raise Refusal(
            f"{host} can be reached from other machines and there is no API key yet; make one "
            "with `slewtrack keys create NAME --scope write`, or use 127.0.0.1 or ::1",
            field="--host",
        )
