"""A campaign revised: what flies soon stays as it was chosen, and later looks are chosen anew."""

import itertools
import math
from collections import Counter
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from planner.base.answer_members import Count, NotNegative, answer
from planner.base.errors import InvalidInput
from planner.base.spec import Within, spec
from planner.world.frames.time_scales import Utc, elapsed_s, shifted_utc, utc_text
from planner.world.resources import EnergyWh, Gbit, StartNMS
from planner.world.scenario import PastLook

if TYPE_CHECKING:
    from planner.planning.campaigns.campaign import ChosenPass
    from planner.planning.campaigns.chosen import ChosenLook
    from planner.planning.campaigns.request import CampaignRequest

_FIRST = (None, 1)  # part of a look that counts: of a mode's scans in a pass the first
Change = Literal["kept", "moved", "dropped", "added"]


@dataclass(frozen=True, kw_only=True)
class RevisionBounds:
    """What a revision may hold."""

    looks_max: int = 10_000  # two of each of 5,000 targets, and half of a request's objects
    least_s: float = 60.0  # a carrier with less left has no time for a look and two slews


BOUNDS = RevisionBounds()


@spec
class PassResources:
    """Levels of a carrier's resources as a pass starts, and as it stops, followed by the choice.

    battery_wh: charge at both; null without a battery. E.g. `[160.0, 151.2]`.
    memory_gbit: data held at both; null without a memory. E.g. `[40.0, 72.0]`.
    momentum_n_m_s: of the wheels at both, in body axes; null without a momentum. E.g.
    `[[0.1, -0.2, 0.0], [0.1, -0.1, 0.05]]`.
    """

    battery_wh: tuple[EnergyWh, EnergyWh] | None = None
    memory_gbit: tuple[Gbit, Gbit] | None = None
    momentum_n_m_s: (
        tuple[tuple[StartNMS, StartNMS, StartNMS], tuple[StartNMS, StartNMS, StartNMS]] | None
    ) = None


@spec
class EarlierLook:
    """A look of the campaign that is revised, as its answer tells it.

    target: id of the target. E.g. `"Phoenix"`.
    part: of an imaging mode, number of the scan from 1. E.g. `2`.
    carrier: id of the carrier that flies it; left out where there is but one. E.g. `"north"`.
    plan: id of the plan of its pass. E.g. `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    start: from when; UTC. E.g. `"2015-02-27T17:36:08Z"`.
    stop: until when; UTC. E.g. `"2015-02-27T17:36:48Z"`.
    pass_start: start of its pass, where the platform rests; UTC. E.g. `"2015-02-27T17:32:46Z"`.
    pass_stop: end of its pass, where the platform rests again; UTC. E.g. `"2015-02-27T17:38:08Z"`.
    pass_number: number of its pass; unless given, passes that stay count from 0. E.g. `1`.
    pass_resources: of its pass, `resources`; required where the carrier has `resources`.
    value: worth of the look as it was chosen. E.g. `0.9`.
    """

    target: str
    part: Annotated[int, Within(1, 10_000)] | None = None
    carrier: str | None = None
    plan: str | None = None
    start: datetime
    stop: datetime
    pass_start: datetime
    pass_stop: datetime
    pass_number: Annotated[int, Within(0, 1_000_000)] | None = None
    pass_resources: PassResources | None = None
    value: Annotated[float, Within(0.0, 1e6)] = 0.0

    def __post_init__(self) -> None:
        times = ("pass_start", "start", "stop", "pass_stop")
        for before, after in itertools.pairwise(times):
            if elapsed_s(getattr(self, after), getattr(self, before)) < 0.0:
                raise ValueError(
                    f"{after} ({utc_text(getattr(self, after))}) must not come before {before} "
                    f"({utc_text(getattr(self, before))})"
                )


@answer
class RevisedLook:
    """A look of a campaign that is revised, or of its revision.

    target: id of the target. E.g. `"Phoenix"`.
    part: of an imaging mode, number of the scan from 1. E.g. `2`.
    carrier: id of the carrier that flies it; null where there is but one. E.g. `"north"`.
    plan: id of the plan of its pass as it was; null of a look that is chosen anew, whose pass is
    among `passes`. E.g. `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    start_utc: from when; UTC. E.g. `"2015-02-27T17:36:08.000Z"`.
    stop_utc: until when; UTC. E.g. `"2015-02-27T17:36:48.000Z"`.
    pass_start_utc: start of its pass; UTC. E.g. `"2015-02-27T17:32:46.000Z"`.
    pass_stop_utc: end of its pass; UTC. E.g. `"2015-02-27T17:38:08.000Z"`.
    pass_number: number of its pass, as of `passes`; null of a look chosen anew. E.g. `1`.
    pass_resources: of its pass, `resources`; null of a look chosen anew, or without any.
    value: worth of the look as it was chosen. E.g. `0.9`.
    """

    target: str
    part: Count | None
    carrier: str | None
    plan: str | None
    start_utc: Utc
    stop_utc: Utc
    pass_start_utc: Utc
    pass_stop_utc: Utc
    pass_number: Count | None
    pass_resources: PassResources | None
    value: NotNegative

    @property
    def key(self) -> tuple[str | None, int | None, str, str]:
        """By which looks at one target are the same, to the rows of a table."""
        return self.carrier, self.part, utc_text(self.start_utc, 1), utc_text(self.stop_utc, 1)


