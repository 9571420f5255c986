"""Errors of the horizon estimator; prints the tables of docs/horizon.md.

Run: OMP_NUM_THREADS=1 python bench/horizon.py [--frames N] [--seed N] [--rows WORD ...]
Words are groups, or parts of the names of the harder rows.  Images come from the renderer; the
default seed was not used while the estimator was written.
"""

import argparse
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from horizon_cases import (
    COLOUR,
    NEGATIVES,
    Case,
    RollingShutter,
    angle_deg,
    case,
    negative,
    other_air,
    random_air,
    ring,
)
from reproduction.lomaka_method import paper_nadir

from estimator.check import Verdict
from estimator.found import VerticalEstimate
from estimator.pipeline import estimate_vertical
from estimator.rendering.atmosphere import Atmosphere
from estimator.rendering.scene import Scene
from estimator.rendering.sensor import Sensor
from estimator.request import HorizonRequest

cv2.setNumThreads(1)
MEDIAN_CHI2 = 1.386  # of two degrees of freedom


@dataclass
class Row:
    """Errors of one condition, against geocentric and geodetic nadir."""

    name: str
    goal: str
    error_deg: list[float] = field(default_factory=list)
    geodetic_deg: list[float] = field(default_factory=list)
    normalised2: list[float] = field(default_factory=list)
    refused: Counter[str] = field(default_factory=Counter)
    cpu_s: list[float] = field(default_factory=list)

    def add(self, one: Case, request: HorizonRequest | None = None) -> VerticalEstimate:
        request = request or one.request
        start = time.process_time()
        answer = estimate_vertical(one.images[: len(request.cameras)], request)
        self.cpu_s.append(time.process_time() - start)
        if answer.geocentric is None or answer.geodetic is None:
            self.refused[answer.reason.name if answer.reason else "?"] += 1
            return answer
        self.error_deg.append(angle_deg(answer.geocentric.nadir_body, one.geocentric_body))
        self.geodetic_deg.append(angle_deg(answer.geodetic.nadir_body, one.geodetic_body))
        nadir = answer.geocentric
        off = nadir.axes_body @ (nadir.nadir_body - one.geocentric_body)
        self.normalised2.append(float(off @ np.linalg.solve(nadir.covariance_rad2, off)))
        return answer

    def show(self) -> None:
        count = len(self.error_deg) + sum(self.refused.values())
        if not self.error_deg:
            print(f"{self.name:44s} all refused: {dict(self.refused)}", flush=True)
            return
        n2 = np.array(self.normalised2)
        # 5 sigma in two dimensions: chance 6e-7, 28.7.
        beyond = int(np.sum(n2 > 28.7))
        print(
            f"{self.name:44s} {_rms(self.error_deg):.4f} {_rms(self.geodetic_deg):.4f} "
            f"{max(self.error_deg):6.3f} {self.goal:>10s} "
            f"{100.0 * len(self.error_deg) / count:5.1f} % "
            f"{np.median(n2) / MEDIAN_CHI2:5.2f} {np.mean(n2) / 2.0:5.2f} {beyond:3d}  "
            f"{1e3 * np.median(self.cpu_s):4.0f} ms  {dict(self.refused) or ''}",
            flush=True,
        )


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def ideal_rows(rng: np.random.Generator, count: int) -> Iterator[Row]:
    clear = Scene(constant_limb_m=17.5e3, cloud_cover=0.0, land=0.0)
    cloudy = replace(clear, cloud_cover=0.6, land=0.4)
    quiet = Sensor(full_well_e=0.0)
    for name, scene, sensor in (
        ("clean", clear, quiet),
        ("noise", clear, Sensor(full_well_e=8e3, read_noise_e=30.0)),
        ("clouds", cloudy, Sensor()),
        ("JPEG q60", cloudy, Sensor(jpeg_quality=60)),
        ("16 bit", cloudy, Sensor(bits=16)),
    ):
        row = Row(f"ideal: constant limb height, {name}", "0.010")
        for _ in range(count):
            row.add(case(rng, ring(2), scene=scene, sensor=sensor))
        yield row


