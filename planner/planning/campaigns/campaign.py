"""From targets over days to the sessions of every pass: the whole choice on one screen."""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, fields, replace
from datetime import datetime

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import figures
from planner.base.reporting import Reporter, tell_nobody
from planner.planning.campaigns.candidates import LookCandidate, scan_roll
from planner.planning.campaigns.carrier_looks import (
    CarrierLooks,
    first_utc,
    looks_of_carrier,
    windows_of_carrier,
)
from planner.planning.campaigns.choice import CampaignChoice, bound_at
from planner.planning.campaigns.chosen import (
    ChosenLook,
    UnchosenByAll,
    UnchosenTarget,
    UnseenByAll,
)
from planner.planning.campaigns.displaced import Displaced
from planner.planning.campaigns.exchanges import exchange_looks
from planner.planning.campaigns.fewer_looks import (
    KeptLooks,
    best_views,
    looks_to_keep,
    sees_often,
)
from planner.planning.campaigns.fleet import FleetRequest
from planner.planning.campaigns.flown import resources_left
from planner.planning.campaigns.joined import Joined, joined_of
from planner.planning.campaigns.keeping import bound_keeping, choose_keeping
from planner.planning.campaigns.path import Look
from planner.planning.campaigns.platforms.registry import follower_of
from planner.planning.campaigns.pricing import Ask
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.campaigns.resources import Keeping
from planner.planning.campaigns.revision import PassResources, RevisionFound
from planner.planning.campaigns.stores import begun_with
from planner.planning.opportunities.closing import Unseen
from planner.world.conditions import Conditions
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.resources import Resources
from planner.world.scenario import PastLook, Scenario, Session
from planner.world.targets import ImagingMode


