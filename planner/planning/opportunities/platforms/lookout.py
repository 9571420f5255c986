"""The lookout: everything that the search for windows asks of a platform, whatever its kind."""

from collections.abc import Iterator
from typing import NamedTuple, Protocol

from planner.base.arrays import Array, Mask
from planner.motion.pointing.reach import Reach
from planner.planning.opportunities.carrier import Base
from planner.planning.opportunities.closing import Closing
from planner.planning.opportunities.margins import WindowScene
from planner.planning.opportunities.request import OpportunityConditions
from planner.planning.opportunities.sights import Sight
from planner.planning.opportunities.sweep import Found
from planner.planning.opportunities.windows import Cause
from planner.world.frames.time_scales import Instants
from planner.world.platforms import AnyPlatform


class HeldScans(NamedTuple):
    """Whether scans that begin at n times are held from end to end by one way of following, (n,).

    as_window: exclusions are kept, and the rate.  as_session: with what plans keep between rows,
    of acceleration and jerk, too, and from when the platform must have settled.
    """

    as_window: Mask
    as_session: Mask


class Narrowing(NamedTuple):
    """A platform with one more of its own conditions.

    cause: of what it leaves nothing of.  because: in words.  name: as windows' edges have it.
    """

    cause: Closing
    platform: AnyPlatform
    because: str
    name: str


def kept_before(count: int) -> str:
    """In words, that what a platform keeps before the n-th of the same list is kept, too."""
    return " with those before it kept" if count > 1 else ""


class Lookout(Base, Protocol):
    """One platform in a search for windows.

    reach: the axes whose angles windows tell, in the frame of the base.
    settle_s: on the track before a session.
    sees_bodies: whether what it keeps hangs on the Sun or the Moon.
    """

    reach: Reach
    settle_s: float
    sees_bodies: bool

    @property
    def angle_names(self) -> tuple[str, str]:
        """Of the angles that windows tell."""
        ...

    @property
    def has_branches(self) -> bool:
        """Whether two pairs of them point at a target."""
        ...

    def warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """What the user should know about that frame."""
        ...

    def conditions(self, asked: OpportunityConditions) -> OpportunityConditions:
        """These, as far as the platform doesn't ask for more itself."""
        ...

    @property
    def causes(self) -> tuple[Cause, ...]:
        """The conditions that the platform sets beside those."""
        ...

    def hold(
        self, sight: Sight, scene: WindowScene, found: Found, shortest_s: float, looks_limit: float
    ) -> tuple[Found, Array, int]:
        """Windows as far as the platform's motion allows them, what a session holds of each,
        (m, 2), NaN where nothing, and how many looks that took: no more are begun at that limit.
        """
        ...

    def held_scans(self, sight: Sight, begins_s: Array, duration_s: float) -> HeldScans:
        """Which scans of a line are held that begin at each time, n of them, as `sight` has it."""
        ...

    def kept_names(self, images: bool) -> tuple[str, ...]:
        """Of its exclusions, the request's directions and star trackers, as windows' edges name
        them; images: of targets that the camera images."""
        ...

    def narrowing(self) -> Iterator[Narrowing]:
        """The platform with more and more of its own conditions, the last with all."""
        ...
