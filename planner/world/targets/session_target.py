"""The interface of a target, whatever its mode, to a session."""

from dataclasses import replace
from datetime import datetime
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

from planner.base.assumed import Assumed

if TYPE_CHECKING:
    from planner.world.targets.terrain import Terrain


class SessionTarget:
    """What the platform is busy with during a session.

    has_windows: whether it can be seen at times of its own, without a session.
    rests_on_earth: whether its place on the Earth never changes, so that many are searched at once.
    images: whether the camera images meanwhile; else nothing is asked that only a look must meet.
    """

    has_windows: ClassVar[bool] = True
    rests_on_earth: ClassVar[bool] = False
    images: ClassVar[bool] = True
    mode: str

    @property
    def label(self) -> str:
        """A few words by which people know it, where the request gives it no name."""
        return self.mode

    def starting(self, start_utc: datetime) -> Self:
        """The target in a session that starts then."""
        return self

    def unbound(self, start_utc: datetime) -> Self:
        """The target as it was asked for before a session that starts then bound it."""
        return self

    def standing_on(self, terrain: "Terrain") -> Self:
        """The target on the ground as the request has it, where it says no height itself.

        Raises ValueError where the terrain has none.
        """
        return self

    def with_heights(self) -> Self:
        """The target on terrain as one without, its heights written out."""
        return self

    def require_known(self, name: str, start_utc: datetime, stop_utc: datetime) -> None:
        """Raise ValueError unless it is known over all that time; `name` is its field."""

    def assumed(self, field: str) -> Assumed | None:
        """What was looked up for it; None where the request says it all.  `field`: its own."""
        return None


class TimedTarget(SessionTarget):
    """A target with a timetable; t = 0 is its start, the session's unless given."""

    has_windows = False
    start: datetime | None

    def starting(self, start_utc: datetime) -> Self:
        """The target with its timetable, from start_utc on unless it says when itself."""
        return self if self.start is not None else self._with_start(start_utc)

    def unbound(self, start_utc: datetime) -> Self:
        """What began with the session will begin with another one."""
        return self._with_start(None) if self.start == start_utc else self

    def _with_start(self, start_utc: datetime | None) -> Self:
        return replace(self, start=start_utc)  # type: ignore[type-var]  # each mode is a dataclass


T = TypeVar("T")


def all_standing_on(terrain: "Terrain | None", wanted: tuple[T, ...], field: str) -> tuple[T, ...]:
    """What has a `target` each, these on the terrain; raises ValueError with the field at fault."""

    def standing(number: int, one: Any) -> T:  # noqa: ANN401 (a session, a campaign's target)
        try:
            target = one.target.standing_on(terrain)
        except ValueError as error:
            raise ValueError(f"{field}.{number}.target: {error}") from None
        stood: T = one if target is one.target else replace(one, target=target)
        return stood

    return wanted if terrain is None else tuple(standing(*each) for each in enumerate(wanted))
