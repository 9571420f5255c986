"""The view of an imaging session: columns over time from its table."""

from functools import partial
from typing import Annotated

import numpy as np

from planner.base.answer_members import (
    AngleSize,
    Count,
    Internal,
    Latitudes,
    Lengths,
    Longitudes,
    Member,
    NotNegative,
    Times,
    answer,
)
from planner.base.arrays import Array
from planner.output.view.carrier import body_track, carrier_track
from planner.output.view.columns import BodyTrack, CarrierTrack
from planner.output.view.rows import view_rows
from planner.output.view.scene import CarrierScene
from planner.output.view.targets import sun_elevation_rad
from planner.spacecraft.ground import AXIS, LEFT, RIGHT, SessionGround, SessionTable
from planner.spacecraft.requests import AreaRequest, Request
from planner.spacecraft.table import TICK_S, ImagingWindow
from planner.world.frames.geodesy import geodetic_from_itrf, up_itrf
from planner.world.frames.time_scales import RowUtc, Utc, shifted_utc
from planner.world.platforms.gyro_craft import RATE_ERROR_MAX_RAD_S

_Places = Annotated[Array, Member("deg", -90.0, 90.0, decimals=6)]
_PlacesEast = Annotated[Array, Member("deg", -180.0, 180.0, decimals=6)]
_Vectors = Annotated[Array, Member("deg", decimals=9, axes=2)]
_HalfTurns = Annotated[Array, Member("deg", 0.0, 180.0, decimals=6)]
_Angles = Annotated[Array, Member("deg", decimals=6)]


@answer
class LineTrace:
    """Direction and footprint of the camera; null where a ray passes the Earth by.

    latitude_rad: of the point where the optical axis meets the WGS84 ellipsoid.
    longitude_rad: of that point; east positive.
    range_m: to that point.
    left_latitude_rad: of the scanned line's left end on the ellipsoid.
    left_longitude_rad: of the scanned line's left end; east positive.
    right_latitude_rad: of the scanned line's right end on the ellipsoid.
    right_longitude_rad: of the scanned line's right end; east positive.
    off_nadir_rad: of the optical axis from the geocentric nadir.
    along_rad: of the optical axis from nadir, positive ahead.
    across_rad: of the optical axis from nadir, positive to the right of flight.
    ground_sample_across_m: width of a pixel on the ground, across the lean of the axis.
    sun_elevation_rad: of the Sun's centre in the sky of the point looked at, without refraction.
    sun_separation_rad: of the optical axis from the Sun's centre.
    moon_separation_rad: of the optical axis from the Moon's centre.
    """

    latitude_rad: Latitudes
    longitude_rad: Longitudes
    range_m: Lengths
    left_latitude_rad: Latitudes
    left_longitude_rad: Longitudes
    right_latitude_rad: Latitudes
    right_longitude_rad: Longitudes
    off_nadir_rad: _HalfTurns
    along_rad: _Angles
    across_rad: _Angles
    ground_sample_across_m: Lengths
    sun_elevation_rad: Latitudes
    sun_separation_rad: _HalfTurns
    moon_separation_rad: _HalfTurns


@answer
class Swath:
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
    latitude_rad: _Places
    longitude_rad: _PlacesEast


@answer
class AskedPlaces:
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
    latitude_rad: _Places
    longitude_rad: _PlacesEast


@answer
class SessionLimits:
    """Limits of the session.

    rate_axis_max_rad_s: about each body axis, in turns. E.g. `1.58`.
    rate_error_max_rad_s: about each body axis while the camera runs, for the image to be sharp.
    E.g. `0.001`.
    gimbal_rate_max_rad_s: of each gimbal. E.g. `57.3`.
    momentum_sphere_n_m_s: the gyros can take so much in every direction. E.g. `60.0`.
    """

    rate_axis_max_rad_s: AngleSize
    rate_error_max_rad_s: AngleSize
    gimbal_rate_max_rad_s: AngleSize
    momentum_sphere_n_m_s: NotNegative


