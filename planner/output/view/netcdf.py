"""A view as NetCDF: the columns of its JSON, classic format, CF conventions."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from dataclasses import fields
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from planner.base.arrays import Array
from planner.base.header_text import one_line
from planner.output.export.netcdf import (
    FILL,
    NO_SESSION,
    axis_identifiers,
    describe,
    write_global_attributes,
    write_times,
)
from planner.output.view.columns import AxisMotion, PlanView, SkyDirection
from planner.output.view.platforms.parts import OUTLINE_POINTS
from planner.world.frames.iers import RAD_PER_ARCSEC
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.plan import KINDS
from planner.world.resources import resource_told

if TYPE_CHECKING:
    from scipy.io import netcdf_file

# By the end of one of our names: what is written instead, the factor to it, its unit.
_UNITS = (
    ("_rad_s3", "_deg_s3", np.degrees(1.0), "degree s-3"),
    ("_rad_s2", "_deg_s2", np.degrees(1.0), "degree s-2"),
    ("_rad_s", "_deg_s", np.degrees(1.0), "degree s-1"),
    ("latitude_rad", "latitude_deg", np.degrees(1.0), "degrees_north"),
    ("longitude_rad", "longitude_deg", np.degrees(1.0), "degrees_east"),
    ("error_rad", "error_arcsec", 1.0 / RAD_PER_ARCSEC, "arcsec"),
    ("major_rad", "major_arcsec", 1.0 / RAD_PER_ARCSEC, "arcsec"),
    ("minor_rad", "minor_arcsec", 1.0 / RAD_PER_ARCSEC, "arcsec"),
    ("_rad", "_deg", np.degrees(1.0), "degree"),
    ("_m", "_m", 1.0, "m"),
    ("_s", "_s", 1.0, "s"),
    ("_share", "_share", 1.0, "1"),
    ("_counts", "_counts", 1.0, "1"),
)
_MOTION = (
    ("angle_rad", "_rad"),
    ("rate_rad_s", "_rate_rad_s"),
    ("acceleration_rad_s2", "_acceleration_rad_s2"),
    ("jerk_rad_s3", "_jerk_rad_s3"),
)


def write_view_netcdf(view: PlanView, created_utc: datetime) -> bytes:
    """Variables are named as the JSON nests them: `carrier_latitude_deg`.

    Targets, cones and masks are a dimension each; the slews of the baseline, the windows and the
    outlines of masks lie end to end along one of their own.  What is null in JSON is filled.
    """
    buffer = io.BytesIO()
    from scipy.io import netcdf_file

    with netcdf_file(buffer, "w", version=2) as file:
        write_global_attributes(file, view.plan, created_utc)
        sizes = {
            "time": len(view.t_s),
            "corner": 4,
            "target": len(view.targets),
            "cone": len(view.keep_out),
            "mask": len(view.masks),
            "mask_point": sum(len(mask.outline_platform) for mask in view.masks),
            "exclusion": len(view.exclusions),
            "component": 3,
            "outline_time": len(view.keep_out[0].outline_t_s) if view.keep_out else 0,
            "way": 2,
            "point": OUTLINE_POINTS,
            "axis": len(view.axes),
            "baseline_time": sum(len(slew.t_s) for slew in view.baseline),
            "window": sum(len(found.windows) for found in view.windows if found),
        }
        for name, size in sizes.items():
            if size:  # none is classic NetCDF's unlimited one
                file.createDimension(name, size)
        write_times(file, Instants(view.plan.table.epoch_utc, view.t_s))
        _activity(file, view)
        names = axis_identifiers(view.plan.table.dof_names)
        _motion(file, names, view.axes, "", "time")
        for section in ("carrier", "boresight", "footprint", "sun", "moon", "pointing"):
            for name, values in _arrays(getattr(view, section)):
                _write(file, f"{section}_{name}", values, ("time", "corner")[: values.ndim])
        _targets(file, view)
        _cones(file, view)
        _masks(file, view)
        _exclusions(file, view)
        _resources(file, view)
        _sky(file, view)
        _baseline(file, view, names)
        _windows(file, view)
        file.flush()
        return buffer.getvalue()


def _activity(file: netcdf_file, view: PlanView) -> None:
    activity = file.createVariable("activity", "b", ("time",))
    activity[:] = np.array([KINDS.index(kind) for kind in view.activity], dtype="i1")
    describe(
        activity,
        long_name="what the platform does from the row on",
        flag_values=np.arange(len(KINDS), dtype="i1"),
        flag_meanings=" ".join(KINDS),
    )
    number = file.createVariable("session", "i", ("time",))
    number[:] = [NO_SESSION if one is None else one for one in view.session]
    describe(number, long_name=f"index of the session, {NO_SESSION}: to the final state")


def _motion(
    file: netcdf_file,
    names: tuple[str, ...],
    axes: Mapping[str, AxisMotion],
    before: str,
    side: str,
) -> None:
    for name, motion in zip(names, axes.values(), strict=True):
        for ours, written in _MOTION:
            _write(file, f"{before}{name}{written}", getattr(motion, ours), (side,))


def _targets(file: netcdf_file, view: PlanView) -> None:
    if not view.targets:
        return
    names = ", ".join(one_line(target.name) for target in view.targets)
    describe(file, target_names=names, target_modes=", ".join(t.mode for t in view.targets))
    for columns in zip(*(list(_arrays(target)) for target in view.targets), strict=True):
        name = columns[0][0]
        if name == "in_session":
            continue
        rows = np.stack([values for _, values in columns])
        _write(file, f"target_{name}", rows, ("target", "time"))


def _cones(file: netcdf_file, view: PlanView) -> None:
    if not view.keep_out:
        return
    cones, sides = view.keep_out, ("cone", "time")
    describe(file, cone_names=", ".join(one_line(cone.about) for cone in cones))
    half_rad = np.array([cone.half_angle_rad for cone in cones])
    _write(file, "keep_out_half_angle_rad", half_rad, sides[:1])
    away = np.stack([cone.separation_rad for cone in cones])
    _write(file, "keep_out_separation_rad", away, sides)
    counts = np.array([cone.counts for cone in cones], dtype=float)  # NaN of None
    _write(file, "keep_out_counts", counts, sides)
    _write(file, "outline_t_s", cones[0].outline_t_s, ("outline_time",))
    outlines_rad = np.stack([_last_axis(cone.outline_rad) for cone in cones])
    _write(
        file,
        "keep_out_outline_rad",
        outlines_rad,
        ("cone", "outline_time", "way", "point", "axis"),
    )


def _masks(file: netcdf_file, view: PlanView) -> None:
    if not view.masks:
        return
    masks = view.masks
    describe(file, mask_names=", ".join(one_line(mask.name) for mask in masks))
    _write(file, "mask_asked_rad", np.array([mask.asked_rad for mask in masks]), ("mask",))
    _write(file, "mask_away_rad", np.stack([mask.away_rad for mask in masks]), ("mask", "time"))
    number = file.createVariable("mask_outline_mask", "i", ("mask_point",))
    number[:] = np.concatenate([np.full(len(mask.outline_platform), mask.number) for mask in masks])
    describe(number, long_name="index of the mask whose outline it is")
    corners = file.createVariable("mask_outline_platform", "d", ("mask_point", "component"))
    corners[:] = np.concatenate([mask.outline_platform for mask in masks])
    describe(corners, units="1", long_name="mask outline, unit vectors in the platform frame")
    outline_rad = np.concatenate([_last_axis(mask.outline_rad) for mask in masks], axis=1)
    _write(file, "mask_outline_rad", outline_rad, ("way", "mask_point", "axis"))


def _exclusions(file: netcdf_file, view: PlanView) -> None:
    if not view.exclusions:
        return
    names = ", ".join(one_line(one.name) for one in view.exclusions)
    describe(file, exclusion_names=names)
    margins = np.stack([one.margin_rad for one in view.exclusions])
    _write(file, "exclusion_margin_rad", margins, ("exclusion", "time"))


def _resources(file: netcdf_file, view: PlanView) -> None:
    for one in view.resources:
        unit = {"Wh": "watt hour", "Gbit": "1e9 bit"}.get(one.unit, one.unit)
        name = f"{one.name}_{one.unit.lower().replace(' ', '_')}"
        variable = file.createVariable(name, "d", ("time",))
        variable[:] = one.level
        words = f"{resource_told(one.name)} of {one.capacity:g} at most; its limit is {one.limit:g}"
        describe(variable, units=unit, long_name=words)


def _sky(file: netcdf_file, view: PlanView) -> None:
    if view.sky is None:
        return
    for name, found in vars(view.sky).items():
        if isinstance(found, SkyDirection):
            for column, values in _arrays(found):
                _write(file, f"sky_{name}_{column}", values, ("time",))
        elif found:
            for columns in zip(*(list(_arrays(one)) for one in found), strict=True):
                rows = np.stack([values for _, values in columns])
                side = {"targets": "target", "keep_out": "cone"}[name]
                _write(file, f"sky_{name}_{columns[0][0]}", rows, (side, "time"))


def _baseline(file: netcdf_file, view: PlanView, names: tuple[str, ...]) -> None:
    if not view.baseline:
        return
    side = "baseline_time"
    _write(file, "baseline_t_s", np.concatenate([slew.t_s for slew in view.baseline]), (side,))
    session = file.createVariable("baseline_session", "i", (side,))
    session[:] = np.concatenate(
        [
            np.full(len(slew.t_s), NO_SESSION if slew.session is None else slew.session)
            for slew in view.baseline
        ]
    )
    describe(session, long_name=f"session slewed to, {NO_SESSION}: the final state")
    whole = {
        axis: AxisMotion(
            **{
                field.name: np.concatenate(
                    [getattr(slew.axes[axis], field.name) for slew in view.baseline]
                )
                for field in fields(AxisMotion)
            }
        )
        for axis in view.axes
    }
    _motion(file, names, whole, "baseline_", side)


def _windows(file: netcdf_file, view: PlanView) -> None:
    found = [(number, one) for number, one in enumerate(view.windows) if one and len(one.windows)]
    if not found:
        return
    epoch_utc = view.plan.table.epoch_utc
    session = file.createVariable("window_session", "i", ("window",))
    session[:] = np.concatenate([np.full(len(one.windows), number) for number, one in found])
    describe(session, long_name="session whose target can be seen")
    for name in ("rise_s", "highest_s", "set_s"):
        times = [
            getattr(one.windows, name) + elapsed_s(one.start_utc, epoch_utc) for _, one in found
        ]
        _write(file, f"window_{name}", np.concatenate(times), ("window",))
    highest = np.concatenate([one.windows.highest_rad for _, one in found])
    _write(file, "window_highest_rad", highest, ("window",))


def _arrays(section: object) -> Iterator[tuple[str, Array]]:
    for name, values in vars(section).items():
        if isinstance(values, np.ndarray):
            yield name, values


def _last_axis(value_by_axis: Mapping[str, Array]) -> Array:
    return np.stack([*value_by_axis.values()], axis=-1)


def _write(file: netcdf_file, name: str, value_by_row: Array, sides: tuple[str, ...]) -> None:
    ours, written, factor, unit = next(one for one in _UNITS if name.endswith(one[0]))
    variable = file.createVariable(name.removesuffix(ours) + written, "d", sides)
    variable[:] = np.where(np.isnan(value_by_row), FILL, value_by_row * factor)
    words = name.removesuffix(ours) + ours.split("_rad")[0]
    describe(variable, _FillValue=FILL, units=unit, long_name=words.replace("_", " "))
