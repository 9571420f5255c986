"""The pointing budget of two axes: orbit, Earth, clock, the carrier's attitude and the drives."""

import math
from collections.abc import Sequence

import numpy as np

from planner.base.arrays import Array, cross
from planner.motion.pointing.angles import axis_angles
from planner.motion.pointing.frame import frame_axes
from planner.motion.pointing.line_of_sight import LineOfSight, line_of_sight
from planner.planning.sessions.budget import PointingBudget
from planner.planning.sessions.probability import probability_inside
from planner.planning.sessions.uncertainty import (
    OPTIONS,
    Bias,
    Cause,
    ImageScene,
    along_track,
    budget_of,
    constant_biases,
    covariances_rad2,
    lasting_biases,
    probabilities_each,
)
from planner.world.attitude import AttitudeErrors, AttitudeLaw
from planner.world.frames.iers import RAD_PER_ARCSEC
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.platforms import RollRule, TwoAxisPlatform
from planner.world.targets import VisibleTarget

DRIVE_RAD = 5.0 * RAD_PER_ARCSEC / math.sqrt(12.0)  # 1-sigma of an axis by its encoder's step
_DRIVES = Cause("drive resolution", "5 arcsec encoder step assumed unless stated", "finer drives")


def pointing_budget(
    los: LineOfSight,
    ephemeris: Ephemeris,
    attitude: AttitudeLaw,
    target: VisibleTarget,
    platform: TwoAxisPlatform,
    angle_rad: Array,
    *,
    session: int,
    clock_s: float = OPTIONS.clock_s,
) -> PointingBudget:
    """Budget of the session, by its number, whose line of sight is `los`.

    angle_rad: (n, 2), the axes at the instants of `los`.

    Orbit, clock, Earth orientation and the mean attitude are taken as constant over the session
    (their errors change over hours); the carrier swings about its mean at the orbital rate with
    a phase that nobody knows beforehand; the drives' resolution is random.  Leaves out the mount's
    alignment and the camera's own distortion, which are calibrated, and refraction.
    """
    scene = PointingScene(los, attitude, target, platform, angle_rad, OPTIONS.samples)
    biases = error_biases(scene, ephemeris, attitude.errors(scene.instants), clock_s)

    def stay(without: Cause | None, every: int) -> float:
        others = [bias for bias in biases if bias.cause != without]
        return stay_probability(others, scene, platform, every)

    return budget_of(scene, biases, {}, {_DRIVES: DRIVE_RAD}, stay, session=session)


def stay_probability(
    biases: Sequence[Bias], scene: "PointingScene", platform: TwoAxisPlatform, every: int = 1
) -> float:
    return probability_inside(
        np.stack(constant_biases(biases)),
        _half_rad(platform),
        scene.off_rad,
        [
            np.stack([bias.offsets_rad, bias.quarter_later_rad])
            for bias in biases
            if bias.quarter_later_rad is not None
        ],
        along_track(biases),
        every=every,
    )


def probabilities_at(
    los: LineOfSight,
    ephemeris: Ephemeris,
    attitude: AttitudeLaw,
    target: VisibleTarget,
    platform: TwoAxisPlatform,
    angle_rad: Array,
) -> Array:
    """That the target is in the frame at each instant by itself, (n,); as `pointing_budget`.

    By every 16th point of the budget's, good to 0.01.
    """
    scene = PointingScene(los, attitude, target, platform, angle_rad, len(los.instants))
    biases = error_biases(scene, ephemeris, attitude.errors_each(scene.instants))
    return probabilities_each(scene, biases, (), _half_rad(platform))


def _half_rad(platform: TwoAxisPlatform) -> Array:
    return np.array(platform.frame_half_rad) - OPTIONS.random_margin_sigma * DRIVE_RAD


