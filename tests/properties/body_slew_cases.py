"""Random slews of a whole body: between rests, and between ground points tracked from orbit."""

import math

import numpy as np
from numpy.polynomial import Chebyshev
from scipy.spatial.transform import Rotation

from planner.base.commands import ROWS_PER_S, Motion
from planner.base.mrp import MrpMotion, body_motion
from planner.motion.attitude.problem import AgilityLimits, AvoidedCone, BodySlewProblem

GM_M3_S2, EARTH_M, SPIN_RAD_S = 3.986004418e14, 6371e3, 7.2921159e-5
FAMILIES = ("resting-magnitude", "pointing-magnitude", "resting-axis", "pointing-axis")
PATIENCE = 3.0  # of the time about the Euler axis, how long a goal at rest may be joined
SEEN_S = 150.0  # a ground point is tracked


def draw_limits(rng, kind):
    """0.5 to 4 deg/s, reached in fractions of a second to a minute."""
    rate = math.exp(rng.uniform(math.log(0.5), math.log(4.0)))
    acceleration = math.exp(rng.uniform(math.log(0.05), math.log(1.5)))
    jerk = acceleration / math.exp(rng.uniform(math.log(0.4), math.log(4.0)))
    by_axis = np.deg2rad(np.tile([rate, acceleration, jerk], (3, 1)))
    if kind != "magnitude":
        by_axis = by_axis * rng.uniform(0.4, 1.0, (3, 1))
    return AgilityLimits(
        kind=kind,
        rate_rad_s=by_axis[:, 0],
        acceleration_rad_s2=by_axis[:, 1],
        jerk_rad_s3=by_axis[:, 2],
    )


def about_s(limits, angle_rad):
    """A rest-to-rest turn about the weakest axis takes so long, more or less."""
    rate, acceleration, jerk = limits.by_order.min(axis=0)
    return angle_rad / rate + rate / acceleration + acceleration / jerk


def still(q, rows):
    none = np.zeros((rows, 3))
    return Motion(np.tile(q.as_quat(), (rows, 1)), none, none)


def draw_resting(rng, kind):
    axis = rng.standard_normal(3)
    angle_rad = math.radians(rng.uniform(5.0, 120.0))
    begin = Rotation.from_quat(rng.standard_normal(4))
    end = begin * Rotation.from_rotvec(angle_rad * axis / np.linalg.norm(axis))
    limits = draw_limits(rng, kind)
    rows = math.ceil(PATIENCE * about_s(limits, angle_rad) * ROWS_PER_S)
    return BodySlewProblem(
        start=still(begin, 1), goal=still(end, rows), first_arrival_row=1, limits=limits
    )


def tracking(height_m, point, yaw_rad, t_s):
    """Body -Y on a ground point, X as near as can be to the flight direction turned by yaw."""
    radius_m = EARTH_M + height_m
    n = math.sqrt(GM_M3_S2 / radius_m**3)
    none = np.zeros_like(t_s)
    inclined = Rotation.from_rotvec([math.radians(97.0), 0.0, 0.0])
    r = inclined.apply(radius_m * np.stack([np.cos(n * t_s), np.sin(n * t_s), none], axis=1))
    v = inclined.apply(np.stack([-np.sin(n * t_s), np.cos(n * t_s), none], axis=1))
    spin = Rotation.from_rotvec(np.outer(t_s, [0.0, 0.0, SPIN_RAD_S]))
    y = r - spin.apply(np.tile(EARTH_M * point / np.linalg.norm(point), (len(t_s), 1)))
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    v = math.cos(yaw_rad) * v + math.sin(yaw_rad) * np.cross(r, v) / radius_m
    x = v - y * np.sum(v * y, axis=1, keepdims=True)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return Rotation.from_matrix(np.stack([x, y, np.cross(x, y)], axis=-1))


