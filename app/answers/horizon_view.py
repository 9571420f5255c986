"""What a horizon camera will see, as answered; plans need it without what reads images."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ViewOut:
    """What one camera will see at one instant.

    reason: why the frame will be of no use, as a word; explanation: in full.  limb_in_frame,
    arc_deg: limb in frame, as azimuth about nadir; lit_arc_deg: what of it stands in daylight
    and away from the Sun.  sun_angle_deg: from the boresight.  limb_px: the limb's line, x
    right, y down, pixel centres at whole numbers.  sigma_deg: expected 1-sigma of geocentric
    nadir by this camera alone.
    """

    at: str
    camera: str
    usable: bool
    reason: str | None
    explanation: str | None
    limb_in_frame: bool
    arc_deg: float
    lit_arc_deg: float
    lit: bool
    sun_angle_deg: float
    sun_in_frame: bool
    sigma_deg: float | None
    limb_px: list[list[float]]


@dataclass(frozen=True, kw_only=True)
class HorizonCheckOut:
    """One camera's use in one session, seen at its start, middle and stop.

    usable: in all three; else `reason` is that of the first that is not.
    """

    session: int
    camera: str
    usable: bool
    reason: str | None
    explanation: str | None
    views: list[ViewOut]
