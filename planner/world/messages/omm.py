"""Reads a CCSDS orbit mean-elements message (OMM).

Reads KVN, XML and the JSON of general-perturbation catalogues (one object, or a list of one).
Source: CCSDS 502.0-B-3, section 4; CelesTrak's GP data formats for JSON.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, NoReturn

from planner.base.errors import InvalidMessage
from planner.world.messages.keywords import MAX_CHARACTERS, Entry, Keywords, read_keywords
from planner.world.messages.segments import require_size

THEORIES = ("SGP4", "SGP/SGP4")
# As catalogues use it, not as CCSDS 502.0-B-3 numbers it: 0 and 2 are elements for SGP4; 4, of
# SGP4-XP, are kilometres off in it.
EPHEMERIS_TYPES = ("0", "2")
MEAN_MOTION_REV_DAY = (0.1, 18.0)
ANGLE_DEG = (-360.0, 360.0)
BSTAR_1_ER = (-1.0, 1.0)  # the ISS had -0.11 after a reboost
INCLINATION_DEG = (0.0, 180.0)


@dataclass(frozen=True, kw_only=True)
class Omm:
    """Mean elements of SGP4's theory, in TEME, units as in the message.

    bstar: in inverse Earth radii.
    """

    object_name: str
    epoch_utc: datetime
    mean_motion_rev_day: float
    eccentricity: float
    inclination_deg: float
    ra_of_asc_node_deg: float
    arg_of_pericenter_deg: float
    mean_anomaly_deg: float
    bstar: float


def read_omm(content: str | Mapping[str, Any] | Sequence[Mapping[str, Any]]) -> Omm:
    """The message as text, or what its JSON holds.

    Raises InvalidMessage naming the line and the keyword.
    """
    if not isinstance(content, str):
        omm = _from_parsed(content)
    elif content.lstrip("\ufeff \t\r\n").startswith(("[", "{")):
        omm = _from_json(content)
    else:
        omm = read_keywords(content, "OMM", ("1", "2", "3"))
    omm.require_earth()
    _require_default(omm, "MEAN_ELEMENT_THEORY", THEORIES)
    _require_default(omm, "REF_FRAME", ("TEME",))
    _require_default(omm, "TIME_SYSTEM", ("UTC",))
    _require_default(omm, "EPHEMERIS_TYPE", EPHEMERIS_TYPES)
    epoch = omm.require("EPOCH")
    return Omm(
        object_name=omm.text("OBJECT_NAME", ""),
        epoch_utc=omm.epoch_utc(epoch, "UTC"),
        mean_motion_rev_day=omm.number(
            "MEAN_MOTION", "rev/day", "rev/d", "revs/day", limits=MEAN_MOTION_REV_DAY
        ),
        eccentricity=omm.number("ECCENTRICITY", limits=(0.0, 0.999)),
        inclination_deg=omm.number("INCLINATION", "deg", limits=INCLINATION_DEG),
        ra_of_asc_node_deg=omm.number("RA_OF_ASC_NODE", "deg", limits=ANGLE_DEG),
        arg_of_pericenter_deg=omm.number("ARG_OF_PERICENTER", "deg", limits=ANGLE_DEG),
        mean_anomaly_deg=omm.number("MEAN_ANOMALY", "deg", limits=ANGLE_DEG),
        bstar=omm.number("BSTAR", "1/er", limits=BSTAR_1_ER),
    )


def _require_default(omm: Keywords, key: str, accepted: tuple[str, ...]) -> None:
    """Catalogues leave these out; where stated, another value needs another propagator."""
    stated = omm.text(key, accepted[0]).upper()
    if stated not in accepted:
        omm.refuse(f"{key} {stated!r} is not supported; only {accepted[0]} is")


def _from_json(content: str) -> Keywords:
    require_size("OMM", content, MAX_CHARACTERS, "one satellite")
    try:
        parsed = json.loads(content.lstrip("\ufeff"), parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise InvalidMessage(f"OMM line {error.lineno}: the JSON is broken: {error.msg}") from None
    except (ValueError, RecursionError):
        raise InvalidMessage("the OMM's JSON holds a value no orbit has") from None
    return _from_parsed(parsed)


def _from_parsed(parsed: object) -> Keywords:
    objects = parsed if isinstance(parsed, list | tuple) else [parsed]
    if len(objects) != 1 or not isinstance(objects[0], Mapping):
        raise InvalidMessage(f"the OMM's JSON holds {len(objects)} entries; send one satellite")
    for key, value in objects[0].items():
        if isinstance(value, str) and not value.isprintable():
            raise InvalidMessage(f"the OMM's {key!r} holds a character that can't be seen")
    entries = [
        Entry(key, str(value), "", 1)
        for key, value in objects[0].items()
        if isinstance(value, str | int | float) and not isinstance(value, bool)
    ]
    return Keywords("OMM", tuple(entries))


def _no_constant(text: str) -> NoReturn:
    raise ValueError(text)
