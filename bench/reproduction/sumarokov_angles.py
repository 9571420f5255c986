"""From the target to the angles of the axes: Sumarokov 2016, eqs. 8 to 11."""

from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.motion.pointing.angles import axis_angles, boresight_platform
from planner.motion.pointing.line_of_sight import line_of_sight
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import WGS84_A_M, WGS84_F, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.platforms import ISS_HRC
from reproduction.example_plans import plan_of
from reproduction.statements import Numbers

TILT_RAD = np.radians(5.0)
ZERO = np.array([0.0, 0.0, 1.0])  # the paper leaves its V open
OUTER, INNER = ISS_HRC.axes_platform
ALPHA_DEG, BETA_DEG = 60.0, 45.0  # how far a session over a city goes
SHAPE = (90, 120)  # of a grid over them, a degree a cell


def printed_target_m(latitude_rad: NDArray, longitude_rad: NDArray, height_m: NDArray) -> NDArray:
    """Eq. 8, with WGS 84's a_E and K_E."""
    k = WGS84_F
    n_m = WGS84_A_M / np.sqrt(1.0 - (2.0 * k - k**2) * np.sin(latitude_rad) ** 2)
    x = (n_m + height_m) * np.cos(latitude_rad) * np.cos(longitude_rad)
    y = (n_m + height_m) * np.cos(latitude_rad) * np.sin(longitude_rad)
    z = ((1.0 - 2.0 * k + k**2) * n_m + height_m) * np.sin(latitude_rad)
    return np.stack([x, y, z], axis=-1)


def printed_intersections(target: NDArray) -> NDArray:
    """Eq. 11 as printed: both directions L of n targets, (2, n, 3); NaN where there are none."""
    cosine, sine = np.cos(TILT_RAD), np.sin(TILT_RAD)
    along = -cosine * target[:, 1] + sine * target[:, 2]
    a, b, v_x = along / sine, cosine / sine, ZERO[0]
    root = 4.0 * a**2 * b**2 - 4.0 * (1.0 + b**2) * (v_x**2 - 1.0 + a**2)
    root = np.sqrt(np.where(root >= 0.0, root, np.nan))
    y = (-2.0 * a * b + np.array([[1.0], [-1.0]]) * root) / (2.0 * (1.0 + b**2))
    z = (along + y * cosine) / sine
    return np.stack([np.full_like(y, v_x), y, z], axis=-1)


@cache
def grid() -> tuple[NDArray, NDArray]:
    """Angles (n, 2) in rad over what a session asks for, and the error of the text's alpha."""
    alpha, beta = np.meshgrid(
        np.radians(np.arange(-ALPHA_DEG + 0.5, ALPHA_DEG)),
        np.radians(np.arange(-BETA_DEG + 0.5, BETA_DEG)),
    )
    angle_rad = np.stack([alpha.ravel(), beta.ravel()], axis=1)
    target = boresight_platform(ISS_HRC, angle_rad)
    turned = boresight_platform(ISS_HRC, angle_rad * [0.0, 1.0])
    as_told_rad = np.arccos(np.clip(np.sum(target * turned, axis=1), -1.0, 1.0))
    return angle_rad, as_told_rad - np.abs(angle_rad[:, 0])


def quaternion_line_of_sight() -> tuple[NDArray, NDArray, NDArray]:
    """By eq. 10 as printed and by the product, unit vectors (n, 3), and the range, (n,) m.

    The pass over Las Vegas; the mount D is one that does something.
    """
    scenario = plan_of("las_vegas_2015.json").scenario
    session = scenario.sessions[0]
    instants = Instants(session.start, np.linspace(0.0, 90.0, 46))
    ephemeris = scenario.orbit.ephemeris(session.start, session.stop)
    mount = Rotation.from_euler("xyz", [10.0, -20.0, 30.0], degrees=True)
    seen = line_of_sight(instants, ephemeris, scenario.attitude, mount, session.target)
    c_itrf = c_itrf_from_eci(instants)
    r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf, seen.states.r_sat_eci_m)
    v_m = session.target.r_target_itrf_m(instants) - r_sat_itrf_m
    # A quaternion q of a transition carries a vector's components as q~ o v o q.
    g = Rotation.from_matrix(c_itrf)
    a = scenario.attitude.q_body_from_eci(instants, seen.states).inv()
    d = mount.inv()
    chain = d.inv() * a.inv() * g.inv()
    platform = chain.apply(v_m)
    range_m = np.linalg.norm(platform, axis=1)
    return platform / range_m[:, None], seen.los_platform, range_m


def numbers() -> Numbers:
    return {**_chain(), **_intersections(), **_misread_angles()}


def _chain() -> Numbers:
    rng = np.random.default_rng(8)
    latitude, longitude = rng.uniform(-1.57, 1.57, 1000), rng.uniform(-3.14, 3.14, 1000)
    height_m = rng.uniform(-400.0, 9000.0, 1000)
    difference_m = printed_target_m(latitude, longitude, height_m) - itrf_from_geodetic(
        latitude, longitude, height_m
    )
    printed, ours, range_m = quaternion_line_of_sight()
    apart_rad = np.linalg.norm(printed - ours, axis=1)
    off_m = float((apart_rad * range_m).max())
    return {
        "target": float(np.abs(difference_m).max()) * 1e3,
        "line of sight": float(ours.shape[1]),
        "rotations": float(np.rad2deg(apart_rad.max())) * 3600.0,
        "off_m": off_m,
        "off_px": off_m / 1.15,
    }


