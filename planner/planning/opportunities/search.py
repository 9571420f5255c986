"""The search for opportunities, from the request to its windows."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from planner.base import effort
from planner.base.arrays import Array, Indices
from planner.base.effort import at_most
from planner.base.errors import SearchEnded
from planner.planning.opportunities.carrier import Carrier, carrier_over
from planner.planning.opportunities.conditions import Condition, conditions_of
from planner.planning.opportunities.description import describe_windows
from planner.planning.opportunities.request import OpportunityRequest
from planner.planning.opportunities.sights import (
    EarthSight,
    FixedPlaces,
    Sight,
    resting_places,
    sight_of,
)
from planner.planning.opportunities.spans import Margin, Nodes, Spans, nodes_over, stretches
from planner.planning.opportunities.trackable_spans import held_parts
from planner.planning.opportunities.windows import Cause, Opportunities, in_order
from planner.world.attitude.lvlh import level_warnings
from planner.world.frames.earth_orientation import earth_orientation_warnings
from planner.world.frames.time_scales import Instants
from planner.world.targets import EarthFixedTarget


@dataclass(frozen=True, kw_only=True)
class WindowSearchOptions:
    """How windows are found between the rows of the carrier's table."""

    batch_cells: int = 3_000_000  # targets times rows compared at a time: some 50 MB in all
    shortest_s: float = 1e-3  # the resolution promised of an edge
    plumb_rad: float = 0.0034  # geodetic against geocentric vertical: 0.1924 deg at most
    # what single precision leaves of an angle's cosine, at its worst near 0
    single_rad: float = 1e-3
    beyond: int = 2  # rows, so that a pass at the end of the span still shows three
    sample_rows: float = 0.45  # work of a reported sample, in rows


OPTIONS = WindowSearchOptions()


@dataclass(frozen=True)
class SearchWork:
    """What is spent, in rows of `effort`, to look once whether a target can be seen, and
    to find a window's extremes."""

    look_rows: float
    window_rows: float


RESTING = SearchWork(look_rows=0.13, window_rows=1.2)  # many places together
ALONE = SearchWork(look_rows=3.3, window_rows=440.0)  # frames and ephemerides at every look


def find_opportunities(request: OpportunityRequest) -> Opportunities:
    """All windows of all targets, by no more work than one request may make.

    The orbit is evaluated once, on rows 0.066 rad of its motion apart (60 s for the ISS);
    fixed ground targets are compared with the rows all together.  Edges and extremes are then
    found for many at once, on polynomials through the rows.  Edges are those of the exact
    orbit and frames to 0.1 ms, where the margin changes by its ordinary rate; windows or gaps
    shorter than a millisecond may be missed.
    Raises OutsideCoverage where orbit, attitude or Earth orientation are not known, SearchEnded.
    """
    with at_most(effort.PLAN):
        return opportunities_however_many(request)
    raise SearchEnded(
        f"the windows of these {len(request.targets)} targets take more work than one request may "
        "make; ask for fewer targets, days, samples or conditions at a time",
        field="targets",
    )


def opportunities_however_many(request: OpportunityRequest) -> Opportunities:
    """Search with whatever work that takes."""
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    carrier = carrier_over(
        ephemeris, request.attitude, request.platform, request.start, request.stop
    )
    found = []
    for numbers, sight, spans, work in found_spans(request, carrier):
        charge_for(spans, work, request.samples)
        held_s = held_parts(request.platform, sight, spans, work.look_rows)
        found.append(describe_windows(request, sight, numbers, spans, held_s))
    ends = Instants(request.start, np.array([0.0, carrier.span_s]))
    return Opportunities(
        start_utc=request.start,
        stop_utc=request.stop,
        ids=tuple(wanted.id for wanted in request.targets),
        axis_names=request.platform.axis_names,
        assumed=request.assumed,
        warnings=(
            *ephemeris.warnings,
            *level_warnings(request.attitude, request.platform),
            *request.attitude.warnings_at(ends),
            *earth_orientation_warnings(ends),
        ),
        windows=in_order(found),
    )


def found_spans(
    request: OpportunityRequest,
    carrier: Carrier,
    more: Callable[[Sight], Iterable[Condition]] = lambda _: (),
) -> Iterator[tuple[Indices, Sight, Spans, SearchWork]]:
    """When all conditions hold, for targets that are treated alike: their rows in the request, how
    they are seen, the spans by their number among these, and the work of one window more.

    more: conditions beside the request's.
    """
    for numbers, sight, nodes, work in _sight_batches(request, carrier):
        conditions = chain(conditions_of(request.conditions, request.platform, sight), more(sight))
        yield numbers, sight, _find_windows(request, conditions, sight, nodes, work), work


def charge_for(spans: Spans, work: SearchWork, samples: int) -> None:
    """The work of describing windows."""
    effort.charge((work.window_rows + OPTIONS.sample_rows * samples) * len(spans.target))


