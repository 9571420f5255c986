"""A test of tone mapping: brightness proportional to light, or mapped for viewing.

Above the limb the air thins by e every 7.6 km, and so does its light.  In an sRGB file, which
holds about the 2.2nd root of the light, the limb fades half as fast and its steepest point lies
kilometres higher.  How fast it fades tells the two apart; sRGB is undone.  A camera's contrast
curve stays, which steepens the dark end again: such files lie in between and either way will do.
Source: IEC 61966-2-1 for the curve.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from estimator.images import Frame, brightness
from estimator.limb.points import LENS_BLUR_PX, LimbPoints
from estimator.limb.projection import LimbProjection


@dataclass(frozen=True, kw_only=True)
class ToneOptions:
    """How the limb's own fading tells a camera's contrast curve."""

    reach_m: float = 60e3  # to either side of the edge, in which brightness is taken,
    step_m: float = 1e3  # every so far
    limb_within_m: float = 30e3  # of where it is expected
    smooth_m: float = 5e3  # before the steepest point is sought
    columns: int = 96  # looked at, at most
    fewest: int = 12  # with a limb, to tell anything
    # From the steepest point out to where the slope is a third: a grey daylight limb makes 15-24
    # km linear and 26-44 km as sRGB, with 2.9 km of lens blur;
    fade_m: float = 25e3
    blue_fade_m: float = 22.5e3  # a blue one less,
    # and an overexposed one is steepest where it saturates, out in the thin air
    clipped_fade_m: float = 5.5e3
    fade_blur_m: float = 2.9e3  # the lens blur in these
    coarsest_m_per_px: float = 10e3  # coarser pixels blur the fading away
    half_span_m: float = 10e3  # over which the projection is taken as straight


OPTIONS = ToneOptions()

_DARK_SLOPE = 12.92


def fade_ratio(frame: Frame, points: LimbPoints, projection: LimbProjection) -> float | None:
    """How far the limb takes to fade against the farthest of a linear file; None if unseen."""
    fade = _fade_m(frame, points, projection)
    if fade is None:
        return None
    fade_m, blur_m = fade
    usual_m = OPTIONS.blue_fade_m if frame.blue else OPTIONS.fade_m
    if points.is_overexposed:
        usual_m -= OPTIONS.clipped_fade_m
    return fade_m / float(np.sqrt(usual_m**2 + 2.0 * max(blur_m**2 - OPTIONS.fade_blur_m**2, 0.0)))


def linear(frame: Frame) -> Frame:
    """An sRGB frame's light."""
    coded = frame.table
    light = np.where(coded <= 0.04045, coded / _DARK_SLOPE, ((coded + 0.055) / 1.055) ** 2.4)
    table = light.astype(np.float32)
    return replace(
        frame,
        grey=brightness(table[frame.pixels], frame.blue),
        step=frame.step / _DARK_SLOPE,
        table=table,
        decoded=True,
    )


def _fade_m(
    frame: Frame, points: LimbPoints, projection: LimbProjection
) -> tuple[float, float] | None:
    """How far the median limb's slope takes to fall to 1/e outwards, and the lens's blur."""
    # Clouds seen down to the ground brighten as slowly as an sRGB limb fades.
    clear = points.found & (points.drawn_m == 0.0)
    ray_body = points.ray_body[clear]
    ray_itrf = ray_body[:: max(1, len(ray_body) // OPTIONS.columns)] @ projection.c_body_from_itrf
    azimuth_rad = projection.limb.azimuth_rad(ray_itrf)
    low_px, high_px, good = projection.span_px(azimuth_rad, OPTIONS.half_span_m)
    if np.sum(good) < OPTIONS.fewest:
        return None
    low_px, high_px = low_px[good], high_px[good]
    span_px = high_px - low_px
    m_per_px = 2.0 * OPTIONS.half_span_m / float(np.median(np.linalg.norm(span_px, axis=1)))
    if m_per_px > OPTIONS.coarsest_m_per_px:
        return None
    above_m = np.arange(-OPTIONS.reach_m, OPTIONS.reach_m, OPTIONS.step_m)[None, :, None]
    px_per_m = (span_px / (2.0 * OPTIONS.half_span_m))[:, None]
    place_px = (0.5 * (low_px + high_px)[:, None] + above_m * px_per_m).astype(np.float32)
    x, y = place_px[..., 0].copy(), place_px[..., 1].copy()
    light = cv2.remap(frame.grey, x, y, cv2.INTER_LINEAR, borderValue=float("nan"))
    in_frame = np.all(np.isfinite(light), axis=1)
    if np.sum(in_frame) < OPTIONS.fewest:
        return None
    middle = np.median(light[in_frame], axis=0)
    smooth = cv2.GaussianBlur(middle[None], (0, 0), OPTIONS.smooth_m / OPTIONS.step_m)[0]
    slope = -np.diff(smooth)
    within = np.abs(above_m[0, 1:, 0]) < OPTIONS.limb_within_m
    steepest = int(np.argmax(np.where(within, slope, -np.inf)))
    gentle = np.flatnonzero(slope[steepest:] < slope[steepest] / np.e)
    if slope[steepest] <= 0.0 or len(gentle) == 0:
        return None
    return float(gentle[0]) * OPTIONS.step_m, m_per_px * LENS_BLUR_PX
