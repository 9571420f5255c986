"""Refusals: their kinds, and what each tells the planner.

Each class is one kind of refusal and says who is to blame, which decides how it is answered.
The message explains the physics and the way out; the attributes carry the same
facts for programs.  Bugs are not refusals: they are left to crash.
"""

import re
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Any, ClassVar, Literal

from annotated_types import Ge

VALUE_CHARACTERS_MAX = 200  # of what was sent, in what is said of it
_LONG_WORD = re.compile(rf"(\S{{{VALUE_CHARACTERS_MAX}}})\S+")
_LONG_QUOTE = re.compile(
    rf"""(?<!\w)(['"])((?:(?!\1)[^\\]|\\.){{{VALUE_CHARACTERS_MAX}}})(?:(?!\1)[^\\]|\\.)+\1""",
    re.DOTALL,
)


def with_short_values(text: str) -> str:
    """The text with what it repeats of a request, a long word or quotation, cut short."""
    return _LONG_QUOTE.sub(r"\1\2...\1", _LONG_WORD.sub(r"\1...", text))


def figures(value: float, *limits: float, digits: int = 4) -> str:
    """A number with the digits it takes to tell it from the limits it is compared with."""
    while digits < 17 and any(
        value != limit and f"{value:.{digits}g}" == f"{limit:.{digits}g}" for limit in limits
    ):
        digits += 1
    return f"{value:.{digits}g}"


# What stands in the way: the request itself; the state of what it is about; a service that has
# too much to do or is partly away, so that the same works later; or a failure of our own.
Blame = Literal["request", "conflict", "busy", "ours"]


class Refusal(Exception):
    """A request that can't be fulfilled as it stands.

    field: the request field at fault, dotted (`sessions.0.start`).
    axis, limit: the axis and the limit that break ("rate", "acceleration", ...).
    at_utc: when the limit breaks.  earliest_feasible_start_utc: the nearest session start
    that works, on the command grid, for a session that stops at feasible_stop_utc.
    costs_sessions: others, by number, that can't be flown as asked when it is moved there; with
    these left out, the whole request was planned.
    """

    slug: ClassVar[str] = "refused"
    title: ClassVar[str] = "The request can't be fulfilled"
    blame: ClassVar[Blame] = "request"

    def __init__(
        self,
        detail: str,
        *,
        field: str | None = None,
        axis: str | None = None,
        limit: str | None = None,
        at_utc: datetime | None = None,
        earliest_feasible_start_utc: datetime | None = None,
        feasible_stop_utc: datetime | None = None,
        costs_sessions: tuple[int, ...] = (),
    ) -> None:
        detail = with_short_values(detail)
        super().__init__(detail)
        self.detail = detail
        self.field = None if field is None else with_short_values(field)
        self.axis = axis
        self.limit = limit
        self.at_utc = at_utc
        self.earliest_feasible_start_utc = earliest_feasible_start_utc
        self.feasible_stop_utc = feasible_stop_utc
        self.costs_sessions = costs_sessions

    def __reduce__(self) -> tuple[Any, ...]:
        """Whole, whatever its class is made from: an exception is else made anew of its text."""
        return type(self).__new__, (type(self), *self.args), vars(self)


class InvalidInput(Refusal):
    """A value no scenario can have, found after the request's shape was accepted."""

    slug = "invalid-input"
    title = "The request holds a value that makes no sense"


@dataclass(frozen=True, kw_only=True)
class FieldError:
    """One field at fault.

    field: its dotted name. E.g. `"sessions.0.target.latitude_deg"`.
    detail: the fault and the way out. E.g. `"must lie in -90..90, not 91"`.
    value: its value, if that is no object or list. E.g. `91`.
    candidates: names that each mean one thing, where the value may mean several or is misspelt.
    E.g. `["Springfield, Ohio, US"]`.
    """

    field: str
    detail: str
    value: str | float | int | bool | None = None
    candidates: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.field}: {self.detail}" if self.field else self.detail


class InvalidRequest(InvalidInput):
    """The request as text, not what it asks for, is at fault; errors: field by field."""

    slug = "invalid-request"
    title = "The request can't be read"

    def __init__(self, *errors: FieldError) -> None:
        more = f"; {len(errors) - 1} more under errors" if len(errors) > 1 else ""
        super().__init__(f"{errors[0]}{more}", field=errors[0].field or None)
        self.errors = errors


class InvalidMessage(InvalidInput):
    """A TLE or CCSDS message that can't be read."""

    slug = "invalid-message"
    title = "The orbit or attitude message can't be read"


class NotForPlatform(Refusal):
    """What was asked for can't be told of a platform of this kind."""

    slug = "not-for-platform"
    title = "There is nothing like this for platforms of this kind"


class OutsideCoverage(Refusal):
    """The orbit, attitude or Earth orientation is not known at the instants asked for."""

    slug = "outside-coverage"
    title = "The orbit or attitude is not known at that time"


class NotVisible(Refusal):
    """The target is hidden, under the elevation asked for, or in a cone to keep out of."""

    slug = "not-visible"
    title = "The target can't be seen during the session"


class Unreachable(Refusal):
    """No pair of axis angles, or none within the stops, points at the target."""

    slug = "unreachable"
    title = "The platform can't point there"


class TrackBreaksLimit(Refusal):
    """Following the target needs more rate or acceleration than an axis has."""

    slug = "track-breaks-limit"
    title = "Tracking the target breaks a limit of the platform"


@dataclass(frozen=True, kw_only=True)
class Relaxation:
    """The time that one session would lose if the plan's `on_conflict` were set so.

    on_conflict: the setting that would lose this. E.g. `"shorten_later"`.
    session: number of the session that loses, from 0. E.g. `1`.
    start_later_s: by how much it would begin later. E.g. `12.4`.
    stop_earlier_s: by how much it would end earlier. E.g. `0.0`.
    """

    on_conflict: str
    session: Annotated[int, Ge(0)]
    start_later_s: Annotated[float, Ge(0.0)]
    stop_earlier_s: Annotated[float, Ge(0.0)]


class InfeasibleSlew(Refusal):
    """The axis can't get from its state to the track in the time available.

    relaxations: what would make the sequence fit, one entry per way out and session that loses.
    needs_s: about the time in which it fits, where that is known.
    """

    slug = "infeasible-slew"
    title = "The slew doesn't fit in the time available"
    relaxations: tuple[Relaxation, ...] = ()
    needs_s: float | None = None


class ResourceRunsOut(Refusal):
    """A resource passes its limit; earliest_feasible_start_utc: where it doesn't."""

    slug = "resource-runs-out"
    title = "A resource runs out"


class CadenceBroken(Refusal):
    """A session comes too soon after the one before, or makes more imaging than a span may have."""

    slug = "cadence-broken"
    title = "Sessions are too close together or too long"


class SearchEnded(Refusal):
    """Neither what was asked for nor a proof that there is none, by the work that may be done."""

    slug = "search-ended"
    title = "The search ended before anything was found"


class SolverFailed(Refusal):
    """A problem certified feasible that the solver left unsolved: our failure, not the user's."""

    slug = "solver-failed"
    title = "The solver found no trajectory"
    blame = "ours"


class VerificationFailed(Refusal):
    """A plan the independent judge rejects; never returned as good."""

    slug = "verification-failed"
    title = "The plan failed its verification"
    blame = "ours"


class Unverified(Refusal):
    """A table asked for by itself whose plan the judge rejects: only the baseline's can be."""

    slug = "unverified"
    title = "The table failed its verification"
