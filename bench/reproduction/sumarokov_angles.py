"""From the target to the angles of the axes: Sumarokov 2016, eqs. 8 to 11."""

from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.frames.earth_orientation import c_itrf_from_eci
from planner.frames.geodesy import WGS84_A_M, WGS84_F, itrf_from_geodetic
from planner.frames.time_scales import Instants
from planner.platforms import ISS_HRC
from planner.pointing.angles import axis_angles, boresight_platform
from planner.pointing.line_of_sight import line_of_sight
from reproduction.example_plans import plan_of
from reproduction.statements import Picture, Statement, holds, judge

PAPER = "Sumarokov 2016"
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


def statements() -> list[Statement]:
    return [*_target(), *_axes(), *_misread_angles()]


def _target() -> list[Statement]:
    rng = np.random.default_rng(8)
    latitude, longitude = rng.uniform(-1.57, 1.57, 1000), rng.uniform(-3.14, 3.14, 1000)
    height_m = rng.uniform(-400.0, 9000.0, 1000)
    difference_m = printed_target_m(latitude, longitude, height_m) - itrf_from_geodetic(
        latitude, longitude, height_m
    )
    worst_mm = float(np.abs(difference_m).max()) * 1e3
    printed, ours, range_m = quaternion_line_of_sight()
    apart_rad = np.linalg.norm(printed - ours, axis=1)
    return [
        Statement(
            paper=PAPER,
            place="eq. 8",
            name="target",
            says="the target's place from latitude, longitude and height",
            stated=0.0,
            ours=worst_mm,
            unit="mm",
            tolerance=0.01,
            verdict=judge(0.0, worst_mm, 0.01),
            why="at 1,000 places of all latitudes, beside ours",
        ),
        Statement(
            paper=PAPER,
            place="eq. 9",
            name="line of sight",
            says="V = T - X, the target's place less the carrier's state",
            stated=6.0,
            ours=float(ours.shape[1]),
            unit="components",
            verdict="differs",
            why="X in (6) and (7) holds the velocity, too, of which a place can't be subtracted: "
            "meant are its first three components",
        ),
        Statement(
            paper=PAPER,
            place="eq. 10",
            name="rotations",
            says="T = D~ A~ G~ V G A D: the line of sight in the platform's frame",
            stated=0.0,
            ours=float(np.rad2deg(apart_rad.max())) * 3600.0,
            unit="arcsec at most",
            tolerance=0.1,
            verdict="differs",
            why="over Las Vegas, the mount being turned about all axes: the order of rotations is "
            "right, but the paper looks at where the target is; light comes from where it seems to "
            "be (aberration, light time, refraction), "
            f"{float((apart_rad * range_m).max()):.0f} m on the ground, "
            f"{float((apart_rad * range_m).max()) / 1.15:.0f} pixels, too little to lose it",
        ),
    ]


def _axes() -> list[Statement]:
    rng = np.random.default_rng(11)
    target = rng.normal(size=(20000, 3))
    target /= np.linalg.norm(target, axis=1, keepdims=True)
    printed = printed_intersections(target)
    branches = axis_angles(ISS_HRC, target)
    turned = np.stack(
        [
            boresight_platform(ISS_HRC, branches.angle_rad[k] * [0.0, 1.0])
            for k in range(len(branches.angle_rad))
        ]
    )
    known = branches.reachable
    # The two solutions come in no order.
    apart = np.minimum(
        np.linalg.norm(printed - turned, axis=2).max(axis=0),
        np.linalg.norm(printed - turned[::-1], axis=2).max(axis=0),
    )
    found = np.isfinite(printed[..., 2]).all(axis=0)
    lost = float(np.mean(printed[:, known, 2] < 0.0))
    kept_one = float(np.mean((printed[:, known, 2] >= 0.0).any(axis=0)))
    square_deg = float(np.rad2deg(np.arccos(OUTER @ INNER)))
    return [
        Statement(
            paper=PAPER,
            place="eq. 11",
            name="axes",
            says="A_beta = [1, 0, 0], A_alpha = [0, -cos 5°, sin 5°]",
            stated=90.0,
            ours=square_deg,
            unit="deg apart",
            verdict=judge(90.0, square_deg, 1e-9),
            why="the platform `iss-hrc`; alpha's axis leans 5 deg out of the base. The paper "
            "leaves the zero direction V open, ours is +Z",
        ),
        Statement(
            paper=PAPER,
            place="eq. 11",
            name="intersections",
            says="two lines in which the cones meet",
            stated=0.0,
            ours=float(np.rad2deg(apart[known].max())) * 3600.0,
            unit="arcsec at most",
            tolerance=0.01,
            verdict=holds(np.array_equal(found, known)),
            why="in 20,000 directions over the whole sphere the printed y and z = a + b y give "
            "both of our solutions",
        ),
        Statement(
            paper=PAPER,
            place="p. 90",
            name="z as a root",
            says="z = +sqrt(1 - x² - y²), before (11): the solutions that it has",
            stated=100.0,
            ours=100.0 * (1.0 - lost),
            unit="% of the solutions",
            tolerance=1.0,
            verdict="differs",
            why="of two solutions in each direction that can be reached, the positive root has but "
            f"this share; {kept_one:.0%} of the directions keep one. The squared equation, and so "
            "(11), has them all",
        ),
    ]


def _misread_angles() -> list[Statement]:
    angle_rad, error_rad = grid()
    alpha_deg = float(np.rad2deg(np.sqrt(np.mean(error_rad**2))))
    turned = boresight_platform(ISS_HRC, angle_rad * [0.0, 1.0])
    beta_error_rad = np.arccos(np.clip(turned @ ZERO, -1.0, 1.0)) - np.abs(angle_rad[:, 1])
    beta_deg = float(np.rad2deg(np.abs(beta_error_rad).max()))
    return [
        Statement(
            paper=PAPER,
            place="p. 90",
            name="alpha as told",
            says="alpha is the angle between T and L",
            stated=0.0,
            ours=alpha_deg,
            unit="deg rms off",
            tolerance=0.02,
            verdict=judge(0.0, alpha_deg, 0.01),
            why=f"over |alpha| < {ALPHA_DEG:.0f}, |beta| < {BETA_DEG:.0f} deg, at most "
            f"{float(np.rad2deg(np.abs(error_rad).max())):.1f} deg, and the sign is lost, too. "
            "Meant is the signed angle about the axis",
        ),
        Statement(
            paper=PAPER,
            place="p. 90",
            name="beta as told",
            says="beta is the angle between V and L",
            stated=0.0,
            ours=beta_deg,
            unit="deg off at most",
            tolerance=1e-3,
            verdict=judge(0.0, beta_deg, 1e-3),
            why="V stands square to beta's axis, so that only the sign is lost; for another V it "
            "would go as alpha does",
        ),
    ]


def pictures(folder: Path) -> list[Picture]:
    _draw_cones(folder / "reproduction_cones.png")
    _draw_error(folder / "reproduction_angles.png")
    return [
        Picture(
            file="reproduction_cones.png",
            shows="The two cones and both lines in which they meet",
            text="As Fig. 1, for alpha 40°, beta 25°: the zero direction V turns about beta's axis "
            "(blue), the target T about alpha's (red). They meet in two lines L; the one with the "
            "smaller turn of beta is taken (solid).",
        ),
        Picture(
            file="reproduction_angles.png",
            shows="How far the angle between T and L is from the angle alpha has to turn",
        ),
    ]


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
