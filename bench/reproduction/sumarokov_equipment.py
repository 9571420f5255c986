"""Camera and platform: Sumarokov 2016, pp. 85 and 86."""

import math
from pathlib import Path

import numpy as np

from planner.commands import COMMAND_STEP_S
from planner.opportunities.ground_sample import sample_along_m
from planner.platforms import ISS_HRC
from planner.platforms.camera import HRC_PIXEL_ARCSEC
from planner.platforms.two_axis import HRC_FRAME_HALF_RAD
from reproduction.example_plans import LAS_VEGAS, view_of
from reproduction.statements import Picture, Statement, holds, judge

PAPER = "Sumarokov 2016"
HEIGHT_KM = 350.0
FRAME_S, EXPOSURE_S = 1.0 / 3.0, 0.3


def statements() -> list[Statement]:
    return [*_camera(), *_platform()]


def _camera() -> list[Statement]:
    pixel_rad = math.radians(HRC_PIXEL_ARCSEC / 3600.0)
    sides_km = [2.0 * HEIGHT_KM * math.tan(half) for half in HRC_FRAME_HALF_RAD]
    [below_m] = sample_along_m(np.ones(1), np.array([HEIGHT_KM * 1e3]), pixel_rad)
    track = view_of(LAS_VEGAS).targets[0]
    height_km = float(view_of(LAS_VEGAS).carrier.height_m.mean()) / 1e3
    across_m = float(np.min(track.ground_sample_across_m[track.in_session]))
    along_m = float(np.max(track.ground_sample_along_m[track.in_session]))
    return [
        *(
            Statement(
                paper=PAPER,
                place="p. 85",
                name=f"frame, {side}",
                says=f"the frame on the ground, its {side} side, from 350 km",
                stated=stated,
                ours=ours,
                unit="km",
                tolerance=1e-3,
                verdict=judge(stated, ours, 5e-3),
                why=f"`field_of_view_deg`; {stated / 1.15e-3:.0f} pixels of 1.15 m",
            )
            for side, stated, ours in zip(("long", "short"), (5.36, 3.56), sides_km, strict=True)
        ),
        Statement(
            paper=PAPER,
            place="p. 85",
            name="pixel",
            says="a pixel on the ground, from 350 km",
            stated=1.15,
            ours=float(below_m),
            unit="m",
            tolerance=1e-3,
            verdict=judge(1.15, float(below_m), 5e-3),
            why=f"{HRC_PIXEL_ARCSEC:.2f} arcsec, right below",
        ),
        Statement(
            paper=PAPER,
            place="p. 85, Fig. 3",
            name="pixel, Las Vegas",
            says="a pixel on the ground, on the paper's own pass over Las Vegas",
            stated=1.15,
            ours=across_m,
            unit="m at best",
            tolerance=2e-3,
            verdict=judge(1.15, across_m, 5e-3),
            why=f"the ISS flew {height_km:.0f} km high by then, not at the 350 km of the paper's "
            f"number; where the session begins, low in the sky, a pixel is {along_m:.1f} m long",
        ),
        Statement(
            paper=PAPER,
            place="p. 85",
            name="exposure",
            says="3 frames a second, exposed for 0.3 s each: they fit",
            stated=round(FRAME_S, 3),
            ours=EXPOSURE_S,
            unit="s",
            verdict=holds(EXPOSURE_S < FRAME_S),
            why="the camera is open nine tenths of the time, so the platform must keep still on "
            "its target all through a session, not between frames only",
        ),
    ]


def _platform() -> list[Statement]:
    limits = ISS_HRC.outer_limits
    stop_deg = math.degrees(limits.angle_max_rad)
    fastest_deg_s = math.degrees(limits.rate_max_rad_s)
    slowest_arcmin_s = math.degrees(limits.rate_min_rad_s) * 60.0
    acceleration_deg_s2 = math.degrees(limits.acceleration_max_rad_s2)
    rows = (
        ("p. 86", "stops", "each axis turns so far either way", 175.0, stop_deg, "deg", ""),
        ("p. 86", "fastest", "the drives' greatest rate", 3.0, fastest_deg_s, "deg/s", ""),
        (
            "p. 86",
            "slowest",
            "the drives' least rate",
            1.0,
            slowest_arcmin_s,
            "arcmin/s",
            "; slower is allowed and reported as `slow_stretches`, friction then shows (Fig. 3)",
        ),
        (
            "p. 91",
            "acceleration",
            "the drives' greatest acceleration, printed in deg/s",
            1.0,
            acceleration_deg_s2,
            "deg/s²",
            "; the square is lost in print",
        ),
        ("p. 86", "table", "angles and rates are commanded every", 0.2, COMMAND_STEP_S, "s", ""),
    )
    return [
        Statement(
            paper=PAPER,
            place=place,
            name=name,
            says=says,
            stated=stated,
            ours=ours,
            unit=unit,
            verdict=judge(stated, ours, 1e-9),
            why=f"`iss-hrc`, both axes{remark}",
        )
        for place, name, says, stated, ours, unit, remark in rows
    ]


def pictures(folder: Path) -> list[Picture]:
    return []
