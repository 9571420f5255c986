"""Database reads by routes that don't hold up the others."""

from collections.abc import Callable
from typing import TypeVar

import anyio.to_thread
from fastapi import Request
from sqlalchemy import Connection

from app.store.database import Database

T = TypeVar("T")


async def read(request: Request, reading: Callable[[Connection], T]) -> T:
    """What `reading` finds in one transaction, in a thread."""
    database: Database = request.app.state.database

    def found() -> T:
        with database.reading() as connection:
            return reading(connection)

    return await anyio.to_thread.run_sync(found)
