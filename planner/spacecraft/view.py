"""The view of an imaging session: columns over time from its table."""

from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np

from planner.base.answer_members import Latitudes, Lengths, Longitudes, Member, answer
from planner.base.arrays import Array, Indices
from planner.output.view.carrier import body_track, carrier_track
from planner.output.view.columns import BodyTrack, CarrierTrack
from planner.output.view.rows import view_rows
from planner.output.view.scene import CarrierScene
from planner.output.view.targets import sun_elevation_rad
from planner.spacecraft.export.ground import AXIS, LEFT, RIGHT, SessionGround
from planner.spacecraft.export.session_table import SessionTable
from planner.world.frames.geodesy import geodetic_from_itrf, up_itrf

NO_WINDOW = -1


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


@dataclass(frozen=True, kw_only=True, eq=False)
class SessionView:
    """An imaging session at n of its rows.

    step_s: from row to row, but for the last.  t_s: since the table's epoch, (n,).
    window: number of the window that the row is in, NO_WINDOW for none, (n,).
    omega_body_rad_s, alpha_body_rad_s2: (n, 3).  gimbal_rad, gimbal_rate_rad_s: (n, 4).
    momentum_body_n_m_s: of the gyros' rotors, (n, 3).
    swath_rad: latitudes and longitudes around what each window images; None beside the Earth.
    """

    plan: SessionTable
    step_s: float
    t_s: Array
    window: Indices
    omega_body_rad_s: Array
    alpha_body_rad_s2: Array
    gimbal_rad: Array
    gimbal_rate_rad_s: Array
    momentum_body_n_m_s: Array
    carrier: CarrierTrack
    line: LineTrace
    sun: BodyTrack
    moon: BodyTrack
    swath_rad: tuple[tuple[Array, Array] | None, ...]


def view_session(plan: SessionTable, step_s: float | None) -> SessionView:
    """step_s: a multiple of 0.2 s; chosen unless given.  Raises InvalidInput for it."""
    table = plan.table
    row, step_s = view_rows(len(table.t_s), 1, step_s)
    ground = SessionGround(plan, row)
    scene = CarrierScene(instants=ground.instants, states=ground.states)
    sun, moon = map(partial(body_track, scene), ("sun", "moon"))
    whole = SessionGround(plan)
    window = np.full(len(table.t_s), NO_WINDOW)
    for number, one in enumerate(table.windows):
        window[one.first_row : one.last_row + 1] = number
    return SessionView(
        plan=plan,
        step_s=step_s,
        t_s=table.t_s[row],
        window=window[row],
        omega_body_rad_s=table.omega_body_rad_s[row],
        alpha_body_rad_s2=table.alpha_body_rad_s2[row],
        gimbal_rad=table.gimbal_rad[row],
        gimbal_rate_rad_s=table.gimbal_rate_rad_s[row],
        momentum_body_n_m_s=plan.spacecraft.array.momentum(table.gimbal_rad[row]),
        carrier=carrier_track(scene),
        line=_line_trace(ground, scene),
        sun=sun,
        moon=moon,
        swath_rad=tuple(whole.ring_rad(one) for one in table.windows),
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
