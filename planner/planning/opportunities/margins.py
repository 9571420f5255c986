"""The margin by which each condition is met, compiled: positive where it holds."""

import math
from collections.abc import Sequence
from typing import NamedTuple, cast, get_args

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.compiled import inlined, lean
from planner.base.vectors import (
    TURN_RAD,
    Vector,
    angle_between,
    arcsin,
    dot,
    norm,
    plus,
    scaled,
    unit,
    vector_at,
)
from planner.motion.pointing.reach import (
    Arc,
    Reach,
    arcs_at,
    axes_at,
    braking,
    off_masks,
    off_plane,
    off_stop,
    off_stops,
    turn_between,
)
from planner.planning.opportunities.looks import (
    CarrierTables,
    Places,
    cells_at,
    climb,
    closeness,
    elevation,
    in_platform,
    look,
    place_at,
    platform_los,
    rests_within_cells,
    sight_at,
    sight_in,
    sun_elevation,
    to_body,
    to_sun,
    up_at,
)
from planner.planning.opportunities.request import OpportunityConditions
from planner.planning.opportunities.windows import Cause
from planner.world.targets.limb_kernel import above_limb

CAUSES = np.array(get_args(Cause))
KEPT = len(CAUSES)  # from here on what a platform keeps, as `Lookout.kept_names` has it
# Of numpy, as a kernel would be compiled anew for each of Python's.
_KINDS = cast(list[int], list(np.arange(len(CAUSES) + 5)))
(
    INTERVAL,
    ELEVATION,
    SUN,
    OFF_NADIR,
    SUN_AWAY,
    MOON_AWAY,
    REACH,
    ACROSS,
    MASK,
    RATE,
    GROUND_SAMPLE,
    GLINT,
    LIGHT,
) = _KINDS[:-5]
OF_SUN_AND_MOON = frozenset({SUN, SUN_AWAY, MOON_AWAY, GLINT, LIGHT})
# What is sought beside: where an axis is quickest, where a pair of angles can follow, and where a
# mask is far enough off to brake before it.
CLOSENESS, OFF_PLANE, MOTION_0, MOTION_1, OFF_MASK = _KINDS[-5:]


class Asked(NamedTuple):
    """Conditions, rad; NaN where not asked for.

    across_rad: of a camera's line from the plane of its track.  sample_range_m: the range over the
    sine of elevation at which a pixel is as long as it may be.  light_sign: 1 where the carrier is
    to be sunlit, -1 where eclipsed.  kinds: which margins narrow the time in sight, the cheap and
    the selective first.
    """

    sun_low_rad: float
    sun_high_rad: float
    off_nadir_rad: float
    sun_away_rad: float
    moon_away_rad: float
    across_rad: float
    sample_range_m: float
    glint_rad: float
    light_sign: float
    kinds: Indices


class WindowScene(NamedTuple):
    """The carrier, its platform's reach, what is asked, and targets.

    arc_cosines: scratch of whoever searches this scene, (8 lanes,): both pairs of angles around an
    instant, by pair and axis all sines, then all cosines.
    """

    c: CarrierTables
    g: Reach
    q: Asked
    p: Places
    arc_cosines: Array


def scene_of(c: CarrierTables, g: Reach, q: Asked, p: Places) -> WindowScene:
    return WindowScene(c, g, q, p, np.empty(8 * OPTIONS.lanes))


_NAN = math.nan
NOTHING = Asked(_NAN, _NAN, _NAN, _NAN, _NAN, _NAN, _NAN, _NAN, _NAN, np.empty(0, np.intp))


class MotionOptions(NamedTuple):
    """How closely tracks keep the limits, and what is hidden."""

    delta_s: float = 0.4  # between the five looks from which rates, accelerations, jerks are found
    within_share: float = 0.995  # of each limit: plans test the motion between rows, too
    # of motion beside the braking distance: ways around a mask are harder to find
    off_mask_s: float = 0.5
    lanes: int = 8  # instants looked at side by side, four at once; five of them count
    hidden_rad: float = math.radians(1.5)  # below the limb: refraction lifts by 1.1 deg, half a
    # disk is 0.3


OPTIONS = MotionOptions()


