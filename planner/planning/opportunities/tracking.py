"""A body that keeps its camera on a target, compiled: how it lies, turns and keeps away."""

import math
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S
from planner.base.compiled import compiled, inlined, lean, nested
from planner.base.vectors import (
    Powers,
    Vector,
    angle_between,
    column_at,
    cross,
    dot,
    motion_at,
    norm,
    plus,
    scaled,
    unit,
    vector_at,
    vector_of,
)
from planner.planning.opportunities.looks import CarrierTables, Places, look, to_body, up_at
from planner.planning.opportunities.margins import KEPT, RATE, WindowScene
from planner.planning.opportunities.sweep import OPTIONS as SWEEP
from planner.planning.opportunities.sweep import Found, found_of
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S
from planner.world.targets.limb_kernel import above_limb

ROLLS = ("nearest", "lines_across_track", "lines_across_motion", "sun_side", "azimuth")
NEAREST, ACROSS_TRACK, ACROSS_MOTION, SUN_SIDE, AZIMUTH = range(len(ROLLS))
CELESTIAL = ("sun", "moon", "limb", "glint", "nadir", "within_limb", "inertial")
SUN, _, LIMB, GLINT, NADIR, WITHIN_LIMB, INERTIAL = range(len(CELESTIAL))
Rows3 = tuple[Vector, Vector, Vector]


class TrackingOptions(NamedTuple):
    """How closely a body's motion along a target keeps its limits."""

    delta_s: float = 0.4  # between the five looks from which rates, accelerations, jerks are found
    within_share: float = 0.995  # of each limit: plans test the motion between rows, too
    within_rad: float = 2e-5  # of an exclusion: plans keep half of it between rows
    step_s: float = 1.0  # between looks: no attitude comes and goes in less
    # The margin of star trackers has a kink where one takes over from another: what a body at
    # 5 deg/s may lose of it on the way there, and looks so close that none is lost.
    nearing_rad_s: float = 0.1
    near_step_s: float = COMMAND_STEP_S


OPTIONS = TrackingOptions()


class Tracking(NamedTuple):
    """How a body lies while it looks, what it keeps away from, and what motion it can do.

    roll: the rule, of `ROLLS`; -1 for what is no body.  senses: 1, or 2 where the camera images
    both ways.  azimuth_rad: of the rule of that name.  body_from_triad: columns (rows here) are
    the boresight, across it towards what the rule turns, and their product, in body axes.
    kept_parameters: (m, 5), a direction's parts along these, what it keeps away from (of
    `CELESTIAL`, and the inertial ones numbered on) and by how much, rad; in the end three rows of
    each star tracker.
    needed: star trackers that must see stars.  trackers: that there are.
    limits: of rate, acceleration and jerk by body axis; is_by_axis: else of the lengths.
    settle_s: on the track before a session.
    disks_m: radii of Sun and Moon.  hidden_rad: below the limb, where these count no more.
    idle: boresight and what the rule turns in the idle attitude, ITRF.  glint: its direction,
    ITRF, and by how much it counts, rad; then each inertial direction.
    """

    roll: int = -1
    senses: int = 0
    azimuth_rad: float = 0.0
    body_from_triad: Rows3 = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    kept_parameters: Array = np.empty((0, 5))
    needed: int = 0
    trackers: int = 0
    limits: Rows3 = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    is_by_axis: bool = False
    settle_s: float = 0.0
    disks_m: tuple[float, float] = (0.0, 0.0)
    hidden_rad: float = 0.0
    idle_step_s: float = 1.0
    idle: Powers = np.empty((0, 6, 6))
    glint_step_s: float = 1.0
    glint: Powers = np.empty((0, 6, 4))


NO_BODY = Tracking()


@lean
def _seen(c: CarrierTables, p: Places, n: int, t_s: float) -> tuple[Vector, Vector, Vector]:
    """As `look`, as a call: direction of a target, position and velocity of the carrier."""
    d, _, r_sat, v = look(c, p, n, t_s)
    return d, r_sat, v


@lean
def _to_body(c: CarrierTables, body: int, r_sat: Vector, v: Vector, t_s: float) -> Vector:
    """The same, as a call."""
    return to_body(c, body, r_sat, v, t_s)


