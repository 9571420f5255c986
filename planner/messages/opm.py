"""Reads a CCSDS orbit parameter message (OPM).

Source: CCSDS 502.0-B-3, section 3.
"""

from dataclasses import dataclass
from datetime import datetime

from planner.messages.keywords import read_keywords
from planner.messages.oem import standard_frame

FRAMES = ("ITRF", "EME2000", "GCRF")


@dataclass(frozen=True, kw_only=True)
class Opm:
    """One state vector, units as in the message; an ITRF velocity is Earth-relative.

    mass_kg, drag_area_m2, drag_coefficient: None if not stated.  ignitions_utc: of the
    manoeuvres it announces.
    """

    object_name: str
    frame: str
    epoch_utc: datetime
    position_km: tuple[float, float, float]
    velocity_km_s: tuple[float, float, float]
    mass_kg: float | None
    drag_area_m2: float | None
    drag_coefficient: float | None
    ignitions_utc: tuple[datetime, ...]


def read_opm(content: str) -> Opm:
    """Raises InvalidMessage naming the line and the keyword.

    Osculating elements and covariance are passed over: the state vector is mandatory.
    """
    found = read_keywords(content, "OPM", ("1", "2", "3"))
    found.require_earth()
    stated = found.text("REF_FRAME")
    frame = standard_frame(stated)
    if frame not in FRAMES:
        found.refuse(f"REF_FRAME {stated!r} is not supported; convert to one of {FRAMES}")
    time_system = found.text("TIME_SYSTEM").upper()
    epoch = found.require("EPOCH")

    def optional(key: str, *units: str) -> float | None:
        return found.number(key, *units) if found.only(key) else None

    return Opm(
        object_name=found.text("OBJECT_NAME", ""),
        frame=frame,
        epoch_utc=found.epoch_utc(epoch, time_system),
        position_km=(found.number("X", "km"), found.number("Y", "km"), found.number("Z", "km")),
        velocity_km_s=(
            found.number("X_DOT", "km/s"),
            found.number("Y_DOT", "km/s"),
            found.number("Z_DOT", "km/s"),
        ),
        mass_kg=optional("MASS", "kg"),
        drag_area_m2=optional("DRAG_AREA", "m**2", "m^2", "m2"),
        drag_coefficient=optional("DRAG_COEFF", "n/a"),
        ignitions_utc=tuple(
            found.epoch_utc(entry, time_system) for entry in found.all("MAN_EPOCH_IGNITION")
        ),
    )
