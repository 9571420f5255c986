"""An attitude from a message (CCSDS AEM), against any of its frames."""

from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidMessage, OutsideCoverage
from planner.base.rotation import Rotation
from planner.base.spec import spec
from planner.world.attitude.correctable import CorrectableAttitude
from planner.world.attitude.errors import AttitudeErrors, known_errors
from planner.world.attitude.rotation_curve import (
    OPTIONS as ROTATION_CURVE_OPTIONS,
)
from planner.world.attitude.rotation_curve import (
    RotationCurve,
    odd_by_rad,
    rotation_curve,
)
from planner.world.frames.earth_orientation import c_frame_from_eci
from planner.world.frames.iers import RAD_PER_ARCSEC
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants, shifted_utc, utc_text
from planner.world.messages.aem import AemSegment, read_aem
from planner.world.orbits import OrbitStates
from planner.world.orbits.ephemeris import EDGE_S


@dataclass(frozen=True, kw_only=True)
class AttitudeMessageOptions:
    """Which rows of an attitude message are warned of."""

    gap_warned: float = 20.0  # times the usual step between rows
    # times what is usual of the message's rows: noise alone stays below 10
    odd_of_usual: float = 20.0
    curve_rows: int = 4  # farther rows hardly bend the curve
    # by which a line between two rows may miss the curve
    linear_warned_rad: float = 10.0 * ROTATION_CURVE_OPTIONS.exact_rad
    # off what the neighbours lead to: 60 m on the ground from 400 km
    odd_warned_rad: float = 30.0 * RAD_PER_ARCSEC
    odd_refused_rad: float = 180.0 * RAD_PER_ARCSEC  # 350 m on the ground from 400 km


OPTIONS = AttitudeMessageOptions()

LOCAL_ORBITAL = ("LVLH", "RTN")

# Radial is -Z of LVLH, along-track +X, and the orbit's normal -Y.
_C_RTN_FROM_LVLH = ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0))


@dataclass(frozen=True, eq=False)
class AttitudeArc:
    """One segment of a message as a curve.

    curve: of the body's attitude against the segment's frame, on the segment's clock.
    odd_rad: `odd_by_rad` of each of its rows.
    """

    segment: AemSegment
    curve: RotationCurve
    odd_rad: Array

    def oddest_near(self, instants: Instants) -> tuple[datetime, float]:
        """When the row is that fits its neighbours worst of those the curve there rests on, and
        by how much (rad).
        """
        row_s, epoch_utc = self.segment.t_s, self.segment.epoch_utc
        t_s = instants.since_s(epoch_utc)
        first = int(np.searchsorted(row_s, t_s.min())) - OPTIONS.curve_rows
        stop = int(np.searchsorted(row_s, t_s.max())) + OPTIONS.curve_rows
        near = slice(max(first, 0), stop)
        row = int(np.argmax(self.odd_rad[near])) + near.start
        return shifted_utc(epoch_utc, float(row_s[row])), float(self.odd_rad[row])

    @cached_property
    def usually_odd_rad(self) -> float:
        """What noise and the turning itself make of it."""
        return float(np.median(self.odd_rad))


