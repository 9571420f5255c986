"""The answer to a request still at work when the service is stopped."""

from http import HTTPStatus

from starlette.exceptions import HTTPException


def service_stops() -> HTTPException:
    """For work that is not kept; what is kept is told by its address instead."""
    return HTTPException(
        HTTPStatus.SERVICE_UNAVAILABLE,
        "the service is being stopped and gives this up; ask again when it is back",
        {"Connection": "close"},
    )
