"""Lomaka, Ustyugov 2016: the vertical from two pictures of the horizon."""

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import lru_cache
from itertools import product
from pathlib import Path

import numpy as np
from horizon_cases import angle_deg, camera, ring
from matplotlib.figure import Figure
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from estimator.camera import HorizonCamera
from estimator.limb.geometry import Limb
from estimator.pipeline import estimate_vertical
from estimator.rendering.scene import HorizonRenderer, Scene
from estimator.rendering.sensor import Sensor
from estimator.request import Body, HorizonRequest, Position, PredictedAttitude
from estimator.surroundings import Surroundings
from planner.base.arrays import Array
from planner.world.frames.geodesy import WGS84_A_M, WGS84_B_M, itrf_from_geodetic
from reproduction.lomaka_method import chord_body, horizon_arc_px, paper_nadir
from reproduction.report import Numbers

# The horizon of a sphere in a frame, its exact arc and what the paper's chord makes of it.
# No picture is taken: what is left is the method's own error, and that of whole pixels.
# Source: Lomaka, Ustyugov 2016, p. 467.

RADIUS_M = 6371e3
AZIMUTHS = 4000


def dip_rad(height_m: float) -> float:
    """How far below the level the horizon is seen."""
    return float(np.arccos(RADIUS_M / (RADIUS_M + height_m)))


def lens(width_deg: float, down_deg: float, azimuth_deg: float) -> HorizonCamera:
    """A 4:3 camera on a body whose +Z is nadir at zero pitch and yaw."""
    return camera("", azimuth_deg, down_deg=down_deg, width_deg=width_deg)


def limb_rays(nadir_body: Array, height_m: float) -> Array:
    """Unit vectors to the horizon all around, (n, 3): the cone of half-angle 90 deg - dip."""
    dip = dip_rad(height_m)
    across = np.linalg.svd(nadir_body[None])[2][1:]
    azimuth = np.linspace(-np.pi, np.pi, AZIMUTHS, endpoint=False)
    around = np.column_stack([np.cos(azimuth), np.sin(azimuth)]) @ across
    return np.asarray(np.sin(dip) * nadir_body + np.cos(dip) * around)


def longest_run(seen: Array) -> Array:
    """Indices of the longest run of True on a ring, in order; empty without any."""
    if np.all(seen):
        return np.arange(len(seen))
    start = int(np.argmin(seen))
    turned = np.roll(np.arange(len(seen)), -start)
    runs = np.split(turned, np.flatnonzero(np.diff(seen[turned].astype(int))) + 1)
    return max((run for run in runs if seen[run[0]]), key=len, default=turned[:0])


def arc_px(camera: HorizonCamera, nadir_body: Array, height_m: float) -> Array:
    """The longest arc of horizon in the frame, pixels (n, 2) in order; n may be 0."""
    xy_px = camera.pixels(limb_rays(nadir_body, height_m))
    edge = [camera.width_px - 1, camera.height_px - 1]
    seen = np.all((xy_px >= 0.0) & (xy_px <= edge), axis=1)
    return np.asarray(xy_px[longest_run(seen)])


def nadir_error_deg(
    cameras: tuple[HorizonCamera, HorizonCamera],
    nadir_body: Array,
    *,
    unit_rays: bool,
    whole_px: bool = False,
) -> float:
    """Of both chords' cross product, from 500 km; NaN where a camera has no arc of ten pixels."""
    chords = []
    for one in cameras:
        arc = arc_px(one, nadir_body, PAPERS_HEIGHT_M)
        if len(arc) < 2 or np.linalg.norm(arc[-1] - arc[0]) < 10.0:
            return float("nan")
        ends = arc[[0, -1]]
        chords.append(chord_body(one, np.rint(ends) if whole_px else ends, unit_rays))
    found = np.cross(*chords)
    across = np.linalg.norm(np.cross(found, nadir_body))
    return float(np.rad2deg(np.arctan2(across, abs(found @ nadir_body))))


def roll_error_deg(
    camera: HorizonCamera, nadir_body: Array, height_m: float, unit_rays: bool
) -> float:
    """Of one camera's chord about its boresight, its ends in whole pixels: how far it is from
    square to the nadir."""
    arc = arc_px(camera, nadir_body, height_m)
    if len(arc) < 2:
        return float("nan")
    chord = chord_body(camera, np.rint(arc[[0, -1]]), unit_rays)
    across = np.cross(camera.boresight_body, nadir_body)
    return float(np.rad2deg(np.arctan2(chord @ nadir_body, abs(chord @ across))))


