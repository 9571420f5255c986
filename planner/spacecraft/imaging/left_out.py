"""Requests that a session leaves out."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """A request that isn't imaged, and why.

    name: the request's. E.g. `"strip"`.
    reason: the obstacle. E.g. `"others are worth more"`.
    """

    name: str
    reason: str
