"""Limb points in a frame, found near the limb that a trial attitude predicts.

The frame is unwrapped into columns across the projected limb; in each the outermost
significant rise of brightness inwards is taken to a fraction of a pixel.  The profile of an
exponential atmosphere, 1 - exp(-exp(-(h - h0)/H)), rises fastest at h0, but blurred its peak
moves outwards, towards the mean of the Gumbel distribution; that shift is taken off.
Where air is clean, clouds behind it are seen down to the ground and their edge may be steeper
than the air's, but in blue: there the limb is where brightness grows, for its own size, as fast as
at the peaks of the columns free of clouds.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.images import Frame, Grey
from estimator.limb.projection import LimbProjection
from planner.base.arrays import Array

LENS_BLUR_PX = 0.7


@dataclass(frozen=True, kw_only=True)
class LimbPointOptions:
    """How the limb's edge is told from noise, clouds and the sky."""

    smoothing_m: float = 5.0e3  # across the limb: less than its own width
    blur_reach: float = 3.0  # smoothing widths that a place's blur looks at
    fewest_columns: int = 8  # with a limb, for an image to be fitted
    correlated_rad: float = np.deg2rad(5.0)  # neighbours within share the limb's roughness
    apart: int = 6  # columns whose noise is their own
    significant: float = 6.0  # times the noise
    # of the steepest slope that the other columns have: less steep is no limb
    share_of_peak: float = 0.25
    behind_m: float = 45e3  # from the edge inwards, where the disc's brightness is looked at
    step_of_noise: float = 0.3  # a file's smallest step, as noise: 1/sqrt(12)
    ideal_edge_px: float = 0.1  # by which a predicted edge without noise is known
    sky_steps: int = 8  # at the strip's end, whose median is the sky's
    overexposed_share: float = 0.3  # of the columns that saturate at the limb: then the image does
    # columns free of clouds are near it: their growth of brightness for its size,
    cloudless_quantile: float = 0.9
    # and a share of it: 0.97 to 1.03 with the noise and the air's own changes along the limb, 0.6
    # to 0.9 at clouds
    cloudless_share: float = 0.86
    sure_sigma: float = 3.0  # of the noise, by which a slope must be above it
    clear_of_clouds_m: float = 6e3  # above an edge, where cloud tops don't reach
    most_drawn_m: float = 22e3  # by clouds: from the highest limbs in grey down to the ground
    separate_m: float = 6e3  # smoothed by more, clouds and the air above them are one edge


OPTIONS = LimbPointOptions()

_SHOULDER_M = np.arange(2.5e3, 21e3, 2.5e3)  # within the edge, where the limb grows bright


@dataclass(frozen=True)
class LimbPoints:
    """The limb as one camera shows it: n columns of pixels across it, evenly spaced in azimuth.

    found (n,): columns with an edge; only there do the arrays about the edge mean something.
    blocked (n,): the craft's own structure, or the dark, hides the column.
    step_rad: azimuth per column.
    Of the edge: xy_px (n, 2), ray_body (n, 3), and lens_shift_body (n, 3, 2), how the ray changes
    with 1-sigma of the lens's focal length and distortion.  exposed_s (n,): when its row was.
    sigma_rad (n,): noise of the edge alone.  drawn_m (n,): how much lower clouds had drawn
    it before it was moved back.  slope_per_px (n,): of brightness, inwards.
    width_m (n,): 1-sigma width at the limb, which holds smooth_m, what the profile was smoothed
    by.  contrast (n,): (within - beyond) / (within + beyond).  behind_ratio (n,): brightness
    45 km further in, or at the window's end, against the brightest on the way.
    clipped (n,): saturated up to 20 km within the edge.
    """

    azimuth_rad: Array
    found: NDArray[np.bool_]
    blocked: NDArray[np.bool_]
    step_rad: float
    xy_px: Array
    ray_body: Array
    lens_shift_body: Array
    exposed_s: Array
    sigma_rad: Array
    drawn_m: Array
    slope_per_px: Array
    width_m: Array
    smooth_m: float
    contrast: Array
    behind_ratio: Array
    clipped: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.azimuth_rad)

    @property
    def arc_rad(self) -> float:
        return self.step_rad * len(self)

    @property
    def is_overexposed(self) -> bool:
        """Whether much of the limb found is saturated."""
        if not np.any(self.found):
            return False
        return float(np.mean(self.clipped[self.found])) > OPTIONS.overexposed_share

    def every(self, by: int) -> "LimbPoints":
        """Every so many-th column; neighbours share nearly all they know."""
        fields = vars(self).items()
        arrays: dict[str, Any] = {k: v[::by] for k, v in fields if isinstance(v, np.ndarray)}
        return replace(self, **arrays, step_rad=self.step_rad * by)

    def taken_by(self, camera: HorizonCamera) -> "LimbPoints":
        """As if lens and shutter were known as this camera's are."""
        return replace(
            self,
            lens_shift_body=camera.lens_shift_body(self.ray_body),
            exposed_s=camera.exposed_s(self.xy_px),
        )

    def without_edges(self) -> "LimbPoints":
        """As if nothing had been found in any column."""
        return replace(self, found=np.zeros(len(self), dtype=bool))

    def columns_per_patch(self) -> Array:
        """How many found columns share each column's 5 deg of azimuth, itself included, (n,)."""
        reach = max(int(OPTIONS.correlated_rad / self.step_rad), 1)
        count = np.convolve(self.found.astype(float), np.ones(reach), mode="same")
        return np.maximum(count[: len(self)], 1.0)


