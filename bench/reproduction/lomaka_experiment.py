"""The experiment of Lomaka, Ustyugov 2016, simulated: what makes 0.752 deg of a model's 0.038."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from horizon_cases import ring
from matplotlib.figure import Figure
from scipy.optimize import brentq

from estimator.rendering.scene import HorizonRenderer
from estimator.rendering.sensor import Sensor
from estimator.request import Body
from estimator.surroundings import Surroundings
from planner.base.arrays import Array
from reproduction.lomaka_method import horizon_arc_px
from reproduction.lomaka_print import TILTS_DEG, Rig, differences_deg, rms_deg
from reproduction.lomaka_rendered import EPOCH, LEVEL, POSITION, SHARP
from reproduction.statements import Numbers

EXPERIMENT_DEG = 0.752
DRAWS = 300
TOLD = ("scale_error", "delay_s", "noise_g", "quantum_g")  # of what the accelerometer tells
VIDEO = Sensor(full_well_e=2e3, read_noise_e=40.0, jpeg_quality=50)
QUIET = Sensor(full_well_e=0.0)


class Cause(NamedTuple):
    """Something that may be wrong with the rig: a field of it, its usual size and its largest.

    Usual sizes are assumed (1 sigma), the accelerometer's from a common one's data sheet
    (ADXL345: 3.9 mg a step, 0.75 steps of noise, sensitivity within 10 %).
    """

    name: str
    field: str
    usual: float
    largest: float
    unit: str
    factor: float = 1.0  # from the field's unit to the one shown


CAUSES = (
    Cause("accelerometer's scale", "scale_error", 0.05, 0.2, "%", 100.0),
    Cause("video late, rig swinging 14 deg in 5 s", "delay_s", 0.08, 1.0, "s"),
    Cause("accelerometer's noise", "noise_g", 0.0029, 0.05, "mg", 1e3),
    Cause("accelerometer's step", "quantum_g", 0.0039, 0.1, "mg", 1e3),
    Cause("camera farther than the picture's perspective", "distance", 0.3, 5.0, "times farther"),
    Cause("horizon below the frame's middle", "off_middle", 0.15, 0.95, "% of half", 100.0),
    Cause("axis of tilt below the lens", "pivot_below", 0.1, 1.5, "% of distance", 100.0),
    Cause("axis of tilt off the optical axis", "axis_off_deg", 3.0, 40.0, "deg"),
    Cause("print leaning", "leaning_deg", 3.0, 40.0, "deg"),
    Cause("print turned aside", "off_square_deg", 3.0, 40.0, "deg"),
    Cause("lens distortion at the corner", "distortion", 0.03, 0.4, "%", 100.0),
    Cause("noise of the arc's ends", "edge_noise_px", 0.0, 12.0, "px"),
)


def rig_with(cause: Cause, size: float) -> Rig:
    """One cause alone."""
    base = 1.0 if cause.field == "distance" else 0.0
    return replace(Rig(), **{cause.field: base + size})


def size_for(cause: Cause, unit_rays: bool) -> float:
    """How large a cause must be to make the experiment's error by itself; NaN: no size does."""

    def short_of(size: float) -> float:
        seeds = range(6 if cause.field in ("noise_g", "edge_noise_px") else 1)
        squares = [rms_deg(rig_with(cause, size), unit_rays=unit_rays, seed=s) ** 2 for s in seeds]
        return float(np.sqrt(np.mean(squares))) - EXPERIMENT_DEG

    # Not every one makes ever more: the first size that is enough.
    tried = np.linspace(0.0, cause.largest, 13)
    enough = next((k for k, size in enumerate(tried) if short_of(size) > 0.0), None)
    if enough is None:
        return float("nan")
    return float(brentq(short_of, tried[enough - 1], tried[enough], xtol=1e-4 * cause.largest))


def typical(cause: Cause, noise_px: float) -> float:
    """The usual size; of the ends' noise the measured one."""
    return noise_px if cause.field == "edge_noise_px" else cause.usual


@lru_cache(maxsize=1)
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