def asked_of(
    c: OpportunityConditions,
    causes: Sequence[Cause],
    in_space: bool,
    across_rad: float,
    pixel_rad: float,
) -> Asked:
    """Conditions as compiled code takes them; causes: that the platform adds by itself."""
    given = (
        (SUN, c.sun_elevation_min_deg, not in_space),
        (SUN, c.sun_elevation_max_deg, not in_space),
        (OFF_NADIR, c.max_off_nadir_deg, not in_space),
        (SUN_AWAY, c.sun_keep_out_deg, True),
        (MOON_AWAY, c.moon_keep_out_deg, True),
        (GLINT, c.glint_keep_out_deg, not in_space),
    )
    others = (
        (GROUND_SAMPLE, c.max_ground_sample_m, not in_space),
        (LIGHT, c.carrier_light, True),
    )
    kinds = {kind for kind, value, applies in given + others if applies and value is not None}
    kinds |= {_KINDS[CAUSES.tolist().index(cause)] for cause in causes}
    kinds |= set() if math.isnan(across_rad) else {ACROSS}
    low, high, off_nadir, sun_away, moon_away, glint = (
        math.nan if value is None else math.radians(value) for _, value, _ in given
    )
    return Asked(
        low,
        high,
        off_nadir,
        sun_away,
        moon_away,
        across_rad,
        sample_range_m=(c.max_ground_sample_m or math.nan) / pixel_rad,
        glint_rad=glint,
        light_sign={"sunlit": 1.0, "eclipsed": -1.0, None: math.nan}[c.carrier_light],
        kinds=np.array(sorted(kinds), dtype=np.intp),
    )


@inlined
def _keep_arcs(s: WindowScene, lane: int, los: Vector) -> None:
    pairs = arcs_at(s.g, los, 1.0), arcs_at(s.g, los, -1.0)
    s.arc_cosines[lane], s.arc_cosines[OPTIONS.lanes + lane] = pairs[0][0]
    s.arc_cosines[2 * OPTIONS.lanes + lane], s.arc_cosines[3 * OPTIONS.lanes + lane] = pairs[0][1]
    s.arc_cosines[4 * OPTIONS.lanes + lane], s.arc_cosines[5 * OPTIONS.lanes + lane] = pairs[1][0]
    s.arc_cosines[6 * OPTIONS.lanes + lane], s.arc_cosines[7 * OPTIONS.lanes + lane] = pairs[1][1]


@inlined
def _look_around(s: WindowScene, n: int, t_s: float) -> None:
    """Both pairs of angles at five instants, into s.arc_cosines."""
    dt = OPTIONS.delta_s
    if rests_within_cells(s.c, s.p, t_s - 2.0 * dt, t_s + 2.0 * dt):
        cells = cells_at(s.c, s.p, n, t_s)
        for lane in range(OPTIONS.lanes):
            _keep_arcs(s, lane, sight_in(s.c, cells, t_s + (lane - 2.0) * dt))
    else:
        for lane in range(5):
            _keep_arcs(s, lane, sight_at(s.c, s.p, n, t_s + (lane - 2.0) * dt))


@inlined
def _arc(s: WindowScene, first: int, lane: int) -> Arc:
    return s.arc_cosines[first + lane], s.arc_cosines[first + OPTIONS.lanes + lane]


@inlined
def _motion_margin(s: WindowScene, branch: int) -> float:
    """How far from its limits the motion along one pair of angles is, in shares of them, by the
    last look around."""
    dt, least = OPTIONS.delta_s, math.inf
    for k in range(2):
        first = (4 * branch + 2 * k) * OPTIONS.lanes
        at = _arc(s, first, 2)
        a, b = turn_between(at, _arc(s, first, 0)), turn_between(at, _arc(s, first, 1))
        d, e = turn_between(at, _arc(s, first, 3)), turn_between(at, _arc(s, first, 4))
        rate, acceleration = abs(d - b) / (2.0 * dt), abs(d + b) / dt**2
        jerk = abs(e - 2.0 * d + 2.0 * b - a) / (2.0 * dt**3)
        limit = s.g.limits[k]
        stop = off_stop(s.g, k, math.atan2(at[0], at[1])) - braking(rate, acceleration, limit)
        peak = rate + acceleration**2 / (2.0 * limit[2])
        for share in (
            stop / (0.5 * (s.g.high[k] - s.g.low[k])),
            OPTIONS.within_share - peak / limit[0],
            OPTIONS.within_share - acceleration / limit[1],
            OPTIONS.within_share - jerk / limit[2],
        ):
            if share != share:
                return -math.pi
            least = min(least, share)
    return least


@lean
def motion_margins(s: WindowScene, n: int, t_s: float) -> tuple[float, float]:
    """Of both pairs of angles, from the same looks."""
    _look_around(s, n, t_s)
    before, last = 0.0, 0.0
    for branch in range(2):  # a loop, as code is compiled for each
        before, last = last, _motion_margin(s, branch)
    return before, last