def error_covariance_rad2(
    los: LineOfSight,
    ephemeris: Ephemeris,
    attitude: AttitudeLaw,
    target: VisibleTarget,
    platform: TwoAxisPlatform,
    angle_rad: Array,
) -> Array:
    """Covariances of the image place by the causes of `pointing_budget`, shape (n, 2, 2).

    In the order of the frame's sides: the first, turned by `frame_turn_rad` from the inner axis
    about the boresight, and the second across it.  angle_rad: (n, 2), the axes at the instants of
    `los`.  Its mean per axis is the square of the budget's `sigma_arcsec`.
    """
    scene = PointingScene(los, attitude, target, platform, angle_rad, len(los.instants))
    biases = error_biases(scene, ephemeris, attitude.errors(scene.instants))
    return covariances_rad2(biases, DRIVE_RAD)


def probability_held(
    platform: TwoAxisPlatform,
    attitude: AttitudeLaw,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    roll: RollRule | None,
    instants: Instants,
    branch: int,
    every: int,
) -> float:
    """That the target stays in the frame, held exactly on a branch of `axis_angles`.

    roll: axes have none.  By one of `every` draws.  NaN where no pair of angles points there at
    one of the instants.
    """
    los = line_of_sight(instants, ephemeris, attitude, platform.q_platform_from_body, target)
    angle_rad = axis_angles(platform, los.los_base).angle_rad[branch]
    if not np.isfinite(angle_rad).all():
        return np.nan
    scene = PointingScene(los, attitude, target, platform, angle_rad, OPTIONS.samples)
    biases = error_biases(scene, ephemeris, attitude.errors(scene.instants))
    return stay_probability(biases, scene, platform, every)


class PointingScene(ImageScene):
    """The same of two axes: their base is turned by the law of the carrier's attitude."""

    def __init__(
        self,
        los: LineOfSight,
        attitude: AttitudeLaw,
        target: VisibleTarget,
        platform: TwoAxisPlatform,
        angle_rad: Array,
        samples: int,
    ) -> None:
        image = frame_axes(platform, angle_rad)
        super().__init__(los, target, image, platform.frame_half_rad, samples)
        self._attitude, self._platform = attitude, platform

    def turned_about_body(self, axis: int) -> Array:
        """Where the target goes, per radian by which the carrier turns about a body axis."""
        axis_platform = self._platform.q_platform_from_body.apply(np.eye(3)[axis])
        return self.in_image(cross(self.los_base, axis_platform))

    def _in_base(self, seen_eci: Array, instants: Instants, states: OrbitStates) -> Array:
        q_body_from_eci = self._attitude.q_body_from_eci(instants, states)
        return (self._platform.q_platform_from_body * q_body_from_eci).apply(seen_eci)


def error_biases(
    scene: PointingScene,
    ephemeris: Ephemeris,
    errors: AttitudeErrors,
    clock_s: float = OPTIONS.clock_s,
) -> list[Bias]:
    """What lasts over a session of two axes, whose carrier's attitude has these errors."""
    return lasting_biases(scene, ephemeris, _attitude_offsets(scene, errors), clock_s)


def _attitude_offsets(scene: PointingScene, errors: AttitudeErrors) -> list[Bias]:
    """Turns about the body axes, constant and swinging with the orbit."""
    sigma_body_rad = np.broadcast_to(errors.sigma_body_rad, (len(scene.instants), 3))
    r_m, v_m_s = scene.states.r_sat_eci_m, scene.states.v_sat_eci_m_s
    rate_rad_s = np.linalg.norm(cross(r_m, v_m_s), axis=1) / np.sum(r_m**2, axis=1)
    phase_rad = (rate_rad_s * (scene.instants.t_s - scene.instants.t_s[0]))[:, None]
    cause = Cause("attitude", errors.basis, errors.better)
    about = np.stack([scene.turned_about_body(axis) for axis in range(3)])
    biases = [
        Bias(cause, np.einsum("na,ani->ni", mode_rad, about)) for mode_rad in errors.modes_body_rad
    ]
    for axis, swing_rms_rad in enumerate(errors.swing_rms_body_rad):
        turned = about[axis]
        if not len(errors.modes_body_rad):
            biases.append(Bias(cause, sigma_body_rad[:, axis, None] * turned))
        if swing_rms_rad > 0.0:
            swing = swing_rms_rad * turned
            biases.append(Bias(cause, swing * np.cos(phase_rad), swing * np.sin(phase_rad)))
    return biases
