"""`slewtrack keys`, on the database the service uses, running or not."""

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from typing import TYPE_CHECKING, Annotated

import typer

from app.store.api_keys import SCOPES, Key, KeyScope
from planner.base.errors import InvalidInput

if TYPE_CHECKING:
    from app.store.keys import KeyStore

NAME_CHARACTERS_MAX = 100

keys = typer.Typer(help="Manage the API keys of the service.", no_args_is_help=True)


@keys.command()
def create(
    name: Annotated[str, typer.Argument(help="Name the key's holder, for people.")],
    scope: Annotated[
        list[str] | None,
        typer.Option(
            help="Allow read (GET), write (also POST and DELETE) or admin (also the audit log); "
            "read by default (may be repeated)."
        ),
    ] = None,
    rate_per_minute: Annotated[
        int | None,
        typer.Option(
            min=1, help="Allow so many requests a minute, instead of the service's limit."
        ),
    ] = None,
    concurrency: Annotated[
        int | None,
        typer.Option(
            min=1, help="Allow so many requests at a time, instead of the service's limit."
        ),
    ] = None,
) -> None:
    """Make a key; its secret is shown only now."""
    scopes = tuple(_scope(text) for text in scope or ["read"])
    with _store() as store:
        key, secret = store.create(
            _printable(name), scopes, rate_per_minute=rate_per_minute, concurrency=concurrency
        )
    text = f"Key {key.id} ({', '.join(key.scopes)}). Keep its secret, shown only once:"
    typer.echo(text, err=True)
    typer.echo(secret)


@keys.command(name="list")
def list_keys() -> None:
    """Show all keys, without their secrets."""
    with _store() as store:
        found = store.all()
    for key in found:
        typer.echo(_line(key))
    if not found:
        typer.echo("There are no keys; `slewtrack keys create NAME` makes one.", err=True)


@keys.command()
def revoke(
    key_id: Annotated[
        str, typer.Argument(metavar="ID", help="Take this key, by its id in `slewtrack keys list`.")
    ],
) -> None:
    """Refuse a key from its next request on."""
    with _store() as store:
        store.revoke(key_id)


@contextmanager
def _store() -> Iterator["KeyStore"]:
    from app.settings import settings_of_environment
    from app.store.keys import KeyStore
    from app.store.migrate import open_migrated

    settings = settings_of_environment()
    with open_migrated(settings.database_url, settings.data_dir) as database:
        yield KeyStore(database)


def _scope(text: str) -> KeyScope:
    for scope in SCOPES:
        if text == scope:
            return scope
    raise InvalidInput(f"must be {', '.join(SCOPES)}, not {text[:80]!r}", field="--scope")


def _printable(name: str) -> str:
    if not name.isprintable() or not 1 <= len(name) <= NAME_CHARACTERS_MAX:
        raise InvalidInput(f"must be 1 to {NAME_CHARACTERS_MAX} printable characters", field="NAME")
    return name


def _line(key: Key) -> str:
    state = "valid" if key.revoked_utc is None else f"revoked {_day_and_time(key.revoked_utc)}"
    scopes = ",".join(key.scopes)
    return f"{key.id}  {scopes:16}  created {_day_and_time(key.created_utc)}  {state}  {key.name}"


def _day_and_time(at_utc: datetime) -> str:
    return f"{at_utc:%Y-%m-%d %H:%M}Z"
