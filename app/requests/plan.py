"""A request for a plan: a scenario within the service's bounds, and horizon cameras."""

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, Field

from app.requests.json_reader import JsonReader, json_fields
from estimator.camera import HorizonCamera
from estimator.request import require_cameras
from planner.base.spec import is_kept, spec
from planner.world.frames.time_scales import elapsed_s, tai_us
from planner.world.initial_state import AskedInitialState
from planner.world.scenario import InitialState, Scenario, Session

SESSIONS_MAX = 200
HORIZON_CHECKS_MAX = 400
SPAN_MAX_S = 86400.0  # 432,000 rows, some 30 MB


@spec
class PlanRequest(Scenario):
    """A carrier, a platform on it, its state, and the sessions to fly in order of time.

    initial_state: state of the platform when the table begins; members left out are filled in, as
    `assumed` of the plan states.
    horizon_cameras: the carrier's; `horizon_checks` says what they will see.
    """

    if not TYPE_CHECKING:  # what is read; once born, it is complete
        initial_state: AskedInitialState = AskedInitialState()
    sessions: Annotated[tuple[Session, ...], Field(max_length=SESSIONS_MAX)]
    horizon_cameras: tuple[HorizonCamera, ...] = ()

    def __post_init__(self) -> None:
        asked: AskedInitialState | InitialState = self.initial_state
        if isinstance(asked, AskedInitialState) and self.sessions:
            first_utc = min((session.start for session in self.sessions), key=tai_us)
            completed = asked.completed(self.platform, first_utc)
            object.__setattr__(self, "initial_state", completed)
        Scenario.__post_init__(self)
        if self.horizon_cameras:
            require_cameras("horizon_cameras", self.horizon_cameras)
            if len(self.horizon_cameras) * len(self.sessions) > HORIZON_CHECKS_MAX:
                raise ValueError(
                    f"horizon_cameras times sessions must not exceed {HORIZON_CHECKS_MAX}, which "
                    f"{len(self.horizon_cameras)} x {len(self.sessions)} do; name fewer cameras"
                )


def _require_span(request: PlanRequest) -> PlanRequest:
    """Of a request as it is read: a start that is tried may lie beyond it."""
    span_s = elapsed_s(request.last_utc, request.initial_state.epoch)
    if span_s > SPAN_MAX_S and not is_kept():
        raise ValueError(
            f"sessions must end within {SPAN_MAX_S:.0f} s of initial_state.epoch, "
            f"not after {span_s:.0f} s; plan them one by one"
        )
    return request


_WITHIN_SPAN: Any = Annotated[PlanRequest, AfterValidator(_require_span)]
PLAN_READER = JsonReader[PlanRequest](_WITHIN_SPAN)

read_plan_request = PLAN_READER.read
read_kept_plan_request = PLAN_READER.read_kept


def write_plan_request(
    scenario: Scenario, words: Mapping[str, Any], target_words: Sequence[object]
) -> bytes:
    """The request that `read_plan_request` reads as this scenario.

    words: of its fields that stay as they were sent.  target_words: of the first sessions' targets.
    """
    sessions = [json_fields(session) for session in scenario.sessions]
    for session, target in zip(sessions, target_words, strict=False):
        session["target"] = target
    return json.dumps(json_fields(scenario, {**words, "sessions": sessions})).encode()
