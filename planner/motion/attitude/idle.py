"""The attitude that a spacecraft keeps between sessions: to nadir, to the Sun, among the stars."""

import numpy as np

from planner.base.commands import Motion
from planner.base.rotation import Rotation, of_like_sign
from planner.motion.attitude.track import attitude_motion, pointed_quaternions
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms.body import IdleLaw, InertialIdle, SunIdle
from planner.world.platforms.kept_direction import unit_vector
from planner.world.targets import BodyTarget


def idle_attitude(law: IdleLaw, instants: Instants, states: OrbitStates) -> Motion:
    """The idle attitude over n instants with its rates and accelerations.

    instants: at least 7, uniformly spaced, with the orbit's states there.  Nadir is geocentric.
    The Sun is its centre as seen, also from the Earth's shadow; north is GCRF's +Z, from which the
    Sun keeps 66 deg.  Rates are 7-point differences of the attitude: of a low orbit their error is
    (step / 54 s)^5 of the rate.
    """
    step_s = float(instants.t_s[-1] - instants.t_s[0]) / (len(instants) - 1)
    if isinstance(law, InertialIdle):
        q_body_from_eci = Rotation.from_quat([law.q_body_from_eci_xyzw] * len(instants))
        still = np.zeros((len(instants), 3))
        return Motion(of_like_sign(np.asarray(q_body_from_eci.inv().as_quat())), still, still)
    if isinstance(law, SunIdle):
        sun = BodyTarget(name="sun", grazing_altitude_km=0.0).apparent(instants, states)
        toward_eci, aside_eci = sun.direction_eci, np.tile([0.0, 0.0, 1.0], (len(instants), 1))
        aside_body = law.north
    else:
        r_sat_eci_m = states.r_sat_eci_m
        toward_eci = -r_sat_eci_m / np.linalg.norm(r_sat_eci_m, axis=1)[:, None]
        aside_eci, aside_body = states.v_sat_eci_m_s, law.forward_body
    toward_body = unit_vector(law.direction_body)
    pointed = pointed_quaternions(toward_eci, aside_eci, toward_body, unit_vector(aside_body))
    return attitude_motion(pointed, step_s)