def ideal_points(
    camera: HorizonCamera,
    ray_body: Array,
    azimuth_rad: Array,
    lit: NDArray[np.bool_],
    step_rad: float,
) -> LimbPoints:
    """Sharp, unsaturated edges exactly along rays (n, 3), found where lit."""
    one = np.ones(len(azimuth_rad))
    no = np.zeros(len(azimuth_rad), dtype=bool)
    return LimbPoints(
        azimuth_rad=azimuth_rad,
        found=lit,
        blocked=no,
        step_rad=step_rad,
        xy_px=camera.pixels(ray_body),
        ray_body=ray_body,
        lens_shift_body=camera.lens_shift_body(ray_body),
        exposed_s=camera.exposed_s(np.nan_to_num(camera.pixels(ray_body))),
        sigma_rad=OPTIONS.ideal_edge_px * camera.rad_per_px * one,
        drawn_m=0.0 * one,
        slope_per_px=one,
        width_m=one,
        smooth_m=0.0,
        contrast=one,
        behind_ratio=one,
        clipped=no,
    )


def no_points(camera: HorizonCamera) -> LimbPoints:
    return ideal_points(camera, np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=bool), 0.0)


def find_limb(
    frame: Frame, projection: LimbProjection, window_rad: float, air_scale_m: float
) -> LimbPoints:
    """The limb within a window on both sides of its projection.

    air_scale_m: scale height for the blur's shift; 0 for a body without air.
    """
    camera = projection.camera
    reach_m = projection.limb.touch_range_m(projection.height_m)
    azimuth_rad, step_rad = projection.visible()
    half_m = 10e3 if reach_m < 5e6 else 2e-3 * reach_m
    low_px, high_px, good = projection.span_px(azimuth_rad, half_m)
    if np.sum(good) < OPTIONS.fewest_columns:
        return no_points(camera)
    strip = _unwrap(frame, low_px[good], high_px[good], half_m, window_rad * reach_m)
    edge = _find_edge(strip, frame.step)
    if air_scale_m > 0.0 and not frame.blue:
        edge = _above_clouds(edge, strip)
    from_middle_px = edge.from_middle_px
    if air_scale_m > 0.0:
        blur_m = strip.typical_m_per_px * np.hypot(strip.smooth_px, LENS_BLUR_PX)
        shift_m = gumbel_shift(blur_m / air_scale_m) * air_scale_m
        from_middle_px = from_middle_px - shift_m / strip.m_per_px
    xy_px = strip.middle_px + from_middle_px[:, None] * strip.outward_unit
    ray_body = camera.rays_body(xy_px)
    inwards_px = (_SHOULDER_M / strip.typical_m_per_px)[:, None]
    shoulder_px = xy_px[:, None] - inwards_px * strip.outward_unit[:, None]
    seen = strip.inside.mean(axis=1).astype(bool)
    return LimbPoints(
        azimuth_rad=azimuth_rad[good],
        found=edge.significant & seen & np.isfinite(ray_body[:, 0]),
        blocked=~strip.inside[:, strip.inside.shape[1] // 2],
        step_rad=step_rad,
        xy_px=xy_px,
        ray_body=ray_body,
        lens_shift_body=camera.lens_shift_body(ray_body),
        exposed_s=camera.exposed_s(xy_px),
        sigma_rad=edge.sigma_px * strip.m_per_px / reach_m,
        drawn_m=edge.drawn_px * strip.m_per_px,
        slope_per_px=edge.slope_per_px,
        width_m=edge.width_px * strip.m_per_px,
        smooth_m=strip.smooth_px * strip.typical_m_per_px,
        contrast=_contrast(strip, edge.peak),
        behind_ratio=_behind_ratio(strip, edge.peak),
        clipped=np.any(frame.is_saturated(shoulder_px), axis=1),
    )


@dataclass(frozen=True)
class _Strip:
    """The frame unwrapped: n columns across the limb's projection, outwards in m steps.

    middle_px (n, 2): on the projection.  outward_unit (n, 2): the column's way in the image.
    offset_px (m,): from the middle, pitch_px apart.  level (n, m): brightness, smoothed by
    smooth_px along the columns.  inside (n, m): in the frame, and nothing hides it.
    searched: the steps whose blur the strip's ends don't reach.
    """

    middle_px: Array
    outward_unit: Array
    m_per_px: Array
    typical_m_per_px: float
    offset_px: Array
    pitch_px: float
    smooth_px: float
    searched: slice
    level: Grey
    inside: NDArray[np.bool_]


@dataclass(frozen=True)
class _Edge:
    """Each column's outermost significant edge; peak (n,): its index along the strip.

    rise_per_px (n, m): of brightness inwards, along the strip.  noise_per_px: its 1-sigma.
    drawn_px (n,): how far inwards clouds had drawn it.
    """

    peak: NDArray[np.intp]
    significant: NDArray[np.bool_]
    from_middle_px: Array
    sigma_px: Array
    slope_per_px: Array
    width_px: Array
    rise_per_px: Grey
    noise_per_px: float
    drawn_px: Array


def _unwrap(frame: Frame, low_px: Array, high_px: Array, half_m: float, window_m: float) -> _Strip:
    """The frame along columns through pixels (n, 2) half_m below and above the limb, up to
    window_m on both sides of it."""
    length_px = np.linalg.norm(high_px - low_px, axis=1)
    middle_px, outward_unit = 0.5 * (low_px + high_px), (high_px - low_px) / length_px[:, None]
    m_per_px = 2.0 * half_m / length_px
    typical_m_per_px = float(np.median(m_per_px))
    smooth_px = max(OPTIONS.smoothing_m / typical_m_per_px, 0.9)
    pitch_px = float(np.clip(smooth_px / 3.0, 0.35, 2.0))
    blurred = int(np.ceil(OPTIONS.blur_reach * smooth_px / pitch_px))
    # Of a pitch of a third 5 smoothing widths are 15, which rounding must not make 16.
    steps = int(np.ceil(max(window_m / typical_m_per_px, 5.0 * smooth_px) / pitch_px - 1e-6))
    steps += blurred
    offset_px = pitch_px * np.arange(-steps, steps + 1.0)
    xy_px = middle_px[:, None] + offset_px[:, None] * outward_unit[:, None]
    x_px, y_px = np.moveaxis(xy_px, 2, 0).astype(np.float32, order="C")
    level = cv2.remap(frame.grey, x_px, y_px, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    level = cv2.GaussianBlur(level, (0, 0), sigmaX=smooth_px / pitch_px, sigmaY=1.2)
    return _Strip(
        middle_px=middle_px,
        outward_unit=outward_unit,
        m_per_px=m_per_px,
        typical_m_per_px=typical_m_per_px,
        offset_px=offset_px,
        pitch_px=pitch_px,
        smooth_px=smooth_px,
        searched=slice(blurred, -blurred),
        level=np.asarray(level, dtype=np.float32),
        inside=_inside(frame, x_px, y_px, blurred),
    )


def _inside(frame: Frame, x_px: Grey, y_px: Grey, blurred: int) -> NDArray[np.bool_]:
    height, width = frame.grey.shape
    inside = (x_px >= 0) & (x_px <= width - 1) & (y_px >= 0) & (y_px <= height - 1)
    if not frame.usable.all():
        clear = cv2.erode(frame.usable.astype(np.uint8), np.ones((7, 7), np.uint8))
        inside &= cv2.remap(clear, x_px, y_px, cv2.INTER_NEAREST, borderValue=0).astype(bool)
    # A border or the strip's end inside the blur makes an edge of its own, along the projection.
    inside[:, [0, -1]] = False
    kernel = np.ones((1, 2 * blurred + 1), np.uint8)
    return np.asarray(cv2.erode(inside.astype(np.uint8), kernel).astype(bool))


def _find_edge(strip: _Strip, step: float) -> _Edge:
    """Where brightness rises fastest inwards, by a parabola through the peak of its slope.

    step: the frame's smallest difference of brightness that tells.
    """
    rise = -np.gradient(strip.level, axis=1) / np.float32(strip.pitch_px)
    peak, significant, noise_per_px = _outermost_peak(rise, strip, step)
    row = np.arange(len(peak))
    before, at, after = (rise[row, peak + k].astype(float) for k in (-1, 0, 1))
    bend = np.maximum(2.0 * at - before - after, 1e-12)
    shift = np.clip(0.5 * (after - before) / bend, -1.0, 1.0)
    curvature = bend / strip.pitch_px**2
    return _Edge(
        peak=peak,
        significant=significant,
        from_middle_px=strip.offset_px[peak] + shift * strip.pitch_px,
        sigma_px=np.hypot(noise_per_px / strip.smooth_px / curvature, 0.03),
        slope_per_px=at,
        width_px=np.sqrt(np.maximum(at, 0.0) / curvature),
        rise_per_px=rise,
        noise_per_px=noise_per_px,
        drawn_px=np.zeros(len(peak)),
    )


def _above_clouds(edge: _Edge, strip: _Strip) -> _Edge:
    """The edges, those that clouds have drawn inwards back where the air's is.

    Brightness grows by the same share of itself a metre where air is as deep, however bright.
    """
    if not edge.significant.any() or strip.smooth_px * strip.typical_m_per_px > OPTIONS.separate_m:
        return edge
    row, last = np.arange(len(edge.peak)), strip.level.shape[1] - 1
    beyond_level = strip.level[:, strip.searched][:, -OPTIONS.sky_steps :]
    sky = np.median(beyond_level, axis=1, keepdims=True)
    light = strip.level - sky
    growth_per_px = edge.rise_per_px / np.maximum(light, edge.noise_per_px)
    at_peak = growth_per_px[row, edge.peak]
    usual = np.quantile(at_peak[edge.significant], OPTIONS.cloudless_quantile)
    at_edge = np.maximum(light[row, edge.peak], edge.noise_per_px)
    surely = at_peak + OPTIONS.sure_sigma * edge.noise_per_px / at_edge
    drawn = edge.significant & (surely < OPTIONS.cloudless_share * usual)
    free = edge.significant & ~drawn
    # Further in, and so brighter; dark structure may grow as slowly.
    drawn &= at_edge > np.median(at_edge[free])
    # As far out that blurred clouds no longer add to the air's light.
    steps = round(OPTIONS.clear_of_clouds_m / strip.typical_m_per_px / strip.pitch_px)
    least = np.median(growth_per_px[row, np.minimum(edge.peak + steps, last)][free])
    beyond = np.arange(last + 1) > edge.peak[:, None]
    reaches = beyond & (growth_per_px >= least) & strip.inside
    index = np.argmax(reaches, axis=1)
    above, below = growth_per_px[row, index], growth_per_px[row, index - 1]
    part = np.clip((above - least) / np.maximum(above - below, 1e-9), 0.0, 1.0)
    from_middle_px = strip.offset_px[index] - strip.pitch_px * (part + steps)
    # Clouds only draw inwards, and not below the ground.
    moved_m = (from_middle_px - edge.from_middle_px) * strip.m_per_px
    drawn &= reaches.any(axis=1) & (moved_m > 0.0) & (moved_m < OPTIONS.most_drawn_m)
    peak = np.where(drawn, np.maximum(index - steps, 0), edge.peak)
    by_px = np.where(drawn, from_middle_px - edge.from_middle_px, 0.0)
    return replace(
        edge,
        peak=peak,
        from_middle_px=edge.from_middle_px + by_px,
        drawn_px=by_px,
        slope_per_px=edge.rise_per_px[row, peak].astype(float),
    )


def _outermost_peak(
    rise: Grey, strip: _Strip, step: float
) -> tuple[NDArray[np.intp], NDArray[np.bool_], float]:
    """Index of each column's outermost significant peak, whether it has one, and the noise."""
    # Neighbours far enough apart to have noise of their own share the limb's smooth profile.
    beyond = rise[:, rise.shape[1] // 2 : strip.searched.stop]
    noise = float(np.median(np.abs(beyond[OPTIONS.apart :] - beyond[: -OPTIONS.apart]))) / (
        0.6745 * np.sqrt(2.0)
    )
    noise = max(noise, OPTIONS.step_of_noise * step / (3.0 * strip.smooth_px))
    inner = np.where(strip.inside, rise, 0.0)[:, 1:-1]
    top = (inner >= rise[:, :-2]) & (inner > rise[:, 2:])
    highest = inner.max(axis=1)
    reference = highest
    for _ in range(2):
        limit = np.maximum(OPTIONS.significant * noise, OPTIONS.share_of_peak * reference)
        peaks = top & (inner > limit[:, None])
        some = peaks.any(axis=1)
        index = inner.shape[1] - 1 - np.argmax(peaks[:, ::-1], axis=1)
        picked = inner[np.arange(len(index)), index]
        # Then against the usual limb, so that a bright cloud's edge can't hide a dim limb.
        usual = float(np.median(picked[some])) if some.any() else np.inf
        reference = np.minimum(highest, 1.5 * usual)
    return np.where(some, index + 1, 1), some, noise


def _contrast(strip: _Strip, peak: NDArray[np.intp]) -> Array:
    """Brightness three smoothing widths within the edge against as far beyond, (n,)."""
    row, last = np.arange(len(peak)), strip.level.shape[1] - 1
    away = round(3.0 * (strip.smooth_px / strip.pitch_px))
    within = strip.level[row, np.clip(peak - away, 0, last)].astype(float)
    beyond = strip.level[row, np.clip(peak + away, 0, last)].astype(float)
    return np.asarray((within - beyond) / (within + beyond + 1e-6))


def _behind_ratio(strip: _Strip, peak: NDArray[np.intp]) -> Array:
    """Brightness 45 km within the edge against the brightest on the way there, (n,)."""
    inwards = round(OPTIONS.behind_m / strip.typical_m_per_px / strip.pitch_px)
    column = np.arange(strip.level.shape[1])[None, :]
    start = np.maximum(peak - inwards, 0)
    on_the_way = (column >= start[:, None]) & (column <= peak[:, None])
    brightest = np.where(on_the_way, strip.level, 0.0).max(axis=1)
    there = strip.level[np.arange(len(peak)), start]
    return np.asarray(there / (brightest + 1e-6), dtype=float)


@cache
def _gumbel_shifts() -> tuple[Array, Array]:
    """Mode of the standard Gumbel distribution blurred by a Gaussian of each width."""
    blur = np.linspace(0.0, 6.0, 61)
    x = np.linspace(-30.0, 40.0, 7001)
    density = np.exp(-x - np.exp(-np.clip(x, -30.0, None)))
    frequency = 2.0 * np.pi * np.fft.rfftfreq(len(x), x[1] - x[0])
    spectrum = np.fft.rfft(density)
    mode = [
        x[np.argmax(np.fft.irfft(spectrum * np.exp(-0.5 * (frequency * b) ** 2), n=len(x)))]
        for b in blur
    ]
    return blur, np.array(mode)


def gumbel_shift(blur: float) -> float:
    """How far a blurred limb's steepest point moves outwards; both in scale heights."""
    return float(np.interp(blur, *_gumbel_shifts()))
