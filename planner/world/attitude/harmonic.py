"""An attitude that keeps swinging as its history shows."""

from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Literal

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.errors import InvalidMessage, OutsideCoverage, Refusal
from planner.base.rotation import Rotation
from planner.base.spec import spec
from planner.world.attitude.aem import LOCAL_ORBITAL, q_frame_from_eci, q_frame_from_lvlh
from planner.world.attitude.blend import Blend, blend
from planner.world.attitude.correctable import CorrectableAttitude
from planner.world.attitude.errors import AttitudeErrors, known_errors
from planner.world.attitude.extrapolation import OFFSET_TAIL_S
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.world.messages.aem import AemSegment, read_aem
from planner.world.orbits import Orbit, OrbitStates


@dataclass(frozen=True, kw_only=True)
class HarmonicOptions:
    """How much of the telemetry forecasts what follows, and how far."""

    history_orbits: float = 5.0  # of telemetry, at most: older rows tell of another swing
    row_step_s: float = 10.0  # a row kept; the carrier swings in minutes
    lead_max_s: float = 6.0 * 3600.0  # six hours: a little beyond the leads that `blend` weighs
    # Errors of one forecast, 900 and 1,800 s apart, have a correlation of 0.6 and 0.4 about x and
    # y (bench/attitude_figures.py of commit 54f03d3).
    error_memory_s: float = 1250.0


OPTIONS = HarmonicOptions()

_TURN = ", and its manoeuvre's turn, which nothing predicts"


