"""The pointing budget of a body: orbit, Earth, clock, and what it knows and controls of itself."""

import math
from collections.abc import Sequence

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.motion.attitude.idle import idle_attitude
from planner.motion.attitude.track import TargetSight, roll_rule, rolled_quaternions
from planner.motion.pointing.line_of_sight import LineOfSight, line_of_sight
from planner.planning.sessions.budget import PointingBudget
from planner.planning.sessions.probability import probability_wandering
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
from planner.world.attitude import AttitudeLaw
from planner.world.frames.iers import RAD_PER_ARCSEC
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.platforms import BodyPlatform
from planner.world.platforms.body import RollRule
from planner.world.targets import VisibleTarget

_FIELD = "the platform's knowledge."
KNOWLEDGE = Cause("attitude knowledge", f"{_FIELD}sigma_arcsec", "better star trackers")
CONTROL = Cause("attitude control", f"{_FIELD}control_sigma_arcsec", "finer control")
VIBRATION = Cause("vibration", f"{_FIELD}jitter_arcsec", "less vibration")


def body_budget(
    los: LineOfSight,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    platform: BodyPlatform,
    q_eci_from_body_xyzw: Array,
    *,
    session: int,
) -> PointingBudget:
    """Budget of the session, by its number, whose line of sight in GCRF is `los`.

    q_eci_from_body_xyzw: (n, 4), the attitude at the instants of `los`.
    Knowledge and control wander over the session, vibration keeps 3 sigma free at the frame's
    edge.  A pushbroom's frame is its line: across it only the time changes at which a point is
    imaged.  Turns about the line of sight are left out: the target is in the frame's middle.
    """
    scene, biases = _scene(los, ephemeris, target, platform, q_eci_from_body_xyzw, OPTIONS.samples)
    wander_rad = _wander_rad(platform)

    def stay(without: Cause | None, every: int) -> float:
        others = [bias for bias in biases if bias.cause != without]
        sigmas_rad = [sigma for cause, sigma in wander_rad.items() if cause != without]
        return _stay_probability(scene, others, math.hypot(*sigmas_rad), platform, every)

    jitter_rad = platform.knowledge.jitter_arcsec * RAD_PER_ARCSEC
    return budget_of(scene, biases, wander_rad, {VIBRATION: jitter_rad}, stay, session=session)


def body_probability_held(
    platform: BodyPlatform,
    attitude: AttitudeLaw | None,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    roll: RollRule | None,
    instants: Instants,
    branch: int,
    every: int,
) -> float:
    """That the target stays in the frame, held exactly by a roll rule, the platform's unless given.

    attitude, branch: a body has none; the frame's sides are alike by both senses of the rule.
    "nearest" is nearest to the idle attitude at the first instant.  By one of `every` paths.
    """
    los = line_of_sight(instants, ephemeris, None, platform.q_base_from_carrier, target)
    sight = TargetSight(target=target, instants=instants, states=los.states, los_eci=los.los_base)
    idle = Rotation.from_quat(idle_attitude(platform.idle, instants, los.states).position[0])
    rule = roll_rule(platform, target, roll)
    q_eci_from_body_xyzw = rolled_quaternions(platform, rule, sight, 0, idle)[0]
    scene, biases = _scene(los, ephemeris, target, platform, q_eci_from_body_xyzw, OPTIONS.samples)
    sigma_rad = math.hypot(*_wander_rad(platform).values())
    lasts_s = float(instants.t_s[-1] - instants.t_s[0])
    effort.count(OPTIONS.half_life * lasts_s / _half_life_s(platform, lasts_s) / every)
    return _stay_probability(scene, biases, sigma_rad, platform, every)


def body_probabilities_at(
    los: LineOfSight,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    platform: BodyPlatform,
    q_eci_from_body_xyzw: Array,
) -> Array:
    """That the target is in the frame at each instant by itself, (n,); as `body_budget`."""
    samples = len(los.instants)
    scene, biases = _scene(los, ephemeris, target, platform, q_eci_from_body_xyzw, samples)
    sigma_rad = math.hypot(*_wander_rad(platform).values())
    turns = [np.tile(sigma_rad * side, (len(los.instants), 1)) for side in np.eye(2)]
    return probabilities_each(scene, biases, turns, _half_rad(platform))


def body_covariance_rad2(
    los: LineOfSight,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    platform: BodyPlatform,
    q_eci_from_body_xyzw: Array,
) -> Array:
    """Covariances of the image place by the causes of `body_budget`, as there, (n, 2, 2)."""
    samples = len(los.instants)
    _, biases = _scene(los, ephemeris, target, platform, q_eci_from_body_xyzw, samples)
    knowledge = platform.knowledge
    alike_arcsec = math.hypot(
        knowledge.sigma_arcsec, knowledge.control_sigma_arcsec, knowledge.jitter_arcsec
    )
    return covariances_rad2(biases, alike_arcsec * RAD_PER_ARCSEC)


def _scene(
    los: LineOfSight,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    platform: BodyPlatform,
    q_eci_from_body_xyzw: Array,
    samples: int,
) -> tuple[ImageScene, list[Bias]]:
    """And what lasts over the session."""
    # Rows of the matrices are the payload's axes in the base.
    image = platform.q_payload_from_base(q_eci_from_body_xyzw).as_matrix()[:, :2]
    scene = ImageScene(los, target, image, platform.frame_half_rad, samples)
    return scene, lasting_biases(scene, ephemeris, (), OPTIONS.clock_s)


def _wander_rad(platform: BodyPlatform) -> dict[Cause, float]:
    knowledge = platform.knowledge
    return {
        KNOWLEDGE: knowledge.sigma_arcsec * RAD_PER_ARCSEC,
        CONTROL: knowledge.control_sigma_arcsec * RAD_PER_ARCSEC,
    }


def _half_rad(platform: BodyPlatform) -> Array:
    """Of the frame, without what vibration takes; (2,)."""
    jitter_rad = platform.knowledge.jitter_arcsec * RAD_PER_ARCSEC
    return np.array(platform.held_half_rad) - OPTIONS.random_margin_sigma * jitter_rad


def _half_life_s(platform: BodyPlatform, lasts_s: float) -> float:
    return max(platform.knowledge.correlation_s, lasts_s / OPTIONS.half_lives)


def _stay_probability(
    scene: ImageScene, biases: Sequence[Bias], sigma_rad: float, platform: BodyPlatform, every: int
) -> float:
    """sigma_rad: of what wanders."""
    t_s = scene.instants.t_s
    return probability_wandering(
        np.stack(constant_biases(biases)),
        _half_rad(platform),
        scene.off_rad,
        t_s,
        sigma_rad,
        _half_life_s(platform, float(t_s[-1] - t_s[0])),
        along_track(biases),
        every=every,
    )
