"""How is the service brought to a port?"""

import uvicorn

from app.main import create_app
from app.observability.logs import configure_logs
from app.security.protocol import HEAD_BYTES_MAX, GuardedProtocol
from app.settings import Settings

_GRACE_S = 10  # for requests at work when the service is told to stop


def serve_on(host: str, port: int, settings: Settings) -> None:
    """Until it is told to stop."""
    configure_logs(settings.log_level, settings.log_format)
    server(host, port, settings).run()


def server(host: str, port: int, settings: Settings) -> uvicorn.Server:
    """Ready to run, with limits on what a connection may do."""

    class Protocol(GuardedProtocol):
        connections_max = settings.max_connections
        head_timeout_s = settings.head_timeout_s

    return uvicorn.Server(
        uvicorn.Config(
            create_app(settings),
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
        )
    )
