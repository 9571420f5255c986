"""The ground point under the slit lies where Skyfield's geometry puts it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from skyfield.api import wgs84
from skyfield.framelib import itrs
from spacecraft_cases import EPOCH, ORBIT, four_modes, session

from planner.spacecraft.plan import plan_imaging
from planner.world.frames.time_scales import Instants


@pytest.fixture(scope="module")
def plan():
    return plan_imaging(session(four_modes(), 640.0, simulation_runs=0))


def footprint(r_sat_eci_m, axis_eci, timescale, t_s):
    """Skyfield's rotation to ITRS, then the near root of the ray with its WGS84 ellipsoid."""
    moment = timescale.tt_jd(*Instants(EPOCH, t_s).tt_jd())
    c = np.moveaxis(itrs.rotation_at(moment), -1, 0)
    origin = np.einsum("nij,nj->ni", c, r_sat_eci_m)
    direction = np.einsum("nij,nj->ni", c, axis_eci)
    polar_m = wgs84.radius.m * (1.0 - 1.0 / wgs84.inverse_flattening)
    scale = 1.0 / np.array([wgs84.radius.m, wgs84.radius.m, polar_m])
    o, d = origin * scale, direction * scale
    a, b, c0 = (d * d).sum(1), 2.0 * (o * d).sum(1), (o * o).sum(1) - 1.0
    reach = (-b - np.sqrt(b**2 - 4.0 * a * c0)) / (2.0 * a)
    return origin + reach[:, None] * direction


def asked_ends(request, window):
    points = request.geometry.coordinates
    leg = window.look if request.mode == "corridor" else 0
    places = [wgs84.latlon(points[k][1], points[k][0]) for k in (leg, leg + 1)]
    return np.array([place.itrs_xyz.m for place in places])


def test_strip_stereo_and_corridor_are_scanned_within_a_metre(plan, timescale):
    asked = {request.name: request for request in plan.request.requests}
    ephemeris = ORBIT.ephemeris(plan.request.start, plan.request.stop)
    scanned = [w for w in plan.windows if w.request != "area"]
    assert len(scanned) == 4  # strip, two stereo looks, corridor
    for window in scanned:
        t_s = np.arange(window.first_row, window.last_row + 1) / 5.0
        states = ephemeris.states(Instants(EPOCH, t_s))
        attitude = Rotation.from_quat(plan.table.position[window.first_row : window.last_row + 1])
        ground = footprint(states.r_sat_eci_m, attitude.apply([0.0, -1.0, 0.0]), timescale, t_s)
        ends = asked_ends(asked[window.request], window)
        if (ends[1] - ends[0]) @ (ground[-1] - ground[0]) < 0.0:
            ends = ends[::-1]
        # 1 m: promised.  Skyfield interpolates polar motion and UT1 on its own.
        assert np.linalg.norm(ground[0] - ends[0]) < 1.0
        chord = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        up = ground / np.linalg.norm(ground, axis=1, keepdims=True)
        beside = np.abs(np.sum(np.cross(up, chord) * (ground - ends[0]), axis=1))
        assert beside.max() < 1.0
        speed = np.linalg.norm(np.diff(ground, axis=0), axis=1) / 0.2
        # 0.1 %: promised; chords of 1 km are as long as their arcs to 1e-9
        assert np.abs(speed / asked[window.request].scan_speed_m_s - 1.0).max() < 1e-3
        reached = (ground[-1] - ends[0]) @ chord
        assert reached > np.linalg.norm(ends[1] - ends[0]) - 1.0
