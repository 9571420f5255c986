"""What the budgets tell against what was: goal and figure seen, on real data.

    python bench/truth.py DATA_FOLDER [--sessions 300]

DATA_FOLDER holds `attitude` (telemetry as bench/attitude.py reads it), `tle/iss_tles.txt` and
`oem` (NASA's ephemerides).  The attitude's figures come from the telemetry's first half, what is
told is tried on the second, the mean wrong by as much as is assumed.
"""

import argparse
import math
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from attitude import channel, held
from orbit_age import read_oem_file, read_tles, ric_m
from scipy.spatial.transform import Rotation, Slerp

from planner.attitude import AttitudeCorrection, LvlhAttitude
from planner.attitude.errors import MEAN_SIGMA_DEG
from planner.frames.earth_orientation import c_itrf_from_eci
from planner.frames.geodesy import geodetic_from_itrf
from planner.frames.time_scales import Instants, shifted_utc
from planner.orbits import StateVectorOrbit, TleOrbit
from planner.orbits.accuracy import state_sigma
from planner.platforms.iss_hrc import ISS_HRC
from planner.pointing.angles import axis_angles
from planner.pointing.line_of_sight import line_of_sight
from planner.sessions.uncertainty import pointing_budget
from planner.targets.ground import GroundTarget

SESSION_S = np.arange(0.0, 90.1, 9.0)
ASIDE_DEG = 3.0  # of latitude and longitude, from below the carrier
SIZES = (0.5, 0.7, 0.9, 1.1, 1.5, 2.0)  # of the HRC's frame
STARTS = 60  # moments of the telemetry for each session
STALE_S = 2.5  # since a value changed
STEP_S = 10.0
BINS = 5
LOOKS_S = (0.0, 420.0, 840.0)  # a day side's worth of frames
CORRECTED_LEADS_S = (120.0, 900.0, 2700.0, 5400.0, 10800.0)
LOOK_SIGMA_DEG = 0.02
LOOK_TRIALS = 200
NOON_UTC = datetime(2018, 10, 12, 12, tzinfo=UTC)
PERIOD_S = 5560.0
RATE_LEADS_S = (60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0)
STATE_LEADS_S = (900.0, 2700.0, 5400.0, 10800.0, 21600.0)
STATE_DAYS = (0.5, 1.6, 4.3)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--sessions", type=int, default=300)
    arguments = parser.parse_args()
    attitude_figures(arguments.data / "attitude")
    reliability(arguments.data, arguments.sessions)
    corrected(arguments.data / "attitude")
    state_growth(arguments.data)


