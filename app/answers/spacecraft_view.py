"""The view of an imaging session: columns over time."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from app.answers.columns import columns_of, numbers
from app.answers.members import BUILT_ON_FIRST_USE, degrees, to_json
from app.answers.ranges import (
    Count,
    LatitudeDeg,
    LongitudeDeg,
    NotNegative,
    Signed,
)
from planner.output.view.columns import BodyTrack, CarrierTrack
from planner.spacecraft.export.map import asked_rad
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.definition import RATE_ERROR_MAX_RAD_S, AgileSpacecraft
from planner.spacecraft.view import NO_WINDOW, LineTrace
from planner.world.frames.time_scales import shifted_utc, utc_text

if TYPE_CHECKING:
    from planner.spacecraft.view import SessionView


@dataclass(frozen=True, kw_only=True)
class SwathOut:
    """The ground imaged in one window: the ring around it, its places in order.

    request: name of the request it belongs to.
    look: number of the strip, look or leg within the request, from 0.
    start: first row; UTC.
    stop: last row; UTC.
    latitude_deg: of each place around it; empty where it isn't all on the Earth.
    longitude_deg: of each place around it; east positive.
    """

    request: str
    look: Count
    start: str
    stop: str
    latitude_deg: list[LatitudeDeg]
    longitude_deg: list[LongitudeDeg]


@dataclass(frozen=True, kw_only=True)
class AskedPlacesOut:
    """One request: the places of its line, or around its polygon.

    name: of the request.
    mode: of the request.
    imaged: true when any of it is imaged.
    latitude_deg: of each place.
    longitude_deg: of each place; east positive.
    """

    name: str
    mode: str
    imaged: bool
    latitude_deg: list[LatitudeDeg]
    longitude_deg: list[LongitudeDeg]


@dataclass(frozen=True, kw_only=True)
class SessionLimitsOut:
    """Limits of the session.

    rate_axis_max_deg_s: about each body axis, in turns. E.g. `1.58`.
    rate_error_max_deg_s: about each body axis while the camera runs, for the image to be sharp.
    E.g. `0.001`.
    gimbal_rate_max_deg_s: of each gimbal. E.g. `57.3`.
    momentum_sphere_n_m_s: the gyros can take so much in every direction. E.g. `60.0`.
    """

    rate_axis_max_deg_s: NotNegative
    rate_error_max_deg_s: NotNegative
    gimbal_rate_max_deg_s: NotNegative
    momentum_sphere_n_m_s: NotNegative


@dataclass(frozen=True, kw_only=True)
class SpacecraftViewResponse:
    """The view of an imaging session as columns, with a value for each row shown.

    Vectors are [x, y, z] in body axes, gimbals 1 to 4.

    id: of the plan, as its address names it.
    name: of the session.
    spacecraft: its name.
    verified: true when the plan's verification passed.
    epoch: of row 0; UTC.
    step_s: from row to row shown; the table's last row is shown too.
    t_s: of each row, since the epoch.
    window: number of the swath being imaged, from 0; null while none is.
    omega_body_deg_s: body relative to ECI, in body axes.
    alpha_body_deg_s2: its derivative, in body axes.
    gimbal_deg: angles of the four gyros' gimbals.
    gimbal_rate_deg_s: rates of the four gyros' gimbals.
    momentum_n_m_s: of the gyros' rotors, in body axes.
    limits: limits of the session.
    swaths: ground imaged in each window.
    requests: places that were asked for, imaged or not.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    id: str
    name: str
    spacecraft: str
    verified: bool
    epoch: str
    step_s: NotNegative
    t_s: list[NotNegative]
    window: list[Count | None]
    omega_body_deg_s: list[list[Signed]]
    alpha_body_deg_s2: list[list[Signed]]
    gimbal_deg: list[list[Signed]]
    gimbal_rate_deg_s: list[list[Signed]]
    momentum_n_m_s: list[list[Signed]]
    limits: SessionLimitsOut
    carrier: CarrierTrack
    line: LineTrace
    sun: BodyTrack
    moon: BodyTrack
    swaths: list[SwathOut]
    requests: list[AskedPlacesOut]


def spacecraft_view_json(view: "SessionView", plan_id: str, *, verified: bool) -> bytes:
    """The whole answer as UTF-8 JSON."""
    request, table = view.plan.request, view.plan.table
    return to_json(
        columns_of(
            SpacecraftViewResponse,
            view,
            id=plan_id,
            name=request.name,
            spacecraft=view.plan.spacecraft.name,
            verified=verified,
            epoch=utc_text(table.epoch_utc, 1),
            step_s=view.step_s,
            t_s=view.t_s.tolist(),
            window=[None if one == NO_WINDOW else one for one in view.window.tolist()],
            momentum_n_m_s=numbers(view.momentum_body_n_m_s, 1.0, 6),
            limits=_limits(view.plan.spacecraft),
            carrier=view.carrier,
            line=view.line,
            sun=view.sun,
            moon=view.moon,
            swaths=_swaths(view),
            requests=_asked(view),
        )
    )


def _limits(spacecraft: AgileSpacecraft) -> SessionLimitsOut:
    return SessionLimitsOut(
        rate_axis_max_deg_s=degrees(spacecraft.slew.rate_axis_rad_s),
        rate_error_max_deg_s=degrees(RATE_ERROR_MAX_RAD_S),
        gimbal_rate_max_deg_s=degrees(spacecraft.array.rate_max_rad_s),
        momentum_sphere_n_m_s=spacecraft.slew.momentum_sphere_n_m_s,
    )


def _swaths(view: "SessionView") -> list[SwathOut]:
    epoch_utc = view.plan.table.epoch_utc
    nowhere = np.zeros(0), np.zeros(0)
    return [
        SwathOut(
            request=window.request,
            look=window.look,
            start=utc_text(shifted_utc(epoch_utc, window.first_row * TICK_S)),
            stop=utc_text(shifted_utc(epoch_utc, window.last_row * TICK_S)),
            latitude_deg=numbers(np.degrees(ring_rad[0]), 1.0, 6),
            longitude_deg=numbers(np.degrees(ring_rad[1]), 1.0, 6),
        )
        for window, ring_rad in zip(
            view.plan.table.windows, (ring or nowhere for ring in view.swath_rad), strict=True
        )
    ]


def _asked(view: "SessionView") -> list[AskedPlacesOut]:
    imaged = {window.request for window in view.plan.table.windows}
    asked = []
    for request in view.plan.request.requests:
        latitude_rad, longitude_rad = asked_rad(request)
        asked.append(
            AskedPlacesOut(
                name=request.name,
                mode=request.mode,
                imaged=request.name in imaged,
                latitude_deg=numbers(np.degrees(latitude_rad), 1.0, 6),
                longitude_deg=numbers((np.degrees(longitude_rad) + 180.0) % 360.0 - 180.0, 1.0, 6),
            )
        )
    return asked
