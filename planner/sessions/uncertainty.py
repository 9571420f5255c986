"""The pointing budget: 1-sigma errors, and whether the target will be in the frame.

Each cause is carried through the geometry by repeating it with the cause disturbed by its
1-sigma: an orbit that is off also turns the local vertical the attitude is against.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from planner.attitude import AttitudeLaw
from planner.attitude.accuracy import attitude_sigma
from planner.frames.earth_orientation import iers_data_end_utc
from planner.frames.iers import RAD_PER_ARCSEC
from planner.frames.time_scales import DAY_S, Instants, elapsed_s
from planner.orbits import Ephemeris, OrbitStates
from planner.orbits.accuracy import orbit_sigma
from planner.platforms import TwoAxisPlatform
from planner.pointing.angles import boresight_platform, carried_axes
from planner.pointing.line_of_sight import LineOfSight
from planner.spec import spec
from planner.targets import VisibleTarget

SAMPLES = 11  # errors change over a pass, not from row to row
DRAWS = 1 << 14
RANDOM_MARGIN_SIGMA = 3.0
RANGE_MAX_M = 1e8  # beyond, metres at the target say nothing
_PROBE_M = 10.0
_PROBE_S = 0.1
_ARCSEC = 1.0 / RAD_PER_ARCSEC
IERS_PREDICTED_DAYS = 365.0  # finals2000A reaches a year ahead of its issue

Offsets = NDArray[np.float64]


@spec
class BudgetAssumptions:
    """What the request can't say about itself.

    clock_s: 1-sigma of the platform's clock against UTC.  drive_resolution_rad: step of an
    axis's encoder.
    """

    clock_s: float = 0.02
    drive_resolution_rad: float = 5.0 * RAD_PER_ARCSEC

    def __post_init__(self) -> None:
        for name in ("clock_s", "drive_resolution_rad"):
            if getattr(self, name) < 0.0:
                raise ValueError(f"{name} must not be negative, not {getattr(self, name)}")


DEFAULT_ASSUMPTIONS = BudgetAssumptions()


@dataclass(frozen=True, kw_only=True)
class Contribution:
    """One cause: 1-sigma per image axis at the session's worst instant.

    ground_m: the same at the target, across the line of sight; None for celestial targets.
    basis: whether measured or assumed, and on what.  is_bias: constant over the session.
    """

    cause: str
    sigma_arcsec: float
    ground_m: float | None
    is_bias: bool
    basis: str


@dataclass(frozen=True, kw_only=True)
class PointingBudget:
    """1-sigma pointing error of one session, per image axis at the worst instant.

    probability_in_frame: that the target is inside the frame at every instant of the session.
    """

    contributions: tuple[Contribution, ...]
    sigma_arcsec: float
    ground_m: float | None
    probability_in_frame: float


def pointing_budget(
    los: LineOfSight,
    ephemeris: Ephemeris,
    attitude: AttitudeLaw,
    target: VisibleTarget,
    platform: TwoAxisPlatform,
    assumptions: BudgetAssumptions = DEFAULT_ASSUMPTIONS,
    *,
    angle_rad: NDArray[np.float64] | None = None,
) -> PointingBudget:
    """Budget of the session whose line of sight is `los`.

    angle_rad: (n, 2), the axes at the instants of `los`; None: exactly on the target.

    Orbit, attitude, clock and Earth orientation are taken as constant over the session (their
    errors change over hours); the drives' resolution as random.  Leaves out the mount's
    alignment and the camera's own distortion, which are calibrated, and refraction.
    """
    scene = _Scene(los, ephemeris, attitude, target, platform, angle_rad)
    biases = [
        *_orbit_offsets(scene, ephemeris),
        *_attitude_offsets(scene, attitude),
        _earth_offsets(scene),
        _clock_offsets(scene, los, assumptions),
    ]
    random_rad = assumptions.drive_resolution_rad / np.sqrt(12.0)
    drives = ("drive resolution", "5 arcsec encoder step assumed unless stated", random_rad)
    total_rad = np.sqrt(sum(_per_axis_rad(o) ** 2 for _, _, o in biases) + random_rad**2)
    worst = int(np.argmax(total_rad))
    range_m = float(scene.range_m[worst])
    causes = list(dict.fromkeys((cause, basis) for cause, basis, _ in biases))
    contributions = [
        _contribution(
            cause,
            basis,
            np.sqrt(sum(_per_axis_rad(o)[worst] ** 2 for c, _, o in biases if c == cause)),
            range_m,
            is_bias=True,
        )
        for cause, basis in causes
    ]
    contributions.append(_contribution(*drives, range_m, is_bias=False))
    half_rad = np.array(platform.frame_half_rad) - RANDOM_MARGIN_SIGMA * random_rad
    return PointingBudget(
        contributions=tuple(contributions),
        sigma_arcsec=float(total_rad[worst]) * _ARCSEC,
        ground_m=_ground_m(float(total_rad[worst]), range_m),
        probability_in_frame=probability_inside(
            np.stack([o for _, _, o in biases]), half_rad, scene.off_rad
        ),
    )


def probability_inside(
    offsets_rad: Offsets, half_rad: NDArray[np.float64], known_rad: Offsets | None = None
) -> float:
    """Probability that a sum of independent constant errors never leaves the frame.

    offsets_rad: shape (m, n, 2), where a 1-sigma error of each of m causes puts the target in
    the image at n instants.  half_rad: shape (2,).  known_rad: (n, 2), where the target is
    without errors, the middle unless given.  The errors that keep the target inside at
    every instant are a convex polytope in m dimensions; its Gaussian measure by 16384
    quasi-random points, good to 0.003 (0.001 where few are lost).
    Source: Genz and Bretz 2009, section 4.2 (Richtmyer lattices).
    """
    if not (half_rad > 0.0).all():
        return 0.0
    causes = len(offsets_rad)
    in_half_frames = (offsets_rad / half_rad).reshape(causes, -1)
    known = np.zeros((1, 2)) if known_rad is None else known_rad
    middle = np.broadcast_to(known / half_rad, offsets_rad.shape[1:]).ravel()
    farthest = np.abs(middle + _normal_points(causes) @ in_half_frames).max(axis=1)
    return float(np.mean(farthest <= 1.0))


@cache
def _normal_points(causes: int) -> NDArray[np.float64]:
    """A Richtmyer lattice mapped to the standard normal, shape (DRAWS, causes)."""
    # SciPy's special functions take 0.1 s to import, which only a plan should pay.
    from scipy.special import ndtri

    primes = np.array([2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37])[:causes]
    if len(primes) < causes:
        raise ValueError(f"at most 12 causes can be drawn, not {causes}")
    return np.asarray(ndtri(np.outer(np.arange(DRAWS) + 0.5, np.sqrt(primes)) % 1.0))


class _Scene:
    """The session at a few instants, and where a disturbance puts the target in the image.

    off_rad: (n, 2), where the target is without errors; the instants are those, one of each
    stretch, at which it is farthest off.
    """

    def __init__(
        self,
        los: LineOfSight,
        ephemeris: Ephemeris,
        attitude: AttitudeLaw,
        target: VisibleTarget,
        platform: TwoAxisPlatform,
        angle_rad: NDArray[np.float64] | None,
    ) -> None:
        n = len(los.instants)
        self.rows = np.unique(np.linspace(0, n - 1, min(n, SAMPLES)).round().astype(np.intp))
        image = _image_axes(platform, los.los_platform, angle_rad)
        off_rad = np.einsum("nij,nj->ni", image, los.los_platform)
        if angle_rad is not None:
            self.rows = _farthest(off_rad / platform.frame_half_rad, self.rows)
        self._image, self.off_rad = image[self.rows], off_rad[self.rows]
        self.instants = Instants(los.instants.epoch_utc, los.instants.t_s[self.rows])
        self.states = ephemeris.states(self.instants)
        self.los_platform = los.los_platform[self.rows]
        self.range_m = los.range_m[self.rows]
        self._attitude, self._target, self._platform = attitude, target, platform

    def in_image(self, shift_platform: NDArray[np.float64]) -> Offsets:
        """Components along the inner axis and across it, shape (n, 2)."""
        return np.asarray(np.einsum("nij,nj->ni", self._image, shift_platform))

    def direction_platform(
        self, states: OrbitStates | None = None, late_s: float = 0.0
    ) -> NDArray[np.float64]:
        """With another orbit, or the target as it will be (the Earth turned on) late_s later."""
        states = states or self.states
        late = Instants(self.instants.epoch_utc, self.instants.t_s + late_s)
        seen = self._target.apparent(late, states).direction_eci
        q_body_from_eci = self._attitude.q_body_from_eci(self.instants, states)
        return np.asarray((self._platform.q_platform_from_body * q_body_from_eci).apply(seen))


def _image_axes(
    platform: TwoAxisPlatform, los_platform: NDArray[np.float64], angle_rad: Offsets | None
) -> NDArray[np.float64]:
    """Directions along the inner axis and across it, both square to the boresight, (n, 2, 3)."""
    if angle_rad is None:
        # On target the inner axis is square to the outer one and to the line of sight.
        boresight = los_platform
        along = np.cross(platform.axes_platform[0], los_platform)
    else:
        boresight = boresight_platform(platform, angle_rad)
        inner = carried_axes(platform, angle_rad)[1]
        along = inner - np.sum(inner * boresight, axis=1)[:, None] * boresight
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.stack([along, np.cross(boresight, along)], axis=1)


def _farthest(shares: Offsets, rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """Of the instants nearest to each of `rows` the one with the largest share of the frame."""
    nearest = np.abs(np.arange(len(shares))[:, None] - rows).argmin(axis=1)
    off = np.abs(shares).max(axis=1)
    return np.array([np.argmax(np.where(nearest == i, off, -1.0)) for i in range(len(rows))])


Cause = tuple[str, str, Offsets]


def _orbit_offsets(scene: _Scene, ephemeris: Ephemeris) -> list[Cause]:
    """Radial, along-track and cross-track, as independent causes."""
    sigma = orbit_sigma(ephemeris, scene.instants)
    r, v = scene.states.r_sat_eci_m, scene.states.v_sat_eci_m_s
    radius = np.linalg.norm(r, axis=1, keepdims=True)
    normal = np.cross(r, v)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    turn = _PROBE_M / radius
    disturbed = (
        (OrbitStates(r * (1.0 + turn), v), sigma.radial_m),
        # Ahead on its track: position and velocity both turned about the orbit's normal.
        (
            OrbitStates(r + turn * np.cross(normal, r), v + turn * np.cross(normal, v)),
            sigma.along_m,
        ),
        (OrbitStates(r + _PROBE_M * normal, v), sigma.cross_m),
    )
    undisturbed = scene.direction_platform()
    return [
        (
            "orbit",
            sigma.basis,
            scene.in_image(scene.direction_platform(states) - undisturbed)
            * (size_m / _PROBE_M)[:, None],
        )
        for states, size_m in disturbed
    ]


def _attitude_offsets(scene: _Scene, attitude: AttitudeLaw) -> list[Cause]:
    """A turn about any axis moves the image by its two components across the line of sight."""
    sigma = attitude_sigma(attitude, scene.instants)
    size = sigma.per_axis_rad[:, None]
    return [
        ("attitude", sigma.basis, size * np.array([1.0, 0.0])),
        ("attitude", sigma.basis, size * np.array([0.0, 1.0])),
    ]


def _earth_offsets(scene: _Scene) -> Cause:
    """UT1; the pole's part is a tenth of it."""
    end_utc = iers_data_end_utc()
    past_days = elapsed_s(scene.instants.epoch_utc, end_utc) / DAY_S
    past_days += float(scene.instants.t_s[-1]) / DAY_S
    predicted_days = max(0.0, min(past_days + IERS_PREDICTED_DAYS, IERS_PREDICTED_DAYS))
    ut1_s = 2e-5 + 2.5e-4 * predicted_days**0.75 + 8.5e-4 * max(0.0, past_days)
    late = scene.direction_platform(late_s=_PROBE_S) - scene.direction_platform(late_s=-_PROBE_S)
    return (
        "Earth orientation",
        "measured UT1 drift of 0.85 ms a day where the last value is held, before that IERS "
        "Bulletin A's 0.25 ms x days^0.75",
        scene.in_image(late) * (ut1_s / (2.0 * _PROBE_S)),
    )


def _clock_offsets(scene: _Scene, los: LineOfSight, assumptions: BudgetAssumptions) -> Cause:
    """A table flown late points where the target was."""
    drift = scene.in_image(los.los_rate_platform_s[scene.rows])
    return (
        "clock",
        "20 ms of the platform's clock assumed unless stated",
        drift * assumptions.clock_s,
    )


def _per_axis_rad(offsets: Offsets) -> NDArray[np.float64]:
    """1-sigma per image axis, shape (n,)."""
    return np.asarray(np.sqrt(0.5 * np.sum(offsets**2, axis=-1)))


def _contribution(
    cause: str, basis: str, sigma_rad: float, range_m: float, *, is_bias: bool
) -> Contribution:
    return Contribution(
        cause=cause,
        sigma_arcsec=float(sigma_rad) * _ARCSEC,
        ground_m=_ground_m(float(sigma_rad), range_m),
        is_bias=is_bias,
        basis=basis,
    )


def _ground_m(sigma_rad: float, range_m: float) -> float | None:
    return sigma_rad * range_m if range_m < RANGE_MAX_M else None
