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
    "growth measured on ISS ephemerides of 2021 to 2025 by the drag in each (bench/truth.py); "
    "20, 50, 40 m at its creation assumed"
)
ASSUMED_STATE = (
    "10 m and 0.01 m/s at the state's epoch assumed, as of a GNSS receiver; "
    "the force model's growth measured (bench/truth.py)"
)
# The air foretold is wrong by so much of itself, rms of ten ephemerides.
OEM_DRAG_WRONG = 0.2
DRAG_LEAST_IN_A_DAY_M = 1200.0  # the air varies, however little of it the elements tell
_RATE_RAD_S = 2.0 * np.pi / 5560.0  # the ISS's, whose figures these are
_STATE_M, _STATE_M_S = 10.0, 0.01


@dataclass(frozen=True, eq=False)
class OrbitSigma:
    """1-sigma errors along radial, along-track and cross-track, each shape (n,).

    Of a prediction free of manoeuvres the source didn't know of.  The ISS's figures.
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
        return oem_sigma(age_s, ephemeris.drag_in_a_day_m)
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
        radial_m=np.sqrt(150.0**2 + (60.0 * days) ** 2 + _radial_m(1.6 * drag_m) ** 2),
        along_m=np.hypot(1200.0, drag_m * days),
        cross_m=np.hypot(400.0, 190.0 * days),
        basis=MEASURED_TLE,
        better="younger elements, or an ephemeris (OEM)",
        is_along_laplace=True,
    )


def oem_sigma(age_s: Array, drag_in_a_day_m: float) -> OrbitSigma:
    """Of an operator's ephemeris, this long after it was made.

    drag_in_a_day_m: how far along the track the drag in it takes the satellite in a day.  The
    operator's forecast of the air stays wrong by the same share, so the error grows as drag does.
    It is the cause of the elements' error, too, and as often small.
    """
    days = age_s / DAY_S
    drag_m = OEM_DRAG_WRONG * drag_in_a_day_m * days  # per day
    return OrbitSigma(
        radial_m=np.hypot(20.0, _radial_m(2.0 * drag_m)),
        along_m=np.sqrt(50.0**2 + (1000.0 * days) ** 2 + (drag_m * days) ** 2),
        cross_m=np.hypot(40.0, 8e-4 * drag_m * days),  # the node turns at another rate
        basis=MEASURED_OEM,
        better="a younger ephemeris",
        is_along_laplace=True,
    )


def _radial_m(drift_m_day: Array) -> Array:
    """What drifts along the track has another radius, by 2/3 of the drift in a radian."""
    return np.asarray(drift_m_day / (1.5 * DAY_S * _RATE_RAD_S))


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