def real_rows(rng: np.random.Generator, count: int) -> Iterator[Row]:
    rows = {n: Row(f"real, {n} camera{'s' * (n > 1)}", g) for n, g in GOALS.items()}
    blind = Row("real, no attitude prediction", "0.030")
    papers = {True: [], False: []}
    for _ in range(count):
        one = case(rng, ring(4))
        for n, row in rows.items():
            row.add(one, replace(one.request, cameras=one.request.cameras[:n]))
        blind.add(one, replace(one.request, cameras=one.request.cameras[:2], predicted=None))
        for unit_rays, errors in papers.items():
            nadir = paper_nadir(one.images[:2], one.request.cameras[:2], unit_rays)
            if nadir is not None:
                errors.append(angle_deg(nadir, one.geocentric_body))
    yield from (*rows.values(), blind)
    for unit_rays, errors in papers.items():
        print(
            f"  the paper's chord, {'unit rays' if unit_rays else 'as printed':10s}: rms of the "
            f"better 90 % {_rms(sorted(errors)[: int(0.9 * len(errors))]):.3f}, "
            f"median {np.median(errors):.3f}"
        )


GOALS = {2: "0.030", 1: "0.090", 3: "0.015", 4: "0.012"}


MONO = Sensor()
DUSTY = Atmosphere(dust_optical_depth=0.2)
HARDER = {
    "real, monochrome": ("0.030", {"sensor": MONO}),
    "real, monochrome, no attitude prediction": (
        "0.030",
        {"sensor": MONO, "predicted_off_deg": None},
    ),
    "real, monochrome, 4 cameras": ("0.012", {"sensor": MONO}),
    "real, Sun's glare in frame": (
        "0.060",
        {"sun_deg": (5.0, 60.0), "sun_from_boresight_deg": (0.0, 40.0)},
    ),
    "real, terminator in frame": ("0.100", {"sun_deg": (3.0, 16.0)}),
    "low Sun, 0-30 deg at the craft": ("0.100", {"sun_deg": (0.0, 30.0)}),
    "low Sun, monochrome": ("0.100", {"sun_deg": (0.0, 30.0), "sensor": MONO}),
    "real, prediction off <= 20 deg, partial limb": (
        "0.040",
        {"predicted_off_deg": 20.0, "attitude_deg": 14.0},
    ),
    "real, JPEG q85, gamma 2.2": ("", {"sensor": replace(COLOUR, jpeg_quality=85, gamma=2.2)}),
    "real, overexposed 3 times": ("", {"sensor": replace(COLOUR, exposure=2.5)}),
    "real, dusty": ("", {"scene": Scene(atmosphere=DUSTY, roughness_m=800.0)}),
}


def harder_row(rng: np.random.Generator, name: str, count: int) -> Row:
    goal, options = HARDER[name]
    row = Row(name, goal)
    cameras = ring(4 if "4 cameras" in name else 2)
    for _ in range(count):
        own = {"scene": replace(random_air(rng), glare=0.03)} if "glare" in name else {}
        row.add(case(rng, cameras, **options, **own))
    return row


def harder_rows(rng: np.random.Generator, count: int) -> Iterator[Row]:
    return (harder_row(rng, name, count) for name in HARDER)


def other_air_rows(rng: np.random.Generator, count: int) -> Iterator[Row]:
    """With and without a prediction; over a dark sea, whose limb is brighter than what lies
    behind it."""
    for name, sensor in (("colour", COLOUR), ("grey", MONO)):
        rows = Row(f"other air, {name}", ""), Row(f"other air, {name}, no prediction", "")
        for _ in range(count):
            one = case(rng, ring(2), scene=other_air(rng), sensor=sensor)
            rows[0].add(one)
            rows[1].add(one, replace(one.request, predicted=None))
        yield from rows
    row = Row("other air without dust, grey, dark sea", "")
    for _ in range(count):
        scene = other_air(rng)
        clean = replace(scene.atmosphere, dust_optical_depth=0.0)
        sea = replace(scene, atmosphere=clean, cloud_cover=rng.uniform(0.0, 0.05), land=0.0)
        row.add(case(rng, ring(2), scene=sea, sensor=MONO))
    yield row


