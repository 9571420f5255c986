"""Prints the API's schema: `python -m app.http.openapi`, without a service running."""

import json

from app.http.app import create_app
from app.settings import Settings

print(json.dumps(create_app(Settings()).openapi(), ensure_ascii=False))
