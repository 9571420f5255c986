"""Which sessions of a plan can be checked by the carrier's horizon cameras?"""

from app.api.horizon_view import HorizonCheckOut, ViewOut
from app.api.horizon_views import views
from estimator.camera import HorizonCamera
from estimator.request import Body
from planner.frames.time_scales import elapsed_s, shifted_utc
from planner.scenario import Scenario

VIEWS_PER_SESSION = 3


def horizon_checks(scenario: Scenario, cameras: tuple[HorizonCamera, ...]) -> list[HorizonCheckOut]:
    """Session by session every camera's part; none without cameras."""
    if not cameras:
        return []
    moments = [
        shifted_utc(session.start, share * elapsed_s(session.stop, session.start))
        for session in scenario.sessions
        for share in (0.0, 0.5, 1.0)
    ]
    seen, _ = views(scenario.orbit, scenario.attitude, cameras, moments, body=Body())
    count = len(cameras)
    return [
        _check(number, seen[first + k : first + VIEWS_PER_SESSION * count : count])
        for number in range(len(scenario.sessions))
        for first in [number * VIEWS_PER_SESSION * count]
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
