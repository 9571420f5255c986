"""Tables of a body that the judge is tried on, made with SciPy and ERFA alone.

From the nadir idle attitude over the orbit of judged_tables the boresight is led to Las Vegas by a
smooth share of the angle, and tracks it; rates are those of splines of the attitude.
"""

import dataclasses

import erfa
import numpy as np
from judged_tables import EPOCH_UTC, LAS_VEGAS, START_S, STOP_S, CircularOrbit, apparent_eci
from scipy.interpolate import BPoly, make_interp_spline
from scipy.spatial.transform import Rotation

from planner.base.commands import BODY_CHANNELS, CommandTable
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.platforms.body import (
    BodyPlatform,
    FrameCamera,
    LinesAcrossTrack,
    MagnitudeAgility,
    NadirIdle,
)
from planner.world.scenario import InitialState, Scenario, Session

LEAVES_S, ARRIVES_S, LAST_S = 5.0, 58.0, 102.0
ORBIT = CircularOrbit()
AGILITY = MagnitudeAgility(rate_max_deg_s=2.0, acceleration_max_deg_s2=0.15, jerk_max_deg_s3=0.05)
BODY = BodyPlatform(
    name="body",
    agility=AGILITY,
    roll=LinesAcrossTrack(),
    idle=NadirIdle(),
    off_nadir_max_deg=60.0,
    camera=FrameCamera(
        pixel_arcsec=1.0, exposure_s=0.001, frames_per_s=10.0, field_of_view_deg=(2.0, 1.5)
    ),
)


def body_scenario(platform=BODY, target=LAS_VEGAS, orbit=ORBIT, **fields):
    return Scenario(
        orbit=orbit,
        platform=platform,
        initial_state=InitialState(epoch=EPOCH_UTC),
        sessions=(
            Session(
                target=target,
                start=shifted_utc(EPOCH_UTC, START_S),
                stop=shifted_utc(EPOCH_UTC, STOP_S),
            ),
        ),
        **fields,
    )


def unit(vector):
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def share_rad(t_s):
    """From 0 to 1 with three derivatives at rest at both ends."""
    rest = np.zeros((4, 1))
    curve = BPoly.from_derivatives([LEAVES_S, ARRIVES_S], [rest, np.array([[1.0], [0], [0], [0]])])
    return np.where(t_s < LEAVES_S, 0.0, np.where(t_s > ARRIVES_S, 1.0, curve(t_s)[:, 0]))


def attitude_matrices(t_s, off_rad=0.0, roll_rad=0.0):
    """Columns: body axes in ECI, x along the flight, on the target along that over the ground.

    off_rad: of the target's direction, about the flight's.  roll_rad: about the boresight.
    """
    states = ORBIT.states(Instants(EPOCH_UTC, t_s))
    down, target = unit(-states.r_sat_eci_m), apparent_eci(ORBIT, LAS_VEGAS, t_s)
    # The pole of 27 February 2015, which moves 0.05 arcsec a day: 3e-3 in this direction.
    earth_rad_s = 7.2921150e-5 * erfa.c2i06a(2457080.5, 0.7)[2]
    over_ground = np.cross(earth_rad_s, states.r_sat_eci_m) * share_rad(t_s)[:, None]
    flight = unit(states.v_sat_eci_m_s - over_ground)
    target = target + off_rad * np.cross(flight, target)
    axis = np.cross(down, target)
    angle = np.arctan2(np.linalg.norm(axis, axis=1), np.sum(down * target, axis=1))
    z = Rotation.from_rotvec(unit(axis) * (share_rad(t_s) * angle)[:, None]).apply(down)
    y = unit(np.cross(z, flight))
    y = Rotation.from_rotvec(z * (roll_rad * share_rad(t_s))[:, None]).apply(y)
    return np.stack([np.cross(y, z), y, z], axis=2)


def body_table(off_rad=0.0, last_s=LAST_S, roll_rad=0.0):
    """Rows from 0 to last_s, of attitudes every 0.1 s from before to after."""
    t_s = np.arange(-20, round(last_s * 10.0) + 21) / 10.0
    q_xyzw = Rotation.from_matrix(attitude_matrices(t_s, off_rad, roll_rad)).as_quat()
    signs = np.sign(np.sum(q_xyzw[1:] * q_xyzw[:-1], axis=1))
    q_xyzw[1:] *= np.cumprod(signs)[:, None]
    curve = make_interp_spline(t_s, q_xyzw, k=7)
    rows_s = np.arange(round(last_s * 5.0) + 1) / 5.0
    q, q1, q2 = (curve.derivative(k)(rows_s) if k else curve(rows_s) for k in range(3))
    back = Rotation.from_quat(q).inv()

    def doubled_product(derivative):
        """2 q* d, the vector part."""
        x, w = q[:, :3], q[:, 3:]
        d, d_w = derivative[:, :3], derivative[:, 3:]
        return 2.0 * (w * d - d_w * x - np.cross(x, d))

    return CommandTable(
        epoch_utc=EPOCH_UTC,
        channels=BODY_CHANNELS,
        position=back.inv().as_quat() * np.sign(np.sum(back.inv().as_quat() * q, axis=1))[:, None],
        rate_rad_s=doubled_product(q1),
        acceleration_rad_s2=doubled_product(q2),
    )


def with_rows(table, rows, **added):
    """The table with something added to some rows of its arrays."""
    arrays = {name: getattr(table, name).copy() for name in added}
    for name, value in added.items():
        arrays[name][rows] += value
    return dataclasses.replace(table, **arrays)
