"""The vertical from two cameras: Lomaka, Ustyugov 2016, its equations, Figs. 3, 5 and 6."""

from functools import lru_cache, partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from estimator.search.plausibility import MIN_ARC_OF_ALL_RAD
from planner.arrays import Array
from reproduction.lomaka_bands import Bands, over_an_orbit
from reproduction.lomaka_edge import (
    MAP_DEG,
    PAPERS_HEIGHT_M,
    circle_misfit_px,
    edge_deg,
    error_map_deg,
    highest_m,
    model_rms_deg,
    pair,
    strip_rms_deg,
)
from reproduction.lomaka_geometry import (
    RADIUS_M,
    dip_rad,
    geodetic_deg,
    nadir_error_deg,
    points_needed,
    printed_circle,
    tilted_nadir,
)
from reproduction.lomaka_rendered import SWEEP_DEG, error_map, errors_deg, real_air, sweep
from reproduction.statements import Picture, Statement, judge

MODEL_DEG = 0.038
FIELDS_DEG = (20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
DOWN_DEG = float(np.rad2deg(dip_rad(PAPERS_HEIGHT_M)))
said = partial(Statement, paper="Lomaka 2016")


def statements() -> list[Statement]:
    return [*_method(), *_figures(), *_edges(), *_bands()]


def _method() -> list[Statement]:
    axis = np.array([0.0, 0.0, 1.0])  # of the horizon's circle: the vertical at (0, 0, R + H)
    printed = np.linalg.norm(printed_circle(axis, corrected=False), axis=1)
    mended = np.linalg.norm(printed_circle(axis, corrected=True), axis=1)
    radius = np.cos(dip_rad(PAPERS_HEIGHT_M))  # R sqrt(H(2R + H)) / (R + H) is R times
    seen_share = np.sin(np.arccos(RADIUS_M / (RADIUS_M + PAPERS_HEIGHT_M)))
    misfit_px = circle_misfit_px(60.0)
    exact, flat = (
        nadir_error_deg(
            pair(60.0, DOWN_DEG), tilted_nadir(12.0, 12.0), PAPERS_HEIGHT_M, unit_rays=unit
        )
        for unit in (True, False)
    )
    geodetic = geodetic_deg()
    return [
        said(
            place="equations of the circle",
            name="circle's radii",
            says="x, y, z of the horizon's arc with parameter t are a circle of radius R",
            ours=float(printed.max() / printed.min()),
            unit="greatest by least radius",
            tolerance=0.001,
            verdict="differs",
            why="as printed it is an ellipse about all axes but those with a = c: about the "
            "vertical its radii differ by this factor and its plane leans by 45 deg; with a cos t "
            f"for c cos t in z the quotient is {mended.max() / mended.min():.6f}",
        ),
        said(
            place="equations of the circle",
            name="circle's size",
            says="the horizon's circle has the Earth's radius R",
            stated=1.0,
            ours=float(seen_share),
            unit="R",
            tolerance=1e-4,
            verdict="differs",
            why="from 500 km the circle of touching points has R sqrt(H(2R+H))/(R+H) about "
            f"{radius:.4f} R along the vertical, R only from infinitely far; a, b, c must be the "
            "vertical's, not the boresight's",
        ),
        said(
            place="text at the circle",
            name="circle on the image",
            says="the horizon is an arc of a circle on the detector",
            ours=misfit_px,
            unit="px",
            tolerance=0.02,
            verdict="differs",
            why="it is a conic, from a low orbit a hyperbola; the best circle is at most so far "
            "off in a frame 640 px and 60 deg wide in whose middle the horizon lies, little beside "
            f"a pixel; {circle_misfit_px(40.0):.2f} px at 40 deg, {circle_misfit_px(90.0):.2f} at "
            "90",
        ),
        said(
            place="text before Fig. 1",
            name="chord in the image plane",
            says="the vector that joins the arc's ends is square to the direction to the Earth's "
            "centre",
            ours=flat,
            unit="deg",
            tolerance=0.02,
            verdict="differs",
            why="of the nadir at pitch and yaw 12 deg, exact points, as joined on the image; "
            f"between unit rays it is exact at any tilt ({exact:.0e} deg left)",
        ),
        said(
            place="statement of the problem",
            name="sphere",
            says="the Earth is a sphere x² + y² + z² = R²",
            ours=geodetic,
            unit="deg",
            tolerance=0.002,
            verdict="differs",
            why="most that geodetic and geocentric nadir differ at 500 km: five times the model's "
            "stated error; our estimator works with the ellipsoid and gives both",
        ),
    ]


def _figures() -> list[Statement]:
    over_map, over_sweep = _rms(error_map()), _rms(sweep(SWEEP_DEG))
    widths = {px: model_rms_deg(60.0, PAPERS_HEIGHT_M, unit_rays=True, width_px=px) for px in
              (320, 640, 1280)}  # fmt: skip
    narrow = max(f for f in FIELDS_DEG if _model(f, unit_rays=False) < 1.2 * MODEL_DEG)
    return [
        said(
            place="Figs. 5, 6",
            name="model's error",
            says="standard deviation of the model",
            stated=MODEL_DEG,
            ours=widths[640],
            unit="deg",
            tolerance=0.004,
            verdict=judge(MODEL_DEG, widths[640], 0.005),
            why="whole pixels would explain it: the exact arc's two ends rounded to the pixels of "
            "a frame 640 wide, joined between unit rays, over pitches of ±14 deg (in theory "
            f"sqrt(1/6)/640 rad = {np.rad2deg(np.sqrt(1 / 6) / 640):.4f} deg, whatever altitude "
            f"and field); {widths[320]:.3f} at 320 px, {widths[1280]:.3f} at 1280. With the chord "
            f"as printed only fields up to {narrow:.0f} deg stay near it: at 60 deg it is "
            f"{_model(60.0, unit_rays=False):.2f}. The paper names neither pixels nor field",
        ),
        said(
            place="Figs. 5, 6",
            name="pitch sweep, edges found",
            says="the same with edges found in pictures",
            stated=MODEL_DEG,
            ours=float(over_sweep[1]),
            unit="deg",
            tolerance=0.005,
            verdict=judge(MODEL_DEG, float(over_sweep[1]), 0.005),
            why="rendered frames, Canny edges, circle fitted to them, unit rays; the fit takes the "
            f"ends below a pixel. As printed {over_sweep[0]:.2f} deg, our estimator on the same "
            f"frames {over_sweep[2]:.4f}. The axes of Figs. 5 and 6 are not in the text; ours run "
            "over ±14 deg",
        ),
        said(
            place="Fig. 3",
            name="error map",
            says="errors over yaw and pitch (the figure's scale is not in the text)",
            ours=float(over_map[1]),
            unit="deg",
            tolerance=0.01,
            verdict="can't be reproduced",
            why="the map's range, orbit and lens are missing. Ours, rms over ±12 deg of both in "
            f"rendered frames: this with unit rays, {over_map[0]:.2f} as printed (greatest "
            f"{np.nanmax(error_map()[..., 0]):.2f}), {over_map[2]:.4f} by our estimator",
        ),
    ]


@lru_cache(maxsize=64)
def _model(field_deg: float, unit_rays: bool) -> float:
    return model_rms_deg(field_deg, PAPERS_HEIGHT_M, unit_rays=unit_rays)


def _rms(errors: Array) -> Array:
    return np.asarray(np.sqrt(np.nanmean(errors.reshape(-1, 3) ** 2, axis=0)))


def _edges() -> list[Statement]:
    level, aimed = edge_deg(60.0, 0.0, 500e3), edge_deg(60.0, DOWN_DEG, 500e3)
    inside, outside = errors_deg(24.0, 0.0), errors_deg(28.0, 0.0)
    beyond = "gives no vertical" if np.isnan(outside.unit_rays) else (
        f"gives one {outside.unit_rays:.0f} deg off, from an edge of the frame"
    )  # fmt: skip
    short, long = strip_rms_deg(32), strip_rms_deg(640)
    return [
        said(
            place="abstract, Fig. 3",
            name="widest tilt",
            says="works over a wide range of orientation angles",
            ours=level,
            unit="deg",
            tolerance=0.25,
            verdict="differs",
            why="pitch at which one of two cameras 60 deg wide has lost the horizon, from 500 km, "
            "when both look level as in the paper; when both look straight at the horizon, at "
            f"{aimed:.2f} deg. In frames rendered so the method is within {inside.unit_rays:.2f} "
            f"deg (unit rays) at 24 deg and {beyond} at 28, where our estimator goes on with the "
            f"other camera ({outside.estimator:.3f} deg)",
        ),
        said(
            place="Fig. 2, Fig. 3",
            name="highest orbit",
            says="boresights square to the long axis; the altitude H is left open",
            ours=highest_m(60.0) / 1e3,
            unit="km",
            tolerance=1.0,
            verdict="can't be reproduced",
            why="above it a level 4:3 camera 60 deg wide sees no horizon with the axis upright; "
            f"{highest_m(40.0) / 1e3:.0f} km at 40 deg, {highest_m(90.0) / 1e3:.0f} at 90. At "
            f"500 km the horizon is {DOWN_DEG:.1f} deg below the level",
        ),
        said(
            place="text before Fig. 1",
            name="shortest arc",
            says="the arc's ends may lie anywhere",
            ours=short,
            unit="deg",
            tolerance=0.15,
            verdict="differs",
            why="of one camera's pitch from an arc 32 px long, whole pixels: the experiment's "
            f"0.752 deg is reached there, the model's 0.038 needs 640 px ({long:.3f}). Our "
            f"estimator asks for {np.rad2deg(MIN_ARC_OF_ALL_RAD):.0f} deg of limb",
        ),
        said(
            place="introduction",
            name="three points",
            says="a vertical needs the horizon in three different places at least",
            stated=3.0,
            ours=float(points_needed()),
            tolerance=0.0,
            verdict="agrees",
            why="fewest exact limb rays whose directions fix nadir and dip (rank of d·n = sin dip)",
        ),
    ]


@lru_cache(maxsize=1)
def _orbit() -> Bands:
    return over_an_orbit()


def _bands() -> list[Statement]:
    orbit = _orbit()
    air = real_air()
    return [
        said(
            place="abstract, conclusion",
            name="infrared verticals",
            says="accuracy comparable with infrared verticals",
            ours=orbit.infrared_sigma_deg,
            unit="deg",
            tolerance=0.005,
            verdict="agrees",
            why="what one camera can expect of the infrared limb (30 to 40 km high: Seshamani, "
            "Jain, Kamalakar 1990), by our covariance; of the visible one "
            f"{orbit.visible_sigma_deg:.3f}: in both the limb's height rules, not the detector. "
            "True of the model's 0.038, not of the experiment's 0.752",
        ),
        said(
            place="introduction",
            name="visible limb",
            says="visible light shows the Earth's edge, not a contrast between layers of air",
            ours=air.limb_km,
            unit="km",
            tolerance=1.0,
            verdict="differs",
            why="height of the steepest brightness in four frames rendered with real air, found by "
            "our estimator: the visible edge is air, too, and 10 km of it unknown would be 0.2 deg "
            f"in one camera. On these frames the paper's method (unit rays) is {air.unit_rays:.3f} "
            f"deg off, our estimator {air.estimator:.3f}",
        ),
        said(
            place="abstract",
            name="lit part of the orbit",
            says="can't measure on the shaded part of the orbit",
            ours=100.0 * orbit.visible_share,
            unit="%",
            tolerance=3.0,
            verdict="agrees",
            why="of an orbit at 500 km and 51.6 deg on 20 March both cameras have a usable limb; "
            f"in the infrared {100.0 * orbit.infrared_share:.0f} %",
        ),
        said(
            place="abstract",
            name="Sun in frame",
            says="sunlight in the frame blinds it",
            ours=100.0 * orbit.sunlit_frames,
            unit="%",
            tolerance=3.0,
            verdict="agrees",
            why="of that orbit's frames have the Sun in them and are refused; its glare alone is "
            "no reason (docs/horizon.md: 0.05 deg)",
        ),
        said(
            place="abstract",
            name="mass and power",
            says="much lighter and thriftier than infrared verticals",
            ours=None,
            verdict="can't be reproduced",
            why="no mass or power is stated",
        ),
    ]


def pictures(folder: Path) -> list[Picture]:
    _draw_map().savefig(folder / "reproduction_vertical_map.png", dpi=90)
    _draw_model().savefig(folder / "reproduction_vertical_model.png", dpi=90)
    return [
        Picture(
            file="reproduction_vertical_map.png",
            shows="Error of the vertical over yaw and pitch, by arrangement and chord",
            text="As Fig. 3, from exact arcs seen from 500 km in 60 deg wide frames of 640 x 480, "
            "ends in whole pixels; crosses: a camera has lost the horizon. As the paper has them, "
            "level and joined on the image, the cameras hardly work at all; aimed at the horizon "
            "and joined between unit rays they are good wherever they see it.",
        ),
        Picture(
            file="reproduction_vertical_model.png",
            shows="Error of one camera's pitch over its field, and over pitch in rendered frames",
            text="Left: whole pixels alone give the model's 0.038 deg at any field and altitude "
            "(unit rays, 640 px); the chord as printed only in narrow fields. Right: the sweep of "
            "Figs. 5 and 6 in rendered frames.",
        ),
    ]


def _draw_map() -> Figure:
    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    rows = figure.subplots(2, 2, sharex=True, sharey=True)
    for row, (down_deg, aim) in zip(
        rows, ((0.0, "level (Fig. 2)"), (DOWN_DEG, "at the horizon")), strict=True
    ):
        for panel, unit_rays in zip(row, (False, True), strict=True):
            errors = error_map_deg(pair(60.0, down_deg), unit_rays=unit_rays, whole_px=True)
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
    errors = sweep(SWEEP_DEG)
    for k, name in enumerate(("as printed", "unit rays", "our estimator")):
        right.plot(SWEEP_DEG, errors[:, k], "o-", color=("C1", "C0", "C2")[k], ms=3, label=name)
    right.axhline(MODEL_DEG, color="0.3", lw=0.8)
    right.set(xlabel="pitch, deg", ylabel="error of the vertical, deg", yscale="log")
    right.legend(fontsize="x-small")
    return figure
