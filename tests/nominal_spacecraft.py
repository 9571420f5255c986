"""The spacecraft that mechanics and Basilisk are compared with: nothing of it is dispersed."""

import numpy as np

from planner.spacecraft.flight.simulation import Dispersion
from planner.spacecraft.vehicle.dynamics import Ripple


def nominal(spacecraft):
    """The spacecraft as designed, without noise."""
    m = len(spacecraft.modes)
    return Dispersion(
        frequency_factor=np.ones(m),
        coupling_factor=np.ones(m),
        damping_factor=np.ones(m),
        inertia_factor=np.ones(3),
        gimbal_scale=np.ones(4),
        gimbal_offset_rad_s=np.zeros(4),
        gimbal_jitter_rad_s=0.0,
        ripple=Ripple(np.zeros(4), np.ones(4), np.zeros(4)),
        gyro_bias_rad_s=np.zeros(3),
        gyro_scale=np.zeros(3),
        noise=False,
        seed=0,
    )
