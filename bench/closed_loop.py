"""Plan, look, correct, plan again: is the probability then told kept, and what was it before?

    python bench/closed_loop.py [--truths 40] [--seed 7]

Each truth is a carrier off its mean attitude by as much as the law lvlh assumes, swinging as it
assumes with phases of its own, and with a rest that is alike as long as it assumes.  Two horizon
cameras see it some times before a pass over Las Vegas; the frames are rendered (air, clouds,
noise), measured, and corrected for.  Told: the probability
that the target stays in frames of several sizes; kept: the share of truths in which it did.
"""

import argparse
import time
from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
from scipy.spatial.transform import Rotation

from app.requests.examples.horizon import AHEAD, RIGHT
from app.requests.horizon import PictureRequest
from app.work.horizon import measure, picture
from estimator.camera import HorizonCamera
from estimator.check import AttitudeCheck
from estimator.rendering.scene import Scene
from estimator.rendering.sensor import Sensor
from estimator.request import HorizonRequest, Position, PredictedAttitude
from planner.attitude import AttitudeCorrection, LvlhAttitude
from planner.attitude.errors import alike
from planner.frames.local_orbital import q_lvlh_from_eci
from planner.frames.time_scales import Instants, utc_from_text
from planner.orbits import StateVectorOrbit, TleOrbit
from planner.platforms import TwoAxisPlatform
from planner.platforms.iss_hrc import ISS_HRC
from planner.pointing.angles import axis_angles
from planner.pointing.line_of_sight import line_of_sight
from planner.sessions.uncertainty import pointing_budget
from planner.targets.ground import GroundTarget

TLE = TleOrbit(
    line1="1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991",
    line2="2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964",
)
LAW = LvlhAttitude(yaw_deg=-4.0, pitch_deg=-2.0, roll_deg=0.8)
LAS_VEGAS = GroundTarget(latitude_deg=36.1147, longitude_deg=-115.1728, height_m=610.0)
START_UTC = utc_from_text("2015-02-27T17:36:20Z")
SESSION_S = np.arange(0.0, 90.1, 9.0)
LOOKS_S = (-900.0, -480.0, -120.0)  # before the session, all by day
REST_S = np.arange(LOOKS_S[0], SESSION_S[-1] + 30.0, 30.0)
SIZES = (0.2, 0.3, 0.5, 0.7, 1.0, 1.5)  # of the HRC's frame
CAMERAS = tuple(
    HorizonCamera(
        **{name: tuple(value) if isinstance(value, list) else value for name, value in one.items()}
    )
    for one in (AHEAD, RIGHT)
)


class Truth:
    """A carrier's error (rad, about body x, y, z) against its law."""

    def __init__(self, rng: np.random.Generator) -> None:
        told = LAW.errors(Instants(START_UTC, np.zeros(1)))
        lasting_rad = np.sqrt(told.sigma_body_rad**2 - told.forgotten_body_rad**2)
        self._mean_rad = rng.normal(0.0, 1.0, 3) * lasting_rad
        likeness = alike(np.subtract.outer(REST_S, REST_S), told.memory_s)
        root = np.linalg.cholesky(likeness + 1e-9 * np.eye(len(REST_S)))
        self._rest_rad = root @ rng.normal(0.0, 1.0, (len(REST_S), 3)) * told.forgotten_body_rad
        self._amplitude_rad = np.sqrt(2.0) * told.swing_rms_body_rad
        self._phase_rad = rng.uniform(0.0, 2.0 * np.pi, 3)

    def turn_rad(self, t_s: np.ndarray) -> np.ndarray:
        """At n times since START_UTC."""
        phase_rad = 2.0 * np.pi * np.asarray(t_s)[:, None] / LAW.orbital_period_s + self._phase_rad
        rest_rad = np.stack([np.interp(t_s, REST_S, rest) for rest in self._rest_rad.T], axis=1)
        return self._mean_rad + self._amplitude_rad * np.cos(phase_rad) + rest_rad


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--truths", type=int, default=40)
    parser.add_argument("--seed", type=int, default=7)
    arguments = parser.parse_args()
    began_s = time.perf_counter()
    before, plain, told, kept, errors_deg = loops(arguments.truths, arguments.seed)
    print(f"{arguments.truths} truths, {time.perf_counter() - began_s:.0f} s")
    print(f"error left at the session, rms about body x, y, z: {rms(errors_deg)} deg")
    print(
        "frame  told before  kept before  told after  kept after (goal: within 0.05 and the count)"
    )
    spread = np.sqrt(0.25 / arguments.truths)
    for size, *row in zip(SIZES, before, plain, told, kept, strict=True):
        print(f"{size:5.1f}" + "".join(f"{value:12.3f}" for value in row))
    print(f"1 sigma of a kept share at one half, by the count: {spread:.3f}")


