"""The view of an imaging session: columns over time."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from app.answers.members import BUILT_ON_FIRST_USE, degrees, to_json
from planner.base.answer_members import Count, Member, NotNegative, Times, answer
from planner.base.arrays import Array
from planner.output.view.columns import BodyTrack, CarrierTrack
from planner.spacecraft.export.map import asked_rad
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.definition import RATE_ERROR_MAX_RAD_S, AgileSpacecraft
from planner.spacecraft.view import NO_WINDOW, LineTrace
from planner.world.frames.time_scales import RowUtc, Utc, shifted_utc

if TYPE_CHECKING:
    from planner.spacecraft.view import SessionView


_Latitudes = Annotated[Array, Member("deg", -90.0, 90.0, decimals=6)]
_Longitudes = Annotated[Array, Member("deg", -180.0, 180.0, decimals=6)]
_Vectors = Annotated[Array, Member("deg", decimals=9, axes=2)]


@answer
class SwathOut:
    """The ground imaged in one window: the ring around it, its places in order.

    request: name of the request it belongs to.
    look: number of the strip, look or leg within the request, from 0.
    start_utc: first row; UTC.
    stop_utc: last row; UTC.
    latitude_rad: of each place around it; empty where it isn't all on the Earth.
    longitude_rad: of each place around it; east positive.
    """

    request: str
    look: Count
    start_utc: Utc
    stop_utc: Utc
    latitude_rad: _Latitudes
    longitude_rad: _Longitudes


@answer
class AskedPlacesOut:
    """One request: the places of its line, or around its polygon.

    name: of the request.
    mode: of the request.
    imaged: true when any of it is imaged.
    latitude_rad: of each place.
    longitude_rad: of each place; east positive.
    """

    name: str
    mode: str
    imaged: bool
    latitude_rad: _Latitudes
    longitude_rad: _Longitudes


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


@answer
class SpacecraftViewResponse:
    """The view of an imaging session as columns, with a value for each row shown.

    Vectors are [x, y, z] in body axes, gimbals 1 to 4.

    id: of the plan, as its address names it.
    name: of the session.
    spacecraft: its name.
    verified: true when the plan's verification passed.
    epoch_utc: of row 0; UTC.
    step_s: from row to row shown; the table's last row is shown too.
    t_s: of each row, since the epoch.
    window: number of the swath being imaged, from 0; null while none is.
    omega_body_rad_s: body relative to ECI, in body axes.
    alpha_body_rad_s2: its derivative, in body axes.
    gimbal_rad: angles of the four gyros' gimbals.
    gimbal_rate_rad_s: rates of the four gyros' gimbals.
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
    epoch_utc: RowUtc
    step_s: NotNegative
    t_s: Times
    window: list[Count | None]
    omega_body_rad_s: _Vectors
    alpha_body_rad_s2: _Vectors
    gimbal_rad: _Vectors
    gimbal_rate_rad_s: _Vectors
    momentum_n_m_s: Annotated[Array, Member(decimals=6, axes=2)]
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
        SpacecraftViewResponse(
            id=plan_id,
            name=request.name,
            spacecraft=view.plan.spacecraft.name,
            verified=verified,
            epoch_utc=table.epoch_utc,
            step_s=view.step_s,
            t_s=view.t_s,
            window=[None if one == NO_WINDOW else one for one in view.window.tolist()],
            omega_body_rad_s=view.omega_body_rad_s,
            alpha_body_rad_s2=view.alpha_body_rad_s2,
            gimbal_rad=view.gimbal_rad,
            gimbal_rate_rad_s=view.gimbal_rate_rad_s,
            momentum_n_m_s=view.momentum_body_n_m_s,
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
            start_utc=shifted_utc(epoch_utc, window.first_row * TICK_S),
            stop_utc=shifted_utc(epoch_utc, window.last_row * TICK_S),
            latitude_rad=ring_rad[0],
            longitude_rad=ring_rad[1],
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
                latitude_rad=latitude_rad,
                longitude_rad=(longitude_rad + np.pi) % (2.0 * np.pi) - np.pi,
            )
        )
    return asked
