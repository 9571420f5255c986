"""Where exactly a frame shows the limb that a trial attitude predicts.

The frame is unwrapped into columns across the projected limb; in each the outermost
significant rise of brightness inwards is taken to a fraction of a pixel.  The profile of an
exponential atmosphere, 1 - exp(-exp(-(h - h0)/H)), rises fastest at h0, but blurred its peak
moves outwards, towards the mean of the Gumbel distribution; that shift is taken off.
"""

import dataclasses
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.images import Frame
from estimator.limb_geometry import Limb
from planner.arrays import Array

_SMOOTHING_M = 5.0e3
LENS_BLUR_PX = 0.7
_MAX_COLUMNS = 640
_COARSE = 2880
_MARGIN_PX = 4.0
_APART = 6
_SIGNIFICANT = 6.0
_SHARE_OF_PEAK = 0.25
_SHOULDER_M = np.arange(2.5e3, 21e3, 2.5e3)  # within the edge, where the limb grows bright
_STEP_OF_NOISE = 0.3  # a file's smallest step, as noise: 1/sqrt(12)


@dataclass(frozen=True)
class LimbPoints:
    """The limb as one camera shows it, along the columns where it should be visible.

    found (n,): columns with an edge; the other arrays have an entry for every column, and
    mean something only where found.  ray_body (n, 3): towards the limb.  bent_body (n, 3, 2): how
    it changes with 1-sigma of the lens's focal length and distortion.  sigma_rad (n,): noise
    of the edge alone.  width_m (n,): 1-sigma width of the edge at the limb.  contrast (n,):
    (within - beyond) / (within + beyond).  behind (n,): brightness 45 km further in, or at the
    window's end, against the brightest on the way.  step_rad: azimuth per column.
    smooth_m: what the profiles were smoothed by, part of width_m.
    blocked (n,): the craft's own structure, or the dark, hides the column.  clipped (n,):
    saturated up to 20 km within the edge.
    """

    ray_body: Array
    bent_body: Array
    pixel: Array
    azimuth_rad: Array
    found: NDArray[np.bool_]
    blocked: NDArray[np.bool_]
    clipped: NDArray[np.bool_]
    sigma_rad: Array
    width_m: Array
    contrast: Array
    slope: Array
    behind: Array
    step_rad: float
    smooth_m: float

    def __len__(self) -> int:
        return len(self.azimuth_rad)

    def every(self, by: int) -> "LimbPoints":
        """Every so many-th column; neighbours share nearly all they know."""
        kept = {
            field.name: getattr(self, field.name)[::by]
            for field in dataclasses.fields(self)
            if field.name not in ("step_rad", "smooth_m")
        }
        return LimbPoints(**kept, step_rad=self.step_rad * by, smooth_m=self.smooth_m)

    @property
    def arc_rad(self) -> float:
        return self.step_rad * len(self)


def visible_limb(
    camera: HorizonCamera, limb: Limb, c_body_from_itrf: Array, height_m: float
) -> tuple[Array, float]:
    """Azimuths of the limb in the frame, evenly spaced, and their spacing."""
    coarse = np.linspace(0.0, 2.0 * np.pi, _COARSE, endpoint=False)
    seen = camera.sees(
        camera.pixels(limb.directions_itrf(coarse, height_m) @ c_body_from_itrf.T), _MARGIN_PX
    )
    turn_px = 2.0 * np.pi * limb.mean_radius_m / limb.range_m / camera.rad_per_px
    columns = min(_MAX_COLUMNS, max(float(np.mean(seen)) * turn_px, 1.0))
    count = max(int(np.sum(seen)), 1)
    per_coarse = max(1, round(columns / count))
    thinning = max(1, int(count / columns))
    step = 2.0 * np.pi / _COARSE / per_coarse * thinning
    inside = np.flatnonzero(seen)[::thinning] if thinning > 1 else np.flatnonzero(seen)
    within = (np.arange(per_coarse) / per_coarse - 0.5 * (per_coarse - 1) / per_coarse) * (
        2.0 * np.pi / _COARSE
    )
    # Start where the arc does, so that neighbours in the array are neighbours on the limb.
    gaps = np.flatnonzero(~seen)
    start = gaps[-1] + 1 if len(gaps) else 0
    inside = (np.sort((inside - start) % _COARSE) + start) % _COARSE
    return (coarse[inside][:, None] + within).ravel(), step


