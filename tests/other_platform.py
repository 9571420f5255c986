"""A two-axis platform and its telemetry, written for tests alone: it knows only the table's CSV.

Nothing here comes from the planner: the table is read with the csv module, interpolated by this
file's own cubic, flown by its own integration of a motor with its own friction, and measured by
its own encoder, gyro and clock.  Run as a script: TABLE.csv TELEMETRY.csv.
"""

import csv
import math
import random
import sys
from array import array
from bisect import bisect_right
from dataclasses import dataclass
from functools import lru_cache

STEP_S = 0.002


@dataclass(frozen=True)
class Drive:
    """Torques over inertia.  friction_deg_s2: Coulomb level.  break_away: times that.

    viscous_per_s: of the rate.  A position loop of this bandwidth with the table's rate and
    acceleration fed forward; no integral part, so that friction shows.
    """

    bandwidth_hz: float = 4.0
    damping: float = 0.8
    friction_deg_s2: float = 0.0
    break_away: float = 1.4
    stribeck_deg_s: float = 0.003
    viscous_per_s: float = 0.0
    swing_hz: float = 0.0
    swing_deg: float = 0.0
    swing_from_s: float = 0.0
    swing_to_s: float = 0.0


@dataclass
class Clock:
    """A tag is offset + (1 + drift) t."""

    offset_s: float = 0.0
    drift: float = 0.0


def read_table(path):
    """Seconds, and by axis the angles and rates, from the table's CSV."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    names = [key[: -len("_rate_deg_s")] for key in rows[0] if key.endswith("_rate_deg_s")]
    t = tuple(float(row["t_s"]) for row in rows)
    motion = {
        name: (
            tuple(float(row[f"{name}_deg"]) for row in rows),
            tuple(float(row[f"{name}_rate_deg_s"]) for row in rows),
        )
        for name in names
    }
    return t, motion


def commanded(times, angles, rates, t):
    """Angle, rate and acceleration between two rows, by the basis functions of Hermite."""
    if t <= times[0]:
        return angles[0], 0.0, 0.0
    if t >= times[-1]:
        return angles[-1], 0.0, 0.0
    k = min(bisect_right(times, t) - 1, len(times) - 2)
    h = times[k + 1] - times[k]
    s = (t - times[k]) / h
    p0, p1, m0, m1 = angles[k], angles[k + 1], h * rates[k], h * rates[k + 1]
    angle = (
        (2 * s**3 - 3 * s**2 + 1) * p0
        + (s**3 - 2 * s**2 + s) * m0
        + (3 * s**2 - 2 * s**3) * p1
        + (s**3 - s**2) * m1
    )
    rate = (
        (6 * s**2 - 6 * s) * (p0 - p1) + (3 * s**2 - 4 * s + 1) * m0 + (3 * s**2 - 2 * s) * m1
    ) / h
    acceleration = ((12 * s - 6) * (p0 - p1) + (6 * s - 4) * m0 + (6 * s - 2) * m1) / h**2
    return angle, rate, acceleration


@lru_cache(maxsize=32)
def fly(times, angles, rates, drive):
    """Times, angles and rates every STEP_S: semi-implicit Euler, sticking as Karnopp has it.

    The same flight is measured with many noises and clocks.
    """
    omega = 2 * math.pi * drive.bandwidth_hz
    angle, rate = angles[0], rates[0]
    at, flown, flown_rates = array("d"), array("d"), array("d")
    stuck_below = drive.stribeck_deg_s / 50
    for n in range(round((times[-1] - times[0]) / STEP_S) + 1):
        t = times[0] + n * STEP_S
        at.append(t)
        flown.append(angle)
        flown_rates.append(rate)
        want, want_rate, want_acceleration = commanded(times, angles, rates, t)
        drive_torque = (
            omega**2 * (want - angle)
            + 2 * drive.damping * omega * (want_rate - rate)
            + want_acceleration
        )
        level = drive.friction_deg_s2
        peak = level * (
            1 + (drive.break_away - 1) * math.exp(-((rate / drive.stribeck_deg_s) ** 2))
        )
        if level and abs(rate) < stuck_below and abs(drive_torque) < peak:
            rate = 0.0
            continue
        friction = math.copysign(peak, rate if rate else drive_torque) if level else 0.0
        friction += drive.viscous_per_s * rate
        new_rate = rate + STEP_S * (drive_torque - friction)
        if level and rate * new_rate < 0:
            new_rate = 0.0  # it stops before it turns back
        rate = new_rate
        angle += STEP_S * rate
    return at, flown, flown_rates


def measure(
    table, drives, clock, rate_hz, noise_arcsec, gyro_noise_deg_s, seed, start=0.0, stop=None
):
    """Rows of telemetry: tag, then angle of each axis, then rate of each axis."""
    times, motion = table
    chance = random.Random(seed)
    stop = times[-1] if stop is None else stop
    flights = {name: fly(times, *columns, drives[name]) for name, columns in motion.items()}
    rows = []
    count = int((stop - start) * rate_hz)
    for n in range(count):
        t = start + n / rate_hz
        row = [clock.offset_s + (1 + clock.drift) * t]
        k = min(int((t - times[0]) / STEP_S), len(next(iter(flights.values()))[0]) - 2)
        part = (t - times[0]) / STEP_S - k
        for column, noise in ((1, noise_arcsec / 3600), (2, gyro_noise_deg_s)):
            for name, flight in flights.items():
                value = flight[column][k] * (1 - part) + flight[column][k + 1] * part
                drive = drives[name]
                if drive.swing_deg and drive.swing_from_s <= t <= drive.swing_to_s:
                    phase = 2 * math.pi * drive.swing_hz * t
                    value += (
                        drive.swing_deg * math.sin(phase)
                        if column == 1
                        else drive.swing_deg * 2 * math.pi * drive.swing_hz * math.cos(phase)
                    )
                row.append(value + chance.gauss(0.0, noise))
        rows.append(row)
    return list(motion), rows


def write_csv(path, names, rows):
    header = ["t_s", *(f"{n}_deg" for n in names), *(f"{n}_rate_deg_s" for n in names)]
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows([f"{value:.9f}" for value in row] for row in rows)


if __name__ == "__main__":
    table = read_table(sys.argv[1])
    drives = {name: Drive() for name in table[1]}
    write_csv(
        sys.argv[2],
        *measure(table, drives, Clock(offset_s=0.37, drift=50e-6), 15.0, 2.0, 0.001, seed=1),
    )
