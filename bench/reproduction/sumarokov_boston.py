"""Boston in four frames, and the gallery: Sumarokov 2016, Fig. 5 and p. 95."""

from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.base.commands import ROWS_PER_S
from planner.output.export.table_states import TableStates, table_states
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import elapsed_s
from planner.world.platforms.camera import HRC_PIXEL_ARCSEC
from planner.world.targets import VisibleTarget
from planner.world.targets.ground import GroundTarget
from planner.world.targets.ground_moving import MovingGroundTarget
from reproduction.example_plans import BOSTON, closest, plan_of, view_of
from reproduction.statements import Numbers

PIXEL_RAD = np.radians(HRC_PIXEL_ARCSEC / 3600.0)
FRAMES, APART_S = 4, 10.0
SPEED_KM_H = 75.0
CITIES = ("london", "barcelona", "boston", "mecca", "vancouver")
# Where skyscrapers stand beside the target, and how high they are.
TOWERS = (
    ("One Boston Place", 42.3586, -71.0580, 183.0),
    ("60 State Street", 42.3592, -71.0568, 155.0),
    ("Custom House", 42.3591, -71.0533, 151.0),
)
CAR = (42.3580, -71.0624)  # a street beside; it drives north-east


@cache
def frames() -> TableStates:
    """Four instants about the closest approach."""
    plan, view = plan_of(BOSTON), view_of(BOSTON)
    _, middle_s = closest(view.targets[0], view.t_s)
    t_s = middle_s + APART_S * (np.arange(FRAMES) - 0.5 * (FRAMES - 1))
    return table_states(plan, np.round(t_s * ROWS_PER_S).astype(np.intp))


def car() -> MovingGroundTarget:
    return MovingGroundTarget(
        epoch=frames().instants.utc(0),
        latitude_deg=CAR[0],
        longitude_deg=CAR[1],
        height_m=10.0,
        course_deg=45.0,
        speed_m_s=SPEED_KM_H / 3.6,
    )


def in_frame_px(target: VisibleTarget) -> NDArray:
    """Where the camera sees a place in each frame, from the middle, right and down, (FRAMES, 2)."""
    rows = frames()
    seen = target.apparent(rows.instants, rows.states)
    ray = Rotation.from_quat(rows.q_payload_from_eci_xyzw).apply(seen.direction_eci)
    return np.asarray(ray[:, :2] / ray[:, 2:] / PIXEL_RAD)


def place(latitude_deg: float, longitude_deg: float, height_m: float) -> GroundTarget:
    return GroundTarget(latitude_deg=latitude_deg, longitude_deg=longitude_deg, height_m=height_m)


def numbers() -> Numbers:
    return {**_car(), **_view(), **_sessions()}


def _car() -> Numbers:
    moving = car()
    r_m = moving.r_target_itrf_m(frames().instants)
    moved_px = np.linalg.norm(in_frame_px(moving) - in_frame_px(place(*CAR, 10.0)), axis=1)
    steps_px = np.diff(moved_px)
    return {
        "car, metres": float(np.linalg.norm(np.diff(r_m, axis=0), axis=1).mean()),
        "car, pixels": float(steps_px.mean()),
        "car, speed": SPEED_KM_H / float(steps_px.mean()),
        "least_px": float(steps_px.min()),
        "most_px": float(steps_px.max()),
    }


def _view() -> Numbers:
    rows = frames()
    r_target_itrf_m = plan_of(BOSTON).scenario.sessions[0].target.r_target_itrf_m(rows.instants)
    r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf_from_eci(rows.instants), rows.states.r_sat_eci_m)
    up = r_sat_itrf_m - r_target_itrf_m
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    _, latitude, longitude, height_m = TOWERS[0]
    lean_px = in_frame_px(place(latitude, longitude, height_m)) - in_frame_px(
        place(latitude, longitude, 0.0)
    )
    return {
        "viewpoint": float(np.rad2deg(np.arccos(up[0] @ up[-1]))),
        "tower_m": height_m,
        "lean_px": float(np.linalg.norm(lean_px[-1] - lean_px[0])),
    }


def _sessions() -> Numbers:
    lengths_s, misses_px, passed = [], [], 0
    for city in CITIES:
        plan, view = plan_of(f"gallery/{city}.json"), view_of(f"gallery/{city}.json")
        session, track = plan.scenario.sessions[0], view.targets[0]
        lengths_s.append(elapsed_s(session.stop, session.start))
        misses_px.append(float(np.nanmax(track.error_rad[track.in_session])) / PIXEL_RAD)
        passed += plan.verification.passed
    return {"gallery": passed, "length": min(lengths_s), "same point": max(misses_px)}


def pictures(folder: Path) -> None:
    figure = Figure(figsize=(8.4, 6.6), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel()
    path_px = in_frame_px(car())
    feet = [in_frame_px(place(lat, lon, 0.0)) for _, lat, lon, _ in TOWERS]
    tops = [in_frame_px(place(lat, lon, height)) for _, lat, lon, height in TOWERS]
    start_px = in_frame_px(place(*CAR, 10.0))
    streets = _streets_px()
    north = in_frame_px(place(42.3601 + 0.0006, -71.0589, 10.0))
    for k, (panel, letter) in enumerate(zip(panels, "abcd", strict=True)):
        for street in streets:
            panel.plot(street[:, k, 0], street[:, k, 1], color="0.85", lw=0.8, zorder=0)
        for foot, top in zip(feet, tops, strict=True):
            panel.plot(*np.stack([foot[k], top[k]]).T, color="#3c5a78", lw=4.0,
                       solid_capstyle="butt")  # fmt: skip
            panel.plot(*top[k], "s", color="#3c5a78", ms=7)
        panel.plot(*np.stack([start_px[k], path_px[k]]).T, color="C3", lw=0.8, ls=":")
        panel.plot(*path_px[k], "o", mfc="none", mec="C3", mew=1.5, ms=9)
        panel.plot(0.0, 0.0, "+", color="k", ms=9)
        dx, dy = 90.0 * north[k] / np.linalg.norm(north[k])
        panel.annotate("", (430.0 + dx, -180.0 + dy), (430.0, -180.0),
                       arrowprops={"arrowstyle": "->"})  # fmt: skip
        panel.text(430.0 + 1.3 * dx, -180.0 + 1.3 * dy, "N", ha="center", va="center")
        panel.set_title(f"{letter}: {frames().instants.utc_text(0)[k][11:19]} UTC", fontsize=10)
        panel.set(xlim=(-420, 520), ylim=(340, -340), aspect="equal")
    for panel in panels[2:]:
        panel.set_xlabel("pixels")
    for panel in panels[::2]:
        panel.set_ylabel("pixels")
    figure.savefig(folder / "reproduction_boston.png", dpi=100)


def _streets_px() -> list[NDArray]:
    """Lines 200 m apart about the target, (2, FRAMES, 2) each."""
    north_deg, east_deg = 200.0 / 111.1e3, 200.0 / 82.2e3
    ends = (-5.0, 5.0)
    ways = [
        way
        for k in range(-5, 6)
        for way in (
            [(42.3601 + k * north_deg, -71.0589 + end * east_deg) for end in ends],
            [(42.3601 + end * north_deg, -71.0589 + k * east_deg) for end in ends],
        )
    ]
    return [np.stack([in_frame_px(place(lat, lon, 10.0)) for lat, lon in way]) for way in ways]