def _sight_batches(
    request: OpportunityRequest, carrier: Carrier
) -> Iterator[tuple[Indices, Sight, Nodes, SearchWork]]:
    """Rows of the request's targets that are treated alike, and where to look for them."""
    asked_rad = math.radians(request.conditions.min_elevation_deg)
    targets = [wanted.target for wanted in request.targets]
    resting = resting_places(targets)
    size = max(1, OPTIONS.batch_cells // len(carrier.node_s))
    for first in range(0, len(resting), size):
        numbers = list(resting)[first : first + size]
        places = FixedPlaces(carrier, [resting[number] for number in numbers])
        least_rad = np.array([_least_rad(resting[number], asked_rad) for number in numbers])
        nodes = _candidate_nodes(carrier, places.r_itrf_m, least_rad)
        yield np.array(numbers), EarthSight(carrier, places, least_rad), nodes, RESTING
    everywhere = Nodes(np.zeros(1, int), np.zeros(len(carrier.node_s), int), carrier.node_s)
    for number, target in enumerate(targets):
        if number not in resting:
            sight = sight_of(carrier, target, _least_rad(target, asked_rad))
            yield np.array([number]), sight, everywhere, ALONE


def _candidate_nodes(carrier: Carrier, r_target_itrf_m: Array, min_elevation_rad: Array) -> Nodes:
    """Rows of the orbit around every instant at which the carrier may stand high enough.

    r_target_itrf_m: (k, 3), at rest.  Each group of nodes reaches two rows beyond both
    ends of visibility, or to the end of the span.  The Earth's central angle to a carrier at
    distance r, seen at elevation e from distance R, is acos(R cos e / r) - e.
    """
    r_sat_m = carrier.r_sat_itrf_m.at(carrier.node_s)
    distance_m = np.linalg.norm(r_sat_m, axis=1)
    ground_m = np.linalg.norm(r_target_itrf_m, axis=1)
    least_rad = min_elevation_rad - OPTIONS.plumb_rad
    cosine = np.minimum(ground_m * np.cos(least_rad) / distance_m.max(), 1.0)
    step_s = carrier.node_s[1] - carrier.node_s[0]
    between_rad = 0.5 * step_s * carrier.turn_max_rad_s
    central_rad = np.arccos(cosine) - least_rad + between_rad + OPTIONS.single_rad

    to_sat = (r_sat_m / distance_m[:, None]).astype(np.float32)
    to_target = (r_target_itrf_m / ground_m[:, None]).astype(np.float32)
    near = to_target @ to_sat.T > np.cos(np.minimum(central_rad, np.pi))[:, None].astype(np.float32)
    wider = near.copy()
    for rows in range(1, OPTIONS.beyond + 1):
        wider[:, rows:] |= near[:, :-rows]
        wider[:, :-rows] |= near[:, rows:]
    target, row = np.divmod(np.flatnonzero(wider), wider.shape[1])
    begins = np.append(True, (target[1:] != target[:-1]) | (row[1:] != row[:-1] + 1))
    begins = begins[: len(target)]
    return Nodes(target=target[begins], group=np.cumsum(begins) - 1, t_s=carrier.node_s[row])


def _least_rad(target: object, asked_rad: float) -> float:
    """The greater of the request's least elevation and the target's own."""
    own_deg = target.min_elevation_deg if isinstance(target, EarthFixedTarget) else 0.0
    return max(math.radians(own_deg), asked_rad)


def _find_windows(
    request: OpportunityRequest,
    conditions: Iterable[Condition],
    sight: Sight,
    nodes: Nodes,
    work: SearchWork,
) -> Spans:
    """When all conditions hold, condition after condition."""
    interval = np.full(len(nodes.target), "interval")
    spans = _spans_holding(sight.clearance_rad, nodes, "elevation", interval, interval, work)
    for condition in conditions:
        nodes = nodes_over(spans, sight, condition.step_s, condition.turn_rad)
        if condition.more_nodes is not None:
            nodes = condition.more_nodes(nodes)
            effort.charge(work.look_rows * len(nodes.t_s))
        edges = spans.opened_by, spans.closed_by
        spans = _spans_holding(condition.margin, nodes, condition.cause, *edges, work)
    least_s = max(request.conditions.min_duration_s, OPTIONS.shortest_s)
    return spans.select(spans.stop_s - spans.start_s >= least_s)


def _spans_holding(
    margin: Margin,
    nodes: Nodes,
    cause: Cause,
    opened_by: NDArray[np.str_],
    closed_by: NDArray[np.str_],
    work: SearchWork,
) -> Spans:
    """Where a margin holds; opened_by, closed_by: what makes the ends of each group of nodes."""
    effort.charge(work.look_rows * len(nodes.t_s))
    inside = stretches(margin, nodes)
    return Spans(
        target=nodes.target[inside.group],
        start_s=inside.start_s,
        stop_s=inside.stop_s,
        opened_by=np.where(inside.from_first, opened_by[inside.group], cause),
        closed_by=np.where(inside.to_last, closed_by[inside.group], cause),
    )
