"""The client of a running service, waiting or awaited; it knows a service by its answers only.

    with slewtrack.Client("http://127.0.0.1:8000") as client:
        plan = client.plan(request, progress=print)
        print(plan.passed, plan.table["alpha_deg"])

    async with slewtrack.AsyncClient() as client:
        plans = await asyncio.gather(*(client.plan(request) for request in requests))

Requests are the JSON that the service takes, as bytes or as the dictionary it holds.  What is
refused raises `slewtrack.Refused`, whose `problem` names the field, the reason and the way out.
"""

from typing import TYPE_CHECKING

from slewtrack.client.answers import Columns, Job, Plan, Progress
from slewtrack.client.asking import Json
from slewtrack.client.events import OnProgress
from slewtrack.client.problems import (
    BadAnswer,
    Cancelled,
    NoAnswer,
    NotFinished,
    Problem,
    Refused,
    Relaxation,
    ServiceError,
    problem_of,
)

if TYPE_CHECKING:
    from slewtrack.client.clients import AsyncClient, Client

__all__ = [
    "AsyncClient",
    "BadAnswer",
    "Cancelled",
    "Client",
    "Columns",
    "Job",
    "Json",
    "NoAnswer",
    "NotFinished",
    "OnProgress",
    "Plan",
    "Problem",
    "Progress",
    "Refused",
    "Relaxation",
    "ServiceError",
    "problem_of",
]


def __getattr__(name: str) -> object:
    """The two that talk HTTP, which whoever asks no service needn't load."""
    if name not in ("AsyncClient", "Client"):
        raise AttributeError(f"slewtrack.client has no {name}")
    from slewtrack.client import clients

    return getattr(clients, name)
