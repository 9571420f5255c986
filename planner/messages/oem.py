"""What does a CCSDS orbit ephemeris message (OEM) say?

Permissive where real messages stray from the standard (NASA's <ndm> wrapper, empty comments,
no interpolation keywords), strict where a guess could point a camera elsewhere (frames, time
systems, centres, units).  Source: CCSDS 502.0-B-3, section 5; 505.0-B-3 for XML.
"""

import re
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from planner.errors import InvalidMessage
from planner.frames.time_scales import utc_from_tai_us
from planner.messages.epochs import TIME_SYSTEMS, EpochReader
from planner.messages.oem_kvn import raw_kvn
from planner.messages.oem_raw import RawSegment, refuse
from planner.messages.oem_xml import raw_xml

MAX_CHARACTERS = 32_000_000  # five times NASA's 15-day file with a node every minute
EARTH_RADIUS_MIN_M = 6.35e6  # below the poles
R_MAX_M = 2.0e9  # beyond, a position in metres was written where km belong

FRAMES = ("EME2000", "GCRF", "ITRF", "TEME")
_FRAME_SYNONYMS = {"J2000": "EME2000", "ICRF": "GCRF", "GCRS": "GCRF"}
_FRAME_FAMILIES = (
    (re.compile(r"ITRF[-_ ]?(\d{2,4}|\d{4}[-_ ]?\d)?"), "ITRF"),
    (re.compile(r"[GI]CRF\d?"), "GCRF"),
)


@dataclass(frozen=True, eq=False)
class OemSegment:
    """One metadata block and its states; no burn or other break is assumed inside or between.

    frame: one of FRAMES.  epoch_utc: the whole microsecond at or before the first node.
    t_s: shape (n,), strictly increasing SI seconds since it.  r_m, v_m_s: shape (n, 3), in
    `frame`'s axes, relative to the Earth's centre (and to the rotating Earth for ITRF).
    useable_s: first and last instant that may be interpolated, same clock.
    """

    object_name: str
    frame: str
    epoch_utc: datetime
    t_s: NDArray[np.float64]
    r_m: NDArray[np.float64]
    v_m_s: NDArray[np.float64]
    useable_s: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Oem:
    """segments: at least one, in the message's order.  creation_utc: None if not stated."""

    creation_utc: datetime | None
    segments: tuple[OemSegment, ...]


def read_oem(content: str) -> Oem:
    """Read an OEM, versions 1 to 3, in KVN or XML.

    Accelerations and covariances are passed over.  Raises InvalidMessage naming the line.
    """
    if len(content) > MAX_CHARACTERS:
        raise InvalidMessage(
            f"the OEM has {len(content)} characters, more than the {MAX_CHARACTERS} accepted; "
            "send only the days around the session",
        )
    is_xml = content.lstrip("\ufeff \t\r\n").startswith("<")
    creation, raw = raw_xml(content) if is_xml else raw_kvn(content)
    if not raw:
        raise InvalidMessage("the OEM has no segment with states; is it cut off?")
    return Oem(creation_utc=_creation(creation), segments=tuple(map(_segment, raw)))


def _creation(text: str | None) -> datetime | None:
    if text is None:
        return None
    try:
        return utc_from_tai_us(EpochReader("UTC").tai_ns(text) // 1000)
    except ValueError:
        return None  # only the age of the prediction is lost


def _segment(raw: RawSegment) -> OemSegment:
    frame, time_system = _conventions(raw)
    if len(raw.rows) < 2:
        refuse(raw.line, f"the segment has {len(raw.rows)} states; at least 2 are needed")
    reader = EpochReader(time_system)
    tai_ns = np.array([_epoch(reader, *pair) for pair in zip(raw.lines, raw.epochs, strict=True)])
    states = _states(raw)
    backward = np.flatnonzero(np.diff(tai_ns) <= 0)
    if len(backward):
        row = int(backward[0]) + 1
        refuse(raw.lines[row], f"epoch {raw.epochs[row]} is not after the one before")
    radius_m = np.linalg.norm(states[:, :3], axis=1)
    odd = np.flatnonzero((radius_m < EARTH_RADIUS_MIN_M) | (radius_m > R_MAX_M))
    if len(odd):
        row = int(odd[0])
        refuse(
            raw.lines[row],
            f"a position {radius_m[row] / 1e3:.3f} km from the Earth's centre is no satellite's; "
            "positions must be in km",
        )
    anchor_us = int(tai_ns[0]) // 1000
    t_s = (tai_ns - anchor_us * 1000) / 1e9
    first_s, last_s = float(t_s[0]), float(t_s[-1])
    useable_s = []
    for key, default_s in (("USEABLE_START_TIME", first_s), ("USEABLE_STOP_TIME", last_s)):
        text = raw.metadata.get(key)
        if text is None:
            useable_s.append(default_s)
        else:
            stated_s = (_epoch(reader, raw.line, text) - anchor_us * 1000) / 1e9
            useable_s.append(min(max(stated_s, first_s), last_s))
    return OemSegment(
        object_name=raw.metadata.get("OBJECT_NAME", ""),
        frame=frame,
        epoch_utc=utc_from_tai_us(anchor_us),
        t_s=t_s,
        r_m=states[:, :3],
        v_m_s=states[:, 3:],
        useable_s=(useable_s[0], useable_s[1]),
    )


def _conventions(raw: RawSegment) -> tuple[str, str]:
    """Frame and time system, both of kinds we can convert."""
    for key in ("REF_FRAME", "TIME_SYSTEM"):
        if key not in raw.metadata:
            refuse(raw.line, f"the segment's metadata lack {key}")
    center = raw.metadata.get("CENTER_NAME", "EARTH")
    if center.upper() not in ("EARTH", "399", "EARTH CENTER"):
        refuse(raw.line, f"CENTER_NAME is {center!r}; only orbits about EARTH are supported")
    stated = raw.metadata["REF_FRAME"].upper()
    frame = _FRAME_SYNONYMS.get(stated, stated)
    for pattern, family in _FRAME_FAMILIES:
        if pattern.fullmatch(frame):
            frame = family
    if frame not in FRAMES:
        refuse(raw.line, f"REF_FRAME {stated!r} is not supported; convert to one of {FRAMES}")
    if frame == "TEME" and "REF_FRAME_EPOCH" in raw.metadata:
        refuse(raw.line, "TEME of a fixed epoch is not supported; convert to EME2000")
    time_system = raw.metadata["TIME_SYSTEM"].upper()
    if time_system not in TIME_SYSTEMS:
        refuse(raw.line, f"TIME_SYSTEM {time_system!r} is not supported; use one of {TIME_SYSTEMS}")
    return frame, time_system


def _epoch(reader: EpochReader, line: int, text: str) -> int:
    try:
        return reader.tai_ns(text)
    except ValueError as error:
        refuse(line, str(error))


def _states(raw: RawSegment) -> NDArray[np.float64]:
    """Position (m) and velocity (m/s), shape (n, 6)."""
    states = np.array([_numbers(row) for row in raw.rows])
    wrong = np.flatnonzero(~np.isfinite(states).all(axis=1))
    if len(wrong):
        first = int(wrong[0])
        refuse(raw.lines[first], f"{' '.join(raw.rows[first])!r} are no six finite numbers")
    return states * 1e3


def _numbers(row: list[str]) -> list[float]:
    try:
        return [float(text) for text in row]
    except ValueError:
        return [np.nan] * 6
