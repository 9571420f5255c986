"""What does a request for a plan hold?"""

from typing import Annotated, Any

from pydantic import FailFast, Field

from app.requests.horizon_cameras import require_cameras
from app.requests.json_reader import JsonReader
from app.requests.platform_choice import PlatformChoice, chosen
from estimator.camera import HorizonCamera
from planner.attitude import Attitude
from planner.frames.time_scales import elapsed_s
from planner.orbits import Orbit
from planner.scenario import InitialState, OnConflict, Scenario, Session, SlewOptions
from planner.slew.backends import BACKENDS
from planner.spec import spec

SESSIONS_MAX = 200
HORIZON_CHECKS_MAX = 400
SPAN_MAX_S = 86400.0  # 432,000 rows, some 30 MB


@spec
class PlanRequest:
    """A carrier, a platform on it, its state, and the sessions to fly in order of time.

    `platform`: a registered name, or a two-axis platform written out in degrees.
    `on_conflict`: when a slew doesn't fit between two sessions, refuse, or begin the later
    one late, end the earlier one early, or whatever of both loses the least time.
    `horizon_cameras`: the carrier's, to be told in `horizon_checks` what they will see.
    """

    name: str = ""
    platform: PlatformChoice
    orbit: Orbit
    attitude: Attitude
    initial_state: InitialState
    sessions: Annotated[tuple[Session, ...], Field(max_length=SESSIONS_MAX), FailFast()]
    slew: SlewOptions = SlewOptions()
    on_conflict: OnConflict = "refuse"
    horizon_cameras: tuple[HorizonCamera, ...] = ()

    def __post_init__(self) -> None:
        if self.slew.method not in BACKENDS:
            raise ValueError(
                f"slew.method must be {' or '.join(BACKENDS)}, not {self.slew.method[:80]!r}"
            )
        scenario = self.scenario()
        span_s = elapsed_s(scenario.sessions[-1].stop, scenario.initial_state.epoch)
        if span_s > SPAN_MAX_S:
            raise ValueError(
                f"sessions must end within {SPAN_MAX_S:.0f} s of initial_state.epoch, "
                f"not after {span_s:.0f} s; plan them one by one"
            )
        if self.horizon_cameras:
            require_cameras("horizon_cameras", self.horizon_cameras)
            if len(self.horizon_cameras) * len(self.sessions) > HORIZON_CHECKS_MAX:
                raise ValueError(
                    f"horizon_cameras times sessions must not exceed {HORIZON_CHECKS_MAX}, which "
                    f"{len(self.horizon_cameras)} x {len(self.sessions)} do; name fewer cameras"
                )

    def scenario(self) -> Scenario:
        """The same, with the platform looked up."""
        return Scenario(
            name=self.name,
            orbit=self.orbit,
            attitude=self.attitude,
            platform=chosen(self.platform),
            initial_state=self.initial_state,
            sessions=self.sessions,
            slew=self.slew,
            on_conflict=self.on_conflict,
        )


_READER = JsonReader(PlanRequest)


def read_whole_plan_request(body: bytes) -> PlanRequest:
    """What a JSON text asks for; raises InvalidRequest with the fields at fault."""
    return _READER.read(body)


def read_plan_request(body: bytes) -> Scenario:
    """The scenario a JSON text describes; raises InvalidRequest with the fields at fault."""
    return read_whole_plan_request(body).scenario()


def plan_request_json_schema(ref_template: str) -> dict[str, Any]:
    """JSON Schema of the request; its `$defs` hold what it refers to by `ref_template`."""
    schema = _READER.json_schema(ref_template)
    schema["$defs"]["SlewOptions"]["properties"]["method"]["enum"] = list(BACKENDS)
    return schema
