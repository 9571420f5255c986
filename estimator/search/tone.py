"""A test of tone mapping: brightness proportional to light, or mapped for viewing.

Above the limb the air thins by e every 7.6 km, and so does its light.  In an sRGB file, which
holds about the 2.2nd root of the light, the limb fades half as fast and its steepest point lies
kilometres higher.  How fast it fades tells the two apart; sRGB is undone.  A camera's contrast
curve stays, which steepens the dark end again: such files lie in between and either way will do.
Source: IEC 61966-2-1 for the curve.
"""

from dataclasses import replace

import cv2
import numpy as np

from estimator.images import Frame, brightness
from estimator.limb.points import LENS_BLUR_PX, LimbPoints
from estimator.limb.projection import LimbProjection

_REACH_M, _STEP_M = 60e3, 1e3
_LIMB_WITHIN_M = 30e3
_SMOOTH_M = 5e3
_COLUMNS = 96
_FEWEST = 12
# From the steepest point out to where the slope is a third: a grey daylight limb makes
# 15-24 km linear and 26-44 km as sRGB, with 2.9 km of lens blur; a blue one less, and an
# overexposed one is steepest where it saturates, out in the thin air.
_FADE_M, _BLUE_FADE_M, _CLIPPED_FADE_M, _FADE_BLUR_M = 25e3, 22.5e3, 5.5e3, 2.9e3
_COARSEST_M_PER_PX = 10e3
_HALF_SPAN_M = 10e3  # over which the projection is taken as straight
_DARK_SLOPE = 12.92


def fade_ratio(frame: Frame, points: LimbPoints, projection: LimbProjection) -> float | None:
    """How far the limb takes to fade against the farthest of a linear file; None if unseen."""
    fade = _fade_m(frame, points, projection)
    if fade is None:
        return None
    fade_m, blur_m = fade
    usual_m = _BLUE_FADE_M if frame.blue else _FADE_M
    if points.is_overexposed:
        usual_m -= _CLIPPED_FADE_M
    return fade_m / float(np.sqrt(usual_m**2 + 2.0 * max(blur_m**2 - _FADE_BLUR_M**2, 0.0)))


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
    ray_itrf = ray_body[:: max(1, len(ray_body) // _COLUMNS)] @ projection.c_body_from_itrf
    azimuth_rad = projection.limb.azimuth_rad(ray_itrf)
    low_px, high_px, good = projection.span_px(azimuth_rad, _HALF_SPAN_M)
    if np.sum(good) < _FEWEST:
        return None
    low_px, high_px = low_px[good], high_px[good]
    span_px = high_px - low_px
    m_per_px = 2.0 * _HALF_SPAN_M / float(np.median(np.linalg.norm(span_px, axis=1)))
    if m_per_px > _COARSEST_M_PER_PX:
        return None
    above_m = np.arange(-_REACH_M, _REACH_M, _STEP_M)[None, :, None]
    px_per_m = (span_px / (2.0 * _HALF_SPAN_M))[:, None]
    place_px = (0.5 * (low_px + high_px)[:, None] + above_m * px_per_m).astype(np.float32)
    x, y = place_px[..., 0].copy(), place_px[..., 1].copy()
    light = cv2.remap(frame.grey, x, y, cv2.INTER_LINEAR, borderValue=float("nan"))
    in_frame = np.all(np.isfinite(light), axis=1)
    if np.sum(in_frame) < _FEWEST:
        return None
    middle = np.median(light[in_frame], axis=0)
    smooth = cv2.GaussianBlur(middle[None], (0, 0), _SMOOTH_M / _STEP_M)[0]
    slope = -np.diff(smooth)
    within = np.abs(above_m[0, 1:, 0]) < _LIMB_WITHIN_M
    steepest = int(np.argmax(np.where(within, slope, -np.inf)))
    gentle = np.flatnonzero(slope[steepest:] < slope[steepest] / np.e)
    if slope[steepest] <= 0.0 or len(gentle) == 0:
        return None
    return float(gentle[0]) * _STEP_M, m_per_px * LENS_BLUR_PX
