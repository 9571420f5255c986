"""Scans of imaging modes: what each mode becomes in every pass, and when its scans may begin."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.request import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
)
from planner.planning.opportunities.search import found_edges
from planner.world.attitude import Attitude
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Orbit
from planner.world.platforms import AnyPlatform
from planner.world.targets import GroundPathTarget, GroundTarget, ImagingMode, ScanWindow


@dataclass(frozen=True, kw_only=True)
class ScanOptions:
    """How passes over imaging modes are told apart, and how their lines are looked at."""

    passes_apart_s: float = 1800.0  # a low orbit lasts an hour and a half
    beside_s: float = 60.0  # of a pass: a line may come into view before its mode's positions
    points: int = 5  # of a line: angles of view are greatest at its ends, or nearly
    points_at_once: int = 300  # of one search, whose work is bounded


OPTIONS = ScanOptions()


class ScansAsked(Protocol):
    """What a search for windows and a campaign ask alike."""

    @property
    def platform(self) -> AnyPlatform: ...
    @property
    def orbit(self) -> Orbit: ...
    @property
    def attitude(self) -> Attitude | None: ...
    @property
    def start(self) -> datetime: ...
    @property
    def stop(self) -> datetime: ...
    @property
    def conditions(self) -> OpportunityConditions: ...
    @property
    def pixel_arcsec(self) -> float | None: ...


@dataclass(frozen=True, kw_only=True, eq=False)
class ModeScan:
    """One scan of a mode in one pass.

    row: of the modes.  pass_number: counts passes of all modes.  part, parts: from 1, of how many.
    share: of the time that the mode is scanned.  begins_s: spans in which the line of sight is
    within all conditions from a scan's begin to its end, (k, 2), since the start of what is asked.
    causes: what makes their edges, as `WindowEdges` has it, (k, 2).
    """

    row: int
    pass_number: int
    part: int
    parts: int
    path: GroundPathTarget
    duration_s: float
    share: float
    begins_s: Array
    causes: NDArray[np.str_]

    @property
    def middle(self) -> GroundTarget:
        """Of its line."""
        return middle_of(self.path)

    def apart_s(self, begin_s: float) -> float:
        """How long before or after the spans in which it can begin."""
        before_s, after_s = (self.begins_s - begin_s).T
        return float(np.maximum(np.maximum(before_s, -after_s), 0.0).min(initial=math.inf))


class Scans(NamedTuple):
    """Scans of modes, and why others have none, by row."""

    found: tuple[ModeScan, ...]
    because: Mapping[int, str]


def scans_by_pass(
    asked: ScansAsked, modes: Mapping[int, ImagingMode], carrier: Carrier, step_s: float
) -> Scans:
    """Every mode's scans in every pass in which all of its positions come into view.

    modes: by row.  step_s: starts that are given are moved by half of it at least.
    Neglected: what the motion of a scan asks of the platform, and how it lies on the line.
    Raises OutsideCoverage.
    """
    laid: list[ModeScan] = []
    because = dict.fromkeys(modes, "no pass brings all of it into view")
    passes = 0
    for row, span_s in _passes(asked, modes, carrier):
        window = modes[row].in_pass(
            ScanWindow(
                orbit=asked.orbit,
                scanning=asked.platform.scanning,
                start_utc=shifted_utc(asked.start, span_s[0]),
                stop_utc=shifted_utc(asked.start, span_s[1]),
            )
        )
        try:
            lines = modes[row].scans(window)
        except ValueError as error:
            because[row] = f"in the pass from {utc_text(window.start_utc, 1)}: {error}"
            continue
        lasts_s = sum(line.duration_s for line in lines)
        duty, longest_s = asked.conditions.duty_cycle, max(line.duration_s for line in lines)
        if duty is not None and longest_s > duty.imaging_max_s:
            because[row] = (
                f"in the pass from {utc_text(window.start_utc, 1)}: a scan lasts {longest_s:.1f} "
                f"s, longer than the {duty.imaging_max_s:g} s of duty_cycle"
            )
            continue
        because.pop(row, None)
        are_looks = len(lines) > 1 and all(line.start_utc is not None for line in lines)
        for part, line in enumerate(lines, start=1):
            # The line itself says from when to when, not the positions of all lines.
            begins_s = span_s[0] - OPTIONS.beside_s, span_s[1] + OPTIONS.beside_s
            cause = "interval"
            if are_looks:
                assert line.start_utc is not None
                slack_s = max(line.slack_s, 0.5 * step_s)
                start_s = elapsed_s(line.start_utc, asked.start)
                begins_s, cause = (start_s - slack_s, start_s + slack_s), "look"
            laid.append(
                ModeScan(
                    row=row,
                    pass_number=passes,
                    part=part,
                    parts=len(lines),
                    path=line.target,
                    duration_s=line.duration_s,
                    share=line.duration_s / lasts_s,
                    begins_s=np.array([begins_s]),
                    causes=np.array([(cause, cause)]),
                )
            )
        passes += 1
    return Scans(tuple(_within_conditions(asked, laid, carrier)), because)


def _passes(
    asked: ScansAsked, modes: Mapping[int, ImagingMode], carrier: Carrier
) -> Iterator[tuple[int, tuple[float, float]]]:
    """Row of a mode, and from when to when some of its positions are in view, all at some time."""
    owner, places = [], []
    for row, mode in modes.items():
        for longitude_deg, latitude_deg, *_ in {place for line in mode.lines for place in line}:
            owner.append(row)
            places.append(
                GroundTarget(
                    latitude_deg=float(latitude_deg),
                    longitude_deg=math.remainder(longitude_deg, 360.0),
                    height_m=mode.height_m,
                    min_elevation_deg=mode.min_elevation_deg,
                )
            )
    spans = [
        (row, place, *span_s)
        for place, (row, each) in enumerate(
            zip(owner, _view_spans(asked, places, carrier), strict=True)
        )
        for span_s in each.spans_s
    ]
    for row in modes:
        own = np.array(sorted(one[1:] for one in spans if one[0] == row), float).reshape(-1, 3)
        own = own[np.argsort(own[:, 1], kind="stable")]
        latest_s = np.maximum.accumulate(own[:, 2])
        apart = np.flatnonzero(own[1:, 1] > latest_s[:-1] + OPTIONS.passes_apart_s) + 1
        for one in np.split(own, apart):
            if len(one) and len(set(one[:, 0])) == owner.count(row):
                yield row, (float(one[:, 1].min()), float(one[:, 2].max()))


def _within_conditions(
    asked: ScansAsked, scans: Sequence[ModeScan], carrier: Carrier
) -> Iterator[ModeScan]:
    """The scans, begun only where points along each are in view as they are passed."""
    points = [
        _ground_target(r_itrf_m, scan.path)
        for scan in scans
        for r_itrf_m in _points_itrf_m(scan.path, OPTIONS.points)
    ]
    spans = iter(_view_spans(asked, points, carrier))
    for scan in scans:
        begins = _EdgedSpans(scan.begins_s, scan.causes)
        for passed_s in np.linspace(0.0, scan.path.duration_s, OPTIONS.points):
            seen = next(spans)
            begins = _overlaps(begins, seen._replace(spans_s=seen.spans_s - passed_s))
        yield replace(scan, begins_s=begins.spans_s, causes=begins.causes)


class _EdgedSpans(NamedTuple):
    """Spans since the start of what is asked, and what makes their edges, (k, 2) each."""

    spans_s: Array
    causes: NDArray[np.str_]


def _view_spans(
    asked: ScansAsked, places: Sequence[GroundTarget], carrier: Carrier
) -> list[_EdgedSpans]:
    """When each place is within all conditions but those of the platform's motion."""
    found = [_EdgedSpans(np.empty((0, 2)), np.empty((0, 2), np.str_))] * len(places)
    for first in range(0, len(places), OPTIONS.points_at_once):
        part = places[first : first + OPTIONS.points_at_once]
        search = OpportunityRequest(
            platform=asked.platform,
            orbit=asked.orbit,
            attitude=asked.attitude,
            targets=tuple(
                OpportunityTarget(id=str(number), target=place) for number, place in enumerate(part)
            ),
            start=asked.start,
            stop=asked.stop,
            conditions=replace(asked.conditions, min_duration_s=0.0),
            samples=2,
            pixel_arcsec=asked.pixel_arcsec,
        )
        for _, _, edges in found_edges(search, carrier, math.pi):
            edges_s = np.stack([edges.rise_s, edges.set_s], axis=1)
            causes = np.stack([edges.opened_by, edges.closed_by], axis=1)
            for number in np.unique(edges.target).tolist():
                own = edges.target == number
                found[first + number] = _EdgedSpans(edges_s[own], causes[own])
    return found


