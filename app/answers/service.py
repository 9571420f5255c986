"""The state of the service, what was done with it, and what a request can name, as answered."""

from dataclasses import dataclass
from typing import Literal

from app.store.audit import AuditEntry
from planner.world.platforms import (
    BODIES,
    PLATFORMS,
    BodyPlatform,
    PlatformDefinition,
    definition_of,
)
from planner.world.targets.autocomplete import KnownPlace, KnownStar

State = Literal["ok", "degraded", "failed"]


@dataclass(frozen=True, kw_only=True)
class Health:
    """The process answers.

    status: ok, as long as there is an answer.
    version: of slewtrack, as installed.
    """

    status: Literal["ok"]
    version: str


@dataclass(frozen=True, kw_only=True)
class ReadinessCheckOut:
    """One thing the service depends on.

    name: name of the dependency.
    state: `degraded` still works, and `detail` says how well.
    detail: the finding in words.
    """

    name: str
    state: State
    detail: str


@dataclass(frozen=True, kw_only=True)
class ReadinessResponse:
    """State of the service and of what it depends on.

    status: `degraded` when a check is, which plans then warn of.
    checks: the checks, one by one.
    """

    status: Literal["ready", "degraded"]
    checks: list[ReadinessCheckOut]


@dataclass(frozen=True, kw_only=True)
class AuditLog:
    """Actions and the keys that took them.

    entries: the latest first; for older ones ask again with `before` the last id.
    """

    entries: list[AuditEntry]


@dataclass(frozen=True, kw_only=True)
class PlatformList:
    """Every registered platform, written as a request may write out its own.

    platforms: all there are, two-axis ones first.
    """

    platforms: list[PlatformDefinition | BodyPlatform]


def platform_list() -> PlatformList:
    return PlatformList(platforms=[*map(definition_of, PLATFORMS.values()), *BODIES.values()])


@dataclass(frozen=True, kw_only=True)
class KnownPlaces:
    """Places whose names begin so.

    places: the most populous first; of those of another name, a twentieth of the people counts.
    """

    places: list[KnownPlace]


@dataclass(frozen=True, kw_only=True)
class KnownStars:
    """Stars whose names begin so.

    stars: the brightest first.
    """

    stars: list[KnownStar]
