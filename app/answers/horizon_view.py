"""The predicted view of a horizon camera, as answered; plans need it without what reads images."""

from dataclasses import dataclass

from planner.base.answer_members import Count, HalfTurnDeg, NotNegative, Signed, TurnDeg


@dataclass(frozen=True, kw_only=True)
class ViewOut:
    """The view of one camera at one instant.

    at: the instant; UTC.
    camera: the camera's name.
    usable: true when an estimate from its frame will be of use.
    reason: the reason why not, as a word; null when it is usable.
    explanation: the reason in full; null when it is usable.
    limb_in_frame: true when any of the limb is in the frame.
    arc_deg: limb in frame, as azimuth about nadir.
    lit_arc_deg: the part of that arc that is in daylight and away from the Sun.
    lit: true when any of the arc is in daylight and away from the Sun.
    sun_angle_deg: of the Sun from the boresight.
    sun_in_frame: true when the Sun's disk is in the frame.
    sigma_deg: expected 1-sigma of geocentric nadir by this camera alone; null when it is not
    usable.
    limb_px: the limb's line, [x, y]: x right, y down, pixel centres at whole numbers.
    """

    at: str
    camera: str
    usable: bool
    reason: str | None
    explanation: str | None
    limb_in_frame: bool
    arc_deg: TurnDeg
    lit_arc_deg: TurnDeg
    lit: bool
    sun_angle_deg: HalfTurnDeg
    sun_in_frame: bool
    sigma_deg: NotNegative | None
    limb_px: list[list[Signed]]


@dataclass(frozen=True, kw_only=True)
class HorizonCheckOut:
    """One camera's use in one session, seen at its start, middle and stop.

    session: its number, from 0. E.g. `0`.
    camera: the camera's name. E.g. `"ahead"`.
    usable: true when its frames will be of use at all three. E.g. `true`.
    reason: of the first that is not usable, as a word; null when all are. E.g. `"low_sun"`.
    explanation: the reason in full; null when all are usable. E.g.
    `"the Sun is too low at the craft"`.
    views: at the three instants.
    """

    session: Count
    camera: str
    usable: bool
    reason: str | None
    explanation: str | None
    views: list[ViewOut]