def tilted_nadir(pitch_deg: float, yaw_deg: float) -> Array:
    """Nadir in body axes of a craft tilted about +X (yaw here) and +Y (pitch)."""
    yaw, pitch = np.deg2rad([yaw_deg, pitch_deg])
    level = np.array([np.sin(pitch), 0.0, np.cos(pitch)])
    c, s = np.cos(yaw), np.sin(yaw)
    return np.asarray(np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ level)


def printed_circle(axis: Array) -> Array:
    """The parametric circle (n, 3) as printed, in units of its R about the origin."""
    a, b, c = axis
    t = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
    ac, abc = np.hypot(a, c), np.linalg.norm(axis)
    return np.column_stack(
        [
            (c * np.cos(t) - a * b * np.sin(t) / abc) / ac,
            ac / abc * np.sin(t),
            -(c * np.cos(t) + b * c * np.sin(t) / abc) / ac,
        ]
    )


def geodetic_deg() -> float:
    """Most that geodetic and geocentric nadir differ at 500 km."""
    latitudes = np.deg2rad(np.arange(30.0, 61.0, 1.0))
    limbs = [Limb(itrf_from_geodetic(at, 0.0, 500e3), WGS84_A_M, WGS84_B_M) for at in latitudes]
    sines = [np.linalg.norm(np.cross(one.nadir_itrf, one.nadir_geodetic_itrf)) for one in limbs]
    return float(np.rad2deg(np.arcsin(max(sines))))


