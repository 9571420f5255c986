"""What a platform's drives must have been, from the angles or rates that they flew."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.arrays import Array, Indices
from planner.commands import CommandTable
from planner.platforms import AxisDrive, TwoAxisPlatform
from planner.simulation.flight import fly

# Fields of a drive that a flight shows, with where a search starts for one that is zero.
IDENTIFIABLE: Mapping[str, float] = {
    "coulomb_deg_s2": 1e-3,
    "breakaway_deg_s2": 1e-3,
    "viscous_per_s": 1e-3,
    "cable_tension_deg_s2": 0.05,
    "cable_stiffness_per_s2": 1e-3,
    "command_latency_s": 0.02,
    "lag_s": 0.005,
    "bandwidth_hz": 0.3,
}
_SIGNED = "cable_tension_deg_s2"
_FRICTION = ("coulomb_deg_s2", "breakaway_deg_s2")
# Sticking and slipping has many local optima: friction is tried from a sixth of the platform's to
# six times, closer than its slips keep step, then closer still around the best.
_COARSE_TRIES = np.linspace(-math.log(6.0), math.log(6.0), 37)
_FINE_TRIES = np.linspace(-0.08, 0.08, 9)
_PRIOR = math.log(10.0)  # 1 sigma, a factor of ten: what a flight doesn't show stays as it was
_CLEAN = {
    "encoder_step_arcsec": 0.0,
    "encoder_noise_arcsec": 0.0,
    "gyro_step_arcsec_s": 0.0,
    "gyro_noise_arcsec_s": 0.0,
    "gyro_bias_arcsec_s": 0.0,
}
_LEAST_SIGMA_ARCSEC = 0.1  # and arcsec/s: what telemetry between two control steps costs
_ROBUST_SIGMAS = 5.0  # above, a residual weighs by its size, not its square
_IMPOSSIBLE_SIGMAS = 1e4
_DIFFERENCE = 1e-3  # of logarithms: a thousand times what the integrator leaves uncertain
_ROUNDS_MAX = 25
# Where an axis sticks, slips that keep no step with the model's leave more than the sensors do, and
# the optimum found lay up to 3 % of friction and nine tenths of the lag from the truth.
_MISFIT_SQUARES = 2.0
_ROUGHNESS, _LAG_ROUGHNESS = 0.03, 1.0  # of logarithms
_STRETCHES = 20  # of a flight, whose misses count as independent
_ARCSEC_RAD = math.radians(1.0 / 3600.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Identified:
    """Parameters of the drives with their uncertainty.

    names: (n,), `axis.field` of `AxisDrive`.  parameters: (n,), in the field's unit.
    covariance_parameters: (n, n), in their products: of what the samples show, counting
    neighbours that err alike once, and held by a prior of a factor of ten.
    drives: the platform's with these parameters.
    residual_rad, residual_rad_s: (2,), root mean square of each axis's angles and rates; NaN
    where none were measured.  bias_rad_s: (2,), of the gyros, taken out before.
    """

    names: tuple[str, ...]
    parameters: Array
    covariance_parameters: Array
    drives: tuple[AxisDrive, AxisDrive]
    residual_rad: Array
    residual_rad_s: Array
    bias_rad_s: Array


def identify(
    table: CommandTable,
    platform: TwoAxisPlatform,
    t_s: Array,
    measured_angle_rad: Array | None,
    measured_rate_rad_s: Array | None,
    names: Sequence[str],
) -> Identified:
    """By least squares between what was measured and what the simulator makes of the table.

    t_s: (k,), ascending seconds since the table's epoch; samples before its first row or after
    its last aren't used.  measured_angle_rad, measured_rate_rad_s: (k, 2), NaN where there is
    none; of the encoders and of rate gyros, whose constant bias is estimated, too.
    names: `axis.field`, fields of `IDENTIFIABLE`; a constant pull of the cables shows only where
    the loop has no integral.  Coulomb friction takes the breakaway along in
    proportion unless that is named, too.  All else is the platform's: what is wrong there goes
    into residuals and parameters.  A latency and an offset of the clock look alike.
    """
    search = _search(table, platform, t_s, measured_angle_rad, measured_rate_rad_s, names)
    moved, covariance = _best_start(search), np.zeros((len(names), len(names)))
    for axis in range(2):  # apart: the axes hardly feel each other
        own = np.flatnonzero(search.of_axis == axis)
        if len(own) > 0:
            moved[own], covariance[np.ix_(own, own)] = _fit(search, moved, own, axis)
    drives, slope = search.drives(moved), search.slope(moved)
    angle_rad, rate_rad_s, bias_rad_s = search.residuals(drives)
    return Identified(
        names=search.names,
        parameters=search.values(moved),
        covariance_parameters=covariance * np.outer(slope, slope),
        drives=_with(platform, platform.drives, search.names, search.values(moved)),
        residual_rad=_root_mean_square(angle_rad),
        residual_rad_s=_root_mean_square(rate_rad_s),
        bias_rad_s=bias_rad_s,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Search:
    """Parameters as the search moves them: the logarithm of a positive one over its start."""

    table: CommandTable
    platform: TwoAxisPlatform
    t_s: Array
    angle_rad: Array
    rate_rad_s: Array
    names: tuple[str, ...]
    start_parameters: Array
    signed: tuple[bool, ...]
    of_axis: Indices
    clean: tuple[AxisDrive, AxisDrive]
    sigma_rad: Array
    sigma_rad_s: Array

    def values(self, moved_parameters: Array) -> Array:
        """In the fields' units."""
        start = self.start_parameters
        scale = np.maximum(np.abs(start), IDENTIFIABLE[_SIGNED])
        return np.where(
            self.signed, start + scale * moved_parameters, start * np.exp(moved_parameters)
        )

    def slope(self, moved_parameters: Array) -> Array:
        """Of each value by what moves it."""
        scale = np.maximum(np.abs(self.start_parameters), IDENTIFIABLE[_SIGNED])
        return np.where(self.signed, scale, self.values(moved_parameters))

    def drives(self, moved_parameters: Array) -> tuple[AxisDrive, AxisDrive]:
        return _with(self.platform, self.clean, self.names, self.values(moved_parameters))

    def residuals(self, drives: tuple[AxisDrive, AxisDrive]) -> tuple[Array, Array, Array]:
        """Measured less flown angles and rates, (k, 2), and the rates' means, taken out, (2,)."""
        from scipy.interpolate import CubicSpline

        flown = fly(self.table, self.platform, drives=drives)
        told = np.concatenate([flown.measured_angle_rad, flown.measured_rate_rad_s], axis=1)
        then = CubicSpline(flown.t_s, told)(self.t_s)
        angle_rad, rate_rad_s = self.angle_rad - then[:, :2], self.rate_rad_s - then[:, 2:]
        has_rate = np.isfinite(rate_rad_s)
        count = np.maximum(np.count_nonzero(has_rate, axis=0), 1)
        bias_rad_s = np.sum(np.where(has_rate, rate_rad_s, 0.0), axis=0) / count
        return angle_rad, rate_rad_s - bias_rad_s, bias_rad_s

    def misses(self, moved_parameters: Array, axis: int) -> Array:
        """Of one axis in sigmas: angles, rates, then how far its parameters are from the start."""
        prior = moved_parameters[self.of_axis == axis] / _PRIOR
        try:
            drives = self.drives(moved_parameters)
        except ValueError:  # its loop would swing up by itself: not the one that was flown
            return np.concatenate([np.full(2 * len(self.t_s), _IMPOSSIBLE_SIGMAS), prior])
        angle_rad, rate_rad_s, _ = self.residuals(drives)
        angle = angle_rad[:, axis] / self.sigma_rad[axis]
        rate = rate_rad_s[:, axis] / self.sigma_rad_s[axis]
        return np.concatenate([np.nan_to_num(angle), np.nan_to_num(rate), prior])


