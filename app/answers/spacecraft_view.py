"""The view of an imaging session: columns over time."""

from app.answers.members import BUILT_ON_FIRST_USE, to_json
from planner.base.answer_members import answer
from planner.spacecraft.view import SessionView


@answer
class SessionViewHead:
    """The plan that a view is of.

    id: of the plan, as its address names it.
    name: of the session.
    spacecraft: its name.
    verified: true when the plan's verification passed.
    """

    id: str
    name: str
    spacecraft: str
    verified: bool


@answer
class SpacecraftViewResponse(SessionView, SessionViewHead):
    """The view of an imaging session as columns, with a value for each row shown.

    Vectors are [x, y, z] in body axes, gimbals 1 to 4.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE


def spacecraft_view_json(view: SessionView, plan_id: str, *, verified: bool) -> bytes:
    """The whole answer as UTF-8 JSON."""
    plan = view.plan
    return to_json(
        SpacecraftViewResponse(
            id=plan_id,
            name=plan.request.name,
            spacecraft=plan.spacecraft.name,
            verified=verified,
            **vars(view),
        )
    )
