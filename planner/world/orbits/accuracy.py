"""Error laws of predicted orbits, by the age of what they rest on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.time_scales import DAY_S

MEASURED_TLE = (
    "measured: ISS TLEs against NASA ephemerides near their epoch, 2,300 of 1998-2004, 2017 and "
    "2024-25 against later ones for the growth, by the drag in the elements; reboosts since, as "
    "the ISS makes up for that drag, count in the probability, not in sigma "
    "(bench/truth.py, docs/decisions/orbit_growth.md)"
)
MEASURED_OEM = (
    "growth measured on ISS ephemerides of 2021 to 2025 by the drag in each, and past planned "
    "burns (docs/decisions/orbit_growth.md); 20, 50, 40 m at its creation assumed; unplanned burns "
    "since, one in 25 days as the ISS's, count in the probability, not in sigma"
)
ASSUMED_STATE = (
    "10 m and 0.01 m/s at the state's epoch assumed, as of a GNSS receiver; "
    "the force model's growth measured (bench/truth.py)"
)


class NormalMixture(NamedTuple):
    """Normal distributions about zero, of which each case has one.

    shares: of the cases, one in all.  sigma_ratios: their sigmas, over the one that is told.
    """

    shares: tuple[float, ...]
    sigma_ratios: tuple[float, ...]

    def scores(self, normal: Array) -> Array:
        """Scores of the standard normal distribution carried onto the mixture, each to one as rare.

        Linear between 81 scores of each part, up to 8 of its sigmas.
        """
        # SciPy's special functions take 0.1 s to import, which only a plan should pay.
        from scipy.special import ndtr, ndtri

        score = np.unique(np.outer(self.sigma_ratios, np.linspace(0.0, 8.0, 81)))
        beyond = ndtr(-score[:, None] / np.array(self.sigma_ratios)) @ np.array(self.shares)
        return np.asarray(np.sign(normal) * np.interp(np.abs(normal), -ndtri(beyond), score))


GAUSS = NormalMixture((1.0,), (1.0,))
# Often small and sometimes large: the same at all ages, fitted to elements of 1 to 7 days.
USUAL = NormalMixture((0.75, 0.25), (0.7, 1.6))


@dataclass(frozen=True, kw_only=True)
class OrbitErrorFigures:
    """What predictions were measured to be wrong by; of the ISS."""

    # the air predicted is wrong by so much of itself, rms of ten ephemerides
    oem_drag_wrong: float = 0.2
    tle_drag_wrong: float = 0.5  # what of the drag in elements is wrong: a share of it,
    tle_air_wrong: float = 0.07  # of what the thickest air at their height makes,
    tle_unseen_in_a_day_m: float = 300.0  # and what a fit can't see
    # times what that air makes: drag of a fit across a reboost,
    tle_beyond_air: tuple[float, float] = (1.3, 1.7)
    tle_beyond_wrong: float = 1.5  # of which nothing is right
    # the same where it is negative, as no air makes it: a share of it, and
    tle_negative_wrong: float = 2.5
    tle_negative_air_wrong: float = 2.0  # of what that air makes
    # power of the age: 1.5 if the air were wrong anew each day, 2 if for good
    tle_growth: float = 1.65
    # Reboosts where drag takes a satellite 4 km along the track in a day, small ones among usual
    # errors: how many, and rms of one, the time since it as the elements' age
    reboosts_a_day: float = 0.04
    reboost_m_s: float = 0.65
    reboost_drag_in_a_day_m: float = 4000.0
    # of burns that an ephemeris didn't plan the same: likeliest of 23, some of them against debris
    unplanned_a_day: float = 0.04
    unplanned_m_s: float = 0.15
    # of a burn in an ephemeris what isn't flown as planned, moved ones included: rms of eight,
    burn_wrong: float = 0.4  # as to the drift that it makes,
    burn_radial_wrong: float = 0.6  # and to the height
    state_m: float = 10.0  # of a GNSS receiver, at the state's epoch
    state_m_s: float = 0.01  # the same in velocity


FIGURES = OrbitErrorFigures()

_RATE_RAD_S = 2.0 * np.pi / 5560.0  # the ISS's, whose figures these are


@dataclass(frozen=True, eq=False)
class OrbitSigma:
    """1-sigma errors along radial, along-track and cross-track, each shape (n,).

    Of a prediction free of manoeuvres the source didn't know of.  The ISS's figures.
    basis: on what evidence.  better: a way to make them smaller.
    along: how the error along the track is distributed, over along_m; unforeseen burns are in it.
    """

    radial_m: Array
    along_m: Array
    cross_m: Array
    basis: str
    better: str
    along: NormalMixture = GAUSS


def tle_sigma(age_s: Array, drag_in_a_day_m: float, air_in_a_day_m: float) -> OrbitSigma:
    """Errors of SGP4 elements, this long from their epoch.

    drag_in_a_day_m: how far along the track their drag takes the satellite in a day from the epoch.
    air_in_a_day_m: how far the thickest air at their height would take the ISS.  Negative drag, or
    more than that air makes, is of elements fitted across a reboost.
    Neglects how other satellites differ: the large ones above 600 km are wrong by less than stated.
    """
    days = age_s / DAY_S
    shares = (FIGURES.tle_drag_wrong, FIGURES.tle_beyond_wrong)
    of_drag = float(np.interp(drag_in_a_day_m / air_in_a_day_m, FIGURES.tle_beyond_air, shares))
    of_air = FIGURES.tle_air_wrong
    if drag_in_a_day_m < 0.0:
        of_drag, of_air = FIGURES.tle_negative_wrong, FIGURES.tle_negative_air_wrong
    wrong_m = math.hypot(
        of_drag * drag_in_a_day_m, of_air * air_in_a_day_m, FIGURES.tle_unseen_in_a_day_m
    )
    drift_m_day = FIGURES.tle_growth * wrong_m * days ** (FIGURES.tle_growth - 1.0)
    along_m = np.hypot(1200.0, wrong_m * days**FIGURES.tle_growth)
    reboost = reboost_since(float(np.mean(age_s)), drag_in_a_day_m, air_in_a_day_m)
    return OrbitSigma(
        radial_m=np.sqrt(150.0**2 + (60.0 * days) ** 2 + _radial_m(drift_m_day) ** 2),
        along_m=along_m,
        cross_m=np.hypot(450.0, 155.0 * days),
        basis=MEASURED_TLE,
        better="younger elements, or an ephemeris (OEM)",
        along=_along_mixture(along_m, reboost),
    )


class UnforeseenBurn(NamedTuple):
    """How likely one is since, and how far along the track it takes: rms, m."""

    share: float
    along_m: float


def reboost_since(age_s: float, drag_in_a_day_m: float, air_in_a_day_m: float) -> UnforeseenBurn:
    """A reboost since elements this old, whose drag and air are as `tle_sigma` takes them.

    Reboosts make up for what drag takes: where it is more they are more often and larger, each by
    its root.  Drag that no air makes is of a fit across a reboost.
    """
    drag_m = min(abs(drag_in_a_day_m), air_in_a_day_m)
    more = math.sqrt(drag_m / FIGURES.reboost_drag_in_a_day_m)
    return _burn_since(age_s, FIGURES.reboosts_a_day * more, FIGURES.reboost_m_s * more)


def _burn_since(age_s: float, a_day: float, rms_m_s: float) -> UnforeseenBurn:
    """Drift of 3 times the gain of velocity, Clohessy and Wiltshire 1960."""
    return UnforeseenBurn(-math.expm1(-a_day * age_s / DAY_S), 3.0 * rms_m_s * age_s)


def _along_mixture(along_m: Array, burn: UnforeseenBurn) -> NormalMixture:
    return NormalMixture(
        (*((1.0 - burn.share) * part for part in USUAL.shares), burn.share),
        (*USUAL.sigma_ratios, math.hypot(1.0, burn.along_m / float(np.mean(along_m)))),
    )


class PlannedBurn(NamedTuple):
    """A burn that an ephemeris forecasts: since_s ago, (n,), 0 before; gain along the track."""

    since_s: Array
    gain_m_s: float


def oem_sigma(
    age_s: Array, drag_in_a_day_m: float, burns: Sequence[PlannedBurn] = ()
) -> OrbitSigma:
    """Errors of an operator's ephemeris, this long after it was made.

    drag_in_a_day_m: how far along the track the drag in it takes the satellite in a day.  The
    operator's forecast of the air stays wrong by the same share, so the error grows as drag does.
    It is the cause of the elements' error, too, and as often small.
    burns: planned when it was made.
    """
    days = age_s / DAY_S
    drag_m = FIGURES.oem_drag_wrong * drag_in_a_day_m * days  # per day
    along_m2 = (drag_m * days) ** 2
    radial_m2 = 20.0**2 + _radial_m(2.0 * drag_m) ** 2
    unplanned = _burn_since(float(np.mean(age_s)), FIGURES.unplanned_a_day, FIGURES.unplanned_m_s)
    for since_s, gain_m_s in burns:
        along_m2 = along_m2 + (3.0 * FIGURES.burn_wrong * gain_m_s * since_s) ** 2
        height_m = 2.0 * FIGURES.burn_radial_wrong * gain_m_s / _RATE_RAD_S
        radial_m2 = radial_m2 + np.where(since_s > 0.0, height_m, 0.0) ** 2
    along_m = np.sqrt(50.0**2 + (1000.0 * days) ** 2 + along_m2)
    return OrbitSigma(
        radial_m=np.sqrt(radial_m2),
        along_m=along_m,
        cross_m=np.hypot(40.0, 8e-4 * np.sqrt(along_m2)),  # the node turns at another rate
        basis=MEASURED_OEM,
        better="a younger ephemeris",
        along=_along_mixture(along_m, unplanned),
    )


def _radial_m(drift_m_day: Array) -> Array:
    """What drifts along the track has another radius, by 2/3 of the drift in a radian."""
    return np.asarray(drift_m_day / (1.5 * DAY_S * _RATE_RAD_S))


def state_sigma(age_s: Array, *, paper_model: bool) -> OrbitSigma:
    """Errors of a state propagated this long from its epoch.

    paper_model: by the paper's central field with J2 and J4.
    """
    model_m = 56.0 * (age_s / 900.0) ** 1.3 if paper_model else 16.0 * (age_s / 5400.0) ** 2.05
    radial_m, along_m, cross_m = _drift_state(age_s)
    return OrbitSigma(
        # 2/3 of the drift in a radian, as of elements
        radial_m=np.hypot(radial_m, (0.3 if paper_model else 0.06) * model_m),
        along_m=np.hypot(along_m, model_m),
        cross_m=np.hypot(cross_m, (0.3 if paper_model else 0.01) * model_m),
        basis=ASSUMED_STATE,
        better="a state nearer to the session, or an ephemeris (OEM)",
    )


def _drift_state(age_s: Array) -> tuple[Array, Array, Array]:
    """What `FIGURES.state_m` and `FIGURES.state_m_s` on each axis grow to: radial, along, across.

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
        np.hypot(FIGURES.state_m * r, FIGURES.state_m_s * v_s)
        for r, v_s in zip(by_position, by_velocity_s, strict=True)
    )
    return radial_m, along_m, cross_m
