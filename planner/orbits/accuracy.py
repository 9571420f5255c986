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
    "the force model's growth measured (bench/truth.py)"
)


@dataclass(frozen=True, eq=False)
class OrbitSigma:
    """1-sigma errors along radial, along-track and cross-track, each shape (n,).

    Of a prediction free of manoeuvres the source didn't know of.  The ISS's figures; drag makes
    the growth along the track vary by a factor of three with height and solar activity.
    basis: on what evidence.  better: what would make them smaller.
    """

    radial_m: Array
    along_m: Array
    cross_m: Array
    basis: str
    better: str


def orbit_sigma(ephemeris: Ephemeris, instants: Instants) -> OrbitSigma:
    """Errors of a prediction at n instants."""
    age_s = ephemeris.age_s(instants)
    if ephemeris.kind == "tle":
        return tle_sigma(age_s)
    if ephemeris.kind == "oem":
        return oem_sigma(age_s)
    return state_sigma(age_s, paper_model=isinstance(ephemeris, PaperEphemeris))


def tle_sigma(age_s: Array) -> OrbitSigma:
    """Of SGP4 elements, this long from their epoch."""
    days = age_s / DAY_S
    return OrbitSigma(
        radial_m=np.hypot(150.0, 60.0 * days),
        along_m=np.hypot(900.0, 3000.0 * days**1.85),
        cross_m=np.hypot(400.0, 190.0 * days),
        basis=MEASURED_TLE,
        better="younger elements, or an ephemeris (OEM)",
    )


def oem_sigma(age_s: Array) -> OrbitSigma:
    """Of an operator's ephemeris, this long after it was made."""
    days = age_s / DAY_S
    return OrbitSigma(
        radial_m=np.hypot(20.0, 12.0 * days),
        along_m=np.hypot(50.0, 550.0 * days**2),
        cross_m=np.hypot(20.0, 12.0 * days),
        basis=MEASURED_OEM,
        better="a younger ephemeris",
    )


def state_sigma(age_s: Array, *, paper_model: bool) -> OrbitSigma:
    """Of a state propagated this long from its epoch.

    paper_model: by the paper's central field with J2 and J4.
    """
    model_m = 56.0 * (age_s / 900.0) ** 1.3 if paper_model else 16.0 * (age_s / 5400.0) ** 2.05
    # A radial or forward velocity error drifts three times as far along the track.
    drift_m = 0.01 * age_s
    return OrbitSigma(
        radial_m=np.hypot(10.0, 0.3 * model_m),
        along_m=np.sqrt(10.0**2 + (3.0 * drift_m) ** 2 + model_m**2),
        cross_m=np.hypot(10.0, (0.3 if paper_model else 0.01) * model_m),
        basis=ASSUMED_STATE,
        better="a state nearer to the session, or an ephemeris (OEM)",
    )
