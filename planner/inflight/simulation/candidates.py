"""Drives that may have flown, and by how much telemetry misses what each makes of its table."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import CommandTable
from planner.inflight.simulation.flight import fly
from planner.world.platforms import AxisDrive, TwoAxisPlatform

# Fields of a drive that a flight shows, with where a search starts for one that is zero.
IDENTIFIABLE: Mapping[str, float] = {
    "coulomb_deg_s2": 1e-3,
    "breakaway_deg_s2": 1e-3,
    "viscous_per_s": 1e-2,
    "cable_tension_deg_s2": 0.05,
    "cable_stiffness_per_s2": 1e-3,
    "command_latency_s": 0.02,
    "lag_s": 0.005,
    "bandwidth_hz": 0.3,
}
_SIGNED = "cable_tension_deg_s2"
FRICTION = ("coulomb_deg_s2", "breakaway_deg_s2")
_PRIOR = math.log(10.0)  # 1 sigma, a factor of ten: what a flight doesn't show stays as it was
# How an axis lets go times its slips, and nobody knows it well: where friction is sought these move
# along, 1 sigma of their logarithms (of viscous friction, of what moves it). The loop's damping
# and lag stand for delays that its law has otherwise.
_EXCESS = "breakaway_excess"  # of breakaway over Coulomb, as a share
_PRESLIDING_PARAMETERS: Mapping[str, float] = {
    _EXCESS: 0.3,
    "stribeck_arcmin_s": 0.7,
    "presliding_arcsec": 1.0,
    "presliding_damping": 1.0,
    "damping": 0.3,
    "lag_s": 1.0,
    "viscous_per_s": 2.3,
}
_CLEAN = {
    "encoder_step_arcsec": 0.0,
    "encoder_noise_arcsec": 0.0,
    "gyro_step_arcsec_s": 0.0,
    "gyro_noise_arcsec_s": 0.0,
    "gyro_bias_arcsec_s": 0.0,
}
IMPOSSIBLE_SIGMAS = 1e4


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidates:
    """Parameters as a search moves them: the logarithm of a positive one over its start.

    names: (n,), first those asked for, then how axes let go.  start_parameters: (n,), in the
    fields' units.  scale_parameters: (n,), above 0 where a parameter is moved by so much at a
    time instead, as its start is 0 or it may be negative.  of_axis: (n,).  prior_parameters: (n,),
    1 sigma of what moves them.
    angle_rad, rate_rad_s: (k, 2), NaN where there is none.
    """

    table: CommandTable
    platform: TwoAxisPlatform
    t_s: Array
    angle_rad: Array
    rate_rad_s: Array
    names: tuple[str, ...]
    start_parameters: Array
    scale_parameters: Array
    of_axis: Indices
    prior_parameters: Array
    clean: tuple[AxisDrive, AxisDrive]

    def is_one_of(self, *fields: str) -> Mask:
        """Of each parameter, (n,)."""
        return np.array([name.split(".")[1] in fields for name in self.names])

    def values(self, moved_parameters: Array) -> Array:
        """Values in the fields' units."""
        start = self.start_parameters
        return np.where(
            self.scale_parameters > 0.0,
            start + self.scale_parameters * moved_parameters,
            start * np.exp(moved_parameters),
        )

    def slope(self, moved_parameters: Array) -> Array:
        """The slope of each value by what moves it."""
        scale = self.scale_parameters
        return np.where(scale > 0.0, scale, self.values(moved_parameters))

    @property
    def least_parameters(self) -> Array:
        """What moves them is never less, (n,)."""
        bounded = (self.scale_parameters > 0.0) & ~self.is_one_of(_SIGNED)
        found: Array = np.where(bounded, 0.0, -np.inf)
        return found

    def drives(self, moved_parameters: Array) -> tuple[AxisDrive, AxisDrive]:
        """Whose sensors tell the truth.  Raises ValueError for those that no platform can have."""
        return with_parameters(self.platform, self.clean, self.names, self.values(moved_parameters))

    def residuals(self, drives: tuple[AxisDrive, AxisDrive]) -> tuple[Array, Array, Array]:
        """Measured less flown angles and rates, (k, 2), and the rates' means, taken out, (2,)."""
        from scipy.interpolate import CubicSpline

        flown = fly(self.table, self.platform, drives=drives)
        rows = np.concatenate([flown.measured_angle_rad, flown.measured_rate_rad_s], axis=1)
        then = CubicSpline(flown.t_s, rows)(self.t_s)
        angle_rad, rate_rad_s = self.angle_rad - then[:, :2], self.rate_rad_s - then[:, 2:]
        has_rate = np.isfinite(rate_rad_s)
        count = np.maximum(np.count_nonzero(has_rate, axis=0), 1)
        bias_rad_s = np.sum(np.where(has_rate, rate_rad_s, 0.0), axis=0) / count
        return angle_rad, rate_rad_s - bias_rad_s, bias_rad_s

    def misses(self, moved_parameters: Array, sigma: Array) -> Array:
        """Misses in sigmas, (2 k, 2): angles, then rates, of both axes; 0 where there is none.

        sigma: (2, 2), of angles and of rates (rad, rad/s), of each axis.
        """
        try:
            drives = self.drives(moved_parameters)
        except ValueError:  # its loop would swing up by itself: not the one that was flown
            return np.full((2 * len(self.t_s), 2), IMPOSSIBLE_SIGMAS)
        angle_rad, rate_rad_s, _ = self.residuals(drives)
        found: Array = np.nan_to_num(np.concatenate([angle_rad / sigma[0], rate_rad_s / sigma[1]]))
        return found


