"""What constants of planner/attitude rest on: how the ISS moves in torque equilibrium.

    python bench/attitude_figures.py TELEMETRY_FOLDER TLE_FILE --hours 0 16.2

TELEMETRY_FOLDER as of bench/attitude.py; the hours, since the recording's begin, of the whole one
(ISS-Mimic/Mimic, commit 41955ae9, Pi/RecordedData/Data/Archive).  Prints the sizes of swing and
rest (lvlh.py, errors.py) from pairs, and how long the rest stays alike; what corrections leave of
hours left out, four at a time, by the others' sizes; how alike the errors of one forecast by
the law harmonic are; and the rms sizes of the shapes that the error of a constant body rate is made
of (inertial.py).
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
from attitude import PERIOD_S, channel, held, lvlh
from scipy.spatial.transform import Rotation
from scipy.stats import norm
from truth_pointing import STEP_S, telemetry

from planner.attitude.blend import blend
from planner.attitude.errors import MEAN_SIGMA_DEG, REST_MEMORY_S, alike

RATE_RAD_S = 2.0 * np.pi / PERIOD_S
BLOCK_S = 4.0 * 3600.0
LOOKS_S = np.array([0.0, 420.0, 840.0])
LOOK_SIGMA_DEG = 0.02
LEADS_S = (120.0, 900.0, 2700.0, 5400.0, 10800.0)
COVERED = (0.5, 0.9, 0.99)
START_STEP_S, GAP_S = 120.0, 30.0
FORECAST_LEADS_S = np.array([300.0, 900.0, 1800.0, 2700.0, 3600.0])
FORECAST_HISTORY_S = 5.0 * PERIOD_S
FORECAST_ROWS = 60  # of telemetry, from one to the next
SHAPES_S = 7200.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("telemetry", type=Path)
    parser.add_argument("tles", type=Path)
    parser.add_argument("--hours", type=float, nargs=2, default=(0.0, 16.2))
    asked = parser.parse_args()
    t_s, q_body_from_lvlh = telemetry(asked.telemetry)
    hours = (t_s - t_s[0]) / 3600.0
    used = (hours >= asked.hours[0]) & (hours < asked.hours[1])
    t_s, q_body_from_lvlh = t_s[used], q_body_from_lvlh[used]
    print_swing_and_rest(t_s, q_body_from_lvlh)
    print_forecasts(t_s, q_body_from_lvlh)
    print_shapes(asked.telemetry, t_s, q_body_from_lvlh * lvlh(asked.tles, t_s))


class Block(NamedTuple):
    """Some hours: instants (n,), and the turn against the mean of all (deg, (n, 3))."""

    t_s: np.ndarray
    turn_deg: np.ndarray


def print_swing_and_rest(t_s: np.ndarray, q_body_from_lvlh: Rotation) -> None:
    turn_deg = (q_body_from_lvlh * q_body_from_lvlh.mean().inv()).as_rotvec(degrees=True)
    blocks = [
        Block(t_s[rows], turn_deg[rows])
        for rows in np.array_split(np.arange(len(t_s)), max(1, round(np.ptp(t_s) / BLOCK_S)))
    ]
    swing_deg, rest_deg = sizes(blocks)
    print("rms about body x, y, z:", np.std(turn_deg, axis=0).round(4), "deg")
    print(f"swing {swing_deg.round(4)}, rest {rest_deg.round(4)} deg; the rest is alike")
    for apart_s in (300.0, 600.0, 900.0):
        swung_deg2 = swing_deg**2 * (1.0 - np.cos(RATE_RAD_S * apart_s))
        likeness = 1.0 - (half_square_deg2(blocks, apart_s) - swung_deg2) / rest_deg**2
        print(
            f"  after {apart_s:3g} s about y: {likeness[1]:.2f} (by REST_MEMORY_S "
            f"{alike(np.array(apart_s), REST_MEMORY_S):.2f})"
        )
    print_left_out(blocks)


def sizes(blocks: list[Block]) -> tuple[np.ndarray, np.ndarray]:
    """Swing and rest (deg rms, (3,)): pairs an orbit apart differ by the rest alone."""
    rest_deg2 = half_square_deg2(blocks, PERIOD_S)
    all_deg2 = np.var(np.concatenate([block.turn_deg for block in blocks]), axis=0)
    return np.sqrt(all_deg2 - rest_deg2), np.sqrt(rest_deg2)


def half_square_deg2(blocks: list[Block], apart_s: float) -> np.ndarray:
    """The variogram, (3,): half the mean square of what pairs within a block differ by."""
    squares = []
    for t_s, turn_deg in blocks:
        then = np.searchsorted(t_s, t_s + apart_s - 0.5 * STEP_S)
        first = np.flatnonzero(then < len(t_s))
        first = first[np.abs(t_s[then[first]] - t_s[first] - apart_s) < STEP_S]
        squares.append((turn_deg[then[first]] - turn_deg[first]) ** 2)
    return np.asarray(0.5 * np.mean(np.concatenate(squares), axis=0))


def print_left_out(blocks: list[Block]) -> None:
    """Each block foretold from three looks by the sizes of the others."""
    print("NEES of each block left out, three looks good to 0.02 deg, about x and y:")
    rng = np.random.default_rng(1)
    for axis in range(2):
        sizes_deg = [
            [of_axes[axis] for of_axes in sizes(blocks[:k] + blocks[k + 1 :])]
            for k in range(len(blocks))
        ]
        for lead_s in LEADS_S:
            by_block = [
                normalised(block, axis, lead_s, of_others, rng)
                for block, of_others in zip(blocks, sizes_deg, strict=True)
            ]
            z = np.abs(np.concatenate(by_block))
            sets = sum(round(np.ptp(block.t_s) / (LOOKS_S[-1] + lead_s)) for block in blocks)
            print(
                f"  {'xy'[axis]}, {lead_s:5g} s later: "
                f"{np.round([np.mean(one**2) for one in by_block], 2)}, all {np.mean(z**2):.2f} "
                f"+-{np.sqrt(2.0 / sets):.2f}; within 50, 90, 99 %: "
                f"{', '.join(f'{np.mean(z < norm.isf(0.5 - 0.5 * p)):.0%}' for p in COVERED)}"
            )


def normalised(
    block: Block, axis: int, lead_s: float, sizes_deg: list[float], rng: np.random.Generator
) -> np.ndarray:
    """Errors after three looks over what is told of them."""
    at_s = np.append(LOOKS_S, LOOKS_S[-1] + lead_s)
    starts_s = np.arange(block.t_s[0], block.t_s[-1] - at_s[-1], START_STEP_S)
    all_s = starts_s[:, None] + at_s
    near = block.t_s[np.searchsorted(block.t_s, all_s - 0.5 * GAP_S)]
    all_s = all_s[(np.abs(near - all_s) <= GAP_S).all(axis=1)]
    turn_deg = np.interp(all_s, block.t_s, block.turn_deg[:, axis])
    turn_deg += rng.normal(0.0, MEAN_SIGMA_DEG, (len(all_s), 1))
    seen_deg = turn_deg[:, :-1] + rng.normal(0.0, LOOK_SIGMA_DEG, (len(all_s), len(LOOKS_S)))
    apart_s = at_s[:, None] - at_s
    covariance = MEAN_SIGMA_DEG**2 + sizes_deg[0] ** 2 * np.cos(RATE_RAD_S * apart_s)
    covariance += sizes_deg[1] ** 2 * alike(apart_s, REST_MEMORY_S)
    of_looks = covariance[:-1, :-1] + LOOK_SIGMA_DEG**2 * np.eye(len(LOOKS_S))
    weights = np.linalg.solve(of_looks, covariance[:-1, -1])
    variance = covariance[-1, -1] - covariance[-1, :-1] @ weights
    return np.asarray((turn_deg[:, -1] - seen_deg @ weights) / np.sqrt(variance))


def print_forecasts(t_s: np.ndarray, q_body_from_lvlh: Rotation) -> None:
    errors = []
    for now in np.flatnonzero(t_s > t_s[0] + 2.0 * PERIOD_S)[::FORECAST_ROWS]:
        then = np.searchsorted(t_s, t_s[now] + FORECAST_LEADS_S)
        if then[-1] < len(t_s) and (t_s[then] - t_s[now] - FORECAST_LEADS_S < GAP_S).all():
            known = (t_s <= t_s[now]) & (t_s > t_s[now] - FORECAST_HISTORY_S)
            foretold = blend(t_s[known], q_body_from_lvlh[known], PERIOD_S).at(t_s[then])
            errors.append((foretold * q_body_from_lvlh[then].inv()).as_rotvec(degrees=True))
    print(
        f"errors of one forecast (law harmonic, {len(errors)}) at {FORECAST_LEADS_S} s are alike:"
    )
    for axis in range(2):
        print(
            f"  {'xy'[axis]}:", *np.corrcoef(np.array(errors)[:, :, axis].T).round(2), sep="\n    "
        )


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
