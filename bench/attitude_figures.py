"""What constants of planner/attitude rest on: how the ISS moves in torque equilibrium.

    python bench/attitude_figures.py TELEMETRY_FOLDER TLE_FILE --hours 10.75 16.5

TELEMETRY_FOLDER as of bench/attitude.py; the hours, since the recording's begin, of the whole one
(ISS-Mimic/Mimic, commit 41955ae9, Pi/RecordedData/Data/Archive).  Prints the sizes of swing and
rest of lvlh.py and errors.py with their likelihood by the rest's memory, and the rms sizes of the
shapes that the error of a constant body rate is made of (inertial.py).
"""

import argparse
from pathlib import Path

import numpy as np
from attitude import PERIOD_S, channel, held, lvlh
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from truth_pointing import telemetry

from planner.attitude.corrections import SWING_MEMORY_S
from planner.attitude.errors import MEAN_SIGMA_DEG

RATE_RAD_S = 2.0 * np.pi / PERIOD_S
MEMORIES_S = (300.0, 400.0, 500.0)
NOISE_DEG = 0.0015
ROWS_APART = 12  # of telemetry, 10 s each
SHAPES_S = 7200.0
FIRST_GUESS_DEG = ((0.236, 0.01), (0.01, 0.015), (0.007, 0.005))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("telemetry", type=Path)
    parser.add_argument("tles", type=Path)
    parser.add_argument("--hours", type=float, nargs=2, default=(0.0, 16.5))
    asked = parser.parse_args()
    t_s, q_body_from_lvlh = telemetry(asked.telemetry)
    hours = (t_s - t_s[0]) / 3600.0
    used = (hours >= asked.hours[0]) & (hours < asked.hours[1])
    t_s, q_body_from_lvlh = t_s[used], q_body_from_lvlh[used]
    print_swing_and_rest(t_s, q_body_from_lvlh)
    print_shapes(asked.telemetry, t_s, q_body_from_lvlh * lvlh(asked.tles, t_s))


def print_swing_and_rest(t_s: np.ndarray, q_body_from_lvlh: Rotation) -> None:
    turn_deg = (q_body_from_lvlh * q_body_from_lvlh.mean().inv()).as_rotvec(degrees=True)
    print("rms about body x, y, z:", np.std(turn_deg, axis=0).round(4), "deg")
    for memory_s in MEMORIES_S:
        fits = [
            likeliest(t_s[::ROWS_APART], turn_deg[::ROWS_APART, axis], guess, memory_s)
            for axis, guess in enumerate(FIRST_GUESS_DEG)
        ]
        swing, rest, likelihood = np.array(fits).T
        print(
            f"rest alike for {memory_s:g} s: swing {swing.round(4)}, rest {rest.round(4)} deg, "
            f"log likelihood {likelihood.round(1)}, together {likelihood.sum():.1f}"
        )


def likeliest(
    t_s: np.ndarray, turn_deg: np.ndarray, guess_deg: tuple[float, float], memory_s: float
) -> tuple[float, float, float]:
    """Swing and rest (deg), and their log likelihood, the mean right to MEAN_SIGMA_DEG."""
    apart_s = t_s[:, None] - t_s
    swing = np.cos(RATE_RAD_S * apart_s) * np.exp(-0.5 * (apart_s / SWING_MEMORY_S) ** 2)
    rest = 1.0 / (1.0 + 0.5 * (apart_s / memory_s) ** 2)
    known = MEAN_SIGMA_DEG**2 + NOISE_DEG**2 * np.eye(len(t_s))

    def unlikely(log_sizes_deg: np.ndarray) -> float:
        swing_deg2, rest_deg2 = np.exp(2.0 * log_sizes_deg)
        root = np.linalg.cholesky(known + swing_deg2 * swing + rest_deg2 * rest)
        news = np.linalg.solve(root, turn_deg)
        return float(0.5 * news @ news + np.log(np.diag(root)).sum())

    found = minimize(unlikely, np.log(guess_deg), method="Nelder-Mead", options={"maxiter": 100})
    swing_deg, rest_deg = np.exp(found.x)
    return swing_deg, rest_deg, -found.fun


def print_shapes(folder: Path, t_s: np.ndarray, q_body_from_eci: Rotation) -> None:
    channels = {number: channel(folder, number) for number in (25, 26, 27)}
    rates_deg_s = np.stack([held(channels, number, t_s) for number in (25, 26, 27)], axis=1)
    found: list[list[np.ndarray]] = [[], [], []]
    left: list[list[float]] = [[], [], []]
    for row in np.flatnonzero(t_s < t_s[-1] - SHAPES_S)[::20]:
        after = (t_s >= t_s[row]) & (t_s < t_s[row] + SHAPES_S)
        since_s = t_s[after] - t_s[row]
        turned = Rotation.from_rotvec(-np.outer(since_s, rates_deg_s[row]), degrees=True)
        foretold = turned * q_body_from_eci[row]
        miss_deg = (q_body_from_eci[after] * foretold.inv()).as_rotvec(degrees=True)
        u = RATE_RAD_S * since_s
        c, s = np.cos(u), np.sin(u)
        across = np.stack([1.0 - c, s, u * c - s, u * s], axis=1)
        shapes = (across, np.stack([1.0 - c, u - s, u], axis=1), across)
        for axis in range(3):
            sizes_deg = np.linalg.lstsq(shapes[axis], miss_deg[:, axis], rcond=None)[0]
            found[axis].append(sizes_deg)
            left[axis].append(float(np.std(miss_deg[:, axis] - shapes[axis] @ sizes_deg)))
    print("a constant body rate's error in two hours, rms sizes (deg) of its shapes")
    names = ("1 - cos u, sin u, u cos u - sin u, u sin u", "1 - cos u, u - sin u, u")
    for axis, name in zip(range(3), (names[0], names[1], names[0]), strict=True):
        rms_deg = np.sqrt(np.mean(np.square(found[axis]), axis=0))
        print(f"  {'xyz'[axis]}: {name}: {rms_deg.round(3)}; left {np.mean(left[axis]):.3f} deg")


if __name__ == "__main__":
    main()
