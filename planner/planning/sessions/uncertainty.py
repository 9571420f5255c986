"""The pointing budget: 1-sigma errors, and whether the target will be in the frame.

Each cause is carried through the geometry by repeating it with the cause disturbed by its
1-sigma: an orbit that is off also turns the local vertical the attitude is against.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, cross
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.planning.sessions.budget import LIKELY, Contribution, PointingBudget
from planner.planning.sessions.probability import lattice_points, mixture_points
from planner.world.frames.earth_orientation import iers_data_end_utc
from planner.world.frames.iers import RAD_PER_ARCSEC
from planner.world.frames.time_scales import DAY_S, Instants, elapsed_s
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.orbits.accuracy import GAUSS, NormalMixture
from planner.world.targets import VisibleTarget

# Sample rows of a session for its pointing budget.

_FRAME_TURN_RAD = 0.1  # a keyhole turns the frame in seconds: one more row each


def spread_rows(image_base: Array, samples: int) -> Indices:
    """Choose that many of the rows, evenly, and more where the frame turns in the base.

    image_base: (n, 2, 3), the directions of the frame's sides.
    """
    rows = np.arange(len(image_base))
    turn_rad = np.linalg.norm(np.diff(image_base, axis=0), axis=(1, 2))
    along = np.linspace(0.0, samples - 1.0, len(rows))
    along[1:] += np.cumsum(turn_rad) / _FRAME_TURN_RAD
    even = np.linspace(0.0, along[-1], math.ceil(along[-1]) + 1)
    return np.unique(np.interp(even, along, rows).round().astype(np.intp))


def farthest_rows(shares: Array, rows: Indices) -> Indices:
    """The one of the instants nearest to each of `rows` with the largest share of the frame."""
    ends = np.concatenate([[0], (rows[1:] + rows[:-1]) // 2 + 1, [len(shares)]])
    return np.array([first + np.argmax(shares[first:last]) for first, last in pairwise(ends)])


@dataclass(frozen=True, kw_only=True)
class BudgetOptions:
    """How a pointing budget is sampled, and what it assumes."""

    samples: int = 11  # errors change over a pass, not from row to row
    coarse: int = 16  # one of so many draws, where instants are many
    compared: int = 4  # the same, where causes are compared to 0.01
    felt: float = 0.005  # of the variance: without a cause of less the probability stays as it is
    batch: int = 1000  # instants: 16 MB
    # of the drives, whose error is another each row: kept free at the frame's edge
    random_margin_sigma: float = 3.0
    off_target: float = 1e-3  # of the frame: more than a table's rows leave between them
    half_lives: float = 128.0  # of what wanders, in a session: quicker, it counts as so many
    half_life: float = 110.0  # of `effort`, each, by all paths
    range_max_m: float = 1e8  # beyond, metres at the target say nothing
    probe_m: float = 10.0  # by which the orbit is probed: 2.5e-5 of the range at 400 km, so linear
    probe_s: float = 0.1  # by which the clock is probed: 50 m of the ground's turning, likewise
    iers_predicted_days: float = 365.0  # finals2000A reaches a year ahead of its issue
    # What a request can't say about itself, so assumed. 1-sigma of the platform's clock against
    # UTC
    clock_s: float = 0.02


OPTIONS = BudgetOptions()

_ARCSEC = 1.0 / RAD_PER_ARCSEC


class Cause(NamedTuple):
    """What makes an error, on what evidence, and what would make it smaller."""

    cause: str
    basis: str
    better: str


def budget_of(
    scene: "ImageScene",
    biases: Sequence["Bias"],
    wander_rad: Mapping[Cause, float],
    random_rad: Mapping[Cause, float],
    stay: Callable[[Cause | None, int], float],
    *,
    session: int,
) -> PointingBudget:
    """All causes of a session, by its number, put together.

    wander_rad, random_rad: 1-sigma per image axis of what changes over seconds, and faster.
    stay: the probability to stay in the frame without a cause, by each so manieth draw.
    """
    squares_rad2: dict[Cause, Array] = {}
    for bias in biases:
        squares_rad2[bias.cause] = squares_rad2.get(bias.cause, 0.0) + bias.sigma_rad**2
    lasting = set(squares_rad2)
    for cause, sigma_rad in wander_rad.items():
        squares_rad2[cause] = np.full(len(scene.range_m), sigma_rad**2)
    random_rad2 = sum(sigma_rad**2 for sigma_rad in random_rad.values())
    total_rad = np.sqrt(sum(squares_rad2.values()) + random_rad2)
    worst = int(np.argmax(total_rad))
    range_m = float(scene.range_m[worst])
    sigmas_rad = {cause: math.sqrt(squares[worst]) for cause, squares in squares_rad2.items()}
    sigmas_rad.update(random_rad)
    probability = stay(None, 1)
    return PointingBudget(
        session=session,
        contributions=tuple(
            Contribution(
                **cause._asdict(),
                sigma_arcsec=sigma_rad * _ARCSEC,
                ground_m=_ground_m(sigma_rad, range_m),
                is_bias=cause in lasting,
            )
            for cause, sigma_rad in sigmas_rad.items()
        ),
        sigma_arcsec=float(total_rad[worst]) * _ARCSEC,
        ground_m=_ground_m(float(total_rad[worst]), range_m),
        probability_in_frame=probability,
        helps_most=None if probability >= LIKELY else _helps_most(squares_rad2, stay),
    )


def _helps_most(
    squares_rad2: Mapping[Cause, Array], stay: Callable[[Cause | None, int], float]
) -> str:
    """The cause without which the target stays likeliest, the largest of those that are alike.

    A frame's sides differ, and so do rare large errors and usual small ones of the same sigma.
    """
    variances_rad2 = {cause: float(np.sum(squares)) for cause, squares in squares_rad2.items()}
    least_rad2 = OPTIONS.felt * sum(variances_rad2.values())

    def share_left(cause: Cause) -> tuple[float, float]:
        return round(stay(cause, OPTIONS.compared), 2), variances_rad2[cause]

    felt = [cause for cause, variance_rad2 in variances_rad2.items() if variance_rad2 >= least_rad2]
    return max(felt, key=share_left).cause


class ImageScene:
    """The session at a few instants, and where a disturbance puts the target in the image.

    The base that the payload moves against is GCRF.  image: (n, 2, 3), directions of the frame's
    sides in it at the instants of `los`.  off_rad: (n, 2), where the target is without errors; the
    instants are those, one of each stretch, at which it is farthest off.
    """

    def __init__(
        self,
        los: LineOfSight,
        target: VisibleTarget,
        image: Array,
        frame_half_rad: tuple[float, float],
        samples: int,
    ) -> None:
        self.rows = spread_rows(image, min(len(image), samples))
        off_rad = np.einsum("nij,nj->ni", image, los.los_base)
        shares = np.abs(off_rad / frame_half_rad).max(axis=1)
        if shares.max() > OPTIONS.off_target:
            self.rows = farthest_rows(shares, self.rows)
        self._image, self.off_rad = image[self.rows], off_rad[self.rows]
        self.instants = Instants(los.instants.epoch_utc, los.instants.t_s[self.rows])
        self.states = OrbitStates(
            los.states.r_sat_eci_m[self.rows], los.states.v_sat_eci_m_s[self.rows]
        )
        self.los_base = los.los_base[self.rows]
        self.los_rate_base_per_s = los.los_rate_base_per_s[self.rows]
        self.range_m = los.range_m[self.rows]
        self._target = target

    def in_image(self, shift_base: Array) -> Array:
        """Components along the inner axis and across it, shape (n, 2)."""
        return np.asarray(np.einsum("nij,nj->ni", self._image, shift_base))

    def directions_base(self, orbits: Sequence[OrbitStates], late_s: Sequence[float]) -> Array:
        """Directions with other orbits and the target as it will be (Earth turned on) late_s later.

        All m cases at once, as a few instants cost what many do.  Shape (m, n, 3).
        """
        epoch_utc, t_s = self.instants.epoch_utc, self.instants.t_s
        states = OrbitStates(
            np.concatenate([orbit.r_sat_eci_m for orbit in orbits]),
            np.concatenate([orbit.v_sat_eci_m_s for orbit in orbits]),
        )
        late = Instants(epoch_utc, np.add.outer(late_s, t_s).ravel())
        seen = self._target.apparent(late, states).direction_eci
        seen_base = self._in_base(seen, Instants(epoch_utc, np.tile(t_s, len(orbits))), states)
        return np.asarray(seen_base.reshape(len(orbits), len(t_s), 3))

    def _in_base(self, seen_eci: Array, instants: Instants, states: OrbitStates) -> Array:
        return seen_eci


class Bias(NamedTuple):
    """Where a 1-sigma error of one cause puts the target in the image, (n, 2).

    quarter_later_rad: of a sinusoid of unknown phase, the same a quarter turn later.
    mixture: distribution of a constant error, where it isn't Gauss's.
    """

    cause: Cause
    offsets_rad: Array
    quarter_later_rad: Array | None = None
    mixture: NormalMixture = GAUSS

    @property
    def sigma_rad(self) -> Array:
        """Per image axis, shape (n,)."""
        squares = np.sum(self.offsets_rad**2, axis=-1)
        if self.quarter_later_rad is not None:
            squares = squares + np.sum(self.quarter_later_rad**2, axis=-1)
        return np.asarray(np.sqrt(0.5 * squares))


def constant_biases(biases: Sequence[Bias]) -> list[Array]:
    """The biases that don't swing, that of `along_track` last."""
    steady = [bias for bias in biases if bias.quarter_later_rad is None]
    return [bias.offsets_rad for bias in sorted(steady, key=lambda bias: bias.mixture != GAUSS)]


