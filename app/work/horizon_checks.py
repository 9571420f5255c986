"""The sessions of a plan that the carrier's horizon cameras can check."""

from app.answers.horizon_view import HorizonCheckOut, ViewOut
from app.work.horizon_views import views
from estimator.camera import HorizonCamera
from estimator.request import Body
from planner.frames.time_scales import elapsed_s, shifted_utc
from planner.scenario import Scenario

SEEN_AT = (0.0, 0.5, 1.0)  # shares of a session


def horizon_checks(scenario: Scenario, cameras: tuple[HorizonCamera, ...]) -> list[HorizonCheckOut]:
    """Session by session every camera's part; none without cameras."""
    if not cameras:
        return []
    moments = [
        shifted_utc(session.start, share * elapsed_s(session.stop, session.start))
        for session in scenario.sessions
        for share in SEEN_AT
    ]
    seen, _ = views(scenario.orbit, scenario.attitude, cameras, moments, body=Body())
    count = len(cameras)
    per_session = len(SEEN_AT) * count
    return [
        _check(number, seen[number * per_session + k : (number + 1) * per_session : count])
        for number in range(len(scenario.sessions))
        for k in range(count)
    ]


def _check(session: int, seen: list[ViewOut]) -> HorizonCheckOut:
    worst = next((view for view in seen if not view.usable), seen[0])
    return HorizonCheckOut(
        session=session,
        camera=worst.camera,
        usable=worst.usable,
        reason=worst.reason,
        explanation=worst.explanation,
        views=seen,
    )