@lean
def _off_mask_margin(s: WindowScene, n: int, t_s: float) -> float:
    """How far off the masks an axis can still be braked before them."""
    dt = OPTIONS.delta_s
    before, off, after = 0.0, 0.0, 0.0
    for place in range(-1, 2):
        before, off = off, after
        after = off_masks(s.g, platform_los(s.c, s.p, n, t_s + place * dt))
    rate = abs(after - before) / (2.0 * dt)
    slowest = s.g.limits[0] if s.g.limits[0][1] <= s.g.limits[1][1] else s.g.limits[1]
    return off - braking(rate, 0.0, slowest) - OPTIONS.off_mask_s * rate


@inlined
def _along_sight(s: WindowScene, kind: int, n: int, t_s: float) -> float:
    """What hangs on the line of sight."""
    d, _, r_sat, v = look(s.c, s.p, n, t_s)
    if kind == OFF_NADIR:
        return s.q.off_nadir_rad - angle_between(d, scaled(-1.0, r_sat))
    if kind in (SUN_AWAY, MOON_AWAY):
        body = to_body(s.c, kind - SUN_AWAY, r_sat, v, t_s)
        away = angle_between(d, body) - (
            s.q.sun_away_rad if kind == SUN_AWAY else s.q.moon_away_rad
        )
        return max(away, -OPTIONS.hidden_rad - above_limb(body, r_sat, 0.0))
    los = in_platform(s.c, d, t_s)
    if kind == ACROSS:
        return s.q.across_rad - abs(math.atan2(los[1], los[2]))
    if kind == MASK:
        return off_masks(s.g, los)
    if kind == OFF_PLANE:
        return off_plane(s.g, los)
    one, two = axes_at(s.g, los)
    return max(off_stops(s.g, one), off_stops(s.g, two))


@lean
def _light_margin(s: WindowScene, kind: int, n: int, t_s: float) -> float:
    """What hangs on the length of a pixel, on the Sun's mirror image, on the carrier's sunlight."""
    r_sat = vector_at(s.c.orbit, s.c.step_s, t_s, 0)
    if kind == LIGHT:
        sun = unit(plus(vector_at(s.c.bodies, s.c.body_step_s, t_s, 0), -1.0, r_sat))
        return s.q.light_sign * above_limb(sun, r_sat, 0.0)
    place, up = place_at(s.p, n, t_s), up_at(s.p, n, t_s)
    apart = plus(r_sat, -1.0, place)
    if kind == GROUND_SAMPLE:
        range_m = norm(apart)
        return s.q.sample_range_m * dot(apart, up) / (range_m * range_m) - 1.0
    sun = to_sun(s.c, place, t_s)
    sine = dot(sun, up)
    mirrored = plus(scaled(2.0 * sine, up), -1.0, sun)
    return max(angle_between(mirrored, apart) - s.q.glint_rad, -arcsin(sine))


@lean
def _margin(s: WindowScene, kind: int, n: int, t_s: float) -> float:
    if kind == ELEVATION:
        return elevation(s.c, s.p, n, t_s) - float(s.p.resting_parameters[n, 6])
    if kind == CLOSENESS:
        return closeness(s.c, s.p, n, t_s)
    if kind == SUN:
        at = sun_elevation(s.c, s.p, n, t_s)
        low = at - s.q.sun_low_rad if s.q.sun_low_rad == s.q.sun_low_rad else TURN_RAD
        high = s.q.sun_high_rad - at if s.q.sun_high_rad == s.q.sun_high_rad else TURN_RAD
        return min(low, high)
    if kind in (MOTION_0, MOTION_1):
        _look_around(s, n, t_s)
        return _motion_margin(s, kind - MOTION_0)
    if kind == OFF_MASK:
        return _off_mask_margin(s, n, t_s)
    if kind in (GROUND_SAMPLE, GLINT, LIGHT):
        return _light_margin(s, kind, n, t_s)
    return _along_sight(s, kind, n, t_s)


@inlined
def margin(s: WindowScene, kind: int, n: int, t_s: float, rate_s: float) -> float:
    """Positive where a condition holds; greatest where what is sought is.

    rate_s: unless 0, what has the sign of its rate, by looks so much before and after.
    """
    if rate_s > 0.0 and s.p.step_s == 0.0 and kind in (ELEVATION, CLOSENESS):
        return climb(s.c, s.p, n, t_s, kind == ELEVATION)
    value = 0.0
    for side in range(-1 if rate_s > 0.0 else 1, 2, 2):
        value += side * _margin(s, kind, n, t_s + side * rate_s)
    return value
