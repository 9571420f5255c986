"""Tables and platforms to fly in tests."""

import math
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np

from planner.base.commands import ROWS_PER_S, CommandTable, axis_channels
from planner.inflight.simulation.plant import plant_of
from planner.world.platforms import IDEAL_DRIVE, ISS_HRC, AxisDrive, CarrierMode

ARCSEC = math.radians(1.0 / 3600.0)
EPOCH = datetime(2015, 2, 27, 17, 34, tzinfo=UTC)

# Four modes about three directions, none along an axis, one of them near another.
ROCKING = replace(
    ISS_HRC,
    structural_modes=tuple(
        CarrierMode(
            axis_platform=axis, frequency_hz=frequency_hz, damping=damping, inertia_kg_m2=inertia
        )
        for axis, frequency_hz, damping, inertia in (
            ((0.6, 0.0, 0.8), 0.1, 0.01, 2000.0),
            ((0.0, 0.6, -0.8), 0.4, 0.005, 900.0),
            ((0.48, 0.6, 0.64), 0.45, 0.0, 700.0),
            ((-0.8, 0.6, 0.0), 2.0, 0.02, 400.0),
        )
    ),
)


def steady(*rates_arcsec_s, duration_s):
    """A table of constant rates from zero angles."""
    t_s = np.arange(round(duration_s * ROWS_PER_S) + 1) / ROWS_PER_S
    rate = np.array(rates_arcsec_s) * ARCSEC
    return CommandTable(
        epoch_utc=EPOCH,
        channels=axis_channels(ISS_HRC.axis_names),
        position=np.outer(t_s, rate),
        rate_rad_s=np.tile(rate, (len(t_s), 1)),
    )


def swinging(duration_s):
    """Both axes swing by tens of degrees, within rate, acceleration and jerk limits."""
    t_s = np.arange(round(duration_s * ROWS_PER_S) + 1) / ROWS_PER_S
    size, rate = np.radians([8.0, 5.0]), np.array([0.3, 0.4])
    phase = np.multiply.outer(t_s, rate)
    return CommandTable(
        epoch_utc=EPOCH,
        channels=axis_channels(ISS_HRC.axis_names),
        position=size * (1.0 - np.cos(phase)),
        rate_rad_s=size * rate * np.sin(phase),
    )


def rows_between(table, t_s):
    """The table's cubic Hermite, by SciPy."""
    from scipy.interpolate import CubicHermiteSpline

    return CubicHermiteSpline(table.t_s, table.position, table.rate_rad_s)(t_s)


def rough(**changes):
    """A drive with everything that is wrong with one, but for its sensors, which tell the truth."""
    return replace(
        AxisDrive(),
        **{
            "encoder_step_arcsec": 0.0,
            "encoder_noise_arcsec": 0.0,
            "gyro_step_arcsec_s": 0.0,
            "gyro_noise_arcsec_s": 0.0,
            "gyro_bias_arcsec_s": 0.0,
        }
        | changes,
    )


def lossless(platform, **changes):
    """Two axes without friction on modes without damping; fields of the plant by name."""
    plant = plant_of(platform, (replace(IDEAL_DRIVE, inertia_kg_m2=90.0), IDEAL_DRIVE))
    return plant._replace(mode_damping_per_s=0.0 * plant.mode_damping_per_s, **changes)
