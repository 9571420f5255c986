"""Reads a CCSDS attitude ephemeris message (AEM).

Reads versions 1 and 2, KVN and XML: quaternions and Euler angles, of the spacecraft's body
against an inertial, Earth-fixed or local orbital frame.  Spin axes are refused.
Source: CCSDS 504.0-B-1 and 504.0-B-2, sections 4 and 5; 505.0-B-3 for XML.
"""

import re
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidMessage
from planner.base.rotation import Rotation, like_signs
from planner.world.messages.kvn import Grammar, raw_kvn
from planner.world.messages.oem import standard_frame
from planner.world.messages.segments import (
    EARTH_NAMES,
    RawSegment,
    TimeAxis,
    is_xml,
    numbers,
    require_size,
    time_axis,
)
from planner.world.messages.xml import message_element

FRAMES = ("EME2000", "GCRF", "ITRF", "LVLH", "RTN")
NORM_TOLERANCE = 1e-3  # three printed decimals
RATE_MISMATCH_MAX = 0.2  # of the turn between two rows; a wrong frame or sign gives 1 or more

_ORBITAL = {"LVLH": "LVLH", "RTN": "RTN", "RSW": "RTN", "RIC": "RTN", "QSW": "RTN"}
_BODY = re.compile(r"(SC|SPACECRAFT)[_ ]?BODY([_ ].*)?")
_AXES = {"1": "X", "2": "Y", "3": "Z"}
_QUATERNION = ("Q1", "Q2", "Q3", "QC")
_DERIVATIVE = ("Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT")
_ANGVEL = ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z")
_ANGLES = ("ANGLE_1", "ANGLE_2", "ANGLE_3")
# What is read of each type, and how many numbers a row holds in all.  Euler rates, which
# version 1 leaves open to two readings, are passed over: the angles say it all.
_TYPES: dict[str, tuple[tuple[str, ...], int]] = {
    "QUATERNION": (_QUATERNION, 4),
    "QUATERNION/DERIVATIVE": (_QUATERNION + _DERIVATIVE, 8),
    "QUATERNION/RATE": (_QUATERNION, 7),
    "QUATERNION/ANGVEL": (_QUATERNION + _ANGVEL, 7),
    "EULER_ANGLE": (_ANGLES, 3),
    "EULER_ANGLE/RATE": (_ANGLES, 6),
    "EULER_ANGLE/DERIVATIVE": (_ANGLES, 6),
    "EULER_ANGLE/ANGVEL": (_ANGLES, 6),
}
_GRAMMAR = Grammar(
    message="AEM",
    versions=("1", "2"),
    sections={
        ("header", "META_START"): "metadata",
        ("metadata", "META_STOP"): "gap before the data",
        ("gap before the data", "DATA_START"): "states",
        ("states", "DATA_STOP"): "header",
    },
    unread_sections=(),
    row_columns=(4, 5, 7, 8, 9),
    row_layout="a row has an epoch and the 3 to 8 numbers of its ATTITUDE_TYPE",
)


@dataclass(frozen=True, eq=False, kw_only=True)
class AemSegment(TimeAxis):
    """One metadata block and its attitudes; nothing is assumed about what lies between blocks.

    frame: one of FRAMES, what the attitude is against.  q_body_from_frame_xyzw: shape (n, 4),
    unit, scalar last, neighbours of like sign; SciPy's `Rotation.from_quat(q).apply(v_frame)`
    gives `v_body`.
    q_dot_s: its derivative, same shape, or None where the message gives none.
    linear: whether the message asks for linear interpolation.
    """

    frame: str
    q_body_from_frame_xyzw: Array
    q_dot_s: Array | None
    linear: bool


def read_aem(content: str) -> tuple[AemSegment, ...]:
    """Segments, at least one, in the message's order.  Raises InvalidMessage naming the line."""
    require_size("AEM", content)
    raw = _raw_xml(content) if is_xml(content) else raw_kvn(content, _GRAMMAR)[1]
    if not raw:
        raise InvalidMessage("the AEM has no segment with attitudes; is it cut off?")
    return tuple(map(_segment_of, raw))


