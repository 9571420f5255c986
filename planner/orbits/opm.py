"""Where will a satellite be whose state came as a message (CCSDS OPM)?"""

from datetime import datetime
from functools import cached_property
from typing import Any, Literal

from planner.errors import InvalidMessage, OutsideCoverage
from planner.frames.time_scales import utc_text
from planner.messages.opm import Opm, read_opm
from planner.orbits.paper_model import PaperEphemeris
from planner.orbits.state_vector import PropagatedEphemeris, StateVectorOrbit
from planner.spec import spec


@spec
class OpmOrbit:
    """The text of a CCSDS OPM, KVN or XML; its state is propagated as a state vector's.

    Mass, drag area and coefficient are the message's; where it is silent, those of
    `StateVectorOrbit`.
    """

    source: Literal["opm"] = "opm"
    content: str
    force_model: Literal["full", "j2j4"] = "full"

    def __post_init__(self) -> None:
        try:
            _ = self.state
        except InvalidMessage as refusal:
            raise ValueError(f"content: {refusal.detail}") from None

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

    def ephemeris(
        self, start_utc: datetime, stop_utc: datetime
    ) -> PropagatedEphemeris | PaperEphemeris:
        """Raises OutsideCoverage as the state vector does, and across an announced burn."""
        epoch_utc = self.message.epoch_utc
        for ignition_utc in self.message.ignitions_utc:
            if min(epoch_utc, start_utc) <= ignition_utc <= max(epoch_utc, stop_utc):
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
                refusal.detail, field="orbit.content", at_utc=refusal.at_utc
            ) from None