@inlined
def _carried_round(v: Vector, later_s: float) -> Vector:
    """A vector of ITRF so much later, in the axes of now that don't turn with the Earth."""
    c, s = math.cos(OMEGA_EARTH_RAD_S * later_s), math.sin(OMEGA_EARTH_RAD_S * later_s)
    return c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]


@inlined
def _carried_over(v: Vector, a: Vector, b: Vector) -> Vector:
    """A vector turned as the least rotation turns unit vector a onto b."""
    both = plus(a, 1.0, b)
    return plus(plus(v, 2.0 * dot(a, v), b), -dot(both, v) / (1.0 + dot(a, b)), both)


@inlined
def _carried_on(v: Vector, a: Vector, b: Vector, later_s: float) -> Vector:
    """The same, ITRF, where that stands still in inertial space: unit vector b so much later."""
    return _carried_round(_carried_over(v, a, _carried_round(b, later_s)), -later_s)


@lean
def aside_at(
    b: Tracking,
    c: CarrierTables,
    p: Places,
    n: int,
    t_s: float,
    d: Vector,
    r_sat: Vector,
    v: Vector,
) -> Vector:
    """What the roll rule turns a body direction towards, of any length, ITRF.

    "nearest" is taken for the attitude nearest to the idle one of that instant.
    """
    if b.roll == ACROSS_TRACK:
        return motion_at(c.orbit, c.step_s, t_s)[1]
    if b.roll == ACROSS_MOTION:
        return motion_at(p.track, p.step_s, t_s - p.begins_s[n])[1]
    if b.roll == SUN_SIDE:
        return _to_body(c, SUN, r_sat, v, t_s)
    if b.roll == AZIMUTH:
        up = up_at(p, n, t_s)
        east = unit((-up[1], up[0], 0.0))
        north = cross(up, east)
        return plus(scaled(math.sin(b.azimuth_rad), east), math.cos(b.azimuth_rad), north)
    boresight = unit(vector_at(b.idle, b.idle_step_s, t_s, 0))
    return _carried_over(vector_at(b.idle, b.idle_step_s, t_s, 3), boresight, d)


@inlined
def _across(aside: Vector, d: Vector) -> Vector:
    return unit(plus(aside, -dot(aside, d), d))


@lean
def _apart(
    b: Tracking, c: CarrierTables, m: int, d: Vector, aside: Vector, r_sat: Vector, v: Vector,
    t_s: float
) -> float:  # fmt: skip
    """By how much a direction that keeps away is farther than it must be; positive, too, where
    there is nothing to keep away from."""
    parts, across = vector_of(b.kept_parameters, m, 0), _across(aside, d)
    seen = plus(plus(scaled(parts[0], d), parts[1], across), parts[2], cross(d, across))
    which, least_rad = int(b.kept_parameters[m, 3]), float(b.kept_parameters[m, 4])
    if which == LIMB:
        return above_limb(seen, r_sat, 0.0) - least_rad
    if which == WITHIN_LIMB:
        return least_rad - above_limb(seen, r_sat, 0.0)
    if which == NADIR:
        return angle_between(seen, scaled(-1.0, r_sat)) - least_rad
    if which >= INERTIAL:
        star = vector_at(b.glint, b.glint_step_s, t_s, 4 + 3 * (which - INERTIAL))
        return angle_between(seen, star) - least_rad
    if which == GLINT:
        counts = column_at(b.glint, b.glint_step_s, t_s, 3)
        glint = vector_at(b.glint, b.glint_step_s, t_s, 0)
        return max(angle_between(seen, glint) - least_rad, -counts)
    body = _to_body(c, which, r_sat, v, t_s)
    away_m = norm(plus(vector_at(c.bodies, c.body_step_s, t_s, 3 * which), -1.0, r_sat))
    away = angle_between(seen, body) - math.asin(b.disks_m[which] / away_m) - least_rad
    return max(away, -b.hidden_rad - above_limb(body, r_sat, 0.0))