def disturbed_rows(rng: np.random.Generator, count: int) -> Iterator[Row]:
    """Lenses and shutters as stated; then such whose error nobody states, or states as none, and
    a rolling shutter on a body that turns as it likes.  Colour and grey."""
    calibrated = ring(2)
    unstated = tuple(replace(c, lens_sigma=None) for c in calibrated)
    rolling = tuple(replace(c, readout_s=0.1) for c in calibrated)
    unsaid = tuple(replace(c, readout_s=None) for c in calibrated)
    for colour, sensor in (("", COLOUR), (", grey", MONO)):
        rows: dict[str, Row] = {}
        for _ in range(count):
            scale = rng.choice([0.99, 1.01])
            longer = tuple(
                replace(c, fx_px=c.fx_px * scale, fy_px=c.fy_px * scale) for c in calibrated
            )
            k1 = rng.choice([-0.02, 0.02])
            distorted = tuple(replace(c, distortion=(k1, 0.0, 0.0, 0.0, 0.0)) for c in calibrated)
            rate_deg_s = rng.normal(size=3)
            rate_deg_s *= 4.0 / np.linalg.norm(rate_deg_s)
            shutters = tuple(RollingShutter(c, rate_deg_s) for c in rolling)
            for true, told in (
                (calibrated, {"as stated": calibrated, "as stated, shutter unstated": unsaid}),
                (longer, {"focal length 1 % off, unstated": unstated,
                          "focal length 1 % off, stated as calibrated": calibrated}),
                (distorted, {"k1 0.02 off, unstated": unstated,
                             "k1 0.02 off, stated as calibrated": calibrated}),
                (shutters, {"4 deg/s, readout 100 ms, rate unknown": rolling,
                            "4 deg/s, readout 100 ms, unstated": unsaid,
                            "4 deg/s, readout 100 ms, stated as global": calibrated}),
            ):  # fmt: skip
                one = case(rng, calibrated, scene=other_air(rng), sensor=sensor, true_cameras=true)
                for name, cameras in told.items():
                    row = rows.setdefault(name, Row(name + colour, ""))
                    row.add(one, replace(one.request, cameras=cameras))
        yield from rows.values()


def negatives(rng: np.random.Generator, count: int) -> None:
    """How many images without a horizon are answered, and the longest processor time."""
    answered, slowest_s = 0, 0.0
    for k in range(count):
        image, request = negative(NEGATIVES[k % len(NEGATIVES)], rng)
        start = time.process_time()
        answer = estimate_vertical([image], request)
        slowest_s = max(slowest_s, time.process_time() - start)
        answered += answer.verdict != Verdict.NOT_OBSERVABLE
    print(
        f"{'images without a horizon':44s} {answered} of {count} answered, "
        f"{slowest_s:.2f} s at most"
    )


# What is measured, its share of the number of frames asked for, and the least number of them.
GROUPS: dict[str, tuple[Callable[..., Iterator[Row] | None], float, int]] = {
    "ideal": (ideal_rows, 0.2, 4),
    "real": (real_rows, 1.0, 1),
    "harder": (harder_rows, 0.5, 4),
    "disturbed": (disturbed_rows, 0.5, 4),
    "negatives": (negatives, 3.8, 19),
    "air": (other_air_rows, 0.5, 4),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=60, help="per row of the group `real`")
    parser.add_argument("--seed", type=int, default=40_117)
    parser.add_argument("--rows", nargs="*", default=[*GROUPS])
    chosen = parser.parse_args()
    print(f"{'':44s} rms deg        max deg       goal  usable  NEES  mean >5 s  CPU")
    print(f"{'':44s} centric detic")
    for k, (name, (measure, share, least)) in enumerate(GROUPS.items()):
        if name in chosen.rows:
            rng = np.random.default_rng([chosen.seed, k])
            for row in measure(rng, max(int(share * chosen.frames), least)) or ():
                row.show()
    for k, name in enumerate(HARDER):
        words = [word for word in chosen.rows if word not in GROUPS]
        if "harder" not in chosen.rows and any(word in name for word in words):
            harder_row(np.random.default_rng([chosen.seed, 2, k]), name, chosen.frames).show()


if __name__ == "__main__":
    main()
