"""What does a request for opportunities hold?"""

from datetime import datetime
from typing import Annotated, Any

from pydantic import FailFast, Field

from app.requests.json_reader import JsonReader
from app.requests.platform_choice import PlatformChoice, chosen
from planner.attitude import Attitude
from planner.attitude.lvlh import LvlhAttitude
from planner.frames.time_scales import DAY_S, elapsed_s
from planner.opportunities import OpportunityConditions, OpportunityRequest, OpportunityTarget
from planner.opportunities.request import HRC_PIXEL_ARCSEC, PIXELS_ARCSEC, SAMPLES
from planner.orbits import Orbit
from planner.spec import Within, spec
from planner.targets import GroundTarget

TARGETS_MAX = 5000
DAYS_MAX = 31.0
# 1,000 places for 10 days with 5 samples: some 3 s, 40,000 windows, 50 MB.
TARGET_DAYS_SAMPLES_MAX = 50_000
MOVING_COUNTS = 300  # what is not fixed to the Earth is looked at one by one


@spec
class OpportunityQuery:
    """A carrier, a platform on it, and the targets it may look at from `start` to `stop`.

    platform: a registered name, or a two-axis platform written out in degrees.
    samples: instants per window, its edges included, at which angles and the rest are told.
    pixel_arcsec: angle a pixel sees, for the ground sample distance.
    """

    platform: PlatformChoice
    orbit: Orbit
    attitude: Attitude = LvlhAttitude()
    targets: Annotated[tuple[OpportunityTarget, ...], Field(max_length=TARGETS_MAX), FailFast()]
    start: datetime
    stop: datetime
    conditions: OpportunityConditions = OpportunityConditions()
    samples: Annotated[int, Within(*SAMPLES)] = 5
    pixel_arcsec: Annotated[float, Within(*PIXELS_ARCSEC)] = HRC_PIXEL_ARCSEC

    def __post_init__(self) -> None:
        self.request()
        days = elapsed_s(self.stop, self.start) / DAY_S
        if days > DAYS_MAX:
            raise ValueError(f"stop must come within {DAYS_MAX:.0f} days of start, not {days:.1f}")
        counted = sum(
            1 if isinstance(wanted.target, GroundTarget) else MOVING_COUNTS
            for wanted in self.targets
        )
        if counted * days * self.samples > TARGET_DAYS_SAMPLES_MAX:
            raise ValueError(
                f"targets times days times samples must not exceed {TARGET_DAYS_SAMPLES_MAX} (a "
                f"target that is no point of the ground counts {MOVING_COUNTS} times), which these "
                f"{len(self.targets)} over {days:.1f} days with {self.samples} samples do; ask for "
                "fewer at a time"
            )

    def request(self) -> OpportunityRequest:
        """The same, with the platform looked up."""
        return OpportunityRequest(
            orbit=self.orbit,
            attitude=self.attitude,
            platform=chosen(self.platform),
            targets=self.targets,
            start=self.start,
            stop=self.stop,
            conditions=self.conditions,
            samples=self.samples,
            pixel_arcsec=self.pixel_arcsec,
        )


_READER = JsonReader(OpportunityQuery)


def read_opportunity_request(body: bytes) -> OpportunityRequest:
    """The request a JSON text describes; raises InvalidRequest with the fields at fault."""
    return _READER.read(body).request()


def opportunity_request_json_schema(ref_template: str) -> dict[str, Any]:
    """JSON Schema of the request; its `$defs` hold what it refers to by `ref_template`."""
    return _READER.json_schema(ref_template)