@lean
def _kept(
    b: Tracking, c: CarrierTables, d: Vector, aside: Vector, r_sat: Vector, v: Vector, t_s: float
) -> float:
    """The least margin of all exclusions, and of the last star tracker that is needed."""
    least, plain = math.inf, len(b.kept_parameters) - 3 * b.trackers
    for m in range(plain):
        least = min(least, _apart(b, c, m, d, aside, r_sat, v, t_s))
    value, place = math.inf, -1
    for _ in range(b.needed):  # the best, then the second best, ...
        best, at = -math.inf, b.trackers
        for number in range(b.trackers):
            apart = math.inf
            for m in range(plain + 3 * number, plain + 3 * number + 3):
                apart = min(apart, _apart(b, c, m, d, aside, r_sat, v, t_s))
            is_left = apart < value or (apart == value and number > place)
            if is_left and apart > best:
                best, at = apart, number
        value, place = best, at
    least = min(least, value)
    return least if least == least else -math.pi


@lean
def _turn(d0: Vector, across0: Vector, d: Vector, across: Vector) -> Vector:
    """The rotation vector, in parts along the first triad, that carries it onto the second."""
    third0, third = cross(d0, across0), cross(d, across)
    x = 0.5 * (dot(third0, across) - dot(across0, third))
    y = 0.5 * (dot(d0, third) - dot(third0, d))
    z = 0.5 * (dot(across0, d) - dot(d0, across))
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (dot(d0, d) + dot(across0, across) + dot(third0, third) - 1.0)
    scale = math.atan2(sine, cosine) / sine if sine > 1e-12 else 1.0
    return scale * x, scale * y, scale * z


@inlined
def _used(b: Tracking, order: int, triad: Vector) -> float:
    """The share of a limit that a vector takes, given along the triad."""
    rows = b.body_from_triad
    body = plus(plus(scaled(triad[0], rows[0]), triad[1], rows[1]), triad[2], rows[2])
    limit = b.limits[order]
    x, y, z = body[0] / limit[0], body[1] / limit[1], body[2] / limit[2]
    if b.is_by_axis:
        return max(abs(x), abs(y), abs(z))
    return math.sqrt(x * x + y * y + z * z)


@lean
def _motion(
    b: Tracking, c: CarrierTables, p: Places, n: int, t_s: float, sign: float, aside: Vector,
    orders: int
) -> float:  # fmt: skip
    """How far from its limits of rate, or of these orders, the motion is, in shares of them.

    aside: of this instant; only "nearest" carries it on.
    """
    dt = OPTIONS.delta_s
    d0 = _seen(c, p, n, t_s)[0]
    across0 = _across(aside, d0)
    far_before = before = after = far_after = (0.0, 0.0, 0.0)
    for place in range(-2, 3):
        if place == 0:
            continue
        later_s = place * dt
        d, r_sat, v = _seen(c, p, n, t_s + later_s)
        there = _carried_round(d, later_s)
        if b.roll == NEAREST:
            across = _across(_carried_over(across0, d0, there), there)
        else:
            then = scaled(sign, aside_at(b, c, p, n, t_s + later_s, d, r_sat, v))
            across = _across(_carried_round(then, later_s), there)
        far_before, before, after = before, after, far_after
        far_after = _turn(d0, across0, there, across)
    rate = scaled(0.5 / dt, plus(after, -1.0, before))
    acceleration = scaled(1.0 / dt**2, plus(after, 1.0, before))
    used = _used(b, 0, rate)
    if orders > 1:
        jerk = plus(plus(far_after, -1.0, far_before), -2.0, plus(after, -1.0, before))
        jerk = plus(scaled(0.5 / dt**3, jerk), -0.5, cross(rate, acceleration))
        used = max(used, _used(b, 1, acceleration), _used(b, 2, jerk))
    return 1.0 - used if used == used else -math.pi


@lean
def _ways_margins(
    b: Tracking, c: CarrierTables, p: Places, n: int, t_s: float
) -> tuple[float, float]:
    """Of the sense of the rule that does better, by how much it keeps the exclusions and its rate;
    and of all senses the exclusions alone."""
    d, r_sat, v = _seen(c, p, n, t_s)
    aside = aside_at(b, c, p, n, t_s, d, r_sat, v)
    best, clear = -math.pi, -math.pi
    for sense in range(b.senses):
        sign = 1.0 - 2.0 * sense
        kept = _kept(b, c, d, scaled(sign, aside), r_sat, v, t_s)
        best = max(best, min(kept, _motion(b, c, p, n, t_s, sign, scaled(sign, aside), 1)))
        clear = max(clear, kept)
    return best, clear


