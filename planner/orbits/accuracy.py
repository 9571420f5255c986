"""The error of a predicted orbit, by its kind and age."""

from dataclasses import dataclass

import numpy as np

from planner.arrays import Array
from planner.frames.time_scales import DAY_S, Instants
from planner.orbits.ephemeris import Ephemeris
from planner.orbits.paper_model import PaperEphemeris

MEASURED_TLE = (
    "measured: ISS TLEs against NASA ephemerides near their epoch, those of 2017 against later "
    "ones for the growth, by the drag in the elements; reboosts excluded (bench/truth.py)"
)
MEASURED_OEM = (
    "growth measured on two ISS ephemerides of February 2022 (bench/truth.py); "
    "20, 50, 20 m at its creation assumed"
)
ASSUMED_STATE = (
    "10 m and 0.01 m/s at the state's epoch assumed, as of a GNSS receiver; "
    "the force model's growth measured (bench/truth.py)"
)
DRAG_LEAST_IN_A_DAY_M = 1200.0  # the air varies, however little of it the elements tell
_RATE_RAD_S = 2.0 * np.pi / 5560.0  # the ISS's, whose figures these are
_STATE_M, _STATE_M_S = 10.0, 0.01


@dataclass(frozen=True, eq=False)
class OrbitSigma:
    """1-sigma errors along radial, along-track and cross-track, each shape (n,).

    Of a prediction free of manoeuvres the source didn't know of.  The ISS's figures; drag makes
    the growth along the track of an ephemeris vary by a factor of three with solar activity.
    basis: on what evidence.  better: what would make them smaller.
    is_along_laplace: whether the error along the track is rather Laplace's than Gauss's.
    """

    radial_m: Array
    along_m: Array
    cross_m: Array
    basis: str
    better: str
    is_along_laplace: bool = False


def orbit_sigma(ephemeris: Ephemeris, instants: Instants) -> OrbitSigma:
    """Errors of a prediction at n instants."""
    age_s = ephemeris.age_s(instants)
    if ephemeris.kind == "tle":
        return tle_sigma(age_s, ephemeris.drag_in_a_day_m)
    if ephemeris.kind == "oem":
        return oem_sigma(age_s)
    return state_sigma(age_s, paper_model=isinstance(ephemeris, PaperEphemeris))


def tle_sigma(age_s: Array, drag_in_a_day_m: float) -> OrbitSigma:
    """Of SGP4 elements, this long from their epoch.

    drag_in_a_day_m: how far along the track their drag takes the satellite in a day from the epoch.
    A forecast is wrong by about as much, more so where it was fitted across a reboost; half of them
    by less than half of that.
    """
    days = age_s / DAY_S
    drag_m = max(abs(drag_in_a_day_m), DRAG_LEAST_IN_A_DAY_M) * days**0.6  # per day
    return OrbitSigma(
        # What drifts along the track has another radius, by 2/3 of the drift in a radian.
        radial_m=np.sqrt(
            150.0**2 + (60.0 * days) ** 2 + (1.07 * drag_m / (DAY_S * _RATE_RAD_S)) ** 2
        ),
        along_m=np.hypot(1200.0, drag_m * days),
        cross_m=np.hypot(400.0, 190.0 * days),
        basis=MEASURED_TLE,
        better="younger elements, or an ephemeris (OEM)",
        is_along_laplace=True,
    )


def oem_sigma(age_s: Array) -> OrbitSigma:
    """Of an operator's ephemeris, this long after it was made."""
    days = age_s / DAY_S
    return OrbitSigma(
        radial_m=np.hypot(20.0, 12.0 * days),
        along_m=np.sqrt(50.0**2 + (1000.0 * days) ** 2 + (550.0 * days**2) ** 2),
        cross_m=np.hypot(20.0, 12.0 * days),
        basis=MEASURED_OEM,
        better="a younger ephemeris",
    )


def state_sigma(age_s: Array, *, paper_model: bool) -> OrbitSigma:
    """Of a state propagated this long from its epoch.

    paper_model: by the paper's central field with J2 and J4.
    """
    model_m = 56.0 * (age_s / 900.0) ** 1.3 if paper_model else 16.0 * (age_s / 5400.0) ** 2.05
    radial_m, along_m, cross_m = _drifted(age_s)
    return OrbitSigma(
        # 2/3 of the drift in a radian, as of elements
        radial_m=np.hypot(radial_m, (0.3 if paper_model else 0.06) * model_m),
        along_m=np.hypot(along_m, model_m),
        cross_m=np.hypot(cross_m, (0.3 if paper_model else 0.01) * model_m),
        basis=ASSUMED_STATE,
        better="a state nearer to the session, or an ephemeris (OEM)",
    )


def _drifted(age_s: Array) -> tuple[Array, Array, Array]:
    """What `_STATE_M` and `_STATE_M_S` on each axis grow to: radial, along, across.

    Source: Clohessy and Wiltshire 1960, with velocities against inertial axes.
    """
    n = _RATE_RAD_S
    s, c = np.sin(n * age_s), np.cos(n * age_s)
    by_position = (
        np.hypot(2.0 - c, s),
        np.hypot(2.0 * s - 3.0 * n * age_s, 2.0 * c - 1.0),
        c,
    )
    by_velocity_s = (
        np.hypot(s, 2.0 * (1.0 - c)) / n,
        np.hypot(2.0 * (1.0 - c) / n, 4.0 * s / n - 3.0 * age_s),
        s / n,
    )
    radial_m, along_m, cross_m = (
        np.hypot(_STATE_M * r, _STATE_M_S * v_s)
        for r, v_s in zip(by_position, by_velocity_s, strict=True)
    )
    return radial_m, along_m, cross_m
