"""Ground track, Sun and eclipses of an orbit over days."""

import math
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

import numpy as np

from planner.base.answer_members import Times, answer
from planner.base.arrays import Array
from planner.base.interpolation import NODES, UniformTable
from planner.base.spec import Within, spec
from planner.output.view.carrier import above_limb_rad, body_track, carrier_track
from planner.output.view.columns import BodyTrack, CarrierTrack
from planner.output.view.scene import CarrierScene
from planner.world.frames.time_scales import DAY_S, Instants, Utc, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Orbit


@dataclass(frozen=True, kw_only=True)
class OrbitTrackOptions:
    """How closely an orbit is looked at, and how long at most."""

    shadow_step_s: float = 30.0  # half the shortest eclipse that is sure to be noticed
    edge_step_s: float = 1.0  # the Sun's height over it is straight to a millisecond
    days_max: float = 31.0  # as of a search for windows
    rows_max: int = 45_000  # 31 days of a row a minute


OPTIONS = OrbitTrackOptions()


@spec
class OrbitTrackRequest:
    """An orbit, and the time over which its ground track is wanted.

    start: start of that time; UTC.
    stop: end of that time; UTC.
    step_s: time between rows.
    """

    orbit: Orbit
    start: datetime
    stop: datetime
    step_s: Annotated[float, Within(1.0, 3600.0)] = 60.0

    def __post_init__(self) -> None:
        span_s = elapsed_s(self.stop, self.start)
        if span_s < 1.0:
            raise ValueError(
                f"stop ({utc_text(self.stop)}) must come a second or more after start "
                f"({utc_text(self.start)})"
            )
        if span_s > OPTIONS.days_max * DAY_S:
            raise ValueError(
                f"stop must come within {OPTIONS.days_max:.0f} days of start, not "
                f"{span_s / DAY_S:.1f}"
            )
        if span_s / self.step_s > OPTIONS.rows_max:
            raise ValueError(
                f"step_s must be at least {math.ceil(span_s / OPTIONS.rows_max)}, as there are at "
                f"most {OPTIONS.rows_max} rows, not {self.step_s:g}"
            )


@answer
class Eclipse:
    """A stretch of time over which the Earth hides the Sun's centre from the carrier.

    start_utc: its start, or that of the time asked for; UTC.
    stop_utc: its end, or that of the time asked for; UTC.
    """

    start_utc: Utc
    stop_utc: Utc


@answer
class OrbitTrack:
    """The carrier over some days, and the Sun.

    start_utc: time of row 0; UTC.
    t_s: of each row, since then.
    eclipses: without refraction, to the second; one of less than a minute may be missed.
    warnings: cautions to read before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the farthest instant asked for"]`.
    """

    start_utc: Utc
    t_s: Times
    carrier: CarrierTrack
    sun: BodyTrack
    eclipses: tuple[Eclipse, ...]
    warnings: tuple[str, ...]


def track_orbit(request: OrbitTrackRequest) -> OrbitTrack:
    """Raises OutsideCoverage."""
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    span_s = elapsed_s(request.stop, request.start)

    def scene_at(t_s: Array) -> CarrierScene:
        instants = Instants(request.start, t_s)
        return CarrierScene(instants=instants, states=ephemeris.states(instants))

    t_s = np.append(np.arange(0.0, span_s - 1e-3, request.step_s), span_s)
    cells = max(math.ceil(span_s / OPTIONS.shadow_step_s), NODES - 1)
    node_s, step_s = np.linspace(0.0, span_s, cells + 1, retstep=True)
    above = UniformTable(float(step_s), above_limb_rad(scene_at(node_s), "sun")[:, None])
    scene = scene_at(t_s)
    return OrbitTrack(
        start_utc=request.start,
        t_s=np.round(t_s, 3),
        carrier=carrier_track(scene),
        sun=body_track(scene, "sun"),
        eclipses=tuple(
            Eclipse(
                start_utc=shifted_utc(request.start, start_s),
                stop_utc=shifted_utc(request.start, stop_s),
            )
            for start_s, stop_s in _below_zero_s(above, span_s)
        ),
        warnings=ephemeris.warnings,
    )


def _below_zero_s(above: UniformTable, span_s: float) -> list[tuple[float, float]]:
    """The stretches over which a table's only column is negative."""
    fine_s = np.linspace(0.0, span_s, math.ceil(span_s / OPTIONS.edge_step_s) + 1)
    value = above.at(fine_s)[:, 0]
    [edge] = np.nonzero((value[1:] < 0.0) != (value[:-1] < 0.0))
    share = value[edge] / (value[edge] - value[edge + 1])
    edge_s = (fine_s[edge] + share * (fine_s[edge + 1] - fine_s[edge])).tolist()
    if value[0] < 0.0:
        edge_s.insert(0, 0.0)
    if value[-1] < 0.0:
        edge_s.append(span_s)
    return list(zip(edge_s[::2], edge_s[1::2], strict=True))