def _overlaps(one: _EdgedSpans, other: _EdgedSpans) -> _EdgedSpans:
    """Spans common to both."""
    one_s, other_s = one.spans_s[:, None], other.spans_s[None]
    # The later start and the sooner stop.
    is_others = (other_s - one_s) * np.array([1.0, -1.0]) >= 0.0
    spans_s = np.where(is_others, other_s, one_s).reshape(-1, 2)
    causes = np.where(is_others, other.causes[None], one.causes[:, None]).reshape(-1, 2)
    is_span = spans_s[:, 0] <= spans_s[:, 1]
    return _EdgedSpans(spans_s[is_span], causes[is_span])


def middle_of(path: GroundPathTarget) -> GroundTarget:
    """Of a line, as a place."""
    return _ground_target(_points_itrf_m(path, 3)[1], path)


def _points_itrf_m(path: GroundPathTarget, count: int) -> Array:
    """Evenly along the line, (count, 3)."""
    any_utc = datetime(2000, 1, 1, tzinfo=UTC)
    at = Instants(any_utc, np.linspace(0.0, path.duration_s, count))
    return path.starting(any_utc).r_target_itrf_m(at)


def _ground_target(r_itrf_m: Array, path: GroundPathTarget) -> GroundTarget:
    latitude_rad, longitude_rad, height_m = geodetic_from_itrf(r_itrf_m)
    return GroundTarget(
        latitude_deg=math.degrees(latitude_rad),
        longitude_deg=math.degrees(longitude_rad),
        height_m=float(height_m),
        min_elevation_deg=path.min_elevation_deg,
    )
