"""A request for opportunities of the imaging spacecraft: an orbit, what may be imaged, and when."""

from datetime import datetime
from typing import Annotated

from pydantic import FailFast, Field

from planner.base.assumed import Assumed
from planner.base.spec import Within, spec
from planner.planning.opportunities.request import (
    BOUNDS as BOUNDS,
)
from planner.planning.opportunities.request import (
    OpportunityConditions,
)
from planner.spacecraft.requests import AreaRequest, Request, SpacecraftSettings
from planner.spacecraft.vehicle.definition import SPACECRAFT, AgileSpacecraft
from planner.world.frames.time_scales import DAY_S, elapsed_s, utc_text
from planner.world.orbits import Orbit
from planner.world.targets.geojson import Position

REQUESTS_MAX = 1000


@spec
class ImagingOpportunityRequest:
    """An orbit, the spacecraft on it, and what it may image from `start` to `stop`.

    The camera looks from orbital orientation, by the angles along and across the track that the
    settings have.

    name: your name for it, shown in lists.
    spacecraft: by its registered name.
    requests: the requests to be imaged, as in a plan; `window_start`, `window_stop` and `start`
    count.
    start: start of the search; UTC.
    stop: end of the search; UTC.
    conditions: to be met for all of a request's positions.
    samples: instants per window, its edges included, at which the view is given.
    """

    name: str = ""
    orbit: Orbit
    spacecraft: str = "agile-cmg"
    settings: SpacecraftSettings = SpacecraftSettings()
    requests: Annotated[tuple[Request, ...], Field(max_length=REQUESTS_MAX), FailFast()]
    start: datetime
    stop: datetime
    conditions: OpportunityConditions = OpportunityConditions()
    samples: Annotated[int, Within(*BOUNDS.samples)] = 5

    def __post_init__(self) -> None:
        if self.spacecraft not in SPACECRAFT:
            raise ValueError(
                f"spacecraft {self.spacecraft!r} is unknown; there is {', '.join(SPACECRAFT)}"
            )
        if elapsed_s(self.stop, self.start) < 1.0:
            raise ValueError(
                f"stop ({utc_text(self.stop)}) must come a second or more after start "
                f"({utc_text(self.start)})"
            )
        if not self.requests:
            raise ValueError("requests must hold at least one request")
        seen: set[str] = set()
        for number, request in enumerate(self.requests):
            if request.name in seen:
                raise ValueError(
                    f"requests.{number}.name {request.name!r} is taken already; windows are told "
                    "by name"
                )
            seen.add(request.name)
        self._require_bounds()
        self.definition()

    @property
    def ids(self) -> tuple[str, ...]:
        """Names of the requests, in order."""
        return tuple(one.name for one in self.requests)

    @property
    def assumed(self) -> tuple[Assumed, ...]:
        """Nothing is."""
        return ()

    def _require_bounds(self) -> None:
        days = elapsed_s(self.stop, self.start) / DAY_S
        if days > BOUNDS.days_max:
            raise ValueError(
                f"stop must come within {BOUNDS.days_max:.0f} days of start, not {days:.1f}"
            )
        count = sum(len(positions_of(request)) for request in self.requests)
        if (
            count > BOUNDS.targets_max
            or count * days * (BOUNDS.window_counts + self.samples) > BOUNDS.work_max
        ):
            raise ValueError(
                f"requests must have at most {BOUNDS.targets_max} positions together, and "
                f"positions times days times ({BOUNDS.window_counts} + samples) must not exceed "
                f"{BOUNDS.work_max}, which these {count} over {days:.1f} days with {self.samples} "
                "samples do; ask for fewer at a time"
            )

    def definition(self) -> AgileSpacecraft:
        """The spacecraft with the settings."""
        return self.settings.applied_to(SPACECRAFT[self.spacecraft])


def positions_of(request: Request) -> tuple[Position, ...]:
    """Longitude and latitude, deg, of a line's positions or a polygon's corners."""
    if isinstance(request, AreaRequest):
        return request.geometry.coordinates[0][:-1]
    return request.geometry.coordinates