@lru_cache(maxsize=2)
def drawn_rigs(unit_rays: bool) -> Array:
    """Rms differences of rigs whose causes are all drawn at their usual sizes, deg, sorted."""
    noise_px, found = frame_noise_px(), []
    for seed in range(DRAWS):
        random = np.random.default_rng(seed)
        rig = Rig(whole_px=True, quantum_g=0.0039, noise_g=0.0029, edge_noise_px=noise_px)
        sizes = {
            cause.field: cause.usual * random.standard_normal()
            for cause in CAUSES
            if cause.field not in ("quantum_g", "noise_g", "edge_noise_px", "distance", "delay_s")
        }
        distance = float(np.exp(0.3 * random.standard_normal()))
        delay_s = abs(0.08 * random.standard_normal())
        rig = replace(rig, distance=distance, delay_s=delay_s, **sizes)
        found.append(rms_deg(rig, unit_rays=unit_rays, seed=seed))
    return np.sort(found)


@lru_cache(maxsize=1)
def causes_alone() -> tuple[tuple[Cause, float, float, float], ...]:
    """Each cause, its rms at its usual size (unit rays), and the sizes that make 0.752 deg:
    between unit rays, as printed."""
    noise_px = frame_noise_px()
    return tuple(
        (
            cause,
            rms_deg(rig_with(cause, typical(cause, noise_px)), unit_rays=True),
            size_for(cause, unit_rays=True),
            size_for(cause, unit_rays=False),
        )
        for cause in CAUSES
    )


def numbers() -> Numbers:
    noise_px = frame_noise_px()
    unit, printed = drawn_rigs(unit_rays=True), drawn_rigs(unit_rays=False)
    low, high = np.quantile(unit, [0.05, 0.95])
    alone = {row[0].field: row for row in causes_alone()}
    told_deg, seen_deg = (
        float(np.sqrt(sum(row[1] ** 2 for field, row in alone.items() if (field in TOLD) is told)))
        for told in (True, False)
    )
    sizes = [
        f"{cause.name} {cause.factor * size:.3g} {cause.unit}"
        for cause, _, size, _ in causes_alone()
        if not np.isnan(size)
    ]
    return {
        "experiment's error": float(np.median(unit)),
        "noise of the frames": rms_deg(Rig(edge_noise_px=noise_px, whole_px=True), unit_rays=True),
        "imperfect rig": float(np.hypot(told_deg, seen_deg)),
        "flat picture": rms_deg(Rig(), unit_rays=False),
        "rigs": DRAWS,
        "low": float(low),
        "high": float(high),
        "median_printed": float(np.median(printed)),
        "as_bad": 100.0 * float(np.mean(unit >= EXPERIMENT_DEG)),
        "noise_px": noise_px,
        "told_deg": told_deg,
        "seen_deg": seen_deg,
        "sizes": "; ".join(sizes),
        "flat_unit_rays": rms_deg(Rig(), unit_rays=True),
        "from_half": rms_deg(Rig(distance=0.5), unit_rays=False),
        "from_twice": rms_deg(Rig(distance=2.0), unit_rays=False),
        "distance": 1.0 + alone["distance"][3],
    }


def pictures(folder: Path) -> None:
    figure = Figure(figsize=(10.0, 4.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    examples = (
        ("perfect rig, as printed", Rig(), False),
        ("twice the distance, as printed", Rig(distance=2.0), False),
        ("accelerometer's scale 9 % off", Rig(scale_error=0.09), True),
        ("axis 25 % above the lens", Rig(pivot_below=-0.25), True),
        ("video 0.2 s late", Rig(delay_s=0.2), True),
        ("noise of frame and accelerometer", Rig(whole_px=True, noise_g=0.0029), True),
    )
    for name, rig, unit_rays in examples:
        left.plot(TILTS_DEG, differences_deg(rig, unit_rays=unit_rays), label=name, lw=1.2)
    left.axhspan(-EXPERIMENT_DEG, EXPERIMENT_DEG, color="0.9", zorder=0)
    left.set(xlabel="tilt of the rig, deg", ylabel="camera minus accelerometer, deg")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    rows = sorted(causes_alone(), key=lambda row: row[1])
    right.barh([row[0].name for row in rows], [row[1] for row in rows], color="C0")
    right.axvline(EXPERIMENT_DEG, color="0.3", lw=0.8)
    right.tick_params(axis="y", labelsize="small")
    right.set_xlabel("rms at its usual size, deg")
    right.annotate("the paper", (0.74, 0.0), ha="right", fontsize="small", color="0.3")
    figure.savefig(folder / "reproduction_vertical_print.png", dpi=90)