@lean
def session_margin_rad(
    b: Tracking, c: CarrierTables, p: Places, n: int, t_s: float, sign: float, aside: Vector,
    off_nadir_rad: float
) -> float:  # fmt: skip
    """How far exclusions are away, where a session may be there: with what plans keep between rows,
    and off the nadir.  Negative where it may not."""
    d, r_sat, v = _seen(c, p, n, t_s)
    if not p.in_space:
        off = angle_between(d, scaled(-1.0, r_sat))
        if not off + OPTIONS.within_rad < off_nadir_rad:
            return -math.pi
    kept = _kept(b, c, d, aside, r_sat, v, t_s)
    if not kept > OPTIONS.within_rad:
        return -math.pi
    is_moved = _motion(b, c, p, n, t_s, sign, aside, len(b.limits)) > 1.0 - OPTIONS.within_share
    return kept if is_moved else -math.pi


@lean
def kept_between(
    b: Tracking, c: CarrierTables, p: Places, n: int, span_s: tuple[float, float], sign: float,
    carried: tuple[bool, Vector, Vector], least_rad: float
) -> bool:  # fmt: skip
    """Whether exclusions are kept between two looks, too.

    carried: whether the attitude is carried on from boresight and +X at the first, or follows from
    the rule and its sense.  least_rad: of their margins at both.
    """
    length_s = span_s[1] - span_s[0]
    if least_rad > 0.5 * OPTIONS.nearing_rad_s * length_s:
        return True
    is_carried, boresight, aside = carried
    looks = math.ceil(length_s / OPTIONS.near_step_s - 1e-6)
    for k in range(1, looks):
        later_s = k / looks * length_s
        t_s = span_s[0] + later_s
        d, r_sat, v = _seen(c, p, n, t_s)
        if is_carried:
            lain = _carried_on(aside, boresight, d, later_s)
        else:
            lain = scaled(sign, aside_at(b, c, p, n, t_s, d, r_sat, v))
        if not _kept(b, c, d, lain, r_sat, v, t_s) > OPTIONS.within_rad:
            return False
    return True


