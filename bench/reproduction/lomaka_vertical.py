"""The vertical from two cameras: Lomaka, Ustyugov 2016, its equations, Figs. 3, 5 and 6."""

from functools import lru_cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from estimator.search.plausibility import OPTIONS as PLAUSIBILITY_OPTIONS
from planner.base.arrays import Array
from reproduction.lomaka_bands import over_an_orbit
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
    dip_rad,
    geodetic_deg,
    nadir_error_deg,
    points_needed,
    printed_circle,
    tilted_nadir,
)
from reproduction.lomaka_rendered import SWEEP_DEG, error_map, errors_deg, real_air, sweep
from reproduction.statements import Numbers

MODEL_DEG = 0.038
FIELDS_DEG = (20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
DOWN_DEG = float(np.rad2deg(dip_rad(PAPERS_HEIGHT_M)))


def numbers() -> Numbers:
    return {**_method(), **_figures(), **_edges(), **_bands()}


def _method() -> Numbers:
    axis = np.array([0.0, 0.0, 1.0])  # of the horizon's circle: the vertical at (0, 0, R + H)
    printed = np.linalg.norm(printed_circle(axis, corrected=False), axis=1)
    mended = np.linalg.norm(printed_circle(axis, corrected=True), axis=1)
    exact, flat = (
        nadir_error_deg(
            pair(60.0, DOWN_DEG), tilted_nadir(12.0, 12.0), PAPERS_HEIGHT_M, unit_rays=unit
        )
        for unit in (True, False)
    )
    return {
        "circle's radii": float(printed.max() / printed.min()),
        "circle's size": float(np.sin(dip_rad(PAPERS_HEIGHT_M))),
        "circle on the image": circle_misfit_px(60.0),
        "chord in the image plane": flat,
        "sphere": geodetic_deg(),
        "mended": float(mended.max() / mended.min()),
        "centre": float(np.cos(dip_rad(PAPERS_HEIGHT_M))),
        "misfit_40_px": circle_misfit_px(40.0),
        "misfit_90_px": circle_misfit_px(90.0),
        "exact_deg": exact,
    }


def _figures() -> Numbers:
    over_map, over_sweep = _rms(error_map()), _rms(sweep(SWEEP_DEG))
    narrow, half, double = (
        model_rms_deg(60.0, PAPERS_HEIGHT_M, unit_rays=True, width_px=px) for px in (640, 320, 1280)
    )
    return {
        "model's error": narrow,
        "pitch sweep, edges found": float(over_sweep[1]),
        "error map": float(over_map[1]),
        "theory_deg": float(np.rad2deg(np.sqrt(1 / 6) / 640)),
        "at_320_px": half,
        "at_1280_px": double,
        "narrow_deg": max(f for f in FIELDS_DEG if _model(f, unit_rays=False) < 1.2 * MODEL_DEG),
        "printed_at_60": _model(60.0, unit_rays=False),
        "sweep_printed": float(over_sweep[0]),
        "sweep_estimator": float(over_sweep[2]),
        "map_printed": float(over_map[0]),
        "map_printed_worst": float(np.nanmax(error_map()[..., 0])),
        "map_estimator": float(over_map[2]),
    }


@lru_cache(maxsize=64)
def _model(field_deg: float, unit_rays: bool) -> float:
    return model_rms_deg(field_deg, PAPERS_HEIGHT_M, unit_rays=unit_rays)


def _rms(errors: Array) -> Array:
    return np.asarray(np.sqrt(np.nanmean(errors.reshape(-1, 3) ** 2, axis=0)))


def _edges() -> Numbers:
    inside, outside = errors_deg(24.0, 0.0), errors_deg(28.0, 0.0)
    beyond = "gives no vertical" if np.isnan(outside.unit_rays) else (
        f"gives one {outside.unit_rays:.0f} deg off, from an edge of the frame"
    )  # fmt: skip
    return {
        "widest tilt": edge_deg(60.0, 0.0, PAPERS_HEIGHT_M),
        "highest orbit": highest_m(60.0) / 1e3,
        "shortest arc": strip_rms_deg(32),
        "three points": float(points_needed()),
        "aimed_deg": edge_deg(60.0, DOWN_DEG, PAPERS_HEIGHT_M),
        "inside_deg": inside.unit_rays,
        "beyond": beyond,
        "estimator_deg": outside.estimator,
        "highest_40_km": highest_m(40.0) / 1e3,
        "highest_90_km": highest_m(90.0) / 1e3,
        "down_deg": DOWN_DEG,
        "long_deg": strip_rms_deg(640),
        "asked_deg": float(np.rad2deg(PLAUSIBILITY_OPTIONS.min_arc_of_all_rad)),
    }


def _bands() -> Numbers:
    orbit, air = over_an_orbit(), real_air()
    return {
        "infrared verticals": orbit.infrared_sigma_deg,
        "visible limb": air.limb_km,
        "lit part of the orbit": 100.0 * orbit.visible_share,
        "Sun in frame": 100.0 * orbit.sunlit_frames,
        "visible_sigma_deg": orbit.visible_sigma_deg,
        "air_unit_rays": air.unit_rays,
        "air_estimator": air.estimator,
        "infrared_percent": 100.0 * orbit.infrared_share,
    }


def pictures(folder: Path) -> None:
    _draw_map().savefig(folder / "reproduction_vertical_map.png", dpi=90)
    _draw_model().savefig(folder / "reproduction_vertical_model.png", dpi=90)


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
