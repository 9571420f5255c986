"""Refusals about jobs."""

from typing import ClassVar

from planner.base.errors import Blame, Refusal


class QueueFull(Refusal):
    """More is waiting than the service promises to get done."""

    slug: ClassVar[str] = "queue-full"
    title: ClassVar[str] = "Too many requests wait to be worked on"
    blame: ClassVar[Blame] = "busy"


class Interrupted(Refusal):
    """Whoever worked on it died each time: our failure, or a request that brings solvers down."""

    slug: ClassVar[str] = "interrupted"
    title: ClassVar[str] = "The work was interrupted too often"
    blame: ClassVar[Blame] = "ours"


class Conflict(Refusal):
    """What is asked doesn't go with the state the job is in."""

    slug: ClassVar[str] = "conflict"
    title: ClassVar[str] = "The state of the job rules this out"
    blame: ClassVar[Blame] = "conflict"


class KeyReused(Refusal):
    """An Idempotency-Key that came with another request before."""

    slug: ClassVar[str] = "idempotency-key-reused"
    title: ClassVar[str] = "The Idempotency-Key belongs to another request"