@lean
def _longest_run(
    b: Tracking, c: CarrierTables, p: Places, n: int, sense: int, span_s: tuple[float, float],
    off_nadir_rad: float
) -> tuple[float, float]:  # fmt: skip
    """The longest part found of a span over which one sense of the rule is held, or NaN.

    "nearest" is nearest to the idle attitude as the part begins, and then carried on.
    """
    cells = max(math.ceil((span_s[1] - span_s[0]) / OPTIONS.step_s), 1)
    held_a, held_b, longest, begins_s = math.nan, math.nan, 0.0, math.nan
    before_s, before, aside = span_s[0], (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    sign, far_rad = 1.0 - 2.0 * sense, 0.0
    for k in range(cells + 1):
        share = k / cells
        t_s = (1.0 - share) * span_s[0] + share * span_s[1]
        d, r_sat, v = _seen(c, p, n, t_s)
        was_rad, was_aside = far_rad, aside
        for is_new in range(2):  # carried on, or begun anew where that is no more held
            if is_new == 0 and (b.roll != NEAREST or begins_s != begins_s):
                continue
            if is_new:
                aside = scaled(sign, aside_at(b, c, p, n, t_s, d, r_sat, v))
            else:
                aside = _carried_on(aside, before, d, t_s - before_s)
            far_rad = session_margin_rad(b, c, p, n, t_s, sign, aside, off_nadir_rad)
            is_held = far_rad > 0.0
            if is_held and begins_s == begins_s:
                carried = b.roll == NEAREST, before, was_aside
                least_rad = min(was_rad, far_rad)
                if not kept_between(b, c, p, n, (before_s, t_s), sign, carried, least_rad):
                    begins_s, is_held = math.nan, is_new == 1
            if is_held and (begins_s != begins_s or (is_new and b.roll == NEAREST)):
                begins_s = t_s
            if is_held:
                break
            begins_s = math.nan
        if t_s - begins_s > longest:
            held_a, held_b, longest = begins_s, t_s, t_s - begins_s
        before_s, before = t_s, d
    return held_a, held_b


@lean
def _unkept(b: Tracking, c: CarrierTables, p: Places, n: int, t_s: float) -> int:
    """The first exclusion that the better sense of the rule doesn't keep then, numbered on after
    the causes; the star trackers come after all of them."""
    d, r_sat, v = _seen(c, p, n, t_s)
    aside, best = aside_at(b, c, p, n, t_s, d, r_sat, v), -math.inf
    plain = len(b.kept_parameters) - 3 * b.trackers
    which = plain
    for sense in range(b.senses):
        lain = scaled(1.0 - 2.0 * sense, aside)
        kept = _kept(b, c, d, lain, r_sat, v, t_s)
        if kept > best:
            best, which = kept, plain
            for m in range(plain - 1, -1, -1):
                if not _apart(b, c, m, d, lain, r_sat, v, t_s) > 0.0:
                    which = m
    return KEPT + which


@lean
def _edge_between(
    b: Tracking, c: CarrierTables, p: Places, n: int, out_s: float, in_s: float
) -> tuple[float, int]:
    """Where the margins change sign, from outside to inside, and which of them does."""
    while abs(in_s - out_s) > SWEEP.edge_s:
        middle_s = 0.5 * (out_s + in_s)
        if _ways_margins(b, c, p, n, middle_s)[0] > 0.0:
            in_s = middle_s
        else:
            out_s = middle_s
    if _ways_margins(b, c, p, n, out_s)[1] > 0.0:
        return in_s, RATE
    return in_s, _unkept(b, c, p, n, out_s)


@nested
def _spans_of(
    b: Tracking, c: CarrierTables, p: Places, n: int, rise_s: float, set_s: float
) -> Array:
    """Where some sense of the rule keeps the exclusions and its rate, and what opens and closes
    each, -1 for the edges of the window, (k, 4)."""
    cells = max(math.ceil((set_s - rise_s) / OPTIONS.step_s), 1)
    spans, count, is_open, was_s = np.empty((cells + 1, 4)), 0, False, rise_s
    for k in range(cells + 1):
        share = k / cells
        t_s = (1.0 - share) * rise_s + share * set_s
        is_in = _ways_margins(b, c, p, n, t_s)[0] > 0.0
        if is_in and not is_open:
            spans[count, 0], spans[count, 2] = t_s, -1.0
            if k > 0:
                spans[count, 0], spans[count, 2] = _edge_between(b, c, p, n, was_s, t_s)
        if is_open and not is_in:
            spans[count, 1], spans[count, 3] = _edge_between(b, c, p, n, t_s, was_s)
            count += 1
        is_open, was_s = is_in, t_s
    if is_open:
        spans[count, 1], spans[count, 3] = set_s, -1.0
        count += 1
    return spans[:count].copy()


@lean
def _session_in(
    b: Tracking, c: CarrierTables, p: Places, n: int, span_s: tuple[float, float],
    off_nadir_rad: float
) -> tuple[float, float]:  # fmt: skip
    """The longest session found of a span, or NaN: what one sense holds, once it has settled."""
    start_s, stop_s, longest = math.nan, math.nan, 0.0
    for sense in range(b.senses):
        begins_s, ends_s = _longest_run(b, c, p, n, sense, span_s, off_nadir_rad)
        begins_s += b.settle_s
        if ends_s - begins_s > longest:
            start_s, stop_s, longest = begins_s, ends_s, ends_s - begins_s
    return start_s, stop_s


@compiled
def follow(
    b: Tracking, s: WindowScene, found: Found, off_nadir_rad: float, limits: tuple[float, float]
) -> tuple[Found, Array, int]:
    """Windows in which the body keeps its exclusions and its rate by some sense of the roll rule;
    what a session holds of each, (m, 2), or NaN; and looks.

    limits: the shortest window, s, and of looks.  Gaps and windows of less than a second may be
    missed.
    """
    rows, looks = [np.empty((0, 8))], 0
    for w in range(len(found.target)):
        if looks > limits[1]:
            break
        n, rise_s, set_s = found.target[w], found.edge_s[w, 0], found.edge_s[w, 1]
        spans = _spans_of(b, s.c, s.p, n, rise_s, set_s)
        each = np.zeros((len(spans), 8))
        each[:, 0], each[:, 1:5] = n, spans
        # By number: of rows taken by iteration the compiled loop saw no starts and stops.
        for k in range(len(spans)):
            for end in range(2):
                if each[k, 3 + end] < 0.0:
                    each[k, 3 + end] = found.cause[w, end]
            span_s = spans[k, 0], spans[k, 1]
            each[k, 6], each[k, 7] = _session_in(b, s.c, s.p, n, span_s, off_nadir_rad)
        rows.append(each[spans[:, 1] - spans[:, 0] >= limits[0]])
        looks += 20 * math.ceil((set_s - rise_s) / OPTIONS.step_s)
    told, count = np.empty((sum([len(each) for each in rows]), 8)), 0
    for each in rows:
        told[count : count + len(each)] = each
        count += len(each)
    return found_of(told, looks), told[:, 6:].copy(), looks


@compiled
def first_not_carried(
    b: Tracking,
    c: CarrierTables,
    p: Places,
    numbers: Indices,
    spans_s: Array,
    before_s: float,
    before: tuple[Vector, Vector],
    off_nadir_rad: float,
) -> tuple[int, float, tuple[Vector, Vector]]:
    """Of sessions of rule "nearest" after each other the first that isn't held, when it last is
    not, and boresight and +X at its end, ITRF; those at the end of all where each is held, after
    their count.

    numbers, spans_s: of the targets, and of the sessions, (n,), (n, 2).
    before: boresight and +X of the camera at before_s, from which it slews there.
    """
    boresight, aside, unheld_s = before[0], before[1], math.nan
    for place in range(len(numbers)):
        start_s, stop_s = spans_s[place]
        cells = max(math.ceil((stop_s - start_s) / OPTIONS.step_s), 1)
        n, far_rad = numbers[place], math.pi
        for k in range(cells + 1):
            share = k / cells
            t_s = (1.0 - share) * start_s + share * stop_s
            d = _seen(c, p, n, t_s)[0]
            was_rad, was_aside = far_rad, aside
            aside = _carried_on(aside, boresight, d, t_s - before_s)
            far_rad = session_margin_rad(b, c, p, n, t_s, 1.0, aside, off_nadir_rad)
            is_held = far_rad > 0.0
            if is_held and k > 0:
                carried, least_rad = (True, boresight, was_aside), min(was_rad, far_rad)
                is_held = kept_between(b, c, p, n, (before_s, t_s), 1.0, carried, least_rad)
            if not is_held:
                unheld_s = t_s
            before_s, boresight = t_s, d
        if not math.isnan(unheld_s):
            return place, unheld_s, (boresight, aside)
    return len(numbers), unheld_s, (boresight, aside)


@compiled
def follow_line(
    b: Tracking, c: CarrierTables, p: Places, begins_s: Array, duration_s: float,
    off_nadir_rad: float
) -> Mask:  # fmt: skip
    """Of scans of a line that begin at n times, whether one sense of the roll rule keeps the
    exclusions and its rate from end to end, and whether a session may be there, (n, 2)."""
    held = np.zeros((len(begins_s), 2), np.bool_)
    cells = max(math.ceil(duration_s / OPTIONS.step_s), 1)
    settling = math.ceil(b.settle_s / OPTIONS.step_s)
    for n in range(len(begins_s)):
        for sense in range(b.senses):
            sign, as_window, as_session = 1.0 - 2.0 * sense, True, True
            was_s, far_rad = begins_s[n], 0.0
            for k in range(-settling, cells + 1):
                if k < 0:
                    t_s = begins_s[n] + k / settling * b.settle_s
                else:
                    t_s = begins_s[n] + k / cells * duration_s
                d, r_sat, v = _seen(c, p, n, t_s)
                aside = scaled(sign, aside_at(b, c, p, n, t_s, d, r_sat, v))
                as_session = as_session and t_s >= 0.0
                if as_session:
                    was_rad = far_rad
                    far_rad = session_margin_rad(b, c, p, n, t_s, sign, aside, off_nadir_rad)
                    as_session = far_rad > 0.0
                    if as_session and k > -settling:
                        by_rule, least_rad = (False, d, aside), min(was_rad, far_rad)
                        as_session = kept_between(
                            b, c, p, n, (was_s, t_s), sign, by_rule, least_rad
                        )
                was_s = t_s
                if k >= 0:
                    kept = _kept(b, c, d, aside, r_sat, v, t_s)
                    if not min(kept, _motion(b, c, p, n, t_s, sign, aside, 1)) > 0.0:
                        as_window, as_session = False, False
                        break
            held[n, 0] = held[n, 0] or as_window
            held[n, 1] = held[n, 1] or as_session
    return held
