"""Refusals before an image is measured.

A frame that shows no usable horizon is not a refusal: it is the answer `not_observable`
with a `Reason`.  Only requests and uploads that can't be read at all are refused.
"""

from enum import StrEnum
from typing import ClassVar

from planner.base.errors import InvalidInput


class InvalidImage(InvalidInput):
    """An upload that is no picture of the kinds we read, is damaged, or is too large."""

    slug: ClassVar[str] = "invalid-image"
    title: ClassVar[str] = "The image can't be read"


class InvalidCamera(InvalidInput):
    """A camera that doesn't fit its image, or cameras without a position that makes sense."""

    slug: ClassVar[str] = "invalid-camera"
    title: ClassVar[str] = "The camera doesn't fit"


class Reason(StrEnum):
    """Why a camera's frame, or all of them together, gave no vertical."""

    ALL_BLACK = "the frame is black: nothing in it is brighter than the noise"
    SATURATED = "the frame is saturated nearly everywhere"
    NO_HORIZON = "no bright-to-dark edge has the shape and the size of the Earth's limb"
    NOT_IN_FRAME = "the limb is not in the frame: the camera sees only sky or only ground"
    NO_SKY = "no dark sky beyond a limb: ground, clouds or glare fill the frame"
    SUN_IN_FRAME = "the Sun shines into the frame, and no limb in it stands up to the tests"
    SHORT_ARC = "the visible arc of the limb is too short"
    BROKEN_ARC = "too little of the limb that should be visible was found"
    NIGHT_SIDE = "the Sun is below the limb in view: a daylight limb can't be there"
    LOW_SUN = "the Sun is too low at the craft: too little of the limb in view is in full daylight"
    HEADING_UNKNOWN = (
        "the Sun is below 20 deg at the craft, and without a predicted attitude nobody knows "
        "which part of the limb it lights; give `predicted`"
    )
    BLURRED = "the edge found is far too soft for the limb: a terminator, glow or cloud edge"
    SHARP = "the edge found is too sharp for air: the craft's structure, a window or a drawing"
    GLOWING_LAYER = "it grows dark again behind the edge: airglow or aurora, not the lit Earth"
    COLOUR = "the light above the edge is no bluer than below it, as it is in the Earth's air"
    LIMB_HEIGHT = "the edge lies at a height the limb doesn't have: airglow, aurora or cloud tops"
    RESIDUALS = "the edge found does not follow the limb's shape; suspect the intrinsics"
    CAMERAS_DISAGREE = "cameras see horizons that contradict each other: check mounts and order"
    ELSEWHERE = "the limb found in the other cameras is not in this frame"
