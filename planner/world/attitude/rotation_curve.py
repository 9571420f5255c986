"""The smooth curve of attitudes that the rows of a message stand for.

Predicted attitudes are smooth and are interpolated.  Measured ones carry noise: a curve
through every row of real 1 s telemetry accelerates by 10-25 arcsec/s2 where the vehicle does
by 0.1, and no camera should be made to follow that.  So the curve is the one that best
predicts rows it has not seen, and what it leaves out is stated.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from planner.base.arrays import Array
from planner.base.interpolation import lagrange_weights, quintic_coefficients
from planner.base.rotation import Rotation
from planner.world.frames.iers import RAD_PER_ARCSEC

if TYPE_CHECKING:
    from scipy.interpolate import BSpline, PPoly

    Curve: TypeAlias = BSpline | PPoly


@dataclass(frozen=True, kw_only=True)
class RotationCurveOptions:
    """How smooth a curve is laid through rows of attitudes."""

    # from row to row: beyond, how it turned between is a guess
    step_turn_max_rad: float = np.deg2rad(45.0)
    exact_rad: float = 0.1 * RAD_PER_ARCSEC  # the pointing error promised of a table
    # tried, the smoothest first
    knot_spacings_s: tuple[float, ...] = (160.0, 80.0, 40.0, 20.0, 10.0, 5.0)
    worth_a_smoother_curve: float = 1.25  # in held-out error
    held_out_every: int = 5  # rows one is foretold, to find the spacing
    sample_rows: int = 1000  # of a sample, and
    samples: int = 5  # so many of a message, evenly: long ones take as long
    degree: int = 5  # continuous in acceleration, which axes must follow


OPTIONS = RotationCurveOptions()

# Offsets, in rows, of the four rows that predict a row: from both sides, from before, from
# after.  A manoeuvre that begins or ends leaves one side right; a damaged row fits none.
_STENCILS = ((-2, -1, 1, 2), (-4, -3, -2, -1), (1, 2, 3, 4))
REACH = 2  # rows at either end whose place between neighbours can't be judged


@dataclass(frozen=True, eq=False)
class RotationCurve:
    """A twice continuously differentiable curve of rotations.

    residual_rms_rad, residual_max_rad: distance of the rows from it; zero when interpolated.
    knot_spacing_s: 0 when interpolated.
    """

    quaternion: "Curve"
    residual_rms_rad: float
    residual_max_rad: float
    knot_spacing_s: float

    def at(self, t_s: Array) -> Rotation:
        """Rotations at n instants within the rows'."""
        return Rotation.from_quat(self.quaternion(t_s))


def rotation_curve(
    t_s: Array, q_body_from_frame_xyzw: Array, q_dot_s: Array | None = None
) -> RotationCurve:
    """Fit the curve; ValueError when the rows are too far apart to say how it turns.

    t_s: shape (n,), increasing, n >= 2.  q_body_from_frame_xyzw: shape (n, 4), unit, neighbours of
    like sign; q_dot_s: its derivative.  Splines are fitted to the four components and normalised,
    which changes the attitude by less than their own error.
    """
    step = np.diff(q_body_from_frame_xyzw, axis=0)
    turn_rad = 4.0 * np.arcsin(0.5 * np.linalg.norm(step, axis=1))
    widest = int(np.argmax(turn_rad))
    if turn_rad[widest] > OPTIONS.step_turn_max_rad:
        raise ValueError(
            f"rows {widest + 1} and {widest + 2} are {np.rad2deg(turn_rad[widest]):.0f} deg "
            "apart: too far to say how it turned between; send rows closer in time"
        )
    spacing_s = _knot_spacing_s(t_s, q_body_from_frame_xyzw, q_dot_s)
    curve = _fit_spline(t_s, q_body_from_frame_xyzw, q_dot_s, spacing_s)
    miss_rad = _distance_rad(curve(t_s), q_body_from_frame_xyzw) if spacing_s else np.zeros(1)
    return RotationCurve(
        quaternion=curve,
        residual_rms_rad=float(np.sqrt(np.mean(miss_rad**2))),
        residual_max_rad=float(np.max(miss_rad)),
        knot_spacing_s=spacing_s,
    )


def _knot_spacing_s(t_s: Array, q: Array, q_dot_s: Array | None) -> float:
    """The widest knot spacing that predicts unseen rows about as well as any; 0 interpolates."""
    starts = np.unique(
        np.linspace(0, max(0, len(t_s) - OPTIONS.sample_rows), OPTIONS.samples).astype(int)
    )
    samples = [slice(start, start + OPTIONS.sample_rows) for start in starts]

    def held_out_rms_rad(spacing_s: float) -> float:
        squares = [
            _held_out_rad(t_s[s], q[s], None if q_dot_s is None else q_dot_s[s], spacing_s)
            for s in samples
        ]
        return float(np.sqrt(np.mean(np.concatenate(squares) ** 2)))

    interpolated_rad = held_out_rms_rad(0.0)
    possible = [s for s in OPTIONS.knot_spacings_s if 4.0 * float(np.median(np.diff(t_s))) <= s]
    if interpolated_rad <= OPTIONS.exact_rad or not possible:
        return 0.0
    errors_rad = [held_out_rms_rad(s) for s in possible]
    best_rad = min(errors_rad)
    if 2.0 * interpolated_rad < best_rad:  # it moves too fast for the knots, and smoothly
        return 0.0
    good_rad = OPTIONS.worth_a_smoother_curve * best_rad
    return next(s for s, e in zip(possible, errors_rad, strict=True) if e <= good_rad)


