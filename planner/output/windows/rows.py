"""Windows as rows of JSON, made column by column: degrees, UTC text, plain numbers."""

import json
from collections.abc import Hashable, Mapping, Sequence
from datetime import datetime
from typing import Any, Protocol

import numpy as np
import pydantic_core

from planner.base.arrays import Array, Indices
from planner.output.windows.members import SightingOut
from planner.planning.opportunities import Sightings, WindowEdges, Windows
from planner.planning.opportunities.windows import TargetSky
from planner.world.frames.time_scales import Instants
from planner.world.platforms import RollRule
from planner.world.targets import GroundPathTarget

EVENTS = ("rise", "culmination", "set")
SIGHTING = tuple(SightingOut.__dataclass_fields__)
# Told by the name of each angle, of shape (..., 2), rad or rad/s.
BY_NAME = {"angles_deg": "angle_rad", "rates_deg_s": "rate_rad_s"}
_USABLE: Sequence[tuple[int, ...]] = ((), (0,), (1,), (0, 1))
# Of each row an object by names, a number, numbers, or its JSON text.
Column = Mapping[str, Any] | Array | list[str]


class AnglesTold(Protocol):
    """The angles that windows tell."""

    @property
    def angle_names(self) -> tuple[str, str]: ...
    @property
    def has_branches(self) -> bool: ...


def window_columns(
    start_utc: datetime,
    ids: Sequence[str],
    told: AnglesTold,
    windows: WindowEdges,
    probability: Array | None = None,
) -> dict[str, Column]:
    """All that is told of windows as far as it is known, by name; probability: of each session."""
    columns = _edge_columns(start_utc, ids, windows)
    if isinstance(windows, Windows):
        columns |= _view_columns(start_utc, told.angle_names, windows)
        if told.has_branches:
            usable = [_USABLE[number] for number in (windows.branches @ [1, 2]).tolist()]
            columns |= {"branch": texts_of(windows.branch.tolist()), "branches": texts_of(usable)}
        if not np.isnan(windows.clear_share).all():
            columns["clear_probability"] = windows.clear_share
    return columns if probability is None else columns | {"probability_in_frame": probability}


def scan_column(
    start_utc: datetime,
    windows: WindowEdges,
    scanned: Mapping[int, tuple[GroundPathTarget, RollRule | None]],
) -> Column:
    """What is scanned in windows of scans; scanned: the line and how it is lain on, by row."""
    rows = np.array([*scanned], np.intp)
    begins_s, part, parts = windows.begins_s(start_utc)[rows], *windows.scan_parameters[rows, :2].T
    fits = np.flatnonzero(begins_s[:, 1] >= begins_s[:, 0])
    ends = [spread(fits, len(rows), times_of(start_utc, begins_s[fits, n])) for n in (0, 1)]
    columns: dict[str, Column] = {
        "part": texts_of(part.astype(np.intp).tolist()),
        "parts": texts_of(parts.astype(np.intp).tolist()),
        "first_start": ends[0],
        "last_start": ends[1],
        "target": [_json_text(path.with_heights()) for path, _ in scanned.values()],
        "roll": [_json_text(roll) for _, roll in scanned.values()],
    }
    return spread(rows, len(windows), columns)


def _json_text(spec: object) -> str:
    return json.dumps(_given(json.loads(pydantic_core.to_json(spec))), separators=(",", ":"))


def _given(value: Any) -> Any:  # noqa: ANN401 (of JSON)
    """The same without members that are null."""
    if isinstance(value, dict):
        return {name: _given(one) for name, one in value.items() if one is not None}
    return [_given(one) for one in value] if isinstance(value, list) else value


def _edge_columns(
    start_utc: datetime, ids: Sequence[str], windows: WindowEdges
) -> dict[str, Column]:
    session_s = windows.sessions_s(start_utc)
    fits = np.flatnonzero(~np.isnan(session_s[:, 0]))
    times = {
        name: times_of(start_utc, session_s[fits, n]) for n, name in enumerate(("start", "stop"))
    }
    return {
        "target": texts_of([ids[row] for row in windows.target]),
        "rise": times_of(start_utc, windows.rise_s),
        "set": times_of(start_utc, windows.set_s),
        "duration_s": windows.set_s - windows.rise_s,
        "session": spread(fits, len(windows), times),
        "opened_by": texts_of(windows.opened_by.tolist()),
        "closed_by": texts_of(windows.closed_by.tolist()),
    }


