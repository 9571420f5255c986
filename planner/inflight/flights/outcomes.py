"""The outcomes of flights: of the one as planned, frame by frame, and of the others, run by run."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from planner.base.answer_members import Count, Internal, Member, NotNegative, answer
from planner.base.arrays import Array, Mask
from planner.inflight.simulation.gyros.report import GyroSteadiness

_NotNegatives = Annotated[Array, Member("", 0.0, decimals=6)]


@dataclass(frozen=True, kw_only=True, eq=False)
class RunOutcomes:
    """What r runs made of one session, each (r,), and p pairs of them.

    causes: of what differs from run to run.
    holds, sharp: whether all frames hold the target, and whether all are sharp, too.
    holds_share, sharp_share: of the frames.  miss_rad: the largest angle between boresight and
    target; miss_m: that on the ground, across the line of sight, infinite for a target in the sky.
    smear_px: median of the frames.  gyro_numbers: of gyros' steadiness, (r, k), k = 0 without.
    variance_px2: (p, 2), of the target's places in the image and of the smear, as two independent
    runs show them.  total_px2, first_px2: (p, 2, causes), half the square by which exchanging a
    cause moves a run away from itself, and leaves it away from the other.
    """

    causes: tuple[str, ...]
    holds: Mask
    sharp: Mask
    holds_share: Array
    sharp_share: Array
    miss_rad: Array
    miss_m: Array
    smear_px: Array
    gyro_numbers: Array
    variance_px2: Array
    total_px2: Array
    first_px2: Array

    @property
    def columns(self) -> Mapping[str, Array]:
        """By name."""
        return {name: values for name, values in vars(self).items() if name != "causes"}


@answer
class NominalSession:
    """A session flown as planned: no errors but those of nominal drives, or of a body's vibration.

    Lists hold every so many frames, at most 300 of them.

    frames: number of frames that the camera takes.
    held: number of frames that hold the target from the first moment of the exposure to the last.
    sharp: number of these that are smeared over less than a pixel.
    turn_rad: the largest turn of the view from one frame to the next.
    t_s: start of each frame, since the epoch.
    error_rad: the largest angle between boresight and target during the exposure.
    error_m: the same at the target, across the line of sight; null for a target in the sky.
    smear_px: the longest way between two places of the target in the image during the exposure.
    holds: true where the frame holds the target.
    north_rad: from the frame's first side towards its second, without jumps; the celestial north
    for a target in the sky.
    ground_sample_across_m: width of a pixel on the ground, across the lean of the line of sight;
    null for a target in the sky.
    ground_sample_along_m: its length, along the lean; null for a target in the sky, and where a
    pixel reaches the horizon.
    moving_object_ground_m: distance that the moving object travels from one frame of its series to
    the next; null without. E.g. `208.33`.
    moving_object_px: the same in the image, by the view of each frame shown; null without. E.g.
    `[181.2]`.
    rate_error_rad_s: of a body with gyros as each frame begins, in body axes; null without. E.g.
    `[[0.0001, -0.0002, 0.0001]]`.
    gyros: steadiness of this flight of a body with gyros; null without.
    """

    frames: Count
    held: Count
    sharp: Count
    turn_rad: Annotated[float, Member("deg", 0.0, 180.0, decimals=6)]  # of all frames
    t_s: _NotNegatives
    error_rad: Annotated[Array, Member("arcsec", 0.0, decimals=6)]
    error_m: _NotNegatives | None
    smear_px: _NotNegatives
    holds: Annotated[Mask, Member()]
    # Where the target is lost beside the camera, the view is that of the commanded angles.
    north_rad: Annotated[Array, Member("deg", decimals=9)]
    ground_sample_across_m: _NotNegatives | None
    ground_sample_along_m: Annotated[Array, Member("", 0.0, decimals=6, gaps=True)] | None
    moving_object_ground_m: NotNegative | None
    moving_object_px: _NotNegatives | None
    rate_error_rad_s: Annotated[Array, Member("deg", decimals=9, axes=2)] | None
    gyros: GyroSteadiness | None
    saturated_s: Internal[Array]  # (d,), how long each drive gives all it has
