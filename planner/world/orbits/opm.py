"""An orbit from a state as a message (CCSDS OPM)."""

import re
from datetime import datetime
from functools import cached_property
from typing import Any, ClassVar, Literal

from planner.base.errors import InvalidMessage, OutsideCoverage
from planner.base.spec import spec
from planner.world.frames.time_scales import elapsed_s, tai_us, utc_text
from planner.world.messages.opm import Opm, read_opm
from planner.world.orbits.ephemeris import CarrierName, OrbitSource
from planner.world.orbits.paper_model import PaperEphemeris
from planner.world.orbits.state_vector import PropagatedEphemeris, StateVectorOrbit

_KEYWORDS = {
    "epoch": "EPOCH",
    "position_km": "position (X, Y, Z)",
    "velocity_km_s": "velocity (X_DOT, Y_DOT, Z_DOT)",
    "mass_kg": "MASS",
    "drag_area_m2": "DRAG_AREA",
    "drag_coefficient": "DRAG_COEFF",
    "frame": "REF_FRAME",
}
_FIELD = re.compile(r"\b(" + "|".join(_KEYWORDS) + r")\b")


@spec
class OpmOrbit(OrbitSource):
    """The text of a CCSDS OPM, KVN or XML; its state is propagated as a state vector's.

    Mass, drag area and coefficient are the message's; where it is silent, those of
    `StateVectorOrbit`.

    content: the whole message, line breaks included.
    force_model: `full` is the 36x36 field, Sun, Moon and drag (0.2 m after 900 s); `j2j4` the
    paper's (56 m).
    """

    search_horizon_s: ClassVar[float] = StateVectorOrbit.search_horizon_s
    source: Literal["opm"] = "opm"
    content: str
    force_model: Literal["full", "j2j4"] = "full"

    def __post_init__(self) -> None:
        try:
            _ = self.state
        except InvalidMessage as refusal:
            raise ValueError(f"content: {refusal.detail}") from None
        except ValueError as error:
            raise ValueError(f"content: the OPM's {_in_its_words(str(error))}") from None

    @cached_property
    def message(self) -> Opm:
        """Read once, at construction."""
        return read_opm(self.content)

    @cached_property
    def state(self) -> StateVectorOrbit:
        """The message as a state vector."""
        opm = self.message
        drag: dict[str, Any] = {
            name: getattr(opm, name)
            for name in ("mass_kg", "drag_area_m2", "drag_coefficient")
            if getattr(opm, name) is not None
        }
        return StateVectorOrbit(
            frame=opm.frame,  # type: ignore[arg-type]  # one of FRAMES: the reader saw to it
            epoch=opm.epoch_utc,
            position_km=opm.position_km,
            velocity_km_s=opm.velocity_km_s,
            force_model=self.force_model,
            **drag,
        )

    @property
    def carrier_name(self) -> CarrierName:
        """The message's OBJECT_NAME."""
        return CarrierName(self.message.object_name)

    def ephemeris(
        self, start_utc: datetime, stop_utc: datetime
    ) -> PropagatedEphemeris | PaperEphemeris:
        """Raises OutsideCoverage as the state vector does, and across an announced burn."""
        epoch_utc = self.message.epoch_utc
        for ignition_utc in self.message.ignitions_utc:
            before_s = elapsed_s(ignition_utc, min(epoch_utc, start_utc, key=tai_us))
            after_s = elapsed_s(max(epoch_utc, stop_utc, key=tai_us), ignition_utc)
            if before_s >= 0.0 and after_s >= 0.0:
                raise OutsideCoverage(
                    f"the OPM announces a burn at {utc_text(ignition_utc)}, between its epoch "
                    f"{utc_text(epoch_utc)} and the plan; send an OEM that holds the burn",
                    field="orbit.content",
                    at_utc=ignition_utc,
                )
        try:
            return self.state.ephemeris(start_utc, stop_utc)
        except OutsideCoverage as refusal:
            raise OutsideCoverage(
                _in_its_words(refusal.detail.replace("orbit.", "")),
                field="orbit.content",
                at_utc=refusal.at_utc,
            ) from None


def _in_its_words(fault: str) -> str:
    """A fault of the state vector, with the message's keywords for our fields."""
    return _FIELD.sub(lambda match: _KEYWORDS[match[0]], fault)