def _segment_of(raw: RawSegment) -> AemSegment:
    frame, body_is_b = _read_frames(raw)
    columns, width = _read_type(raw)
    for row, line in zip(raw.rows, raw.lines, strict=True):
        if len(row) not in (len(columns), width):
            raw.refuse(f"a row of type {raw.metadata['ATTITUDE_TYPE']} has {width} numbers", line)
    axis = time_axis(raw)
    rows = numbers(raw, len(columns))
    q_xyzw, q_dot_s = _read_quaternions(raw, columns, rows)
    # The message's quaternion turns axes, SciPy's turns vectors: A to B is the conjugate.
    if body_is_b == (_read_choice(raw, "ATTITUDE_DIR", "A2B", "B2A") == "A2B"):
        q_xyzw, q_dot_s = _q_conjugate(q_xyzw), None if q_dot_s is None else _q_conjugate(q_dot_s)
    sign = like_signs(q_xyzw)[:, None]
    q_xyzw = q_xyzw * sign
    if q_dot_s is not None:
        q_dot_s = q_dot_s * sign
        _check_rates(raw, axis.t_s, q_xyzw, q_dot_s)
    method = raw.metadata.get("INTERPOLATION_METHOD", "").upper()
    return AemSegment(
        **vars(axis),
        frame=frame,
        q_body_from_frame_xyzw=q_xyzw,
        q_dot_s=q_dot_s,
        linear=method in ("LINEAR", "SLERP") or raw.metadata.get("INTERPOLATION_DEGREE") == "1",
    )


def _read_frames(raw: RawSegment) -> tuple[str, bool]:
    """The frame the attitude is against, and whether the body is REF_FRAME_B."""
    stated = [raw.require(key).upper() for key in ("REF_FRAME_A", "REF_FRAME_B")]
    is_body = [_BODY.fullmatch(name) is not None for name in stated]
    if sum(is_body) != 1:
        raw.refuse(
            f"REF_FRAME_A {stated[0]!r} and REF_FRAME_B {stated[1]!r}: exactly one must be the "
            "spacecraft's body, SC_BODY_..."
        )
    outer = stated[is_body[0]]
    frame = _ORBITAL.get(outer.removesuffix("_ROTATING"), standard_frame(outer))
    if frame not in FRAMES:
        raw.refuse(f"the reference frame {outer!r} is not supported; convert to one of {FRAMES}")
    center = raw.metadata.get("CENTER_NAME", "EARTH").upper()
    if frame in _ORBITAL and center not in EARTH_NAMES:
        raw.refuse(f"CENTER_NAME is {center!r}; a local orbital frame must be about EARTH")
    return frame, is_body[1]


def _read_choice(raw: RawSegment, key: str, default: str, other: str) -> str:
    """The value of a keyword that version 2 dropped for its default."""
    stated = raw.metadata.get(key, default).upper()
    if stated not in (default, other):
        first, second = sorted((default, other))
        raw.refuse(f"{key} must be {first} or {second}, not {stated!r}")
    return stated


def _read_type(raw: RawSegment) -> tuple[tuple[str, ...], int]:
    stated = raw.require("ATTITUDE_TYPE").upper().replace(" ", "_")
    if stated.startswith("SPIN"):
        raw.refuse(
            f"ATTITUDE_TYPE {stated} describes a spinning satellite by its axis, from which no "
            "camera is pointed; convert to QUATERNION"
        )
    if stated not in _TYPES:
        raw.refuse(f"ATTITUDE_TYPE {stated!r} is not known; use one of {', '.join(_TYPES)}")
    return _TYPES[stated]