def _search(
    table: CommandTable,
    platform: TwoAxisPlatform,
    t_s: Array,
    measured_angle_rad: Array | None,
    measured_rate_rad_s: Array | None,
    names: Sequence[str],
) -> _Search:
    for name in names:
        _require_identifiable(name, platform)
    if measured_angle_rad is None and measured_rate_rad_s is None:
        raise ValueError("give measured_angle_rad, measured_rate_rad_s or both, not neither")
    inside = (t_s >= 0.0) & (t_s <= table.t_s[-1])
    count = int(np.count_nonzero(inside))
    if count < len(names) + 2:
        raise ValueError(
            f"{count} samples within the table's {table.t_s[-1]:g} s are too few for "
            f"{len(names)} parameters; give more, or name fewer"
        )
    nothing = np.full((count, 2), np.nan)
    of_axis = np.array([platform.axis_names.index(name.split(".")[0]) for name in names], np.intp)
    fields = [name.split(".")[1] for name in names]
    start = [
        getattr(platform.drives[axis], field) for axis, field in zip(of_axis, fields, strict=True)
    ]
    first, second = platform.drives
    return _Search(
        table=table,
        platform=platform,
        t_s=t_s[inside],
        angle_rad=nothing if measured_angle_rad is None else measured_angle_rad[inside],
        rate_rad_s=nothing if measured_rate_rad_s is None else measured_rate_rad_s[inside],
        names=tuple(names),
        start_parameters=np.array(
            [
                value if value != 0.0 or field == _SIGNED else IDENTIFIABLE[field]
                for value, field in zip(start, fields, strict=True)
            ]
        ),
        signed=tuple(field == _SIGNED for field in fields),
        of_axis=of_axis,
        clean=(replace(first, **_CLEAN), replace(second, **_CLEAN)),
        sigma_rad=_sigma(platform, "encoder_step_arcsec", "encoder_noise_arcsec"),
        sigma_rad_s=_sigma(platform, "gyro_step_arcsec_s", "gyro_noise_arcsec_s"),
    )


