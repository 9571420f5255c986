"""Scans of imaging modes: what each mode becomes in every pass, and when its scans may begin."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import NamedTuple, Protocol

import numpy as np

from planner.base.arrays import Array
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.request import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
)
from planner.planning.opportunities.search import found_spans
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
    """

    row: int
    pass_number: int
    part: int
    parts: int
    path: GroundPathTarget
    duration_s: float
    share: float
    begins_s: Array

    @property
    def middle(self) -> GroundTarget:
        """Of its line."""
        return _ground_target(_points_itrf_m(self.path, 3)[1], self.path)

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
        because.pop(row, None)
        lasts_s = sum(line.duration_s for line in lines)
        are_looks = len(lines) > 1 and all(line.start_utc is not None for line in lines)
        for part, line in enumerate(lines, start=1):
            begins_s = span_s
            if are_looks:
                assert line.start_utc is not None
                slack_s = max(line.slack_s, 0.5 * step_s)
                start_s = elapsed_s(line.start_utc, asked.start)
                begins_s = (start_s - slack_s, start_s + slack_s)
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
        for span_s in each
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
        begins_s = scan.begins_s
        for passed_s in np.linspace(0.0, scan.path.duration_s, OPTIONS.points):
            begins_s = _overlaps(begins_s, next(spans) - passed_s)
        yield replace(scan, begins_s=begins_s)


def _view_spans(asked: ScansAsked, places: Sequence[GroundTarget], carrier: Carrier) -> list[Array]:
    """When each place is within all conditions but those of the platform's motion, (k, 2) each."""
    found = [np.empty((0, 2))] * len(places)
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
        for numbers, _, spans, _ in found_spans(search, carrier, math.pi):
            edges_s = np.stack([spans.start_s, spans.stop_s], axis=1)
            for number in np.unique(spans.target).tolist():
                found[first + int(numbers[number])] = edges_s[spans.target == number]
    return found


def _overlaps(one_s: Array, other_s: Array) -> Array:
    """Spans common to both, (k, 2) each."""
    starts_s = np.maximum(one_s[:, None, 0], other_s[None, :, 0]).ravel()
    stops_s = np.minimum(one_s[:, None, 1], other_s[None, :, 1]).ravel()
    return np.stack([starts_s, stops_s], axis=1)[starts_s <= stops_s]


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
