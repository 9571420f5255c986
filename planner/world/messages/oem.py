"""Reads a CCSDS orbit ephemeris message (OEM).

Permissive where real messages stray from the standard (NASA's <ndm> wrapper, empty comments,
no interpolation keywords), strict where a guess could point a camera elsewhere (frames, time
systems, centres, units).  Source: CCSDS 502.0-B-3, section 5; 505.0-B-3 for XML.
"""

import re
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidMessage
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.messages.kvn import Grammar, raw_kvn
from planner.world.messages.segments import (
    EARTH_NAMES,
    RawSegment,
    TimeAxis,
    creation_utc,
    is_xml,
    numbers,
    require_size,
    time_axis,
)
from planner.world.messages.xml import message_element

EARTH_RADIUS_MIN_M = 6.35e6  # below the poles
R_MAX_M = 2.0e9  # beyond, a position in metres was written where km belong
SPIN_MAX_RAD_S = 7.3e-5  # of the Earth: what a velocity in ITRF may have on top

FRAMES = ("EME2000", "GCRF", "ITRF", "TEME")
_FRAME_SYNONYMS = {"J2000": "EME2000", "ICRF": "GCRF", "GCRS": "GCRF"}
_FRAME_FAMILIES = (
    (re.compile(r"ITRF[-_ ]?(\d{2,4}|\d{4}[-_ ]?\d)?"), "ITRF"),
    (re.compile(r"[GI]CRF\d?"), "GCRF"),
)
_GRAMMAR = Grammar(
    message="OEM",
    versions=("1", "2", "3"),
    sections={
        ("header", "META_START"): "metadata",
        ("states", "META_START"): "metadata",
        ("metadata", "META_STOP"): "states",
        ("states", "COVARIANCE_START"): "covariance",
        ("covariance", "COVARIANCE_STOP"): "states",
    },
    unread_sections=("covariance",),
    row_columns=(7, 10),
    row_layout="a state has an epoch and 6 numbers, or 9 with accelerations",
)
_UNITS = dict.fromkeys(("X", "Y", "Z"), "km") | dict.fromkeys(("X_DOT", "Y_DOT", "Z_DOT"), "km/s")


@dataclass(frozen=True, eq=False, kw_only=True)
class OemSegment(TimeAxis):
    """One metadata block and its states; no burn or other break is assumed inside or between.

    frame: one of FRAMES.  r_m, v_m_s: shape (n, 3), in `frame`'s axes, relative to the Earth's
    centre (and to the rotating Earth for ITRF).
    """

    object_name: str
    frame: str
    r_m: Array
    v_m_s: Array


@dataclass(frozen=True, eq=False)
class Oem:
    """segments: at least one, in the message's order.  creation_utc: None if not stated."""

    creation_utc: datetime | None
    segments: tuple[OemSegment, ...]


def read_oem(content: str) -> Oem:
    """Read an OEM, versions 1 to 3, in KVN or XML.

    Accelerations and covariances are passed over.  Raises InvalidMessage naming the line.
    """
    require_size("OEM", content)
    if is_xml(content):
        message = message_element(content, "OEM", _GRAMMAR.versions)
        raw = message.segments("stateVector", lambda _: tuple(_UNITS), _UNITS)
        creation = message.creation
    else:
        creation, raw = raw_kvn(content, _GRAMMAR)
    if not raw:
        raise InvalidMessage("the OEM has no segment with states; is it cut off?")
    return Oem(creation_utc=creation_utc(creation), segments=tuple(map(_segment_of, raw)))


def standard_frame(stated: str) -> str:
    """Our name of a reference frame: "J2000" is EME2000, every realisation of ITRF is ITRF."""
    frame = _FRAME_SYNONYMS.get(stated.upper(), stated.upper())
    for pattern, family in _FRAME_FAMILIES:
        if pattern.fullmatch(frame):
            frame = family
    return frame


def _segment_of(raw: RawSegment) -> OemSegment:
    frame = _read_frame(raw)
    axis = time_axis(raw)
    states = numbers(raw, 6) * 1e3
    radius_m = np.linalg.norm(states[:, :3], axis=1)
    odd = np.flatnonzero((radius_m < EARTH_RADIUS_MIN_M) | (radius_m > R_MAX_M))
    if len(odd):
        row = int(odd[0])
        raw.refuse(
            f"a position {radius_m[row] / 1e3:.3f} km from the Earth's centre is no satellite's; "
            "positions must be in km",
            raw.lines[row],
        )
    speed_m_s = np.linalg.norm(states[:, 3:], axis=1)
    fast = np.flatnonzero(
        speed_m_s > np.sqrt(2.0 * MU_EARTH_M3_S2 / radius_m) + SPIN_MAX_RAD_S * radius_m
    )
    if len(fast):
        row = int(fast[0])
        raw.refuse(
            f"a satellite {radius_m[row] / 1e3:.0f} km from the Earth's centre leaves it at "
            f"{speed_m_s[row] / 1e3:.6g} km/s; velocities must be in km/s",
            raw.lines[row],
        )
    return OemSegment(
        **vars(axis),
        object_name=raw.metadata.get("OBJECT_NAME", ""),
        frame=frame,
        r_m=states[:, :3],
        v_m_s=states[:, 3:],
    )


def _read_frame(raw: RawSegment) -> str:
    """The frame: of a kind we can convert, about the Earth."""
    stated = raw.require("REF_FRAME")
    center = raw.metadata.get("CENTER_NAME", "EARTH")
    if center.upper() not in EARTH_NAMES:
        raw.refuse(f"CENTER_NAME is {center!r}; only orbits about EARTH are supported")
    frame = standard_frame(stated)
    if frame not in FRAMES:
        raw.refuse(f"REF_FRAME {stated!r} is not supported; convert to one of {FRAMES}")
    if frame == "TEME" and "REF_FRAME_EPOCH" in raw.metadata:
        raw.refuse("TEME of a fixed epoch is not supported; convert to EME2000")
    return frame