def find_limb(
    frame: Frame,
    camera: HorizonCamera,
    limb: Limb,
    c_body_from_itrf: Array,
    height_m: float,
    window_rad: float,
    air_scale_m: float,
) -> LimbPoints:
    """The limb within a window on both sides of where the trial attitude puts it.

    air_scale_m: scale height for the blur's shift; 0 for a body without air.
    """
    azimuth, step_rad = visible_limb(camera, limb, c_body_from_itrf, height_m)
    reach_m = limb.touch_range_m(height_m)
    rise_m = 10e3 if reach_m < 5e6 else 2e-3 * reach_m
    foot, head = (
        camera.pixels(limb.directions_itrf(azimuth, height_m + h) @ c_body_from_itrf.T)
        for h in (-rise_m, rise_m)
    )
    outward = head - foot
    length = np.linalg.norm(outward, axis=1)
    good = np.isfinite(length) & (length > 0.0)
    azimuth, foot, head = azimuth[good], foot[good], head[good]
    outward = outward[good] / length[good, None]
    m_per_px = 2.0 * rise_m / length[good]
    typical_m_per_px = float(np.median(m_per_px)) if len(azimuth) else 1.0
    if len(azimuth) < 8:
        return _no_points(step_rad)

    smooth_px = max(_SMOOTHING_M / typical_m_per_px, 0.9)
    pitch_px = float(np.clip(smooth_px / 3.0, 0.35, 2.0))
    half = int(np.ceil(max(window_rad * reach_m / typical_m_per_px, 5.0 * smooth_px) / pitch_px))
    offset = pitch_px * np.arange(-half, half + 1)
    middle = 0.5 * (foot + head)
    x = (middle[:, :1] + offset * outward[:, :1]).astype(np.float32)
    y = (middle[:, 1:] + offset * outward[:, 1:]).astype(np.float32)
    profile = cv2.remap(frame.grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    inside = _inside(frame, x, y)
    sigma = smooth_px / pitch_px
    profile = cv2.GaussianBlur(profile, (0, 0), sigmaX=sigma, sigmaY=1.2)
    rise = -np.gradient(profile, axis=1) / np.float32(pitch_px)
    rise[~inside] = 0.0
    peak, significant, noise = _outermost_peak(rise, smooth_px, frame.step)
    row = np.arange(len(peak))
    before, at, after = (rise[row, peak + k].astype(float) for k in (-1, 0, 1))
    bend = np.maximum(2.0 * at - before - after, 1e-12)
    shift = np.clip(0.5 * (after - before) / bend, -1.0, 1.0)
    position_px = offset[peak] + shift * pitch_px
    curve = bend / pitch_px**2
    width_px = np.sqrt(np.maximum(at, 0.0) / curve)
    if air_scale_m > 0.0:
        blur_m = typical_m_per_px * np.hypot(smooth_px, LENS_BLUR_PX)
        position_px = position_px - gumbel_shift(blur_m / air_scale_m) * air_scale_m / m_per_px
    found = significant & inside.mean(axis=1).astype(bool)
    pixel = middle + position_px[:, None] * outward
    ray = camera.rays_body(pixel)
    within, beyond = _sides(np.asarray(profile), peak, round(3.0 * sigma))
    inward_px = 45e3 / typical_m_per_px / pitch_px
    gap = _behind(np.asarray(profile), peak, inward_px)
    shoulder = pixel[:, None] - (_SHOULDER_M / typical_m_per_px)[:, None] * outward[:, None]
    sigma_px = np.hypot(noise / smooth_px / curve, 0.03)
    return LimbPoints(
        ray_body=ray,
        bent_body=camera.bends_body(ray, frame.decoded),
        pixel=pixel,
        azimuth_rad=azimuth,
        found=found & np.isfinite(ray[:, 0]),
        blocked=~inside[:, half],
        clipped=np.any(frame.is_saturated(shoulder), axis=1),
        sigma_rad=sigma_px * m_per_px / reach_m,
        width_m=width_px * m_per_px,
        contrast=(within - beyond) / (within + beyond + 1e-6),
        slope=at,
        behind=gap,
        step_rad=step_rad,
        smooth_m=smooth_px * typical_m_per_px,
    )


def _inside(frame: Frame, x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.bool_]:
    height, width = frame.grey.shape
    inside = (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)
    if not frame.usable.all():
        clear = cv2.erode(frame.usable.astype(np.uint8), np.ones((7, 7), np.uint8))
        inside &= cv2.remap(clear, x, y, cv2.INTER_NEAREST, borderValue=0).astype(bool)
    # A border inside the blur makes an edge of its own.
    return np.asarray(cv2.erode(inside.astype(np.uint8), np.ones((1, 7), np.uint8)).astype(bool))


def _outermost_peak(
    rise: NDArray[np.float32], smooth_px: float, step: float
) -> tuple[NDArray[np.intp], NDArray[np.bool_], float]:
    """Index of each column's outermost significant peak, whether it has one, and the noise."""
    # Neighbours far enough apart to have noise of their own share the limb's smooth profile.
    beyond = rise[:, rise.shape[1] // 2 :]
    noise = float(np.median(np.abs(beyond[_APART:] - beyond[:-_APART]))) / (0.6745 * np.sqrt(2.0))
    noise = max(noise, _STEP_OF_NOISE * step / (3.0 * smooth_px))
    inner = rise[:, 1:-1]
    top = (inner >= rise[:, :-2]) & (inner > rise[:, 2:])
    highest = inner.max(axis=1)
    reference = highest
    for _ in range(2):
        limit = np.maximum(_SIGNIFICANT * noise, _SHARE_OF_PEAK * reference)
        peaks = top & (inner > limit[:, None])
        some = peaks.any(axis=1)
        index = inner.shape[1] - 1 - np.argmax(peaks[:, ::-1], axis=1)
        picked = inner[np.arange(len(index)), index]
        # Then against the usual limb, so that a bright cloud's edge can't hide a dim limb.
        usual = float(np.median(picked[some])) if some.any() else np.inf
        reference = np.minimum(highest, 1.5 * usual)
    return np.where(some, index + 1, 1), some, noise


def _sides(profile: NDArray[np.float32], peak: NDArray[np.intp], away: int) -> tuple[Array, Array]:
    """Brightness within and beyond the edge, each (n,)."""
    row = np.arange(len(peak))
    last = profile.shape[1] - 1
    within = profile[row, np.clip(peak - away, 0, last)].astype(float)
    beyond = profile[row, np.clip(peak + away, 0, last)].astype(float)
    return within, beyond


def _behind(profile: NDArray[np.float32], peak: NDArray[np.intp], away: float) -> Array:
    """Brightness 45 km within the edge against the brightest on the way there, each (n,)."""
    column = np.arange(profile.shape[1])[None, :]
    start = np.maximum(peak - round(away), 0)
    on_the_way = (column >= start[:, None]) & (column <= peak[:, None])
    brightest = np.where(on_the_way, profile, 0.0).max(axis=1)
    there = profile[np.arange(len(peak)), start]
    return np.asarray(there / (brightest + 1e-6), dtype=float)


@cache
def _gumbel_shifts() -> tuple[Array, Array]:
    """Mode of the standard Gumbel distribution blurred by a Gaussian of each width."""
    blur = np.linspace(0.0, 6.0, 61)
    x = np.linspace(-30.0, 40.0, 7001)
    density = np.exp(-x - np.exp(-np.clip(x, -30.0, None)))
    frequency = 2.0 * np.pi * np.fft.rfftfreq(len(x), x[1] - x[0])
    spectrum = np.fft.rfft(density)
    mode = np.array(
        [
            x[np.argmax(np.fft.irfft(spectrum * np.exp(-0.5 * (frequency * b) ** 2), n=len(x)))]
            for b in blur
        ]
    )
    return blur, mode


def gumbel_shift(blur: float) -> float:
    """How far a blurred limb's steepest point moves outwards; both in scale heights."""
    return float(np.interp(blur, *_gumbel_shifts()))


def _no_points(step_rad: float) -> LimbPoints:
    none = np.zeros(0)
    no = np.zeros(0, dtype=bool)
    return LimbPoints(
        ray_body=np.zeros((0, 3)),
        bent_body=np.zeros((0, 3, 2)),
        pixel=np.zeros((0, 2)),
        azimuth_rad=none,
        found=no,
        blocked=no,
        clipped=no,
        sigma_rad=none,
        width_m=none,
        contrast=none,
        slope=none,
        behind=none,
        step_rad=step_rad,
        smooth_m=0.0,
    )