def _intersections() -> Numbers:
    target = np.random.default_rng(11).normal(size=(20000, 3))
    target /= np.linalg.norm(target, axis=1, keepdims=True)
    printed = printed_intersections(target)
    branches = axis_angles(ISS_HRC, target)
    turned = np.stack([boresight_platform(ISS_HRC, one * [0.0, 1.0]) for one in branches.angle_rad])
    known = branches.reachable
    # The two solutions come in no order.
    apart = np.minimum(
        np.linalg.norm(printed - turned, axis=2).max(axis=0),
        np.linalg.norm(printed - turned[::-1], axis=2).max(axis=0),
    )
    found = np.isfinite(printed[..., 2]).all(axis=0)
    return {
        "axes": float(np.rad2deg(np.arccos(OUTER @ INNER))),
        "intersections": float(np.rad2deg(apart[known].max())) * 3600.0,
        "z as a root": 100.0 * float(np.mean(printed[:, known, 2] >= 0.0)),
        "missed": int(np.sum(found != known)),
        "keep_one": float(np.mean((printed[:, known, 2] >= 0.0).any(axis=0))),
    }


def _misread_angles() -> Numbers:
    angle_rad, error_rad = grid()
    turned = boresight_platform(ISS_HRC, angle_rad * [0.0, 1.0])
    beta_error_rad = np.arccos(np.clip(turned @ ZERO, -1.0, 1.0)) - np.abs(angle_rad[:, 1])
    return {
        "alpha as told": float(np.rad2deg(np.sqrt(np.mean(error_rad**2)))),
        "beta as told": float(np.rad2deg(np.abs(beta_error_rad).max())),
        "worst_deg": float(np.rad2deg(np.abs(error_rad).max())),
    }


def pictures(folder: Path) -> None:
    _draw_cones(folder / "reproduction_cones.png")
    _draw_error(folder / "reproduction_angles.png")


def _draw_cones(file: Path) -> None:
    target = boresight_platform(ISS_HRC, np.radians([[40.0, 25.0]]))
    lines = printed_intersections(target)[:, 0]
    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    panel = figure.add_subplot(projection="3d")
    around = np.linspace(0.0, 2.0 * np.pi, 121)
    for axis, start, colour in ((INNER, ZERO, "C0"), (OUTER, target[0], "C3")):
        circle = Rotation.from_rotvec(around[:, None] * axis).apply(start)
        x, y, z = (np.stack([0.0 * edge, edge]) for edge in circle.T)
        panel.plot_surface(x, y, z, color=colour, alpha=0.12)
        panel.plot(*circle.T, color=colour, lw=1.0)
    named = (
        ("V", ZERO, "C0"),
        ("T", target[0], "C3"),
        ("$A_β$", INNER, "C0"),
        ("$A_α$", OUTER, "C3"),
    )
    for name, direction, colour in named:
        is_axis = name.startswith("$")
        panel.plot(*np.stack([0.0 * direction, 1.25 * direction]).T, color=colour, lw=1.6,
                   ls="--" if is_axis else "-")  # fmt: skip
        panel.text(*(1.35 * direction), name, color=colour)
    beta_rad = np.abs(np.arctan2(-lines[:, 1], lines[:, 2]))
    for k, line in enumerate(lines):
        chosen = k == int(beta_rad.argmin())
        panel.plot(*np.stack([0.0 * line, 1.1 * line]).T, "k", lw=2.0, ls="-" if chosen else ":")
        panel.text(*(1.2 * line), "L", color="k")
    panel.set(xlabel="x", ylabel="y", zlabel="z", box_aspect=(1, 1, 1))
    ends = {f"{axis}{what}": (-1, 1) for axis in "xyz" for what in ("lim", "ticks")}
    panel.set(**ends)
    panel.view_init(elev=20.0, azim=-25.0)
    figure.savefig(file, dpi=100)


def _draw_error(file: Path) -> None:
    angle_rad, error_rad = grid()
    error_deg = np.rad2deg(error_rad).reshape(SHAPE)
    alpha_deg, beta_deg = (np.rad2deg(angle_rad[:, k]).reshape(SHAPE) for k in (0, 1))
    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    panel = figure.add_subplot()
    filled = panel.contourf(alpha_deg, beta_deg, error_deg, levels=12, cmap="Blues_r")
    lines = panel.contour(alpha_deg, beta_deg, error_deg, [-15, -10, -5, -2, -0.5], colors="k",
                          linewidths=0.6, linestyles="-")  # fmt: skip
    panel.clabel(lines, fmt="%g°", fontsize=8)
    figure.colorbar(filled, label="angle between T and L less |alpha|, deg")
    panel.set(xlabel="alpha, deg", ylabel="beta, deg")
    figure.savefig(file, dpi=100)