@answer
class TargetChange:
    """A target before a revision and after it.

    target: id of the target. E.g. `"Phoenix"`.
    change: `kept`: the same looks; `moved`: as many, but others; `added`: more than before;
    `dropped`: fewer.
    before: looks that it had and has no more.
    now: looks that it has now and had not.
    """

    target: str
    change: Change
    before: tuple[RevisedLook, ...]
    now: tuple[RevisedLook, ...]


@answer
class RevisionFound:
    """A revision: the looks that stayed as they were chosen, and every target's change.

    frozen_until_utc: until when; UTC. E.g. `"2015-02-27T18:00:00.000Z"`.
    frozen: looks of passes that began before it: they stay as they were.
    frozen_value: worth of these, beside the `value` of the looks chosen anew. E.g. `2.4`.
    kept: number of targets with the same looks as before. E.g. `12`.
    moved: number of targets with as many looks, but others. E.g. `3`.
    dropped: number of targets with fewer looks. E.g. `1`.
    added: number of targets with more looks. E.g. `2`.
    targets: the change of every target that had a look or has one now.
    """

    frozen_until_utc: Utc
    frozen: tuple[RevisedLook, ...]
    frozen_value: NotNegative
    kept: Count
    moved: Count
    dropped: Count
    added: Count
    targets: tuple[TargetChange, ...]

    @property
    def next_number(self) -> int:
        """Of the first pass chosen anew, after all that stay."""
        passes = {(look.carrier, look.pass_start_utc) for look in self.frozen}
        return max(
            [
                len(passes),
                *(look.pass_number + 1 for look in self.frozen if look.pass_number is not None),
            ]
        )