def _view_columns(
    start_utc: datetime, angle_names: tuple[str, str], windows: Windows
) -> dict[str, Column]:
    on_earth = np.flatnonzero(~np.isnan(windows.sky.azimuth_rad[:, 0]))
    count = len(windows)
    return {
        "highest_at": times_of(start_utc, windows.highest_s),
        "highest_deg": np.degrees(windows.highest_rad),
        "closest": _sighting(start_utc, angle_names, windows.closest),
        "through": _sighting(start_utc, angle_names, windows.through),
        "place": spread(on_earth, count, _places(windows.sky, on_earth)),
        "sky": spread(
            on_earth,
            count,
            {
                event: {"at": times_of(start_utc, sky.pop("t_s")), **sky}
                for event, sky in _sky(windows.sky, on_earth).items()
            },
        ),
    }


def _sighting(start_utc: datetime, angle_names: tuple[str, str], seen: Sightings) -> Column:
    columns: dict[str, Column] = {
        "at": times_of(start_utc, seen.t_s),
        "range_km": seen.range_m / 1e3,
        "ground_sample_across_m": seen.ground_sample_across_m,
        "ground_sample_along_m": seen.ground_sample_along_m,
    }
    for one, told in BY_NAME.items():
        motion_rad = getattr(seen, told)
        columns[one] = {
            name: np.degrees(motion_rad[..., angle]) for angle, name in enumerate(angle_names)
        }
    for one in SIGHTING:
        if one not in columns:
            columns[one] = np.degrees(getattr(seen, one.replace("_deg", "_rad")))
    return {one: columns[one] for one in SIGHTING}


def rows_json(columns: Column) -> list[str]:
    """The JSON of each row; numbers are rounded, null where there is none."""
    if isinstance(columns, list):
        return columns
    if isinstance(columns, Mapping):
        template = "{" + ",".join(f"{json.dumps(name)}:%s" for name in columns) + "}"
        return [template % row for row in zip(*map(rows_json, columns.values()), strict=True)]
    return joined(texts_of(_rounded(columns).ravel().tolist()), columns.shape)


def _rounded(numbers: Array) -> Array:
    """To what can be read: 1e-6 deg is 4 milliarcsec, 1e-6 km a millimetre."""
    return np.asarray(np.round(numbers, 6) + 0.0)  # no -0.0


def joined(texts: list[str], shape: tuple[int, ...]) -> list[str]:
    """The texts of numbers of a shape (rows,) or (rows, n): an array a row of those."""
    if len(shape) == 1:
        return texts
    n = shape[1]
    return [f"[{','.join(texts[k : k + n])}]" for k in range(0, len(texts), n)]


def spread(rows: Indices, count: int, columns: Column) -> list[str]:
    """So many rows' JSON: those of the columns, null between them."""
    texts = ["null"] * count
    for row, text in zip(rows.tolist(), rows_json(columns), strict=True):
        texts[row] = text
    return texts


def times_of(start_utc: datetime, t_s: Array, decimals: int = 3) -> list[str]:
    """As JSON texts; of shape (rows, n) an array each."""
    texts = [f'"{text}"' for text in Instants(start_utc, t_s.ravel()).utc_text(decimals)]
    return joined(texts, t_s.shape)


def texts_of(values: Sequence[Hashable]) -> list[str]:
    """The JSON of each; beside numbers, what comes again is made once."""
    if values and isinstance(values[0], float):
        numbers = pydantic_core.to_json(values, inf_nan_mode="null")
        return numbers[1:-1].decode().split(",")
    known = {one: pydantic_core.to_json(one).decode() for one in set(values)}
    return [known[one] for one in values]


def _sky(sky: TargetSky, rows: Indices) -> dict[str, dict[str, Any]]:
    """By event, of windows on the Earth, `t_s` for the time."""
    return {
        event: {
            "t_s": sky.t_s[rows, n],
            "azimuth_deg": _turns_deg(sky.azimuth_rad[rows, n]),
            "elevation_deg": np.degrees(sky.elevation_rad[rows, n]),
            "sun_azimuth_deg": _turns_deg(sky.sun_azimuth_rad[rows, n]),
            "sun_elevation_deg": np.degrees(sky.sun_elevation_rad[rows, n]),
            "local_solar_time": _clocks(sky.solar_time_s[rows, n]),
        }
        for n, event in enumerate(EVENTS)
    }


def _places(sky: TargetSky, rows: Indices) -> dict[str, Array]:
    """Of windows on the Earth."""
    return {
        "latitude_deg": np.degrees(sky.latitude_rad[rows, 1]),
        "longitude_deg": np.degrees(sky.longitude_rad[rows, 1]),
        "height_m": np.round(sky.height_m[rows, 1], 3),
    }


def _turns_deg(angle_rad: Array) -> Array:
    """In 0..360, the latter excluded."""
    return _rounded(np.degrees(angle_rad)) % 360.0


def _clocks(since_midnight_s: Array) -> list[str]:
    """As JSON texts, to the second, which is 15 arcsec of the Sun."""
    shown = np.datetime_as_string(np.rint(since_midnight_s).astype("M8[s]"))
    return [f'"{text[11:]}"' for text in shown.tolist()]