def _require_identifiable(name: str, platform: TwoAxisPlatform) -> None:
    axis, _, field = name.partition(".")
    if axis not in platform.axis_names or field not in IDENTIFIABLE:
        raise ValueError(
            f"{name!r} can't be identified; name an axis ({', '.join(platform.axis_names)}), a dot "
            f"and one of {', '.join(IDENTIFIABLE)}"
        )


def _sigma(platform: TwoAxisPlatform, step: str, noise: str) -> Array:
    """Of a sensor's reading on either axis, radians (per second), (2,)."""
    return np.array(
        [
            _ARCSEC_RAD
            * math.hypot(
                getattr(drive, step) / math.sqrt(12.0), getattr(drive, noise), _LEAST_SIGMA_ARCSEC
            )
            for drive in platform.drives
        ]
    )


def _with(
    platform: TwoAxisPlatform,
    drives: tuple[AxisDrive, AxisDrive],
    names: Sequence[str],
    parameters: Array,
) -> tuple[AxisDrive, AxisDrive]:
    """The drives with these fields."""
    outer, inner = (
        _changed(
            drive,
            {
                name.split(".")[1]: float(value)
                for name, value in zip(names, parameters, strict=True)
                if name.split(".")[0] == axis
            },
        )
        for axis, drive in zip(platform.axis_names, drives, strict=True)
    )
    return outer, inner


def _changed(drive: AxisDrive, fields: dict[str, float]) -> AxisDrive:
    coulomb, breakaway = _FRICTION
    if coulomb in fields and breakaway not in fields:
        share = drive.breakaway_deg_s2 / drive.coulomb_deg_s2 if drive.coulomb_deg_s2 else 1.0
        fields[breakaway] = share * fields[coulomb]
    if breakaway in fields:  # none breaks away at less than it slides with
        fields[breakaway] = max(fields[breakaway], fields.get(coulomb, drive.coulomb_deg_s2))
    return replace(drive, **fields)


