"""Example answers in the OpenAPI document, as they were really given."""

import json
from pathlib import Path
from typing import Any

ANSWERS = Path(__file__).parent / "data" / "answers.json"


def document_answers(document: dict[str, Any]) -> None:
    """Add the worked answers, which are nested as the document nests what they are examples of."""
    shown = json.loads(ANSWERS.read_text())
    for path, methods in shown.items():
        for method, statuses in methods.items():
            for status, media_types in statuses.items():
                content = document["paths"][path][method]["responses"][status]["content"]
                for media_type, examples in media_types.items():
                    content[media_type]["examples"] = examples