@spec
class AemAttitude(CorrectableAttitude):
    """The text of a CCSDS AEM, KVN or XML, as published.

    The curve through its rows is smooth. It is never carried beyond a segment's useable times,
    nor from one segment into the next.

    content: the whole message, line breaks included.
    """

    law: Literal["aem"] = "aem"
    content: str

    def __post_init__(self) -> None:
        try:
            _ = self.arcs
        except InvalidMessage as refusal:
            raise ValueError(f"content: {refusal.detail}") from None
        for number, one in enumerate(self.corrections):
            try:
                self._arc_over(Instants(one.epoch, np.zeros(1)))
            except OutsideCoverage as refusal:
                raise ValueError(
                    f"corrections.{number}.epoch {utc_text(one.epoch)} lies outside the message: "
                    f"{refusal.detail}; leave the correction out, or send a message that covers it"
                ) from None

    @cached_property
    def arcs(self) -> tuple[AttitudeArc, ...]:
        """Curves of the segments, read and fitted once, at construction."""
        return tuple(map(_arc_of, read_aem(self.content)))

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know about the message's quality."""
        warnings = (
            warning
            for arc in self.arcs
            for warning in (_noise_text(arc), _gap_text(arc.segment), _not_linear(arc))
        )
        return tuple(dict.fromkeys(filter(None, warnings)))

    def law_warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """Those of the whole message, and the row there that fits its neighbours worst."""
        arc = self._arc_over(instants)
        at_utc, odd_rad = arc.oddest_near(instants)
        if odd_rad <= max(OPTIONS.odd_warned_rad, OPTIONS.odd_of_usual * arc.usually_odd_rad):
            return self.warnings
        return (*self.warnings, _odd_at(at_utc, odd_rad))

    @property
    def residual_rad(self) -> float:
        """Rms distance of the message's attitudes from the curve, of its worst segment."""
        return max(arc.curve.residual_rms_rad for arc in self.arcs)

    def law_errors(self, instants: Instants) -> AttitudeErrors:
        """The noise of the message's worst segment."""
        return known_errors(
            np.full(3, self.residual_rad),
            "the message is assumed true to 56 arcsec an axis, the measured difference of the "
            "ISS's two attitude solutions; its noise is measured",
            "an attitude with less noise",
        )

    def q_law_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants; raises OutsideCoverage unless one segment holds them all."""
        arc = self._arc_over(instants)
        at_utc, odd_rad = arc.oddest_near(instants)
        if odd_rad > max(OPTIONS.odd_refused_rad, OPTIONS.odd_of_usual * arc.usually_odd_rad):
            raise InvalidMessage(
                f"{_odd_at(at_utc, odd_rad)}; was a number damaged on its way, or does the carrier "
                "turn faster than the rows tell? Get the message again, or with closer rows",
                field="attitude.content",
                at_utc=at_utc,
            )
        t_s = np.clip(instants.since_s(arc.segment.epoch_utc), *arc.segment.useable_s)
        return arc.curve.at(t_s) * q_frame_from_eci(arc.segment.frame, instants, states)

    def _arc_over(self, instants: Instants) -> AttitudeArc:
        for arc in self.arcs:
            t_s, (start_s, stop_s) = instants.since_s(arc.segment.epoch_utc), arc.segment.useable_s
            outside_s = max(start_s - float(t_s.min()), float(t_s.max()) - stop_s)
            if round(outside_s, 6) <= EDGE_S:
                return arc
        first_utc, last_utc = (
            shifted_utc(instants.epoch_utc, float(t))
            for t in (instants.t_s.min(), instants.t_s.max())
        )
        spans = ", ".join(
            " to ".join(
                utc_text(shifted_utc(arc.segment.epoch_utc, t)) for t in arc.segment.useable_s
            )
            for arc in self.arcs[:3]
        )
        more = f" and {len(self.arcs) - 3} more" if len(self.arcs) > 3 else ""
        raise OutsideCoverage(
            f"the AEM has no one segment from {utc_text(first_utc)} to {utc_text(last_utc)}; "
            f"its segments are useable from {spans}{more}",
            field="attitude.content",
            at_utc=first_utc,
        )


def q_frame_from_eci(frame: str, instants: Instants, states: OrbitStates) -> Rotation:
    """n rotations to the axes of one of `planner.world.messages.aem.FRAMES`.

    `states` is the orbit at the same n instants; only the local orbital frames need it.
    """
    if frame in LOCAL_ORBITAL:
        q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
        return q_frame_from_lvlh(frame) * q_lvlh
    return Rotation.from_matrix(c_frame_from_eci(frame, instants))


def q_frame_from_lvlh(frame: str) -> Rotation:
    """The constant rotation from LVLH to one of LOCAL_ORBITAL."""
    return Rotation.from_matrix(_C_RTN_FROM_LVLH) if frame == "RTN" else Rotation.identity()


def _arc_of(segment: AemSegment) -> AttitudeArc:
    try:
        curve = rotation_curve(segment.t_s, segment.q_body_from_frame_xyzw, segment.q_dot_s)
    except ValueError as error:
        start = utc_text(segment.epoch_utc)
        raise InvalidMessage(f"AEM segment from {start}: {error}") from None
    return AttitudeArc(segment, curve, odd_by_rad(segment.t_s, segment.q_body_from_frame_xyzw))


def _odd_at(at_utc: datetime, odd_rad: float) -> str:
    return (
        f"the AEM's attitude at {utc_text(at_utc)} lies {odd_rad / RAD_PER_ARCSEC:.0f} arcsec or "
        "more off what the rows around it lead to"
    )


def _noise_text(arc: AttitudeArc) -> str | None:
    curve = arc.curve
    if curve.residual_rms_rad <= ROTATION_CURVE_OPTIONS.exact_rad:
        return None
    rms, worst = curve.residual_rms_rad / RAD_PER_ARCSEC, curve.residual_max_rad / RAD_PER_ARCSEC
    return (
        f"the AEM's attitudes are noisy and were smoothed (spline knots every "
        f"{curve.knot_spacing_s:.0f} s): they lie {rms:.2f} arcsec rms, {worst:.1f} at most, "
        "from the curve flown"
    )


def _gap_text(segment: AemSegment) -> str | None:
    step_s = np.diff(segment.t_s)
    row = int(np.argmax(step_s))
    usual_s = float(np.median(step_s))
    if step_s[row] <= OPTIONS.gap_warned * usual_s:
        return None
    at = utc_text(shifted_utc(segment.epoch_utc, float(segment.t_s[row])))
    return (
        f"the AEM, with rows every {usual_s:.3g} s, has a gap of {step_s[row]:.0f} s from {at}, "
        "bridged by the curve"
    )


def _not_linear(arc: AttitudeArc) -> str | None:
    segment = arc.segment
    if not segment.linear or len(segment.t_s) == 2:
        return None
    middle_s = 0.5 * (segment.t_s[1:] + segment.t_s[:-1])
    q_xyzw = segment.q_body_from_frame_xyzw
    linear = Rotation.from_quat(q_xyzw[1:] + q_xyzw[:-1])  # slerp's own midpoint
    apart_rad = float(np.max((arc.curve.at(middle_s) * linear.inv()).magnitude()))
    if apart_rad <= OPTIONS.linear_warned_rad:
        return None
    return (
        "the AEM asks for linear interpolation, whose rate jumps at every row; the smooth curve "
        f"flown departs from it by up to {apart_rad / RAD_PER_ARCSEC:.1f} arcsec"
    )