def reliability(data: Path, sessions: int) -> None:
    """Told and kept probabilities of staying in the frame, by bins of the told one."""
    t_s, q_body_from_lvlh = telemetry(data / "attitude")
    middle_s = t_s[len(t_s) // 2]
    mean = q_body_from_lvlh[t_s < middle_s].mean()
    yaw_deg, pitch_deg, roll_deg = mean.inv().as_euler("ZYX", degrees=True)
    law = LvlhAttitude(yaw_deg=yaw_deg, pitch_deg=pitch_deg, roll_deg=roll_deg)
    swing = Slerp(t_s, q_body_from_lvlh)
    rng = np.random.default_rng(2)
    tles = list(read_tles(data / "tle" / "iss_tles.txt"))
    told, kept = [], []
    for _ in range(sessions):
        found = session(tles[rng.integers(len(tles))], law, rng)
        starts_s = rng.uniform(middle_s, t_s[-1] - SESSION_S[-1], STARTS)
        true = swing((starts_s[:, None] + SESSION_S).ravel())
        for frame, probability, sight, sides in found:
            wrong = Rotation.from_rotvec(np.deg2rad(rng.normal(0.0, MEAN_SIGMA_DEG, (STARTS, 3))))
            stated = wrong[np.repeat(np.arange(STARTS), len(SESSION_S))] * mean
            seen = (true * stated.inv()).apply(np.tile(sight, (STARTS, 1))).reshape(STARTS, -1, 3)
            off_rad = np.einsum("nij,knj->kni", sides, seen)
            told.append(probability)
            kept.append(np.mean(np.all(np.abs(off_rad) <= frame.frame_half_rad, axis=(1, 2))))
    told, kept = np.array(told), np.array(kept)
    print("probability of staying in the frame: goal |told - kept| <= 0.05 in every bin")
    for edge in np.arange(BINS) / BINS:
        inside = (told >= edge) & (told <= edge + 1.0 / BINS)
        if inside.sum() >= 20:
            print(
                f"  {edge:.1f} to {edge + 1.0 / BINS:.1f}: {inside.sum():5d} sessions, "
                f"told {told[inside].mean():.3f}, kept {kept[inside].mean():.3f}"
            )


def corrected(folder: Path) -> None:
    """What looks at the telemetry's second half, of a horizon's kind, leave of its errors later."""
    t_s, q_body_from_lvlh = telemetry(folder)
    middle_s = t_s[len(t_s) // 2]
    mean = q_body_from_lvlh[t_s < middle_s].mean()
    swing = Slerp(t_s, q_body_from_lvlh)
    rng = np.random.default_rng(4)
    variances = np.diag([LOOK_SIGMA_DEG**2, LOOK_SIGMA_DEG**2, 180.0**2])
    seen, told = [], []
    for _ in range(LOOK_TRIALS):
        wrong = Rotation.from_rotvec(np.deg2rad(rng.normal(0.0, MEAN_SIGMA_DEG, 3)))
        first_s = rng.uniform(middle_s, t_s[-1] - LOOKS_S[-1] - CORRECTED_LEADS_S[-1])
        last_s = first_s + LOOKS_S[-1]

        def error_deg(at_s: np.ndarray, wrong: Rotation = wrong) -> np.ndarray:
            return (swing(at_s) * (wrong * mean).inv()).as_rotvec(degrees=True)

        noise_deg = rng.normal(0.0, LOOK_SIGMA_DEG, (len(LOOKS_S), 3)) * [1.0, 1.0, 0.0]
        law = LvlhAttitude(
            corrections=tuple(
                AttitudeCorrection(
                    epoch=shifted_utc(NOON_UTC, at_s),
                    turn_body_deg=tuple(turn_deg.tolist()),
                    covariance_deg2=tuple(tuple(row) for row in variances.tolist()),
                )
                for at_s, turn_deg in zip(
                    LOOKS_S, error_deg(first_s + np.array(LOOKS_S)) + noise_deg, strict=True
                )
            )
        )
        at = Instants(NOON_UTC, LOOKS_S[-1] + np.array(CORRECTED_LEADS_S))
        left_deg = error_deg(last_s + np.array(CORRECTED_LEADS_S)) - np.rad2deg(law.turn_rad(at))
        seen.append(left_deg)
        told.append(np.rad2deg(np.sqrt(np.sum(law.errors(at).modes_body_rad ** 2, axis=0))))
    print(
        f"looks {LOOKS_S} s with {LOOK_SIGMA_DEG} deg about x and y: rms left about x, y, told, "
        "NEES (goal 0.8 to 1.3)"
    )
    for k, lead_s in enumerate(CORRECTED_LEADS_S):
        left, sigma = np.array(seen)[:, k, :2], np.array(told)[:, k, :2]
        print(
            f"  {lead_s:6.0f} s after: {np.sqrt(np.mean(left**2, axis=0)).round(3)}, "
            f"{np.sqrt(np.mean(sigma**2, axis=0)).round(3)} deg, {np.mean((left / sigma) ** 2):.2f}"
        )


def attitude_figures(folder: Path) -> None:
    """The swing about the mean, and how far a constant body rate goes wrong."""
    t_s, q_body_from_lvlh = telemetry(folder)
    turn_deg = (q_body_from_lvlh * q_body_from_lvlh.mean().inv()).as_rotvec(degrees=True)
    print(f"swing about body x, y, z: rms {np.std(turn_deg, axis=0).round(3)} deg")
    # LVLH turns about -Y once an orbit; from which direction doesn't matter.
    q_lvlh = Rotation.from_rotvec(np.outer(2.0 * np.pi / PERIOD_S * t_s, [0.0, 1.0, 0.0]))
    q_body = q_body_from_lvlh * q_lvlh
    rates = {number: channel(folder, number) for number in (25, 26, 27)}
    omega_deg_s = np.stack([held(rates, number, t_s) for number in (25, 26, 27)], axis=1)
    row_of = {round(at_s / STEP_S): row for row, at_s in enumerate(t_s)}
    print("constant body rate: rms about body x, y, z")
    for lead_s in RATE_LEADS_S:
        ahead = [row_of.get(round((at_s + lead_s) / STEP_S), -1) for at_s in t_s]
        now = np.flatnonzero(np.array(ahead) >= 0)
        later = q_body[np.array(ahead)[now]]
        turned = Rotation.from_rotvec(-np.deg2rad(omega_deg_s[now]) * lead_s) * q_body[now]
        miss_deg = (turned * later.inv()).as_rotvec(degrees=True)
        print(f"  {lead_s:6.0f} s: {np.sqrt(np.mean(miss_deg**2, axis=0)).round(3)} deg")


def telemetry(folder: Path) -> tuple[np.ndarray, Rotation]:
    """Every 10 s where values are fresh: seconds of the year, body from LVLH."""
    channels = {number: channel(folder, number) for number in (18, 19, 20, 21)}
    changes_s = channels[20][0]
    t_s = np.arange(channels[21][0][0], changes_s[-1], STEP_S)
    latest_s = changes_s[np.searchsorted(changes_s, t_s, side="right") - 1]
    t_s = t_s[t_s - latest_s < STALE_S]
    xyzw = np.stack([held(channels, number, t_s) for number in (19, 20, 21, 18)], axis=1)
    return t_s, Rotation.from_quat(xyzw).inv()


def session(tle: TleOrbit, law: LvlhAttitude, rng: np.random.Generator) -> Iterator[tuple]:
    """A target near the track, seen from a state without age: frames with what is told of them."""
    start_utc = tle.epoch_utc + timedelta(seconds=float(rng.integers(0, 43200)))
    stop_utc = start_utc + timedelta(seconds=95)
    instants = Instants(start_utc, SESSION_S)
    states = tle.ephemeris(start_utc, stop_utc).states(instants)
    middle = Instants(start_utc, SESSION_S[5:6])
    r_itrf_m = np.einsum("nij,nj->ni", c_itrf_from_eci(middle), states.r_sat_eci_m[5:6])
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(r_itrf_m)
    target = GroundTarget(
        latitude_deg=float(np.clip(math.degrees(latitude_rad[0]) + aside(rng), -89.0, 89.0)),
        longitude_deg=float((math.degrees(longitude_rad[0]) + aside(rng) + 540.0) % 360.0 - 180.0),
        height_m=0.0,
    )
    orbit = StateVectorOrbit(
        frame="GCRF",
        epoch=start_utc,
        position_km=tuple(states.r_sat_eci_m[0] / 1e3),
        velocity_km_s=tuple(states.v_sat_eci_m_s[0] / 1e3),
    )
    ephemeris = orbit.ephemeris(start_utc, stop_utc)
    los = line_of_sight(instants, ephemeris, law, ISS_HRC.q_platform_from_body, target)
    along = np.cross(ISS_HRC.axes_platform[0], los.los_platform)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    sides = np.stack([along, np.cross(los.los_platform, along)], axis=1)
    angle_rad = axis_angles(ISS_HRC, los.los_platform).angle_rad[0]
    for size in SIZES:
        frame = replace(ISS_HRC, frame_half_rad=tuple(size * np.array(ISS_HRC.frame_half_rad)))
        budget = pointing_budget(los, ephemeris, law, target, frame, angle_rad, clock_s=0.0)
        yield frame, budget.probability_in_frame, los.los_platform, sides


def aside(rng: np.random.Generator) -> float:
    return float(rng.uniform(-ASIDE_DEG, ASIDE_DEG))


def state_growth(data: Path) -> None:
    """A propagated state against NASA's ephemerides: the force model's part alone."""
    errors_m = []
    for path in sorted((data / "oem").glob("*.xml.gz")):
        oem = read_oem_file(path)
        for days in STATE_DAYS:
            epoch_utc = shifted_utc(oem.message.segments[0].epoch_utc, days * 86400.0)
            stop_utc = shifted_utc(epoch_utc, STATE_LEADS_S[-1] + 60.0)
            truth = oem.ephemeris(epoch_utc, stop_utc)
            first = truth.states(Instants(epoch_utc, np.zeros(1)))
            state = StateVectorOrbit(
                frame="GCRF",
                epoch=epoch_utc,
                position_km=tuple(first.r_sat_eci_m[0] / 1e3),
                velocity_km_s=tuple(first.v_sat_eci_m_s[0] / 1e3),
            )
            instants = Instants(epoch_utc, np.array(STATE_LEADS_S))
            found = state.ephemeris(epoch_utc, stop_utc).states(instants)
            errors_m.append(ric_m(truth.states(instants), found))
    rms_m = np.sqrt(np.mean(np.square(errors_m), axis=0))
    told = state_sigma(np.array(STATE_LEADS_S), paper_model=False)
    print(
        "a state propagated, along and across the track: rms seen of the force model, 1 sigma told"
    )
    for lead_s, seen_m, along_m, cross_m in zip(
        STATE_LEADS_S, rms_m, told.along_m, told.cross_m, strict=True
    ):
        print(
            f"  {lead_s:7.0f} s: {seen_m[1]:7.1f} and {seen_m[2]:5.1f} m, "
            f"{along_m:7.1f} and {cross_m:5.1f} m"
        )


if __name__ == "__main__":
    main()
