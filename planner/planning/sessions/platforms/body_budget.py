"""The pointing budget of a body: orbit, Earth, clock, and what it knows and controls of itself."""

import math

import numpy as np

from planner.base.arrays import Array
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.planning.sessions.budget import PointingBudget
from planner.planning.sessions.probability import probability_wandering
from planner.planning.sessions.uncertainty import (
    OPTIONS,
    Cause,
    ImageScene,
    along_track,
    budget_of,
    constant_biases,
    covariances_rad2,
    lasting_biases,
)
from planner.world.frames.iers import RAD_PER_ARCSEC
from planner.world.orbits import Ephemeris
from planner.world.platforms.body import BodyPlatform, PushbroomCamera
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
    # Rows of the matrices are the payload's axes in the base.
    image = platform.q_payload_from_base(q_eci_from_body_xyzw).as_matrix()[:, :2]
    scene = ImageScene(los, target, image, platform.frame_half_rad, OPTIONS.samples)
    biases = lasting_biases(scene, ephemeris, (), OPTIONS.clock_s)
    knowledge = platform.knowledge
    wander_rad = {
        KNOWLEDGE: knowledge.sigma_arcsec * RAD_PER_ARCSEC,
        CONTROL: knowledge.control_sigma_arcsec * RAD_PER_ARCSEC,
    }
    jitter_rad = knowledge.jitter_arcsec * RAD_PER_ARCSEC
    half_rad = np.array(platform.frame_half_rad) - OPTIONS.random_margin_sigma * jitter_rad
    if isinstance(platform.camera, PushbroomCamera):
        half_rad[0] = math.inf

    lasts_s = float(scene.instants.t_s[-1] - scene.instants.t_s[0])
    half_life_s = max(knowledge.correlation_s, lasts_s / OPTIONS.half_lives)

    def stay(without: Cause | None, every: int) -> float:
        others = [bias for bias in biases if bias.cause != without]
        sigmas_rad = [sigma for cause, sigma in wander_rad.items() if cause != without]
        return probability_wandering(
            np.stack(constant_biases(others)),
            half_rad,
            scene.off_rad,
            scene.instants.t_s,
            math.hypot(*sigmas_rad),
            half_life_s,
            along_track(others),
            every=every,
        )

    return budget_of(scene, biases, wander_rad, {VIBRATION: jitter_rad}, stay, session=session)


def body_covariance_rad2(
    los: LineOfSight,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    platform: BodyPlatform,
    q_eci_from_body_xyzw: Array,
) -> Array:
    """Covariances of the image place by the causes of `body_budget`, as there, (n, 2, 2)."""
    image = platform.q_payload_from_base(q_eci_from_body_xyzw).as_matrix()[:, :2]
    scene = ImageScene(los, target, image, platform.frame_half_rad, len(los.instants))
    biases = lasting_biases(scene, ephemeris, (), OPTIONS.clock_s)
    knowledge = platform.knowledge
    alike_arcsec = math.hypot(
        knowledge.sigma_arcsec, knowledge.control_sigma_arcsec, knowledge.jitter_arcsec
    )
    return covariances_rad2(biases, alike_arcsec * RAD_PER_ARCSEC)
