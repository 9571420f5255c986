"""The follower: everything that a campaign asks of a platform, whatever its kind."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from typing import NamedTuple, Protocol

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import Motion
from planner.planning.campaigns.platforms.slew_fits import FollowerLimits
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.sights import Sight
from planner.world.attitude import Attitude
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.scenario import FinalState, InitialState, Session, SlewOptions


class Following(NamedTuple):
    """One way to follow targets over n samples.

    states: (n, s), as `slew_fits` takes them.  usable: (n,), within all limits.  goes_on: (n - 1,),
    whether a sample follows from the one before.
    """

    states: Array
    usable: Mask
    goes_on: Mask


class FollowedLook(NamedTuple):
    """A look of a pass, from when to when on the carrier's clock.

    row: of the request's targets; None of a scan, which lies on its line whatever came before.
    stop_state: of `Following.states`, at its end.
    """

    row: int | None
    start_s: float
    stop_s: float
    stop_state: Array


class PassEnds(NamedTuple):
    """How the plan of a pass begins and ends.

    rest: the sessions after the last look.  attitude: of the carrier, if it stands on one.
    final_by: when it is back at rest at the latest, unless the sessions say.
    """

    attitude: Attitude | None
    initial_state: InitialState
    rest: tuple[Session, ...]
    final_state: FinalState | None
    final_by: datetime | None
    slew: SlewOptions


class Follower(Protocol):
    """One platform in a campaign.

    slew_limits: of its slews.  longest_slew_s: none between two targets needs longer.  rest_s: room
    that a pass needs at either end, whole rows.  held_s: at rest, of the room at a pass's end.
    settle_s: on a target before a look.
    resting, unable: reasons: that a pass leaves no time, that it can't follow for `least_s`.
    """

    slew_limits: FollowerLimits
    longest_slew_s: float
    rest_s: float
    held_s: float
    settle_s: float
    resting: str
    unable: str

    def carrier(self, ephemeris: Ephemeris) -> Carrier:
        """The carrier over all of the campaign."""
        ...

    def ways(self, sight: Sight, which: Indices, t_s: Array) -> Iterator[Following]:
        """Every way to follow targets `which` (n,) at t_s (n,)."""
        ...

    def rest_state(self, carrier: Carrier, at_s: float) -> Array:
        """In which it rests at an instant, (s,), as of `Following.states`."""
        ...

    def start_state(self, carrier: Carrier, at_s: float) -> Array:
        """The same at the instant at which the campaign begins."""
        ...

    def first_unheld(
        self, carrier: Carrier, looks: Sequence[FollowedLook], rows: Sequence[int]
    ) -> tuple[int, float] | None:
        """The first look of a pass that can't be held after those before it: its place, and the
        last instant at which it is not.

        rows: of all targets that the carrier's looks may be at.
        """
        ...

    def probability(self, sight: Sight, which: Indices, t_s: Array, ephemeris: Ephemeris) -> Array:
        """That each target is in the frame at that instant, (n,); 0 where it can't be pointed."""
        ...

    def rest_motion(self, instants: Instants, states: OrbitStates) -> Motion | None:
        """The attitude that panels have between passes, at n instants evenly apart; None where they
        stand on the carrier, which no look turns."""
        ...

    def pass_ends(self, start_utc: datetime, stop_utc: datetime, *, is_first: bool) -> PassEnds:
        """Of a pass, at rest from the start and again by the stop.

        is_first: whether it begins as the campaign does.
        """
        ...