def points_needed() -> int:
    """Fewest rays d with d.n = sin(dip) that leave n and the dip no freedom but n's length."""
    rays = limb_rays(tilted_nadir(5.0, 3.0), 500e3)
    for count in range(1, 6):
        some = rays[:: len(rays) // count][:count]
        if np.linalg.matrix_rank(np.column_stack([some, -np.ones(count)])) == 3:
            return count
    raise ValueError("five rays don't fix the nadir")


# Limits of the paper's method (tilt, altitude, length of the arc), and sources of its errors.

MAP_DEG = np.arange(-30.0, 31.0, 3.0)
ROLLS_DEG = np.arange(-14.0, 14.1, 0.5)
PAPERS_HEIGHT_M = 500e3  # ours: the paper names none


def pair(width_deg: float, down_deg: float) -> tuple[HorizonCamera, HorizonCamera]:
    """Two cameras at right angles, each so far below the level (the paper's: 0)."""
    return lens(width_deg, down_deg, 0.0), lens(width_deg, down_deg, 90.0)


def error_map_deg(cameras: tuple[HorizonCamera, HorizonCamera], unit_rays: bool) -> Array:
    """Errors of chords in whole pixels over MAP_DEG of yaw (rows) and pitch."""
    errors = [
        nadir_error_deg(cameras, tilted_nadir(pitch, yaw), unit_rays=unit_rays, whole_px=True)
        for yaw, pitch in product(MAP_DEG, MAP_DEG)
    ]
    return np.reshape(errors, (len(MAP_DEG), len(MAP_DEG)))


def model_rms_deg(width_deg: float, height_m: float, *, unit_rays: bool) -> float:
    """Of one camera's pitch over ROLLS_DEG about its boresight, the horizon in the middle."""
    one = lens(width_deg, np.rad2deg(dip_rad(height_m)), 0.0)
    errors = [
        roll_error_deg(one, _turned(one.boresight_body, float(roll)), height_m, unit_rays)
        for roll in np.deg2rad(ROLLS_DEG)
    ]
    return float(np.sqrt(np.mean(np.square(errors))))


def _turned(axis: Array, angle: float) -> Array:
    nadir, c, s = np.array([0.0, 0.0, 1.0]), np.cos(angle), np.sin(angle)
    return np.asarray(c * nadir + s * np.cross(axis, nadir) + (1.0 - c) * (axis @ nadir) * axis)


def circle_misfit_px(width_deg: float) -> float:
    """Most that the horizon's arc in the middle of a frame departs from the circle nearest to it.

    Gauss-Newton in the largest departure: each step is a linear programme in the circle's changes.
    """
    one = lens(width_deg, np.rad2deg(dip_rad(PAPERS_HEIGHT_M)), 0.0)
    arc = arc_px(one, np.array([0.0, 0.0, 1.0]), PAPERS_HEIGHT_M)
    design = np.column_stack([2.0 * arc, np.ones(len(arc))])
    x, y, rest = np.linalg.lstsq(design, np.sum(arc**2, axis=1), rcond=None)[0]
    circle = np.array([x, y, np.sqrt(rest + x * x + y * y)])
    for _ in range(8):
        away = arc - circle[:2]
        distance = np.hypot(*away.T)
        off = distance - circle[2]
        slope = np.column_stack([-away / distance[:, None], -np.ones(len(arc))])
        bound = -np.ones((2 * len(arc), 1))
        rows = np.hstack([np.vstack([slope, -slope]), bound])
        step = linprog([0, 0, 0, 1], rows, np.append(-off, off), bounds=(None, None)).x
        circle += step[:3]
    return float(np.max(np.abs(np.hypot(*(arc - circle[:2]).T) - circle[2])))


# The paper's method and the product's estimator on the same rendered frames.
# The limb is the paper's: sharp and everywhere at one height, here 17.5 km above WGS84, from 500
# km.  Two 4:3 cameras 60 deg wide, 22 deg below the level so that the horizon is in the middle.

EPOCH = datetime(2026, 3, 20, 12, tzinfo=UTC)
POSITION = Position(frame="ITRF", position_km=(6878.0, 0.0, 0.0))
LEVEL = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
SHARP = Scene(constant_limb_m=17.5e3, cloud_cover=0.0, land=0.0)
SWEEP_DEG = (-14.0, -12.0, -9.0, -6.0, -3.0, 0.0, 3.0, 6.0, 9.0, 12.0, 14.0)


@lru_cache(maxsize=1)
def sweep() -> Array:
    """Errors over SWEEP_DEG of pitch, deg: as printed, between unit rays, of our estimator;
    (n, 3), NaN where a method gives none."""
    found = []
    for pitch_deg in SWEEP_DEG:
        request, images, truth = frames(pitch_deg)
        answer = estimate_vertical(images, request).geocentric
        nadirs = [paper_nadir(images, request.cameras, unit_rays) for unit_rays in (False, True)]
        nadirs.append(answer.nadir_body if answer else None)
        found.append([np.nan if nadir is None else angle_deg(nadir, truth) for nadir in nadirs])
    return np.array(found)


def frames(pitch_deg: float) -> tuple[HorizonRequest, list, Array]:
    """A request, its two images and the true geocentric nadir in body axes."""
    around = Surroundings(EPOCH, POSITION, Body())
    tilt = Rotation.from_euler("y", pitch_deg, degrees=True).as_matrix()
    c_body_from_itrf = tilt @ LEVEL
    cameras = ring(2)
    horizon = HorizonRenderer(around.limb.r_itrf_m, c_body_from_itrf, around.sun_itrf, SHARP, 3)
    images = [horizon.picture(one, Sensor()) for one in cameras]
    q = Rotation.from_matrix(c_body_from_itrf @ around.c_itrf_from_eci).as_quat()
    request = HorizonRequest(epoch=EPOCH, position=POSITION, cameras=cameras)
    told = PredictedAttitude(q_body_from_eci_xyzw=tuple(q.tolist()), sigma_deg=1.0)
    truth = np.asarray(c_body_from_itrf @ around.limb.nadir_itrf)
    return replace(request, predicted=told), images, truth


# The paper's experiment on the bench: a flat picture of the horizon before a tilting camera.
# A rig carries camera and accelerometer and is turned about a nearly level axis in front of a
# print or a screen.  What the camera finds for the tilt is compared with what the accelerometer
# says, both zeroed upright.  Lengths are in distances from which the flat picture's perspective
# is right.
# Source: Lomaka, Ustyugov 2016, p. 468-469; all sizes are assumed, the paper gives none.

HEIGHT_M = 500e3
HALF_WIDTH, HALF_HEIGHT = np.tan(np.deg2rad(30.0)), 0.75 * np.tan(np.deg2rad(30.0))
WIDTH_PX = 640
TILTS_DEG = np.linspace(-14.0, 14.0, 29)
SWING_S = 20.0  # of a full swing to both sides, during which the video runs


@dataclass(frozen=True, kw_only=True)
class Rig:
    """What is not as it should be; all zeros (distance 1) is a perfect one.

    distance: of the camera, by that from which the picture's perspective is right.
    off_square_deg: of the print, about the upright axis through its middle.
    leaning_deg: of the print, about the level axis through its middle.
    off_middle: how far below the frame's middle the horizon is, by half the frame's height.
    axis_off_deg: of the axis of tilt from the optical axis, sideways.
    pivot_below: the axis passes so far below the lens.
    distortion: of the lens, at the frame's corner, by the distance from the middle.
    whole_px: whether the arc's ends are whole pixels of a frame 640 wide.
    edge_noise_px: 1-sigma of each end.
    scale_error: of the accelerometer's sideways channel.  quantum_g, noise_g: of a sample.
    delay_s: of the video behind the accelerometer, during the swing.
    """

    distance: float = 1.0
    off_square_deg: float = 0.0
    leaning_deg: float = 0.0
    off_middle: float = 0.0
    axis_off_deg: float = 0.0
    pivot_below: float = 0.0
    distortion: float = 0.0
    whole_px: bool = False
    edge_noise_px: float = 0.0
    scale_error: float = 0.0
    quantum_g: float = 0.0
    noise_g: float = 0.0
    delay_s: float = 0.0


def horizon_print(count: int = 1600) -> Array:
    """Points (n, 2) of the horizon on the print: seen from 500 km, its top in the middle.

    x to the right, y down, in distances; it goes on beyond what the camera sees at first.
    """
    dip = dip_rad(HEIGHT_M)
    # The optical axis (+z) points at the horizon, nadir is mostly down (+y).
    rays = limb_rays(np.array([0.0, np.cos(dip), np.sin(dip)]), HEIGHT_M)
    ahead = rays[rays[:, 2] > 0.25]
    flat = ahead[:, :2] / ahead[:, 2:]
    order = np.argsort(flat[:, 0])
    # Close together in the middle, where most rigs see it.
    x = 3.6 * np.sinh(np.linspace(-3.0, 3.0, count)) / np.sinh(3.0)
    return np.column_stack([x, np.interp(x, flat[order, 0], flat[order, 1])])


def seen(print_xy: Array, rig: Rig, tilt_rad: float) -> Array:
    """Where the camera sees points (n, 2) of the print, on its own plane at unit depth, (n, 2)."""
    plane = Rotation.from_euler("yx", [rig.off_square_deg, rig.leaning_deg], degrees=True)
    point = plane.apply(np.column_stack([print_xy, np.zeros(len(print_xy))]))
    point += [0.0, rig.off_middle * HALF_HEIGHT * rig.distance, rig.distance]
    off = np.deg2rad(rig.axis_off_deg)
    turn = Rotation.from_rotvec(tilt_rad * np.array([np.sin(off), 0.0, np.cos(off)]))
    pivot = np.array([0.0, rig.pivot_below, 0.0])
    lens_at = pivot - turn.apply(pivot)
    x, y, z = turn.inv().apply(point - lens_at).T
    flat = np.column_stack([x, y]) / z[:, None]
    far2 = np.sum(flat**2, axis=1, keepdims=True) / (HALF_WIDTH**2 + HALF_HEIGHT**2)
    return np.asarray(flat * (1.0 + rig.distortion * far2))


def found_tilt_rad(
    print_xy: Array, rig: Rig, tilt_rad: float, random: np.random.Generator
) -> float:
    """The tilt the camera finds by the chord between its arc's ends; NaN without an arc."""
    flat = seen(print_xy, rig, tilt_rad)
    inside = (np.abs(flat[:, 0]) <= HALF_WIDTH) & (np.abs(flat[:, 1]) <= HALF_HEIGHT)
    run = longest_run(inside)
    if len(run) < 2:
        return float("nan")
    ends = flat[run[[0, -1]]]
    pixel = 2.0 * HALF_WIDTH / WIDTH_PX
    ends = ends + rig.edge_noise_px * pixel * random.standard_normal((2, 2))
    if rig.whole_px:
        ends = np.rint(ends / pixel) * pixel
    rays = np.column_stack([ends, np.ones(2)])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    x, y, z = rays[1] - rays[0]
    # Square to the nadir [-sin, cos] cos(dip) + [0, 0, sin(dip)], the camera looking at the
    # horizon as it believes.
    lift = np.arcsin(np.clip(z * np.tan(dip_rad(HEIGHT_M)) / np.hypot(x, y), -1.0, 1.0))
    return -float(np.arctan2(y, x) + lift)


def told_tilt_rad(tilt_rad: Array, rig: Rig, random: np.random.Generator) -> Array:
    """What the accelerometer tells at tilts (n,), from both its channels."""
    g = np.stack([np.sin(tilt_rad) * (1.0 + rig.scale_error), np.cos(tilt_rad)])
    g = g + rig.noise_g * random.standard_normal(g.shape)
    if rig.quantum_g > 0.0:
        g = np.rint(g / rig.quantum_g) * rig.quantum_g
    return np.asarray(np.arctan2(g[0], g[1]))


def rms_deg(rig: Rig, seed: int = 0) -> float:
    """Of camera minus accelerometer over TILTS_DEG, both zeroed upright."""
    random = np.random.default_rng(seed)
    tilt_rad = np.deg2rad(TILTS_DEG)
    # A swing about its middle: fast upright, at rest at the ends.
    rate_rad_s = 2.0 * np.pi / SWING_S * np.sqrt(tilt_rad[-1] ** 2 - tilt_rad**2)
    print_xy = horizon_print()
    found_rad = np.array(
        [
            found_tilt_rad(print_xy, rig, float(late_rad), random)
            for late_rad in tilt_rad - rate_rad_s * rig.delay_s
        ]
    )
    upright = replace(rig, noise_g=0.0, edge_noise_px=0.0, whole_px=False)
    zero_found = found_tilt_rad(print_xy, upright, 0.0, random)
    zero_told = told_tilt_rad(np.zeros(1), upright, random)[0]
    told_rad = told_tilt_rad(tilt_rad, rig, random)
    off_deg = np.rad2deg((found_rad - zero_found) - (told_rad - zero_told))
    return float(np.sqrt(np.nanmean(off_deg**2)))


# The experiment of Lomaka, Ustyugov 2016, simulated: what makes 0.752 deg of a model's 0.038.

DRAWS = 300
# Usual imperfections, assumed (1 sigma), by field of Rig; the accelerometer's from a common one's
# data sheet (ADXL345: 3.9 mg a step, 0.75 steps of noise, sensitivity within 10 %).
USUAL = {
    "scale_error": 0.05,
    "off_middle": 0.15,
    "pivot_below": 0.1,
    "axis_off_deg": 3.0,
    "leaning_deg": 3.0,
    "off_square_deg": 3.0,
    "distortion": 0.03,
}
USUAL_OF_ALL = {"quantum_g": 0.0039, "noise_g": 0.0029}
FARTHER, DELAY_S = 0.3, 0.08  # than the picture's perspective; of the video, swinging 14 deg in 5 s
VIDEO = Sensor(full_well_e=2e3, read_noise_e=40.0, jpeg_quality=50)
QUIET = Sensor(full_well_e=0.0)


def frame_noise_px() -> float:
    """1-sigma of an arc's ends by noise and coding of a video frame, as the paper's method finds.

    Rendered frames, the same with and without noise, at six attitudes.
    """
    around, [camera] = Surroundings(EPOCH, POSITION, Body()), ring(1)
    random, shifts = np.random.default_rng(4), []
    for roll in np.deg2rad([-14.0, -8.0, -2.0, 3.0, 9.0, 14.0]):
        c, s = np.cos(roll), np.sin(roll)
        turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        horizon = HorizonRenderer(
            around.limb.r_itrf_m, turn @ LEVEL, around.sun_itrf, SHARP, seed=3
        )
        light = horizon.radiance(camera, random)
        ends = []
        for sensor in (QUIET, VIDEO):
            arc = horizon_arc_px(sensor.expose(light, random), camera)
            if arc is None:
                raise RuntimeError("no horizon is found in a plain frame")
            ends.append(arc[0])
        along = ends[0][1] - ends[0][0]
        across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
        shifts.append((ends[1] - ends[0]) @ across)
    return float(np.sqrt(np.mean(np.square(shifts))))


def drawn_rigs(noise_px: float) -> Array:
    """Rms differences of rigs whose causes are all drawn at their usual sizes, deg."""
    found = []
    for seed in range(DRAWS):
        random = np.random.default_rng(seed)
        sizes = {name: usual * random.standard_normal() for name, usual in USUAL.items()}
        distance = float(np.exp(FARTHER * random.standard_normal()))
        delay_s = abs(DELAY_S * random.standard_normal())
        own = Rig(whole_px=True, edge_noise_px=noise_px, distance=distance, delay_s=delay_s)
        found.append(rms_deg(replace(own, **USUAL_OF_ALL, **sizes), seed))
    return np.array(found)


def experiment_numbers() -> Numbers:
    noise_px = frame_noise_px()
    alone = {**USUAL, **USUAL_OF_ALL, "distance": 1.0 + FARTHER, "delay_s": DELAY_S}
    alone["edge_noise_px"] = noise_px
    squares = [rms_deg(Rig(**{name: size})) ** 2 for name, size in alone.items()]
    return {
        "experiment's error": float(np.median(drawn_rigs(noise_px))),
        "noise of the frames": rms_deg(Rig(edge_noise_px=noise_px, whole_px=True)),
        "imperfect rig": float(np.sqrt(sum(squares))),
    }


# The vertical from two cameras: Lomaka, Ustyugov 2016, its equations, Figs. 3, 5 and 6.

MODEL_DEG = 0.038
FIELDS_DEG = (20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
DOWN_DEG = float(np.rad2deg(dip_rad(PAPERS_HEIGHT_M)))


def vertical_numbers() -> Numbers:
    axis = np.array([0.0, 0.0, 1.0])  # of the horizon's circle: the vertical at (0, 0, R + H)
    printed = np.linalg.norm(printed_circle(axis), axis=1)
    return {
        "circle's radii": float(printed.max() / printed.min()),
        "circle's size": float(np.sin(dip_rad(PAPERS_HEIGHT_M))),
        "circle on the image": circle_misfit_px(60.0),
        "chord in the image plane": nadir_error_deg(
            pair(60.0, DOWN_DEG), tilted_nadir(12.0, 12.0), unit_rays=False
        ),
        "sphere": geodetic_deg(),
        "model's error": model_rms_deg(60.0, PAPERS_HEIGHT_M, unit_rays=True),
        "pitch sweep, edges found": float(np.sqrt(np.nanmean(sweep()[:, 1] ** 2))),
        "three points": float(points_needed()),
    }


def draw_vertical(folder: Path) -> None:
    _draw_map().savefig(folder / "reproduction_vertical_map.png", dpi=90)
    _draw_model().savefig(folder / "reproduction_vertical_model.png", dpi=90)


def _draw_map() -> Figure:
    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    rows = figure.subplots(2, 2, sharex=True, sharey=True)
    for row, (down_deg, aim) in zip(
        rows, ((0.0, "level (Fig. 2)"), (DOWN_DEG, "at the horizon")), strict=True
    ):
        for panel, unit_rays in zip(row, (False, True), strict=True):
            errors = error_map_deg(pair(60.0, down_deg), unit_rays)
            shown = panel.pcolormesh(
                MAP_DEG,
                MAP_DEG,
                np.log10(np.maximum(errors, 1e-3)),
                vmin=-2.5,
                vmax=1.0,
                cmap="viridis",
            )
            yaw, pitch = np.nonzero(np.isnan(errors))
            panel.plot(MAP_DEG[pitch], MAP_DEG[yaw], "x", color="0.6", ms=3.0)
            name = "between unit rays" if unit_rays else "as printed"
            panel.set_title(f"cameras {aim}, chord {name}", fontsize="medium")
        row[0].set_ylabel("yaw, deg")
    for panel in rows[-1]:
        panel.set_xlabel("pitch, deg")
    bar = figure.colorbar(shown, ax=rows, ticks=[-2, -1, 0, 1])
    bar.ax.set_yticklabels(["0.01", "0.1", "1", "10"])
    bar.set_label("error of the vertical, deg")
    return figure


def _draw_model() -> Figure:
    figure = Figure(figsize=(10.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    for height_m, dash in ((300e3, ":"), (500e3, "-"), (700e3, "--")):
        for unit_rays, colour in ((False, "C1"), (True, "C0")):
            name = "unit rays" if unit_rays else "as printed"
            rms = [model_rms_deg(f, height_m, unit_rays=unit_rays) for f in FIELDS_DEG]
            label = f"{name}, {height_m / 1e3:.0f} km"
            left.plot(FIELDS_DEG, rms, color=colour, ls=dash, label=label)
    left.axhline(MODEL_DEG, color="0.3", lw=0.8)
    left.annotate("the paper: 0.038", (62.0, 0.041), fontsize="small", color="0.3")
    left.set(xlabel="width of the field, deg", ylabel="rms of pitch, deg", yscale="log")
    left.legend(fontsize="x-small")
    errors = sweep()
    for k, name in enumerate(("as printed", "unit rays", "our estimator")):
        right.plot(SWEEP_DEG, errors[:, k], "o-", color=("C1", "C0", "C2")[k], ms=3, label=name)
    right.axhline(MODEL_DEG, color="0.3", lw=0.8)
    right.set(xlabel="pitch, deg", ylabel="error of the vertical, deg", yscale="log")
    right.legend(fontsize="x-small")
    return figure
