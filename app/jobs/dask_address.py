"""Checks that a Dask scheduler answers at an address, with the certificates given."""

from typing import TYPE_CHECKING, Literal

from planner.base.errors import InvalidInput

if TYPE_CHECKING:
    from distributed import Security

_VARIABLES = "DASK_DISTRIBUTED__COMM__TLS__"


def check_scheduler(address: str, role: Literal["worker", "client"], field: str) -> None:
    """Raises InvalidInput where waiting for the scheduler would be in vain."""
    try:
        from distributed import Security
        from distributed.comm.addressing import parse_host_port
    except ModuleNotFoundError:
        raise InvalidInput(
            "a Dask scheduler needs `pip install 'slewtrack[dask]'`", field=field
        ) from None
    scheme, _, where = address.partition("://")
    try:
        host, port = parse_host_port(where)
    except ValueError:
        host, port = "", None
    if scheme not in ("tcp", "tls") or not host or not port:
        raise InvalidInput(
            f"{address!r} is no scheduler's address; give tcp://HOST:PORT or tls://HOST:PORT",
            field=field,
        )
    security = Security()
    if scheme == "tls":
        _check_certificates(security, role, field)
    elif security.require_encryption:
        raise InvalidInput(
            f"{address} is not encrypted, which Dask is set to require; give tls://{where}",
            field=field,
        )


def _check_certificates(security: "Security", role: str, field: str) -> None:
    needed = f"{_VARIABLES}CA_FILE, {_VARIABLES}{role.upper()}__CERT and …__KEY"
    try:
        context = security.get_connection_args(role)["ssl_context"]
    except OSError as error:
        files = security.get_tls_config_for_role(role)
        names = ", ".join(str(files[name]) for name in ("ca_file", "cert", "key"))
        raise InvalidInput(
            f"the certificates for tls:// can't be read ({names}: {error}); look at {needed}",
            field=field,
        ) from None
    if context is None:
        raise InvalidInput(f"tls:// needs certificates; set {needed}", field=field)