def tracked_rows(height_m, point, yaw_rad, first_s, rows):
    """Rows of such a motion; rates by Chebyshev polynomials of its Rodrigues parameters."""
    last_s = first_s + max(rows - 1, 1) / ROWS_PER_S
    middle_s, half_s = (first_s + last_s) / 2.0, (last_s - first_s) / 2.0 + 2.0
    nodes = np.cos(np.pi * (np.arange(40) + 0.5) / 40)
    about = tracking(height_m, point, yaw_rad, np.array([middle_s]))[0]
    sigma = (about.inv() * tracking(height_m, point, yaw_rad, middle_s + half_s * nodes)).as_mrp()
    t_s = first_s + np.arange(rows) / ROWS_PER_S
    domain = (middle_s - half_s, middle_s + half_s)
    curves = [
        Chebyshev(np.polynomial.chebyshev.chebfit(nodes, part, 24), domain) for part in sigma.T
    ]
    parts = [
        np.stack([curve.deriv(order)(t_s) if order else curve(t_s) for curve in curves], axis=1)
        for order in range(4)
    ]
    body = body_motion(MrpMotion(*parts))
    q = (about * Rotation.from_mrp(parts[0])).as_quat()
    return Motion(q, body.omega_body_rad_s, body.alpha_body_rad_s2)


def draw_pointing(rng, kind):
    """Both points within 40 deg of nadir; the second is tracked for 150 s from the start on."""
    inclined = Rotation.from_rotvec([math.radians(97.0), 0.0, 0.0])
    while True:
        height_m = rng.uniform(450e3, 700e3)
        n = math.sqrt(GM_M3_S2 / (EARTH_M + height_m) ** 3)
        points = []
        for t_s in (0.0, 60.0):
            along, across = rng.uniform(-400e3, 400e3, 2) / EARTH_M
            at = n * t_s + along
            p = [math.cos(at) * math.cos(across), math.sin(at) * math.cos(across), math.sin(across)]
            points.append(Rotation.from_rotvec([0, 0, -SPIN_RAD_S * t_s]).apply(inclined.apply(p)))
        limits = draw_limits(rng, kind)
        yaws = rng.uniform(-0.6, 0.6, 2)
        start = tracked_rows(height_m, points[0], yaws[0], 0.0, 1)
        rows = int(SEEN_S * ROWS_PER_S)
        goal = tracked_rows(height_m, points[1], yaws[1], 1.0 / ROWS_PER_S, rows)
        problem = BodySlewProblem(start=start, goal=goal, first_arrival_row=1, limits=limits)
        angle_rad = float(problem.angles_rad[300])
        used = [
            np.max(
                np.abs(np.stack([motion.rate_rad_s, motion.acceleration_rad_s2], -1))
                / limits.by_order[:, :2]
            )
            for motion in (start, goal)
        ]
        if angle_rad > math.radians(5.0) and about_s(limits, angle_rad) < 90.0 and max(used) < 0.6:
            return problem


def draw(rng, family):
    """A slew of one of the families."""
    make, kind = family.split("-")
    return {"resting": draw_resting, "pointing": draw_pointing}[make](rng, kind)


def draw_cone(rng, q_eci_from_body_xyzw, rows):
    """A cone that a body direction enters on this path, both of whose ends lie outside by 2 deg.

    None where none was found.
    """
    for _ in range(200):
        direction = rng.standard_normal(3)
        direction /= np.linalg.norm(direction)
        seen = Rotation.from_quat(q_eci_from_body_xyzw).apply(direction)
        k = rng.integers(len(seen) // 4, 3 * len(seen) // 4)
        half_rad = math.radians(rng.uniform(8.0, 40.0))
        aside = np.cross(seen[k], rng.standard_normal(3))
        turn = rng.uniform(0.0, 0.8) * half_rad * aside / np.linalg.norm(aside)
        centre = Rotation.from_rotvec(turn).apply(seen[k])
        if np.arccos(np.clip(seen[[0, -1]] @ centre, -1, 1)).min() > half_rad + math.radians(2.0):
            return AvoidedCone(
                name="cone",
                direction_body=direction,
                centre_eci=np.tile(centre, (rows, 1)),
                half_rad=half_rad,
            )
    return None
