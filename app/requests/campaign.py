"""What does a request for a campaign hold?"""

from collections.abc import Mapping
from datetime import datetime
from typing import Annotated, Any

from pydantic import FailFast, Field

from app.requests.json_reader import JsonReader
from app.requests.platform_choice import PlatformChoice, chosen
from planner.attitude import Attitude
from planner.attitude.lvlh import LvlhAttitude
from planner.campaigns import CampaignRequest, CampaignTarget
from planner.campaigns.request import STEPS_S
from planner.frames.time_scales import DAY_S
from planner.opportunities import OpportunityConditions
from planner.orbits import Orbit
from planner.platforms import AngleDeg
from planner.scenario import SlewOptions
from planner.slew.backends import BACKENDS
from planner.spec import Within, spec
from planner.targets import GroundTarget

TARGETS_MAX = 5000
DAYS_MAX = 31.0
TARGET_DAYS_MAX = 7000.0  # 1,000 places for 7 days: a minute's choice
STEP_S = 2.0  # finer steps count more
MOVING_COUNTS = 100  # what is not fixed to the Earth is looked at one by one


@spec
class CampaignQuery:
    """A carrier, a platform on it, and targets to be looked at from `start` to `stop`.

    platform: a registered name, or a two-axis platform written out in degrees.
    rest_angles_deg: where the axes rest before, between and after passes; 0 unless given.
    step_s: looks begin on whole multiples of it after `start`; finer finds more and takes
    longer.
    """

    name: str = ""
    platform: PlatformChoice
    orbit: Orbit
    attitude: Attitude = LvlhAttitude()
    rest_angles_deg: Mapping[str, AngleDeg] | None = None
    targets: Annotated[tuple[CampaignTarget, ...], Field(max_length=TARGETS_MAX), FailFast()]
    start: datetime
    stop: datetime
    conditions: OpportunityConditions = OpportunityConditions()
    slew: SlewOptions = SlewOptions()
    step_s: Annotated[float, Within(*STEPS_S)] = STEP_S

    def __post_init__(self) -> None:
        days = self.request().span_s / DAY_S
        if days > DAYS_MAX:
            raise ValueError(f"stop must come within {DAYS_MAX:.0f} days of start, not {days:.1f}")
        counted = sum(
            1 if isinstance(wanted.target, GroundTarget) else MOVING_COUNTS
            for wanted in self.targets
        )
        if counted * days * max(STEP_S / self.step_s, 1.0) > TARGET_DAYS_MAX:
            raise ValueError(
                f"targets times days must not exceed {TARGET_DAYS_MAX:.0f} at a step_s of "
                f"{STEP_S:g} s (finer counts more, a target that is no point of the ground "
                f"{MOVING_COUNTS} times), which these {len(self.targets)} over {days:.1f} days do; "
                "ask for fewer at a time"
            )

    def request(self) -> CampaignRequest:
        """The same, with the platform looked up."""
        platform = chosen(self.platform)
        at_zero = dict.fromkeys(platform.axis_names, 0.0)
        return CampaignRequest(
            name=self.name,
            orbit=self.orbit,
            attitude=self.attitude,
            platform=platform,
            rest_angles_deg=at_zero if self.rest_angles_deg is None else self.rest_angles_deg,
            targets=self.targets,
            start=self.start,
            stop=self.stop,
            conditions=self.conditions,
            slew=self.slew,
            step_s=self.step_s,
        )


_READER = JsonReader(CampaignQuery)


def read_campaign_request(body: bytes) -> CampaignRequest:
    """The request a JSON text describes; raises InvalidRequest with the fields at fault."""
    return _READER.read(body).request()


def campaign_request_json_schema(ref_template: str) -> dict[str, Any]:
    """JSON Schema of the request; its `$defs` hold what it refers to by `ref_template`."""
    schema = _READER.json_schema(ref_template)
    # The same definition as that of plans, whichever of the two is told last.
    schema["$defs"]["SlewOptions"]["properties"]["method"]["enum"] = list(BACKENDS)
    return schema
