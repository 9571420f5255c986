"""Reads a CCSDS orbit parameter message (OPM).

Source: CCSDS 502.0-B-3, section 3.
"""

from dataclasses import dataclass
from datetime import datetime

from planner.world.messages.keywords import read_keywords
from planner.world.messages.oem import standard_frame

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
    opm = read_keywords(content, "OPM", ("1", "2", "3"))
    opm.require_earth()
    stated = opm.text("REF_FRAME")
    frame = standard_frame(stated)
    if frame not in FRAMES:
        opm.refuse(f"REF_FRAME {stated!r} is not supported; convert to one of {FRAMES}")
    time_system = opm.text("TIME_SYSTEM").upper()
    epoch = opm.require("EPOCH")

    def optional_number(key: str, *units: str) -> float | None:
        return opm.number(key, *units) if opm.only(key) else None

    return Opm(
        object_name=opm.text("OBJECT_NAME", ""),
        frame=frame,
        epoch_utc=opm.epoch_utc(epoch, time_system),
        position_km=(opm.number("X", "km"), opm.number("Y", "km"), opm.number("Z", "km")),
        velocity_km_s=(
            opm.number("X_DOT", "km/s"),
            opm.number("Y_DOT", "km/s"),
            opm.number("Z_DOT", "km/s"),
        ),
        mass_kg=optional_number("MASS", "kg"),
        drag_area_m2=optional_number("DRAG_AREA", "m**2", "m^2", "m2"),
        drag_coefficient=optional_number("DRAG_COEFF", "n/a"),
        ignitions_utc=tuple(
            opm.epoch_utc(entry, time_system) for entry in opm.all("MAN_EPOCH_IGNITION")
        ),
    )