def covariances_rad2(biases: Sequence[Bias], random_rad: float) -> Array:
    """Of the place in the image by these errors, and one alike each way, (n, 2, 2)."""
    count = len(biases[0].offsets_rad)
    covariance_rad2 = np.tile(random_rad**2 * np.eye(2), (count, 1, 1))
    for bias in biases:
        for part_rad in (bias.offsets_rad, bias.quarter_later_rad):
            if part_rad is not None:
                covariance_rad2 += part_rad[:, :, None] * part_rad[:, None, :]
    return covariance_rad2


def along_track(biases: Sequence[Bias]) -> NormalMixture:
    """How the only error that isn't Gauss's is distributed."""
    return next((bias.mixture for bias in biases if bias.mixture != GAUSS), GAUSS)


def probabilities_each(
    scene: ImageScene, biases: Sequence[Bias], own_rad: Sequence[Array], half_rad: Array
) -> Array:
    """That the target is in the frame at each instant by itself, (n,).

    own_rad: further errors, of Gauss's distribution: where 1-sigma of each puts the target, (n, 2).
    By every 16th point of the budget's, good to 0.01.
    """
    if not (half_rad > 0.0).all():
        return np.zeros(len(scene.instants))
    constant = [*own_rad, *constant_biases(biases)]
    swings = [
        part
        for bias in biases
        if bias.quarter_later_rad is not None
        for part in (bias.offsets_rad, bias.quarter_later_rad)
    ]
    points = lattice_points(len(constant), len(swings) // 2)[:, :: OPTIONS.coarse]
    points = mixture_points(points, len(constant) - 1, along_track(biases))
    offsets = np.stack([*constant, *swings], axis=-1) / half_rad[:, None]
    middle = scene.off_rad / half_rad
    parts = []
    for first in range(0, len(scene.instants), OPTIONS.batch):
        batch = slice(first, first + OPTIONS.batch)
        places = middle[batch, :, None] + offsets[batch] @ points
        parts.append(np.mean(np.abs(places).max(axis=1) <= 1.0, axis=1))
    return np.concatenate(parts)


def lasting_biases(
    scene: ImageScene,
    ephemeris: Ephemeris,
    attitude: Sequence[Bias],
    clock_s: float,
) -> list[Bias]:
    """Those of orbit, attitude as given, Earth and clock."""
    orbits = [*_disturbed_orbits(scene.states), scene.states, scene.states]
    *moved, late, early = scene.directions_base(
        orbits, [0.0, 0.0, 0.0, OPTIONS.probe_s, -OPTIONS.probe_s]
    )
    return [
        *_orbit_offsets(scene, ephemeris, moved),
        *attitude,
        _earth_offsets(scene, late - early),
        _clock_offsets(scene, clock_s),
    ]


def _disturbed_orbits(states: OrbitStates) -> tuple[OrbitStates, ...]:
    """`OPTIONS.probe_m` out, ahead and across."""
    r, v = states.r_sat_eci_m, states.v_sat_eci_m_s
    radius = np.linalg.norm(r, axis=1, keepdims=True)
    normal = cross(r, v)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    turn = OPTIONS.probe_m / radius
    return (
        OrbitStates(r * (1.0 + turn), v),
        # Position and velocity both turned about the orbit's normal.
        OrbitStates(r + turn * cross(normal, r), v + turn * cross(normal, v)),
        OrbitStates(r + OPTIONS.probe_m * normal, v),
    )


def _orbit_offsets(
    scene: ImageScene, ephemeris: Ephemeris, moved_base: Sequence[Array]
) -> list[Bias]:
    """Radial, along-track and cross-track, as independent causes.

    moved_base: where the target is seen from each of the `_disturbed_orbits`.
    """
    sigma = ephemeris.sigma(scene.instants)
    sizes_m = (sigma.radial_m, sigma.along_m, sigma.cross_m)
    mixtures = (GAUSS, sigma.along, GAUSS)
    return [
        Bias(
            Cause("orbit", sigma.basis, sigma.better),
            scene.in_image(direction - scene.los_base) * (size_m / OPTIONS.probe_m)[:, None],
            mixture=mixture,
        )
        for direction, size_m, mixture in zip(moved_base, sizes_m, mixtures, strict=True)
    ]


def ut1_sigma_s(instants: Instants) -> float:
    """1-sigma of UT1 at the last of them, by how far the data of the Earth's turning reach."""
    end_utc = iers_data_end_utc()
    past_days = elapsed_s(instants.epoch_utc, end_utc) / DAY_S
    past_days += float(instants.t_s[-1]) / DAY_S
    predicted_days = max(
        0.0, min(past_days + OPTIONS.iers_predicted_days, OPTIONS.iers_predicted_days)
    )
    return 2e-5 + 2.5e-4 * float(predicted_days**0.75) + 8.5e-4 * max(0.0, past_days)


def _earth_offsets(scene: ImageScene, passing_base: Array) -> Bias:
    """UT1; the pole's part is a tenth of it.

    passing_base: how far the turning Earth moves the target from `probe_s` before to after.
    """
    ut1_s = ut1_sigma_s(scene.instants)
    cause = Cause(
        "Earth orientation",
        "measured UT1 drift of 0.85 ms a day where the last value is held, before that IERS "
        "Bulletin A's 0.25 ms x days^0.75",
        "newer Earth orientation data",
    )
    return Bias(cause, scene.in_image(passing_base) * (ut1_s / (2.0 * OPTIONS.probe_s)))


def _clock_offsets(scene: ImageScene, clock_s: float) -> Bias:
    """A table flown late points where the target was."""
    drift = scene.in_image(scene.los_rate_base_per_s)
    cause = Cause("clock", "20 ms of the platform's clock assumed unless stated", "a better clock")
    return Bias(cause, drift * clock_s)


def _ground_m(sigma_rad: float, range_m: float) -> float | None:
    return sigma_rad * range_m if range_m < OPTIONS.range_max_m else None