@spec
class Revision:
    """The campaign that is revised, and until when it stays as it is.

    frozen_until: passes that begin before it stay as they were chosen, and nothing else begins
    before it; UTC. E.g. `"2015-02-27T18:00:00Z"`.
    looks: those of the campaign before, flown or to be flown. `POST /v1/campaigns` with `revises`,
    the campaign's id, writes them here.
    """

    frozen_until: datetime
    looks: Annotated[tuple[EarlierLook, ...], Field(max_length=BOUNDS.looks_max)]

    def require(self, start: datetime, stop: datetime) -> None:
        """Raises ValueError for a request that can't be revised so."""
        if not 0.0 <= elapsed_s(self.frozen_until, start) < elapsed_s(stop, start):
            raise ValueError(
                f"revises.frozen_until ({utc_text(self.frozen_until)}) must not come before start "
                f"({utc_text(start)}), and must come before stop ({utc_text(stop)})"
            )

    def frozen(self, carriers: Container[str], start: datetime) -> tuple[EarlierLook, ...]:
        """Looks that stay: flown before the start by any carrier, or to be by one of these."""
        return tuple(
            look
            for look in self.looks
            if elapsed_s(look.pass_start, self.frozen_until) < 0.0
            and ((look.carrier or "") in carriers or elapsed_s(look.pass_stop, start) <= 0.0)
        )

    @property
    def past_looks(self) -> tuple[PastLook, ...]:
        """As rules among looks count them."""
        spans = {(look.start, look.stop) for look in self.looks if look.start < look.stop}
        past = tuple(PastLook(start=start, stop=stop) for start, stop in sorted(spans))
        return past[-PastLook.most :]

    def chosen_anew(
        self, requests: "Mapping[str, CampaignRequest]", frozen: Sequence[EarlierLook]
    ) -> "dict[str, CampaignRequest]":
        """What each carrier chooses anew, from where it rests after all that stays.

        Looks begin on the same grid as before.  A carrier without targets or time is left out.
        `revises` of each then holds what stays of its own, all before its start.
        Raises InvalidInput where nothing is left to choose.
        """
        had = Counter(look.target for look in frozen if look.part in _FIRST)
        own: dict[str, list[EarlierLook]] = {}
        for look in frozen:
            own.setdefault(look.carrier or "", []).append(look)
        found = {}
        for carrier, request in requests.items():
            free = [self.frozen_until]
            for look in own.get(carrier, ()):
                free += [look.pass_stop, shifted_utc(look.stop, request.conditions.min_gap_s)]
            free_s = max(0.0, *(elapsed_s(one, request.start) for one in free))
            begin_s = math.ceil(free_s / request.step_s - 1e-9) * request.step_s
            targets = tuple(
                replace(one, looks=one.looks - had[one.id])
                for one in request.targets
                if one.looks > had[one.id]
            )
            if not targets or request.span_s - begin_s < BOUNDS.least_s:
                continue
            begin_q_xyzw, begin_utc = (
                request.initial_q_body_from_eci_xyzw,
                shifted_utc(request.start, begin_s),
            )
            found[carrier] = replace(
                request,
                targets=targets,
                start=begin_utc,
                initial_q_body_from_eci_xyzw=begin_q_xyzw if begin_s == 0.0 else None,
                conditions=replace(request.conditions, duty_cycle=request.duty_cycle),
                revises=replace(self, frozen_until=begin_utc, looks=tuple(own.get(carrier, ()))),
            )
        if not found:
            raise InvalidInput(
                f"{utc_text(self.frozen_until)} leaves nothing to choose: every target has its "
                "looks in passes that stay, or no carrier has time after them; freeze less, add "
                "targets, or let the campaign stop later",
                field="revises.frozen_until",
            )
        return found

    def warnings(self, frozen: Sequence[EarlierLook]) -> list[str]:
        """Of carriers that are gone."""
        stays = set(map(id, frozen))
        gone = {
            look.carrier or "a campaign of one carrier"
            for look in self.looks
            if id(look) not in stays and elapsed_s(look.pass_start, self.frozen_until) < 0.0
        }
        until = utc_text(self.frozen_until)
        return [
            f"passes of {one} that begin before {until} don't stay: no carrier of this request "
            "flies them"
            for one in sorted(gone)
        ]

    def found(self, stays: Sequence[EarlierLook], passes: "Sequence[ChosenPass]") -> RevisionFound:
        """What became of every target.

        stays: the looks frozen.  passes: those chosen anew.
        """
        anew = (_told_anew(look, one) for one in passes for look in one.looks)
        frozen = tuple(_told(look) for look in stays)
        before: dict[str, dict[object, RevisedLook]] = {}
        now: dict[str, dict[object, RevisedLook]] = {}
        for which, looks in ((before, map(_told, self.looks)), (now, (*frozen, *anew))):
            for look in looks:
                which.setdefault(look.target, {})[look.key] = look
        targets = tuple(
            TargetChange(
                target=target,
                change=_change(before.get(target, {}).values(), now.get(target, {}).values()),
                before=_others(before.get(target, {}), now.get(target, {})),
                now=_others(now.get(target, {}), before.get(target, {})),
            )
            for target in dict.fromkeys((*before, *now))
        )
        counts = Counter(one.change for one in targets)
        return RevisionFound(
            frozen_until_utc=self.frozen_until,
            frozen=frozen,
            frozen_value=sum((look.value for look in frozen), 0.0),
            kept=counts["kept"],
            moved=counts["moved"],
            dropped=counts["dropped"],
            added=counts["added"],
            targets=targets,
        )


def _others(
    looks: Mapping[object, RevisedLook], known: Mapping[object, RevisedLook]
) -> tuple[RevisedLook, ...]:
    return tuple(look for key, look in looks.items() if key not in known)


def _change(before: Iterable[RevisedLook], now: Iterable[RevisedLook]) -> Change:
    """Scans of an imaging mode in one pass count as one look."""
    was, is_now = ({one.key for one in looks} for looks in (before, now))
    if was == is_now:
        return "kept"
    had, has = (sum(part in _FIRST for _, part, *_ in keys) for keys in (was, is_now))
    return "added" if has > had else "dropped" if has < had else "moved"


def _told(look: EarlierLook) -> RevisedLook:
    return RevisedLook(
        target=look.target,
        part=look.part,
        carrier=look.carrier or None,
        plan=look.plan,
        start_utc=look.start,
        stop_utc=look.stop,
        pass_start_utc=look.pass_start,
        pass_stop_utc=look.pass_stop,
        pass_number=look.pass_number,
        pass_resources=look.pass_resources,
        value=look.value,
    )


def _told_anew(look: "ChosenLook", flight: "ChosenPass") -> RevisedLook:
    return RevisedLook(
        target=look.target,
        part=look.part,
        carrier=flight.carrier or None,
        plan=None,
        start_utc=look.start_utc,
        stop_utc=look.stop_utc,
        pass_start_utc=flight.start_utc,
        pass_stop_utc=flight.stop_utc,
        pass_number=None,
        pass_resources=None,
        value=look.value,
    )
