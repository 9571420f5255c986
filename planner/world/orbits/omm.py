"""An orbit from mean elements as a message (CCSDS OMM), by SGP4."""

import math
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Tag
from sgp4.api import WGS72, Satrec

from planner.base.errors import InvalidMessage
from planner.base.spec import spec
from planner.world.frames.time_scales import DAY_S
from planner.world.messages.omm import Omm, read_omm
from planner.world.orbits.ephemeris import CarrierName, OrbitSource
from planner.world.orbits.tle import TleEphemeris, require_earth_orbit, sgp4_ephemeris

_SGP4_ORIGIN = datetime(1949, 12, 31, tzinfo=UTC)
_MINUTES_PER_DAY = 1440.0
_Elements = Mapping[str, Any]


def _form_text(value: object) -> str:
    if isinstance(value, Mapping):
        return "object"
    return "list" if isinstance(value, list | tuple) else "text"


OmmContent = Annotated[
    Annotated[str, Tag("text")]
    | Annotated[_Elements, Tag("object")]
    | Annotated[tuple[_Elements, ...], Tag("list")],
    Discriminator(_form_text),
]


@spec
class OmmOrbit(OrbitSource):
    """A CCSDS OMM: JSON as catalogues send it, KVN or XML.

    The same elements as a TLE with more digits, so the same error: about 1 km at the epoch.

    content: the whole message as text, line breaks included; JSON also as it is, an object or a
    list of one.
    """

    search_horizon_s: ClassVar[float] = DAY_S
    source: Literal["omm"] = "omm"
    content: OmmContent

    def __post_init__(self) -> None:
        try:
            require_earth_orbit(self._elements())
        except (InvalidMessage, ValueError) as error:
            raise ValueError(f"content: {error}") from None

    @cached_property
    def message(self) -> Omm:
        """Read once, at construction."""
        return read_omm(self.content)

    @property
    def carrier_name(self) -> CarrierName:
        """The message's OBJECT_NAME."""
        return CarrierName(self.message.object_name)

    def ephemeris(self, start_utc: datetime, stop_utc: datetime) -> TleEphemeris:
        """Raises OutsideCoverage when an instant is 30 days or more from the epoch."""
        return sgp4_ephemeris(
            self._elements(), self.message.epoch_utc, start_utc, stop_utc, field="orbit.content"
        )

    def _elements(self) -> Satrec:
        omm = self.message
        # SGP4's day count, like its Julian dates, knows no leap seconds.
        since = omm.epoch_utc - _SGP4_ORIGIN
        satrec = Satrec()
        satrec.sgp4init(
            WGS72,
            "i",
            0,  # the catalogue number plays no part
            since.days + (since.seconds + since.microseconds * 1e-6) / DAY_S,
            omm.bstar,
            0.0,  # SGP4 does without the derivatives of the mean motion
            0.0,
            omm.eccentricity,
            math.radians(omm.arg_of_pericenter_deg),
            math.radians(omm.inclination_deg),
            math.radians(omm.mean_anomaly_deg),
            omm.mean_motion_rev_day * 2.0 * math.pi / _MINUTES_PER_DAY,
            math.radians(omm.ra_of_asc_node_deg),
        )
        return satrec
