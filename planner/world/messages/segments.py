"""Segments of CCSDS ephemeris messages (OEM, AEM), in either notation."""

from dataclasses import dataclass
from datetime import datetime
from typing import NoReturn

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidMessage
from planner.world.frames.time_scales import utc_from_tai_us
from planner.world.messages.epochs import TIME_SYSTEMS, tai_ns

_STATED_S = 1.0  # START_TIME and STOP_TIME are often given in whole seconds
MAX_CHARACTERS = 32_000_000  # five times NASA's 15-day file with a node every minute
EARTH_NAMES = ("EARTH", "399", "EARTH CENTER")


@dataclass
class RawSegment:
    """Texts of one segment as they stand in the message; `lines` numbers the rows.

    message: "OEM" or "AEM".  line: where the segment begins.
    """

    message: str
    line: int
    metadata: dict[str, str]
    epochs: list[str]
    rows: list[list[str]]
    lines: list[int]

    def refuse(self, what: str, line: int | None = None) -> NoReturn:
        """Say what is wrong with the segment, and in which line (its first by default)."""
        refuse(self.message, line or self.line, what)

    def require(self, key: str) -> str:
        """A metadata value there is no going on without."""
        if key not in self.metadata:
            self.refuse(f"the segment's metadata lack {key}")
        return self.metadata[key]


@dataclass(frozen=True, eq=False, kw_only=True)
class TimeAxis:
    """When the n rows of a segment are.

    epoch_utc: the whole microsecond at or before the first row.

    t_s: shape (n,), strictly increasing SI seconds since it.  useable_s: first and last
    instant that may be interpolated, same clock.
    """

    epoch_utc: datetime
    t_s: Array
    useable_s: tuple[float, float]


def refuse(message: str, line: int, what: str) -> NoReturn:
    """Say what is wrong with the message, and in which line."""
    raise InvalidMessage(f"{message} line {line}: {what}")


def require_version(
    message: str, stated: str, version: str, versions: tuple[str, ...], line: int
) -> None:
    """Refuse a version that isn't read; stated: it, as the refusal names it."""
    if version.split(".")[0] not in versions:
        what = f"{stated} is not supported; versions {versions[0]} to {versions[-1]} are"
        refuse(message, line, what)


def require_size(
    message: str,
    content: str,
    characters_max: int = MAX_CHARACTERS,
    send: str = "only the days around the session",
) -> None:
    """Refuse a text no reader should be kept busy with, saying what to send instead."""
    if len(content) > characters_max:
        raise InvalidMessage(
            f"the {message} has {len(content)} characters, more than the {characters_max} "
            f"accepted; send {send}"
        )


def is_xml(content: str) -> bool:
    """Whether the text is XML rather than keyword = value."""
    return content.lstrip("\ufeff \t\r\n").startswith("<")


def creation_utc(text: str | None) -> datetime | None:
    """CREATION_DATE, or None where it is absent or unreadable: only the age is lost."""
    if text is None:
        return None
    try:
        return utc_from_tai_us(tai_ns(text, "UTC") // 1000)
    except ValueError:
        return None


def time_axis(raw: RawSegment) -> TimeAxis:
    """Epochs of the rows; refused when out of order, or too few to interpolate."""
    time_system = raw.require("TIME_SYSTEM").upper()
    if time_system not in TIME_SYSTEMS:
        raw.refuse(f"TIME_SYSTEM {time_system!r} is not supported; use one of {TIME_SYSTEMS}")
    if len(raw.rows) < 2:
        raw.refuse(f"the segment has {len(raw.rows)} states; at least 2 are needed")
    row_ns = np.array([_tai_ns(raw, *row) for row in zip(raw.lines, raw.epochs, strict=True)])
    backward = np.flatnonzero(np.diff(row_ns) <= 0)
    if len(backward):
        row = int(backward[0]) + 1
        raw.refuse(f"epoch {raw.epochs[row]} is not after the one before", raw.lines[row])
    anchor_us = int(row_ns[0]) // 1000
    t_s = (row_ns - anchor_us * 1000) / 1e9
    first_s, last_s = float(t_s[0]), float(t_s[-1])

    def stated_s(key: str, default_s: float) -> float:
        text = raw.metadata.get(key)
        if text is None:
            return default_s
        return (_tai_ns(raw, raw.line, text) - anchor_us * 1000) / 1e9

    start_s, stop_s = stated_s("START_TIME", first_s), stated_s("STOP_TIME", last_s)
    if first_s < start_s - _STATED_S or last_s > stop_s + _STATED_S:
        raw.refuse(
            f"the rows from {raw.epochs[0]} to {raw.epochs[-1]} go beyond the stated START_TIME "
            f"{raw.metadata.get('START_TIME', '')} and STOP_TIME "
            f"{raw.metadata.get('STOP_TIME', '')}; one of them is wrong"
        )
    useable_s = stated_s("USEABLE_START_TIME", first_s), stated_s("USEABLE_STOP_TIME", last_s)
    if useable_s[0] > useable_s[1] or useable_s[0] > last_s or useable_s[1] < first_s:
        raw.refuse("no row lies between USEABLE_START_TIME and USEABLE_STOP_TIME")
    return TimeAxis(
        epoch_utc=utc_from_tai_us(anchor_us),
        t_s=t_s,
        useable_s=(max(useable_s[0], first_s), min(useable_s[1], last_s)),
    )


def _tai_ns(raw: RawSegment, line: int, text: str) -> int:
    """The instant of an epoch in the segment's time system."""
    try:
        return tai_ns(text, raw.metadata["TIME_SYSTEM"].upper())
    except ValueError as error:
        raw.refuse(str(error), line)


def numbers(raw: RawSegment, columns: int) -> Array:
    """The first `columns` numbers of every row, shape (n, columns), all finite."""
    table = np.array([_row_floats(row[:columns]) for row in raw.rows])
    wrong = np.flatnonzero(~np.isfinite(table).all(axis=1))
    if len(wrong):
        first = int(wrong[0])
        shown = " ".join(raw.rows[first])[:80]
        raw.refuse(f"{shown!r} are no {columns} finite numbers", raw.lines[first])
    return table


def plain(text: str) -> str:
    """The text of a number, but for what only Python takes for one."""
    return "" if "_" in text or not text.isascii() else text


def _row_floats(row: list[str]) -> list[float]:
    try:
        return [float(plain(text)) for text in row]
    except ValueError:
        return [np.nan] * len(row)
