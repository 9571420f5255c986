"""The least angle between the boresight and each mask of a platform, as answered."""

from dataclasses import dataclass

from app.answers.members import degrees
from app.answers.ranges import Count, HalfTurnDeg, Signed
from planner.verification.report import MaskMargin
from planner.world.frames.time_scales import utc_text


@dataclass(frozen=True, kw_only=True)
class MaskMarginOut:
    """The least angle between the boresight and one of the platform's `masks`.

    number: of the mask among the platform's, from 0. E.g. `0`.
    name: of the mask. E.g. `"radiator"`.
    asked_deg: angle from it that the boresight must keep, the mask's `margin_deg`. E.g. `1.0`.
    away_min_deg: least angle between boresight and the mask's region, negative inside, found to
    2 arcsec on and between rows. E.g. `4.2`.
    margin_deg: least angle less `asked_deg`; negative when the mask is entered. E.g. `3.2`.
    at: time of the least angle; UTC. E.g. `"2015-02-27T17:36:10.000Z"`.
    """

    number: Count
    name: str
    asked_deg: HalfTurnDeg
    away_min_deg: Signed
    margin_deg: Signed
    at: str


def mask_margin_out(margin: MaskMargin) -> MaskMarginOut:
    """In degrees."""
    return MaskMarginOut(
        number=margin.number,
        name=margin.name,
        asked_deg=degrees(margin.asked_rad),
        away_min_deg=degrees(margin.away_min_rad),
        margin_deg=degrees(margin.away_min_rad - margin.asked_rad),
        at=utc_text(margin.at_utc),
    )