def loops(truths: int, seed: int) -> tuple[np.ndarray, ...]:
    """Told and kept before, told and kept after, for each of SIZES; errors left, (truths, 3)."""
    rng = np.random.default_rng(seed)
    told: list[list[float]] = []
    kept: list[list[bool]] = []
    errors_deg: list[np.ndarray] = []
    before, flown = probabilities(LAW)
    for k in range(truths):
        truth = Truth(rng)
        corrections = tuple(
            look
            for number, at_s in enumerate(LOOKS_S)
            if (look := measured(truth, at_s, seed=1000 * k + number)) is not None
        )
        corrected = replace(LAW, corrections=corrections)
        after, _ = probabilities(corrected)
        told.append(after)
        kept.append(stays(truth, corrected, *flown))
        middle = Instants(START_UTC, SESSION_S[5:6])
        error = truth.turn_rad(SESSION_S[5:6]) - corrected.turn_rad(middle)
        errors_deg.append(np.rad2deg(error[0]))
    plain = [stays(Truth(rng), LAW, *flown) for _ in range(2000)]
    means = (np.mean(shares, axis=0) for shares in (plain, told, kept))
    return np.array(before), *means, np.array(errors_deg)


def measured(truth: Truth, at_s: float, seed: int) -> AttitudeCorrection | None:
    """What the rendered frames say; None where they show no usable horizon."""
    at_utc = START_UTC + timedelta(seconds=at_s)
    states = TLE.ephemeris(at_utc, at_utc).states(Instants(at_utc, np.zeros(1)))
    q_law = LAW.q_body_from_eci(Instants(at_utc, np.zeros(1)), states)
    q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
    q_true = Rotation.from_rotvec(truth.turn_rad(np.array([at_s]))) * q_law
    yaw_deg, pitch_deg, roll_deg = (q_true * q_lvlh.inv()).inv().as_euler("ZYX", degrees=True)[0]
    images = [
        picture(
            PictureRequest(
                orbit=TLE,
                attitude=LvlhAttitude(yaw_deg=yaw_deg, pitch_deg=pitch_deg, roll_deg=roll_deg),
                camera=camera,
                at=at_utc,
                scene=Scene(cloud_cover=0.5, roughness_m=800.0),
                sensor=Sensor(blur_px=0.7, bits=8),
                seed=seed,
            )
        )
        for camera in CAMERAS
    ]
    x, y, z = (states.r_sat_eci_m[0] / 1e3).tolist()
    request = HorizonRequest(
        epoch=at_utc,
        position=Position(frame="GCRF", position_km=(x, y, z)),
        cameras=CAMERAS,
        predicted=PredictedAttitude(
            q_body_from_eci_xyzw=tuple(q_law.as_quat()[0].tolist()), sigma_deg=0.5
        ),
    )
    estimate, _ = measure(request, images, draw=False)
    return estimate.check and correction_of(at_utc, estimate.check)


def correction_of(at_utc: datetime, check: AttitudeCheck) -> AttitudeCorrection:
    covariance_deg2 = check.turn_covariance_rad2 * np.rad2deg(1.0) ** 2
    return AttitudeCorrection(
        epoch=at_utc,
        turn_body_deg=tuple(np.rad2deg(check.turn_body_rad).tolist()),
        covariance_deg2=tuple(tuple(row) for row in covariance_deg2.tolist()),
    )


def probabilities(law: LvlhAttitude) -> tuple[list[float], tuple]:
    """Told for each of SIZES, from a state without age; the line of sight and the frame's sides."""
    stop_utc = START_UTC + timedelta(seconds=95)
    instants = Instants(START_UTC, SESSION_S)
    states = TLE.ephemeris(START_UTC, stop_utc).states(instants)
    orbit = StateVectorOrbit(
        frame="GCRF",
        epoch=START_UTC,
        position_km=tuple(states.r_sat_eci_m[0] / 1e3),
        velocity_km_s=tuple(states.v_sat_eci_m_s[0] / 1e3),
    )
    ephemeris = orbit.ephemeris(START_UTC, stop_utc)
    los = line_of_sight(instants, ephemeris, law, ISS_HRC.q_platform_from_body, LAS_VEGAS)
    angle_rad = axis_angles(ISS_HRC, los.los_platform).angle_rad[0]
    along = np.cross(ISS_HRC.axes_platform[0], los.los_platform)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    sides = np.stack([along, np.cross(los.los_platform, along)], axis=1)
    told = [
        pointing_budget(
            los, ephemeris, law, LAS_VEGAS, frame_of(size), angle_rad, clock_s=0.0
        ).probability_in_frame
        for size in SIZES
    ]
    return told, (los.los_platform, sides)


def frame_of(size: float) -> TwoAxisPlatform:
    return replace(ISS_HRC, frame_half_rad=tuple(size * np.array(ISS_HRC.frame_half_rad)))


def stays(truth: Truth, law: LvlhAttitude, sight: np.ndarray, sides: np.ndarray) -> list[bool]:
    """Whether the target stays in each of SIZES where the table follows the law."""
    left_rad = truth.turn_rad(SESSION_S) - law.turn_rad(Instants(START_UTC, SESSION_S))
    moved = np.cross(left_rad, sight)
    off_rad = np.abs(np.einsum("nij,nj->ni", sides, moved)).max(axis=0)
    return [bool((off_rad <= frame_of(size).frame_half_rad).all()) for size in SIZES]


def rms(turns_deg: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(np.square(turns_deg), axis=0)).round(3)


if __name__ == "__main__":
    main()