@answer
class SessionView:
    """The view of an imaging session as columns, with a value for each row shown.

    Vectors are [x, y, z] in body axes, gimbals 1 to 4.

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

    plan: Internal[SessionTable]
    epoch_utc: RowUtc
    step_s: NotNegative
    t_s: Times
    window: tuple[Count | None, ...]
    omega_body_rad_s: _Vectors
    alpha_body_rad_s2: _Vectors
    gimbal_rad: _Vectors
    gimbal_rate_rad_s: _Vectors
    momentum_n_m_s: Annotated[Array, Member(decimals=6, axes=2)]
    limits: SessionLimits
    carrier: CarrierTrack
    line: LineTrace
    sun: BodyTrack
    moon: BodyTrack
    swaths: tuple[Swath, ...]
    requests: tuple[AskedPlaces, ...]


def view_session(plan: SessionTable, step_s: float | None) -> SessionView:
    """step_s: a multiple of 0.2 s; chosen unless given.  Raises InvalidInput for it."""
    table = plan.table
    row, step_s = view_rows(len(table.t_s), 1, step_s)
    ground = SessionGround(plan, row)
    scene = CarrierScene(instants=ground.instants, states=ground.states)
    sun, moon = map(partial(body_track, scene), ("sun", "moon"))
    whole = SessionGround(plan)
    window: list[int | None] = [None] * len(table.t_s)
    for number, one in enumerate(table.windows):
        window[one.first_row : one.last_row + 1] = [number] * (one.last_row + 1 - one.first_row)
    return SessionView(
        plan=plan,
        epoch_utc=table.epoch_utc,
        step_s=step_s,
        t_s=table.t_s[row],
        window=tuple(window[one] for one in row.tolist()),
        omega_body_rad_s=table.omega_body_rad_s[row],
        alpha_body_rad_s2=table.alpha_body_rad_s2[row],
        gimbal_rad=table.gimbal_rad[row],
        gimbal_rate_rad_s=table.gimbal_rate_rad_s[row],
        momentum_n_m_s=plan.spacecraft.array.momentum(table.gimbal_rad[row]),
        limits=SessionLimits(
            rate_axis_max_rad_s=plan.spacecraft.slew.rate_axis_rad_s,
            rate_error_max_rad_s=RATE_ERROR_MAX_RAD_S,
            gimbal_rate_max_rad_s=plan.spacecraft.array.rate_max_rad_s,
            momentum_sphere_n_m_s=plan.spacecraft.slew.momentum_sphere_n_m_s,
        ),
        carrier=carrier_track(scene),
        line=_line_trace(ground, scene),
        sun=sun,
        moon=moon,
        swaths=tuple(_swath(whole, one) for one in table.windows),
        requests=tuple(_asked_places(plan, one) for one in plan.request.requests),
    )


def _swath(ground: SessionGround, window: ImagingWindow) -> Swath:
    latitude_rad, longitude_rad = ground.ring_rad(window) or (np.zeros(0), np.zeros(0))
    epoch_utc = ground.plan.table.epoch_utc
    return Swath(
        request=window.request,
        look=window.look,
        start_utc=shifted_utc(epoch_utc, window.first_row * TICK_S),
        stop_utc=shifted_utc(epoch_utc, window.last_row * TICK_S),
        latitude_rad=latitude_rad,
        longitude_rad=longitude_rad,
    )


def _asked_places(plan: SessionTable, request: Request) -> AskedPlaces:
    if isinstance(request, AreaRequest):
        positions = request.geometry.coordinates[0][:-1]  # a ring's first only once
    else:
        positions = request.geometry.coordinates
    longitude_rad, latitude_rad = np.radians([position[:2] for position in positions]).T
    return AskedPlaces(
        name=request.name,
        mode=request.mode,
        imaged=any(window.request == request.name for window in plan.table.windows),
        latitude_rad=latitude_rad,
        longitude_rad=(longitude_rad + np.pi) % (2.0 * np.pi) - np.pi,
    )


def _line_trace(ground: SessionGround, scene: CarrierScene) -> LineTrace:
    places = []
    for ray in (AXIS, LEFT, RIGHT):
        on_ground = ground.line.on_ground[:, ray]
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(ground.line.end_itrf_m[:, ray])
        places += [np.where(on_ground, angle, np.nan) for angle in (latitude_rad, longitude_rad)]
    on_ground, end_itrf_m = ground.line.on_ground[:, AXIS], ground.line.end_itrf_m[:, AXIS]
    range_m = np.linalg.norm(end_itrf_m - scene.r_sat_itrf_m, axis=1)
    range_m = np.where(on_ground, range_m, np.nan)
    sun_rad = sun_elevation_rad(
        scene.in_itrf(scene.r_sun_eci_m),
        end_itrf_m,
        up_itrf(*(np.where(on_ground, angle, 0.0) for angle in places[:2])),
    )
    along_rad, across_rad = ground.look_angles_rad()
    return LineTrace(
        latitude_rad=places[0],
        longitude_rad=places[1],
        range_m=range_m,
        left_latitude_rad=places[2],
        left_longitude_rad=places[3],
        right_latitude_rad=places[4],
        right_longitude_rad=places[5],
        off_nadir_rad=scene.off_nadir_rad(ground.axis_eci),
        along_rad=along_rad,
        across_rad=across_rad,
        ground_sample_across_m=range_m * ground.plan.spacecraft.camera.pixel_rad,
        sun_elevation_rad=np.where(on_ground, sun_rad, np.nan),
        sun_separation_rad=scene.separation_rad(ground.axis_eci, "sun"),
        moon_separation_rad=scene.separation_rad(ground.axis_eci, "moon"),
    )
