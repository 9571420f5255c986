"""The API's schema, which several test files ask for: put together once a process."""

import json
from functools import cache
from typing import Any

from app.http.app import create_app


@cache
def _text() -> str:
    return json.dumps(create_app().openapi())


def api_document() -> dict[str, Any]:
    """As the service answers it; whoever asks may change what it gets."""
    document: dict[str, Any] = json.loads(_text())
    return document
