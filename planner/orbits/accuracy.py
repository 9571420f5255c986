"""The error of a predicted orbit, by its kind and age."""

from dataclasses import dataclass

import numpy as np

from planner.arrays import Array
from planner.frames.time_scales import DAY_S, Instants
from planner.orbits.ephemeris import Ephemeris
from planner.orbits.paper_model import PaperEphemeris

MEASURED_TLE = (
    "measured: 24 ISS TLEs against NASA ephemerides near their epoch, 493 of 2017 against later "
    "ones for the growth; reboosts excluded (bench/orbit_age.py)"
)
MEASURED_OEM = (
    "growth measured on one pair of ISS ephemerides 4 days apart (bench/orbit_age.py); "
    "20, 50, 20 m at its creation assumed"
)
ASSUMED_STATE = (
    "10 m and 0.01 m/s at the state's epoch assumed, as of a GNSS receiver; "
    "the force model's growth measured (bench/orbits.py)"
)


@dataclass(frozen=True, eq=False)
class OrbitSigma:
    """1-sigma errors along radial, along-track and cross-track, each shape (n,), and on what
    evidence."""

    radial_m: Array
    along_m: Array
    cross_m: Array
    basis: str


def orbit_sigma(ephemeris: Ephemeris, instants: Instants) -> OrbitSigma:
    """Errors of a prediction free of manoeuvres the source didn't know of.

    The ISS's figures; drag makes the growth along the track vary by a factor of three with
    height and solar activity.
    """
    age_s = ephemeris.age_s(instants)
    days = age_s / DAY_S
    if ephemeris.kind == "tle":
        return OrbitSigma(
            radial_m=np.hypot(150.0, 60.0 * days),
            along_m=np.hypot(900.0, 3000.0 * days**1.85),
            cross_m=np.hypot(350.0, 200.0 * days),
            basis=MEASURED_TLE,
        )
    if ephemeris.kind == "oem":
        return OrbitSigma(
            radial_m=np.hypot(20.0, 12.0 * days),
            along_m=np.hypot(50.0, 500.0 * days**2),
            cross_m=np.hypot(20.0, 8.0 * days),
            basis=MEASURED_OEM,
        )
    paper = isinstance(ephemeris, PaperEphemeris)
    model_m = 56.0 * (age_s / 900.0) ** 1.3 if paper else 0.2 * (age_s / 900.0) ** 2
    # A radial or forward velocity error drifts three times as far along the track.
    drift_m = 0.01 * age_s
    return OrbitSigma(
        radial_m=np.hypot(10.0, 0.3 * model_m),
        along_m=np.sqrt(10.0**2 + (3.0 * drift_m) ** 2 + model_m**2),
        cross_m=np.hypot(10.0, 0.3 * model_m),
        basis=ASSUMED_STATE,
    )