@spec
class HarmonicAttitude(CorrectableAttitude):
    """An attitude history (CCSDS AEM, KVN or XML) extrapolated beyond its end.

    The history is described by orbital harmonics of its attitude to LVLH and the present offset
    from them, and by the present attitude or rate alone, a rate that slows down coming to rest; at
    each lead each counts by how well it predicts the history's own tail so far ahead.  What is
    older than a manoeuvre isn't used, and while one is under way its turn is stated in the error.
    On ISS telemetry in torque equilibrium: 0.02 deg rms after 900 s.

    content: the whole message, line breaks included.
    history_orbit: orbit of the carrier during the history; needed unless the message is against a
    local orbital frame.
    orbital_period_s: the default is the ISS's; 1 % off takes 0.022 deg after 900 s to 0.030.
    """

    law: Literal["harmonic"] = "harmonic"
    content: str
    history_orbit: Orbit | None = None

    def __post_init__(self) -> None:
        try:
            _ = self.segments
        except InvalidMessage as refusal:
            raise ValueError(f"content: {refusal.detail}") from None
        try:
            _ = self.extrapolated
        except Refusal as refusal:
            raise ValueError(f"history_orbit: {refusal.detail}") from None
        except ValueError as error:
            raise ValueError(f"content: {error}") from None
        for number, one in enumerate(self.corrections):
            try:
                self._refuse_outside(Instants(one.epoch, np.zeros(1)))
            except OutsideCoverage as refusal:
                raise ValueError(
                    f"corrections.{number}.epoch can't be compared with the law: {refusal.detail}; "
                    "leave the correction out"
                ) from None

    @cached_property
    def segments(self) -> tuple[AemSegment, ...]:
        """Read once, at construction."""
        return read_aem(self.content)

    @cached_property
    def extrapolated(self) -> Blend:
        """Fitted once, at construction; its clock is that of the message's last segment."""
        return blend(*self._history, self.orbital_period_s)

    def choice_at(self, lead_s: float) -> str:
        """What counts most so long after the history's end, and on what evidence."""
        shares = [pair for pair in self.extrapolated.shares_at(lead_s) if pair[1] >= 0.1]
        rms_rad = np.linalg.norm(self.extrapolated.error_rms_at(np.array([lead_s])))
        beyond = lead_s > self.extrapolated.tried_s
        return (
            f"the attitude is extrapolated from {utc_text(self._end_utc)}, {lead_s:.0f} s ahead by "
            f"{', '.join(f'{description} ({share:.0%})' for description, share in shares)}: "
            f"{np.rad2deg(rms_rad):.3f} deg rms "
            + (
                f"expected from its errors up to {self.extrapolated.tried_s:.0f} s ahead on "
                if beyond
                else "on "
            )
            + "parts of its own history it had not seen"
            + _TURN * self.extrapolated.under_way
        )

    def law_warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """The choice: it may be a poor one, and its rms says so; a manoeuvre in the history."""
        lead_s = max(0.0, float(instants.since_s(self._end_utc)[-1]))
        changed_s = self.extrapolated.changed_s
        if changed_s is None:
            return (self.choice_at(lead_s),)
        changed_utc = shifted_utc(self.segments[-1].epoch_utc, changed_s)
        what = (
            "is under way, which began about {}: a turn as likely as not is told in the error, "
            "unless attitude.uncertainty states it"
            if self.extrapolated.under_way
            else "began or ended about {}: the error told holds no other"
        )
        return (
            self.choice_at(lead_s),
            f"the attitude history holds a manoeuvre, which {what.format(utc_text(changed_utc))}; "
            "what is older is not used, and nothing predicts when a manoeuvre begins or ends",
        )

    def law_errors(self, instants: Instants) -> AttitudeErrors:
        """Errors from the held-out tail, so long after it as the instants are."""
        lead_s = np.maximum(instants.since_s(self._end_utc), 0.0)
        return known_errors(
            self.extrapolated.error_rms_at(lead_s),
            "measured on the history's own tail, held out of the fit"
            + _TURN * self.extrapolated.under_way,
            "a history that ends nearer to the session",
            OPTIONS.error_memory_s,
        )

    def q_law_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants; raises OutsideCoverage before the history's end."""
        self._refuse_outside(instants)
        since_end_s = instants.since_s(self._end_utc)
        q_body_from_lvlh = self.extrapolated.at(since_end_s + self.extrapolated.end_s)
        return q_body_from_lvlh * q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)

    def _refuse_outside(self, instants: Instants) -> None:
        since_end_s = instants.since_s(self._end_utc)
        for wrong, why in (
            (since_end_s < -OFFSET_TAIL_S, "lies in the history: use the attitude law aem"),
            (
                since_end_s > OPTIONS.lead_max_s,
                f"is more than {OPTIONS.lead_max_s / 3600.0:.0f} h after it",
            ),
        ):
            if wrong.any():
                at_utc = instants.utc(int(np.argmax(wrong)))
                raise OutsideCoverage(
                    f"the attitude history ends at {utc_text(self._end_utc)}; "
                    f"{utc_text(at_utc)} {why}",
                    field="attitude.content",
                    at_utc=at_utc,
                )

    @cached_property
    def _end_utc(self) -> datetime:
        last = self.segments[-1]
        return shifted_utc(last.epoch_utc, float(last.t_s[-1]))

    @cached_property
    def _history(self) -> tuple[Array, Rotation]:
        """Rows of the last orbits, thinned: seconds since the last segment's epoch, attitudes."""
        last = self.segments[-1]
        oldest_s = float(last.t_s[-1]) - OPTIONS.history_orbits * self.orbital_period_s
        times: list[Array] = []
        attitudes: list[Rotation] = []
        for segment in self.segments:
            t_s = segment.t_s + elapsed_s(segment.epoch_utc, last.epoch_utc)
            rows = _thin_rows(t_s, oldest_s)
            if len(rows) and (not times or t_s[rows[0]] > times[-1][-1]):
                times.append(t_s[rows])
                attitudes.append(self._q_body_from_lvlh(segment, rows))
        return np.concatenate(times), Rotation.concatenate(attitudes)

    def _q_body_from_lvlh(self, segment: AemSegment, rows: Indices) -> Rotation:
        q_body_from_frame = Rotation.from_quat(segment.q_body_from_frame_xyzw[rows])
        if segment.frame in LOCAL_ORBITAL:
            return q_body_from_frame * q_frame_from_lvlh(segment.frame)
        if self.history_orbit is None:
            raise ValueError(
                f"the history is against {segment.frame}; give history_orbit, the orbit flown "
                "during it, or send it against LVLH"
            )
        instants = Instants(segment.epoch_utc, segment.t_s[rows])
        ephemeris = self.history_orbit.ephemeris(instants.utc(0), instants.utc(-1))
        states = ephemeris.states(instants)
        q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
        return q_body_from_frame * q_frame_from_eci(segment.frame, instants, states) * q_lvlh.inv()


def _thin_rows(t_s: Array, oldest_s: float) -> Indices:
    """The last row of every stretch of `row_step_s` counted back from the end."""
    rows = np.flatnonzero(t_s >= oldest_s)[::-1]
    _, first = np.unique((t_s[-1] - t_s[rows]) // OPTIONS.row_step_s, return_index=True)
    return np.asarray(rows[first][::-1])