def candidates(
    table: CommandTable,
    platform: TwoAxisPlatform,
    t_s: Array,
    measured_angle_rad: Array | None,
    measured_rate_rad_s: Array | None,
    names: Sequence[str],
) -> Candidates:
    """Candidates as `identify` takes them.  Raises ValueError for what can't be identified."""
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
    starts = _start_values(platform, names) | _letting_go(platform, names)
    first, second = platform.drives
    return Candidates(
        table=table,
        platform=platform,
        t_s=t_s[inside],
        angle_rad=nothing if measured_angle_rad is None else measured_angle_rad[inside],
        rate_rad_s=nothing if measured_rate_rad_s is None else measured_rate_rad_s[inside],
        names=tuple(starts),
        start_parameters=np.array(list(starts.values())),
        scale_parameters=np.array([_scale(name, start) for name, start in starts.items()]),
        of_axis=np.array(
            [platform.axis_names.index(name.split(".")[0]) for name in starts], np.intp
        ),
        prior_parameters=np.array(
            [
                _PRIOR if name in names else _PRESLIDING_PARAMETERS[name.split(".")[1]]
                for name in starts
            ]
        ),
        clean=(replace(first, **_CLEAN), replace(second, **_CLEAN)),
    )


def _require_identifiable(name: str, platform: TwoAxisPlatform) -> None:
    axis, _, field = name.partition(".")
    if axis not in platform.axis_names or field not in IDENTIFIABLE:
        raise ValueError(
            f"{name!r} can't be identified; name an axis ({', '.join(platform.axis_names)}), a dot "
            f"and one of {', '.join(IDENTIFIABLE)}"
        )


def _start_values(platform: TwoAxisPlatform, names: Sequence[str]) -> dict[str, float]:
    """Starts of the parameters asked for; friction is sought in steps of its logarithm."""
    starts = {}
    for name in names:
        axis, _, field = name.partition(".")
        value = getattr(platform.drives[platform.axis_names.index(axis)], field)
        starts[name] = IDENTIFIABLE[field] if value == 0.0 and field in FRICTION else value
    return starts


def _scale(name: str, start_value: float) -> float:
    """The unit by which a parameter is moved; 0 where its logarithm is."""
    field = name.split(".")[1]
    if field == _SIGNED:
        return max(abs(start_value), IDENTIFIABLE[field])
    return IDENTIFIABLE[field] if start_value == 0.0 else 0.0


def _letting_go(platform: TwoAxisPlatform, names: Sequence[str]) -> dict[str, float]:
    """Of what moves along on axes whose friction is sought."""
    starts = {}
    for axis, drive in zip(platform.axis_names, platform.drives, strict=True):
        if not any(f"{axis}.{field}" in names for field in FRICTION):
            continue
        for field in _PRESLIDING_PARAMETERS:
            value = _breakaway_excess(drive) if field == _EXCESS else getattr(drive, field)
            known = FRICTION[1] if field == _EXCESS else field
            if (value > 0.0 or field == "viscous_per_s") and f"{axis}.{known}" not in names:
                starts[f"{axis}.{field}"] = value
    return starts


def _breakaway_excess(drive: AxisDrive) -> float:
    return drive.breakaway_deg_s2 / drive.coulomb_deg_s2 - 1.0 if drive.coulomb_deg_s2 else 0.0


def with_parameters(
    platform: TwoAxisPlatform,
    drives: tuple[AxisDrive, AxisDrive],
    names: Sequence[str],
    parameters: Array,
) -> tuple[AxisDrive, AxisDrive]:
    """The drives with these fields; Coulomb friction takes an unnamed breakaway along."""
    outer, inner = (
        _changed_drive(
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


def _changed_drive(drive: AxisDrive, fields: dict[str, float]) -> AxisDrive:
    coulomb, breakaway = FRICTION
    excess = fields.pop(_EXCESS, _breakaway_excess(drive))
    if coulomb in fields and breakaway not in fields:
        fields[breakaway] = (1.0 + excess) * fields[coulomb]
    if breakaway in fields:  # none breaks away at less than it slides with
        fields[breakaway] = max(fields[breakaway], fields.get(coulomb, drive.coulomb_deg_s2))
    return replace(drive, **fields)