def _held_out_rad(t_s: Array, q: Array, q_dot_s: Array | None, spacing_s: float) -> Array:
    """Errors at every fifth row, the curve having been fitted to the others."""
    held_out = np.zeros(len(t_s), dtype=bool)
    held_out[OPTIONS.held_out_every // 2 : -1 : OPTIONS.held_out_every] = True
    if not held_out.any():
        return np.zeros(1)
    rates = None if q_dot_s is None else q_dot_s[~held_out]
    curve = _fit_spline(t_s[~held_out], q[~held_out], rates, spacing_s)
    return _distance_rad(curve(t_s[held_out]), q[held_out])


def _fit_spline(t_s: Array, q: Array, q_dot_s: Array | None, spacing_s: float) -> "Curve":
    # SciPy's interpolators take 0.2 s to import, which only a message should pay.
    from scipy.interpolate import make_interp_spline, make_lsq_spline

    if spacing_s:
        return make_lsq_spline(t_s, q, _knots(t_s, spacing_s), k=OPTIONS.degree, method="norm-eq")
    if q_dot_s is not None and len(t_s) >= 4:
        return _through_rates(t_s, q, q_dot_s)
    if len(t_s) == 2:
        from scipy.spatial.transform import Slerp

        turn = Slerp(t_s, Rotation.from_quat(q))
        t_s = np.linspace(t_s[0], t_s[1], 2 * OPTIONS.degree)
        q = turn(t_s).as_quat()
        q = q * np.sign(q @ q[0])[:, None]
    degree = OPTIONS.degree if len(t_s) > OPTIONS.degree else min(3, len(t_s) - 1)
    return make_interp_spline(t_s, q, k=degree)


def _knots(t_s: Array, spacing_s: float) -> Array:
    """Knots on rows about spacing_s apart, none in a gap: at least two rows between any two."""
    _, first = np.unique((t_s - t_s[0]) // spacing_s, return_index=True)
    inner: list[int] = [0]
    for row in first[1:]:
        if row - inner[-1] >= 3 and row < len(t_s) - OPTIONS.degree:
            inner.append(int(row))
    ends = np.repeat(t_s[[0, -1]], OPTIONS.degree + 1)
    return np.concatenate([ends[: OPTIONS.degree + 1], t_s[inner[1:]], ends[OPTIONS.degree + 1 :]])


def _through_rates(t_s: Array, q: Array, q_dot_s: Array) -> "PPoly":
    """Quintic Hermite through values and rates, second derivatives from a spline of the rates."""
    from scipy.interpolate import PPoly, make_interp_spline

    degree = min(3, len(t_s) - 1)
    second = make_interp_spline(t_s, q_dot_s, k=degree).derivative()(t_s)
    h = np.diff(t_s)[:, None]
    powers = quintic_coefficients(
        h, (q[:-1], q_dot_s[:-1], second[:-1]), (q[1:], q_dot_s[1:], second[1:])
    )
    return PPoly(np.stack([c / h**order for order, c in enumerate(powers)][::-1]), t_s)


def _distance_rad(p: Array, q: Array) -> Array:
    """Angles between attitudes that are nearly the same, p of any length, q unit, shape (n,)."""
    unit = p / np.linalg.norm(p, axis=1, keepdims=True)
    return np.asarray(2.0 * np.linalg.norm(unit - q, axis=1))


def odd_by_rad(t_s: Array, q_body_from_frame_xyzw: Array) -> Array:
    """How far each row is, at least, from where a cubic through four others leads, shape (n,).

    t_s: shape (n,), increasing.  q_body_from_frame_xyzw: shape (n, 4), unit, neighbours of like
    sign.
    Zero for the first and last REACH rows.
    """
    odd_rad = np.full(len(t_s), np.inf)
    rows = np.arange(len(t_s))
    for stencil in _STENCILS:
        inside = (rows + min(stencil) >= 0) & (rows + max(stencil) < len(t_s))
        at = rows[inside]
        others = at[:, None] + np.array(stencil)
        weights = lagrange_weights(t_s[others] - t_s[at, None])
        miss = q_body_from_frame_xyzw[at] - np.einsum(
            "nk,nkj->nj", weights, q_body_from_frame_xyzw[others]
        )
        miss_rad = 2.0 * np.linalg.norm(miss, axis=1)
        odd_rad[at] = np.minimum(odd_rad[at], miss_rad)
    odd_rad[:REACH] = odd_rad[len(t_s) - REACH :] = 0.0
    return np.where(np.isfinite(odd_rad), odd_rad, 0.0)