def _fit(search: _Search, start_parameters: Array, own: Indices, axis: int) -> tuple[Array, Array]:
    """One axis's parameters as they fit best from where the search starts, and their covariance."""
    from scipy.optimize import least_squares  # half a second, which most processes never need

    def misses(own_parameters: Array) -> Array:
        moved = start_parameters.copy()
        moved[own] = own_parameters
        return search.misses(moved, axis)

    def jacobian(own_parameters: Array) -> Array:
        here, steps = misses(own_parameters), _DIFFERENCE * np.eye(len(own))
        return np.stack(
            [(misses(own_parameters + step) - here) / _DIFFERENCE for step in steps], axis=1
        )

    found = least_squares(
        misses,
        start_parameters[own],
        jacobian,
        loss="soft_l1",
        f_scale=_ROBUST_SIGMAS,
        xtol=1e-4,
        ftol=1e-4,
        max_nfev=_ROUNDS_MAX,
    )
    rough = np.array([search.names[k].endswith(".lag_s") for k in own])
    roughness = np.where(rough, _LAG_ROUGHNESS, _ROUGHNESS)
    return found.x, _covariance(jacobian(found.x), misses(found.x), roughness)


def _best_start(search: _Search) -> Array:
    """Where the search begins."""
    best = np.zeros(len(search.names))
    is_friction = np.array([name.split(".")[1] in _FRICTION for name in search.names])
    if not np.any(is_friction):
        return best
    for tries in (_COARSE_TRIES, _FINE_TRIES):
        costs = np.array([_robust_costs(search, best + shift * is_friction) for shift in tries])
        best = best + is_friction * tries[np.argmin(costs, axis=0)][search.of_axis]
    return best


def _robust_costs(search: _Search, moved_parameters: Array) -> tuple[float, float]:
    """As least_squares adds them up, of each axis."""
    drives = search.drives(moved_parameters)
    angle_rad, rate_rad_s, _ = search.residuals(drives)
    missed = np.concatenate([angle_rad / search.sigma_rad, rate_rad_s / search.sigma_rad_s])
    size = (np.nan_to_num(missed) / _ROBUST_SIGMAS) ** 2
    outer, inner = np.sum(np.sqrt(1.0 + size) - 1.0, axis=0)
    return float(outer), float(inner)


def _covariance(
    jacobian_parameters: Array, missed_value: Array, roughness_parameters: Array
) -> Array:
    """Of one axis's parameters, by how samples of whole stretches miss together.

    The sandwich of White (1980) over clusters of successive samples: where the model is exact
    and samples are independent it is the inverse of their information.
    """
    n = jacobian_parameters.shape[1]
    weights = 1.0 / np.sqrt(1.0 + (missed_value / _ROBUST_SIGMAS) ** 2)
    inverse = np.linalg.inv(jacobian_parameters.T @ (weights[:, None] * jacobian_parameters))
    pulls = jacobian_parameters[:-n] * (weights * missed_value)[:-n, None]
    samples = len(pulls) // 2
    together = pulls[:samples] + pulls[samples:]  # angles and rates of the same time
    parts = min(_STRETCHES, samples)
    stretches = np.add.reduceat(together, np.arange(parts) * samples // parts, axis=0)
    scatter = stretches.T @ stretches * parts / max(parts - n, 1) + np.eye(n) / _PRIOR**2
    clustered = inverse @ scatter @ inverse
    found = clustered if np.trace(clustered) > np.trace(inverse) else inverse
    present = np.count_nonzero(missed_value[:-n])
    if np.sum(missed_value[:-n] ** 2) > _MISFIT_SQUARES * present:
        found = found + np.diag(roughness_parameters**2)
    return np.asarray(found, dtype=np.float64)


def _root_mean_square(missed_value: Array) -> Array:
    """Of each column, without what isn't there."""
    there = np.isfinite(missed_value)
    count = np.count_nonzero(there, axis=0)
    squares = np.sum(np.where(there, missed_value, 0.0) ** 2, axis=0)
    found: Array = np.where(count > 0, np.sqrt(squares / np.maximum(count, 1)), np.nan)
    return found
