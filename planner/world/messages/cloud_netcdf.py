"""Cloud fraction over time as a forecast's NetCDF file has it, by the CF conventions."""

import io
import math
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidMessage
from planner.world.messages.geographic_grid import GeographicGrid, require_cells

_SECONDS = {"second": 1.0, "minute": 60.0, "hour": 3600.0, "day": 86400.0}
_SINCE = re.compile(
    r"(second|minute|hour|day)s? since (\S+?)[T ]?(\d\d?:\d\d(?::\d\d)?)?(?:\.0*)?Z?$"
)
_AXES = {"latitude": r"degrees?_?n(orth)?", "longitude": r"degrees?_?e(ast)?"}


@dataclass(frozen=True, kw_only=True)
class AxisOptions:
    """How even the steps of an axis must be."""

    uneven_share: float = 1e-3  # of a step: degrees are often kept in 32 bits


OPTIONS = AxisOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class GridsOverTime:
    """A grid for each time, in order; one grid and no time where it is the same always.

    unit: as the file says it, "1" or "%"; None where it doesn't.
    """

    times_utc: tuple[datetime, ...]
    grids: tuple[GeographicGrid, ...]
    unit: str | None = None


def read_cloud_netcdf(content: bytes, name: str | None) -> GridsOverTime:
    """The variable of that name, or the only one of latitude and longitude; raises InvalidMessage.

    Source: NetCDF classic and 64-bit offset formats, by SciPy; CF Conventions 1.11, chapters 4, 5.
    """
    if content[:4] == b"\x89HDF":
        raise InvalidMessage(
            "content is NetCDF-4: write it in the classic format, e.g. `nccopy -k classic`"
        )
    # A tenth of a second to load, which only a forecast should pay.
    from scipy.io import netcdf_file

    try:
        with warnings.catch_warnings(action="ignore"):  # of damage, which is refused by what lacks
            file = netcdf_file(io.BytesIO(content), mmap=False, maskandscale=True)
            return _grids(file.variables, name)
    except InvalidMessage:
        raise
    except Exception as error:  # noqa: BLE001 (SciPy's, of damaged files)
        raise InvalidMessage(f"content is no NetCDF that can be read ({str(error)[:60]})") from None


def _grids(variables: Mapping[str, Any], name: str | None) -> GridsOverTime:
    found = variables.get(name) if name is not None else None
    fields = [key for key, one in variables.items() if len(one.dimensions) in (2, 3)]
    if name is None and len(fields) == 1:
        found = variables[fields[0]]
    if found is None or len(found.dimensions) not in (2, 3):
        raise InvalidMessage(
            f"variable must name the cloud fraction, of time, latitude and longitude: the file has "
            f"{', '.join(fields) or 'none such'}"
        )
    *when, north, east = found.dimensions
    latitude_deg = _degrees(variables, north, "latitude")
    longitude_deg = _degrees(variables, east, "longitude")
    times_utc = _times(variables, when[0]) if when else ()
    require_cells(len(latitude_deg) * max(len(times_utc), 1), len(longitude_deg))
    values = np.ma.filled(np.ma.asarray(found[:], dtype=np.float64), math.nan)
    values = values.reshape(-1, len(latitude_deg), len(longitude_deg))
    if latitude_deg[0] < latitude_deg[-1]:
        latitude_deg, values = latitude_deg[::-1], values[:, ::-1]
    unit = getattr(found, "units", b"").decode().strip()
    return GridsOverTime(
        times_utc=times_utc,
        grids=tuple(
            GeographicGrid(
                values=one.astype(np.float32),
                north_deg=float(latitude_deg[0]),
                west_deg=float(longitude_deg[0]),
                step_deg=(_step(latitude_deg[::-1], north), _step(longitude_deg, east)),
            )
            for one in values
        ),
        unit="%" if unit in ("%", "percent") else "1" if unit else None,
    )


def _degrees(variables: Mapping[str, Any], name: str, axis: str) -> Array:
    """Of the centres of cells, as the variable of a dimension has them."""
    one = variables.get(name)
    unit = b"" if one is None else getattr(one, "units", b"")
    if one is None or not re.fullmatch(_AXES[axis], unit.decode().strip().lower()):
        raise InvalidMessage(
            f"the last dimensions of the cloud fraction must be latitude and longitude in degrees, "
            f"and {name[:40]} is no {axis}; order them so, e.g. by `ncpdq`"
        )
    return np.asarray(one[:], dtype=np.float64)


def _step(ascending_deg: Array, name: str) -> float:
    steps = np.diff(ascending_deg)
    step_deg = float(steps.mean()) if len(steps) else 1.0
    if not step_deg > 0.0 or np.any(np.abs(steps - step_deg) > OPTIONS.uneven_share * step_deg):
        raise InvalidMessage(
            f"{name[:40]} must go by even steps: regrid the file, e.g. with `cdo remapbil`"
        )
    return step_deg


def _times(variables: Mapping[str, Any], name: str) -> tuple[datetime, ...]:
    one = variables.get(name)
    unit = b"" if one is None else getattr(one, "units", b"")
    calendar = b"standard" if one is None else getattr(one, "calendar", b"standard")
    match = _SINCE.match(unit.decode().strip().lower())
    if one is None or match is None or calendar.decode() not in _CALENDARS:
        raise InvalidMessage(
            f"{name[:40]} must be a time of the standard calendar such as "
            f"'hours since 2026-06-01 00:00:00', in UTC, not {unit.decode()[:40]!r}"
        )
    since_utc = datetime.fromisoformat(f"{match[2]}T{match[3] or '00:00'}").replace(tzinfo=UTC)
    passed_s = np.asarray(one[:], dtype=np.float64) * _SECONDS[match[1]]
    if np.any(np.diff(passed_s) <= 0.0):
        raise InvalidMessage(f"the times of {name[:40]} must go forward, each once")
    return tuple(since_utc + timedelta(seconds=each) for each in passed_s.tolist())


_CALENDARS: Sequence[str] = ("standard", "gregorian", "proleptic_gregorian")
