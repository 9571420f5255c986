"""Docstrings of the calls, whose arguments and exceptions are the same in many of them."""

import inspect
from collections.abc import Callable
from typing import Any, get_args

_ARGS = {
    "request": "JSON of the API (docs/requests.md): a dictionary, bytes, or a file's Path",
    "plan": "what `plan` or `plans` returned, or its id",
    "job": "what `submit` or a list returned, or its id",
    "revises": "id of the plan whose place the new one takes, or of the campaign revised",
    "frozen_until": "UTC text, with `revises`: passes that begin before it stay as they were",
    "start": "when the search begins: aware datetime or UTC text; now unless given",
    "progress": "called with a `Progress` at each step",
    "timeout_s": "seconds to wait before NotFinished; all it takes unless given",
    "limit": "the largest number of entries",
    "filters": "state, name, target, text, after, before, campaign: see `Filters`",
    "format_name": "as the service's lists name it: csv, netcdf, aem, czml, kml, png and more",
    "step_s": "seconds from row to row; by the plan's length unless given",
    "search": "what `opportunities` or `searches` returned, or its id",
    "target": "id of one target; all unless given",
    "include": "what to tell of windows beyond edges and session: view, probability; why targets "
    "are never seen: reasons",
    "images": "one PNG, JPEG or TIFF per camera: bytes, or a file's Path",
    "csv": "telemetry as CSV (docs/telemetry.md): bytes, or a file's Path",
    "begin": "letters that the name begins with",
}
_REFUSED = "Refused: it can't be read or done; `problem` has field, limit and ways out"
_LATE = "NotFinished, Cancelled: the time is over, or somebody cancelled the work"
_LOST = "NoAnswer, BadAnswer: the service can't be reached, or is none"


def whole_docstring(method: Callable[..., Any], example: str) -> str:
    """Of a call: what its docstring says, and then args, answer, exceptions and the example."""
    names = [name for name in inspect.signature(method).parameters if name != "self"]
    answer = get_args(method.__annotations__["return"])[2]
    told = inspect.formatannotation(answer).replace("slewtrack.client.answers.", "")
    first_line = (getattr(answer, "__doc__", None) or "").partition("\n")[0]
    is_ours = getattr(answer, "__module__", "").startswith("slewtrack")
    sections = {
        "Args": [f"{name}: {_ARGS[name]}." for name in names],
        "Returns": [f"{told}: {first_line}" if is_ours else told],
        "Raises": [_REFUSED, *([_LATE] if "timeout_s" in names else []), _LOST],
        "Example, with a Client as client, or slewtrack itself": [f">>> {example}"],
    }
    lines = ["\n    ".join((f"{name}:", *entries)) for name, entries in sections.items() if entries]
    return "\n\n".join((inspect.cleandoc(method.__doc__ or ""), *lines))