def _read_quaternions(
    raw: RawSegment, columns: tuple[str, ...], rows: Array
) -> tuple[Array, Array | None]:
    """The message's own quaternions and derivatives, scalar last, each (n, 4)."""
    if columns == _ANGLES:
        return Rotation.from_euler(_read_sequence(raw), rows, degrees=True).as_quat(), None
    scalar_first = _read_choice(raw, "QUATERNION_TYPE", "LAST", "FIRST") == "FIRST"
    q_xyzw = np.roll(rows[:, :4], -1, axis=1) if scalar_first else rows[:, :4]
    norm = np.linalg.norm(q_xyzw, axis=1, keepdims=True)
    wrong = np.flatnonzero(np.abs(norm[:, 0] - 1.0) > NORM_TOLERANCE)
    if len(wrong):
        row = int(wrong[0])
        raw.refuse(f"the quaternion's length is {norm[row, 0]:.6g}, not 1", raw.lines[row])
    q_xyzw = q_xyzw / norm
    if columns[4:] == _DERIVATIVE:
        return q_xyzw, np.roll(rows[:, 4:], -1, axis=1) if scalar_first else rows[:, 4:]
    if columns[4:] == _ANGVEL:
        return q_xyzw, _q_derivative(q_xyzw, np.deg2rad(rows[:, 4:]), _angvel_in_b(raw))
    return q_xyzw, None


def _read_sequence(raw: RawSegment) -> str:
    """Axes in the order they are turned about, each after the turns before."""
    stated = raw.require("EULER_ROT_SEQ").upper()
    sequence = "".join(_AXES.get(axis, axis) for axis in stated)
    if not re.fullmatch(r"[XYZ]{3}", sequence) or sequence[1] in (sequence[0], sequence[2]):
        raw.refuse(f"EULER_ROT_SEQ {stated!r} is no sequence of three axes such as 321 or ZXZ")
    return sequence


def _angvel_in_b(raw: RawSegment) -> bool:
    stated = raw.require("ANGVEL_FRAME").upper()
    in_a, in_b = (
        stated in (key, raw.metadata[key].upper()) for key in ("REF_FRAME_A", "REF_FRAME_B")
    )
    if not in_a and not in_b:
        raw.refuse(f"ANGVEL_FRAME {stated!r} is neither REF_FRAME_A nor REF_FRAME_B")
    return in_b


def _q_derivative(q_a_from_b_xyzw: Array, omega_rad_s: Array, in_b: bool) -> Array:
    """q' = q o omega_b / 2 = omega_a o q / 2 for the quaternion that turns A's axes into B's."""
    vector, scalar = q_a_from_b_xyzw[:, :3], q_a_from_b_xyzw[:, 3:]
    cross = np.cross(vector, omega_rad_s) if in_b else np.cross(omega_rad_s, vector)
    dot = np.sum(vector * omega_rad_s, axis=1, keepdims=True)
    return 0.5 * np.hstack([scalar * omega_rad_s + cross, -dot])


def _check_rates(
    raw: RawSegment, t_s: Array, q_body_from_frame_xyzw: Array, q_dot_s: Array
) -> None:
    """Rates must lead from one row to the next, or their frame or sign is not what we think."""
    step_s = np.diff(t_s)[:, None]
    turn = np.diff(q_body_from_frame_xyzw, axis=0)
    expected = 0.5 * (q_dot_s[1:] + q_dot_s[:-1]) * step_s
    miss = float(np.median(np.linalg.norm(turn - expected, axis=1)))
    size = float(np.median(np.linalg.norm(turn, axis=1)))
    if miss > RATE_MISMATCH_MAX * size + 1e-6:
        percent = 100.0 * miss / max(size, 1e-12)
        raw.refuse(
            f"the stated rates miss the next row's attitude by {percent:.0f} % of the turn; "
            "check their frame, sign and unit, or leave them out"
        )


def _q_conjugate(q: Array) -> Array:
    return np.asarray(q * np.array([-1.0, -1.0, -1.0, 1.0]))


def _raw_xml(content: str) -> list[RawSegment]:
    """The segments, their numbers in the order of `_TYPES`."""
    message = message_element(content, "AEM", _GRAMMAR.versions)
    units = dict.fromkeys(_ANGLES, "deg")
    segments = message.segments("attitudeState", lambda raw: _read_type(raw)[0], units)
    for raw in segments:
        raw.metadata["QUATERNION_TYPE"] = "LAST"  # elements are named, so we choose the order
    return segments