@dataclass(frozen=True, kw_only=True)
class ChosenPass:
    """Looks in order of time, with the platform at rest from start and again by stop.

    carrier: id of the one that flies it; empty where there is but one.  resources: as the passes
    before leave them, where the campaign has any.  held: what they hold then, and at its stop.
    past_looks: of the passes before it, where a rule is among looks.
    """

    carrier: str
    start_utc: datetime
    stop_utc: datetime
    looks: tuple[ChosenLook, ...]
    resources: Resources | None = None
    held: PassResources | None = None
    past_looks: tuple[PastLook, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """Passes in order of time.

    The first may begin on the start, where the platform rests, and the last end on the stop.
    value: what the looks are worth together.  bound: no choice is worth more whose looks
    begin on the grid, have one of the lengths tried and lie in the same passes.
    greedy_value: worth of the choice that takes whatever is worth most in each pass, one pass after
    another.
    windows: number of windows to choose from.
    unseen: targets that can't be looked at for as long as they must.  left_out: that can, but
    others are worth more.
    revision: of one that revises another, what stays, which nothing else here tells of.
    """

    passes: tuple[ChosenPass, ...]
    value: float
    bound: float
    greedy_value: float
    windows: int
    unseen: tuple[Unseen, ...]
    left_out: tuple[UnchosenTarget, ...]
    warnings: tuple[str, ...]
    revision: RevisionFound | None = None

    @property
    def gap_share(self) -> float:
        """How much more than `value` there could be at most, as a share of the bound."""
        return 1.0 - self.value / self.bound if self.bound > 0.0 else 0.0


PricedBy = Callable[[Joined], AbstractContextManager[Ask]]


@contextmanager
def priced_here(joined: Joined) -> Iterator[Ask]:
    """By threads of this process."""
    yield joined.priced_passes.answers


def choose_campaign(
    request: CampaignRequest | FleetRequest, tell: Reporter = tell_nobody
) -> Campaign:
    """Choose sessions and their order.

    tell: is called with what is being done, and how many parts of how many are done.
    Slew times are those of `slew_time`: without hard stops on the way and
    without cones to keep out of, which planning the passes then may find in the way.
    Raises OutsideCoverage, and ResourceRunsOut where a resource does without any look.
    """
    return choose_what_is_asked(request, tell)[1]


def requests_to_choose(
    request: CampaignRequest | FleetRequest,
) -> Mapping[str, CampaignRequest]:
    """For one carrier or several, what each of them is to choose from, by its id.

    What stays of a campaign that is revised is not chosen.
    """
    revises = request.revises
    if revises is None:
        return request.requests
    stays = revises.frozen(request.carrier_ids, request.start)
    requests = revises.chosen_anew(request.requests, stays)
    for carrier, anew in requests.items():
        left = resources_left(request.requests[carrier], anew, request.field_of(carrier, ""))
        requests[carrier] = replace(anew, resources=left)
    return requests


def choose_what_is_asked(
    request: CampaignRequest | FleetRequest,
    tell: Reporter = tell_nobody,
    looks: Mapping[str, CarrierLooks] | None = None,
    priced_by: PricedBy = priced_here,
) -> tuple[Mapping[str, CampaignRequest], Campaign]:
    """`requests_to_choose`, and the choice.

    looks: of each of these, where they are found, as pickle leaves them.  priced_by: where passes
    are priced.  Of what stays of a campaign that is revised only `revision` tells.
    """
    requests = requests_to_choose(request)
    if looks:
        looks = {one: looks[one].completed(own) for one, own in requests.items()}
    found = choose_together(requests, tell, request.field_of, looks, priced_by)
    revises = request.revises
    if revises is None:
        return requests, found
    stays = revises.frozen(request.carrier_ids, request.start)
    return requests, replace(
        found,
        revision=revises.found(stays, found.passes),
        warnings=(*revises.warnings(stays), *found.warnings),
    )


def choose_together(
    requests: Mapping[str, CampaignRequest],
    tell: Reporter = tell_nobody,
    field_of: Callable[[str, str], str] = lambda carrier, field: field,
    looks: Mapping[str, CarrierLooks] | None = None,
    priced_by: PricedBy = priced_here,
) -> Campaign:
    """Choose for several carriers at once, whose targets are the same where their ids are.

    requests: by the carrier's id, alike in all that is no carrier's own and no list of targets.
    field_of: as refusals name it, by the carrier's id.  looks: of each, where they are found.
    Otherwise as `choose_campaign`.
    """
    joined = joined_of(looks) if looks else _joined(requests, tell)
    passes = joined.priced_passes
    is_kept = any(one.is_kept for one in requests.values())
    keeping = Keeping(joined, field_of) if is_kept else None
    proven: dict[bytes, float] = {}

    def prove(price: Array) -> float:
        if (at := price.tobytes()) not in proven:
            proven[at] = bound_at(passes, price, ask=ask)
        return proven[at]

    with priced_by(joined) as ask:
        choice, rows = choose_keeping(keeping, passes, tell, ask=ask, prove=prove)
        choice, left_out = exchange_looks(joined, passes, choice, keeping)
        tell("proof", 0, 1, value=choice.value)
        if keeping is not None and rows:
            bound = bound_keeping(keeping, passes, choice, rows, ask)
        else:
            bound = prove(choice.price)
    bound = max(bound, choice.value)
    tell("proof", 1, 1, value=choice.value, bound=bound)
    candidates = joined.candidates
    looked_at = {candidates[look.target].wanted.id for one in choice.passes for look in one}
    told = _left_out(joined, left_out)
    known = looked_at.union(one.target for one in told)
    return Campaign(
        passes=_in_utc(joined, choice, keeping),
        value=choice.value,
        bound=bound,
        greedy_value=choice.greedy_value,
        windows=sum(len(looks.windows.target) for looks in joined.carriers.values()),
        unseen=_unseen(joined, known),
        left_out=told,
        warnings=tuple(
            dict.fromkeys(
                f"{carrier}: {one}" if carrier else one
                for carrier, looks in joined.carriers.items()
                for one in looks.warnings
            )
        ),
    )


def _joined(requests: Mapping[str, CampaignRequest], tell: Reporter) -> Joined:
    """What each carrier can look at; of several, one stage tells them all."""
    if len(requests) == 1:
        [(carrier, request)] = requests.items()
        return joined_of({carrier: looks_of_carrier(request, tell)})
    found = {}
    for number, (carrier, request) in enumerate(requests.items()):
        tell("opportunities", number, len(requests))
        found[carrier] = windows_of_carrier(request, modes_by_pass=True)
    kept: Sequence[KeptLooks | tuple[()]] = [()] * len(found)
    if sees_often(requests):
        kept = looks_to_keep([best_views(one) for one in found.values()])
    return joined_of(
        {
            carrier: one.with_looks(tell_nobody, *own)
            for (carrier, one), own in zip(found.items(), kept, strict=True)
        }
    )


def scenario_of(request: CampaignRequest, flight: ChosenPass, number: int) -> Scenario:
    """The pass as it is to be planned: from rest over all observations to rest.

    What a slew lacks, its neighbours give where none of them scans: slew times were estimated
    without stops.
    """
    ends = follower_of(request).pass_ends(
        flight.start_utc, flight.stop_utc, is_first=flight.start_utc == first_utc(request)
    )
    told_number = f"pass {number + 1}"
    return Scenario(
        name=", ".join(filter(None, (request.name or "campaign", flight.carrier, told_number))),
        orbit=request.orbit,
        attitude=ends.attitude,
        platform=request.platform,
        initial_state=replace(ends.initial_state, past_looks=flight.past_looks),
        sessions=(
            *(_session_of(request, look) for look in flight.looks),
            *ends.rest,
        ),
        slew=ends.slew,
        # What a slew took from a scan would be missing from its line.
        on_conflict="refuse" if any(look.path for look in flight.looks) else "least_loss",
        final_state=ends.final_state,
        final_by=ends.final_by,
        conditions=_conditions_of(request),
        resources=flight.resources,
    )


def _conditions_of(request: CampaignRequest) -> Conditions:
    """Of a plan, whose pixel is that of the platform's camera."""
    asked = request.conditions
    kept = {field.name: getattr(asked, field.name) for field in fields(Conditions)}
    kept["duty_cycle"] = request.duty_cycle
    if asked.max_ground_sample_m is not None:
        pixel_ratio = request.platform.camera.pixel_rad / request.opportunities().pixel_rad
        kept["max_ground_sample_m"] = asked.max_ground_sample_m * pixel_ratio
    return Conditions(**kept)


def _session_of(request: CampaignRequest, look: ChosenLook) -> Session:
    wanted = request.targets[look.row]
    if look.path is None:
        assert not isinstance(wanted.target, ImagingMode)
        return Session(
            id=look.target,
            target=wanted.target.with_heights(),
            start=look.start_utc,
            stop=look.stop_utc,
            roll=wanted.roll,
        )
    is_alone = look.parts == 1
    return Session(
        id=look.target if is_alone else f"{look.target}-{look.part}",
        name=None if is_alone else f"{look.target} {look.part}/{look.parts}",
        target=look.path.with_heights(),
        start=look.start_utc,
        stop=look.stop_utc,
        roll=scan_roll(request, wanted),
        of=look.target,
    )


def _unseen(joined: Joined, known: Set[str]) -> tuple[Unseen, ...]:
    """Of targets that nobody can look at, by the carrier that comes nearest to it: one that has
    windows, or else that stands highest in its sky."""
    rows: dict[str, dict[str, int]] = {one: {} for one in joined.ids if one not in known}
    for carrier, looks in joined.carriers.items():
        for row, wanted in enumerate(looks.request.targets):
            if wanted.id in rows:
                rows[wanted.id][carrier] = row
    for own in rows.values():
        in_view = [one for one, row in own.items() if joined.carriers[one].has_windows(row)]
        for carrier in set(own).difference(in_view) if in_view else ():
            del own[carrier]
    nearest = _nearest(joined, rows)
    told: dict[str, Unseen] = {}
    for carrier, looks in joined.carriers.items():
        own_rows = [rows[one][carrier] for one, other in nearest.items() if other == carrier]
        for one in looks.unseen(own_rows):
            told[one.target] = UnseenByAll(**vars(one), carrier=carrier) if carrier else one
    return tuple(told[one] for one in rows)


def _nearest(joined: Joined, rows: Mapping[str, Mapping[str, int]]) -> Mapping[str, str]:
    """Of each target the carrier that stands highest in its sky, of those with a row for it."""
    nearest = {one: next(iter(own)) for one, own in rows.items()}
    best_rad = dict.fromkeys(rows, -math.inf)
    for carrier, looks in joined.carriers.items():
        targets = [one for one, own in rows.items() if carrier in own and len(own) > 1]
        highest_rad = looks.highest_rad([rows[one][carrier] for one in targets])
        for one, high_rad in zip(targets, highest_rad, strict=True):
            if high_rad > best_rad[one]:
                best_rad[one], nearest[one] = high_rad, carrier
    return nearest


def _left_out(joined: Joined, left_out: Sequence[Displaced]) -> tuple[UnchosenTarget, ...]:
    """Of each target, by the scan of it that comes first."""
    group = joined.looking.group
    unseen = [n for n in range(len(joined.candidates)) if n not in joined.seen]
    partial = {int(group[n]) for n in unseen if joined.candidates[n].is_part}
    told: dict[str, UnchosenTarget] = {}
    for one in left_out:
        candidate = joined.candidates[one.look.target]
        if candidate.is_part and int(group[one.look.target]) in partial:
            continue
        if candidate.wanted.id not in told:
            told[candidate.wanted.id] = _unchosen(joined, one, unseen)
    return tuple(told[one] for one in joined.ids if one in told)


def _unchosen(joined: Joined, one: Displaced, unseen: Sequence[int]) -> UnchosenTarget:
    candidates, looks = joined.candidates, joined.looks_at(one.pass_number)
    candidate, out = candidates[one.look.target], one.out
    request = looks.request
    start_utc = shifted_utc(request.start, looks.grid_s + one.look.first_step * request.step_s)
    group = candidate.wanted.group
    lacks = [
        candidates[number].wanted.id
        for number in (() if group is None else unseen)
        if candidates[number].wanted.group == group
    ]
    by = () if lacks else one.by  # without these its group would lack as much
    ids = tuple(dict.fromkeys(candidates[look.target].wanted.id for look in by))
    displaced_value = sum((look.value for look in by), 0.0)
    what = "a look"
    if out is not None:
        what = f"a scan of {candidate.scans[0].parts}" if candidate.is_part else what
        at_utc = utc_text(shifted_utc(request.start, out.at_s), 1)
        why = "but " if group is None else f"but with all of its group {group} "
        why += f"{out.told} at {at_utc}, in the end by {figures(out.short_value)} {out.unit}"
        why += f"; looks at it tried: {one.tried}" if one.tried else ""
    elif group is not None and lacks:
        why = f"but its group {group} lacks {', '.join(lacks)}"
    elif group is not None:
        why = f"but no sequence with all of its group {group} was found that is worth more"
    elif candidate.is_part:
        if candidate.scans[0].parts > 1:
            what = f"its scan {candidate.scans[0].part} of {candidate.scans[0].parts}"
        why = "but no sequence with all of its scans was found that is worth more"
    elif ids:
        why = f"and what it displaces, {', '.join(ids)}, is worth {displaced_value:.4g}"
    elif one.look.value <= 0.0:
        why = "and no other view of it is worth more, as `view` weighs them"
    else:
        why = "but no sequence with it was found that is worth more"
    told = UnchosenTarget(
        row=candidate.row,
        target=candidate.wanted.id,
        because=f"{what} from {utc_text(start_utc, 1)} would be worth {one.look.value:.4g}, {why}",
        start_utc=start_utc,
        stop_utc=shifted_utc(start_utc, candidate.lengths_s[one.look.length]),
        value=one.look.value,
        displaced_by=ids,
        displaced_value=displaced_value,
        lacks=None if out is None else out.name,
    )
    carrier = joined.carrier_id(one.pass_number)
    return UnchosenByAll(**vars(told), carrier=carrier) if carrier else told


def _in_utc(
    joined: Joined, choice: CampaignChoice, keeping: Keeping | None
) -> tuple[ChosenPass, ...]:
    """Passes with looks in order of time."""
    flown: dict[int, ChosenPass] = {}
    for place, (carrier, looks) in enumerate(joined.carriers.items()):
        own = [n for n in range(len(choice.passes)) if joined.carrier_id(n) == carrier]
        own = [n for n in own if choice.passes[n]]
        passes = [choice.passes[n] for n in own]
        held = [None] * len(own) if keeping is None else keeping.held(place, choice.passes)
        found = _passes_of(carrier, looks, joined.candidates, passes, held)
        flown |= dict(zip(own, found, strict=True))
    return tuple(flown[number] for number in sorted(flown))


def _passes_of(
    carrier: str,
    looks: CarrierLooks,
    candidates: Sequence[LookCandidate],
    passes: Sequence[Sequence[Look]],
    held: Sequence[PassResources | None],
) -> Iterator[ChosenPass]:
    request = looks.request
    row_of = {wanted.id: row for row, wanted in enumerate(request.targets)}
    chosen = [look for one in passes for look in one]
    start_s = np.array([looks.grid_s + look.first_step * request.step_s for look in chosen])
    length_s = np.array([candidates[look.target].lengths_s[look.length] for look in chosen])
    target = np.array([look.target for look in chosen], np.intp)
    pixel_rad = request.opportunities().pixel_rad
    views = looks.viewing.seen(
        looks.carrier, candidates, target, start_s + 0.5 * length_s, pixel_rad
    )
    pending = iter(
        [
            ChosenLook(
                row=row_of[one.wanted.id],
                path=None if scan is None else scan.path,
                target=one.wanted.id,
                part=None if scan is None else scan.part,
                parts=None if scan is None else scan.parts,
                start_utc=shifted_utc(request.start, begin_s),
                stop_utc=shifted_utc(shifted_utc(request.start, begin_s), lasts_s),
                value=look.value,
                # Where it is 1, the quotient may round up.
                quality=min(look.value / one.worth_value(lasts_s), 1.0),
                **vars(seen),
            )
            for one, look, begin_s, lasts_s, seen in zip(
                [candidates[look.target] for look in chosen],
                chosen,
                start_s.tolist(),
                length_s.tolist(),
                views,
                strict=True,
            )
            for scan in [one.scan_at(begin_s) if one.scans else None]
        ]
    )
    has_rules = bool(request.conditions.min_gap_s or request.conditions.duty_cycle)
    past = request.revises.past_looks if has_rules and request.revises else ()
    for one, own in zip(passes, held, strict=True):
        flown = tuple(itertools.islice(pending, len(one)))
        begins_s, ends_s = looks.pass_span_s(
            elapsed_s(flown[0].start_utc, request.start),
            elapsed_s(flown[-1].stop_utc, request.start),
        )
        yield ChosenPass(
            carrier=carrier,
            start_utc=shifted_utc(request.start, begins_s),
            stop_utc=shifted_utc(request.start, ends_s),
            looks=flown,
            resources=begun_with(request.resources, own) if own and request.resources else None,
            held=own,
            past_looks=past,
        )
        if has_rules:
            past += tuple(PastLook(start=look.start_utc, stop=look.stop_utc) for look in flown)
            past = past[-PastLook.most :]
