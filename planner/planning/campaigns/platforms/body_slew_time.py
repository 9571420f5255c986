"""Test of a body's slew against a time that suffices, and one that is needed.

A time suffices in which the ends' motions, continued and blended into each other about the Euler
axis, keep the limits, or in which the body comes to rest, turns, and is accelerated again.  A time
is needed in which a scalar motion between the ends' rates turns by the angle: along the direction
that the body's rate has at one instant it moves no faster (`planner.motion.attitude.bounds`); and
in which the rate about each body axis turns by the twist about it, but for the solid angle that
the axis itself may sweep meanwhile, which is the most that a curve so long can enclose.
Both are computed millions of times over.
"""

import math
from typing import NamedTuple

from planner.base.arrays import Array, Mask
from planner.base.commands import COMMAND_STEP_S
from planner.base.compiled import inlined, lean
from planner.base.vectors import (
    Vector,
    angle_between,
    cross,
    dot,
    norm,
    plus,
    scaled,
)
from planner.planning.campaigns.platforms.axis_slew_time import (
    by_peak_s,
    change_s,
    needed_axis_s,
)


class BodyEnvelope(NamedTuple):
    """Limits of a body, rad and s.

    by_axis: rate, acceleration, jerk about each body axis, (3, 3); of magnitudes three times one.
    is_round: whether each of these limits is an ellipsoid with such semi-axes; else a box, (3,).
    length_limits: (3,), no vector within the limits is longer.  least_limits: (3,), any vector as
    long is within them.  boresight_body: a unit vector, (3,).
    """

    by_axis: Array
    is_round: Mask
    length_limits: Array
    least_limits: Array
    boresight_body: Array


class BodySlewTimeOptions(NamedTuple):
    """How closely a blend is looked at."""

    looks: int = 15  # two or so in each phase of the profile
    shortest_share: float = (
        0.5  # of the time about the axis from rest to rest: moving ends may help
    )
    # of each limit: a blend bulges between the looks, and the solver needs some room
    within_share: float = 0.985
    least_rad: float = 1e-4  # turned at least, so that there is a profile to blend by
    switching_s: float = 2.0 * COMMAND_STEP_S  # beyond the least time: jerk changes on rows only


OPTIONS = BodySlewTimeOptions()


class _Ends(NamedTuple):
    """The turn from start to end, its axis in the start's body axes, and both ends' motions.

    is_known: whether the roll of both ends is; else the turn may be any that is no smaller.
    """

    angle_rad: float
    axis: Vector
    omega_0: Vector
    alpha_0: Vector
    omega_1: Vector
    alpha_1: Vector
    is_known: bool


@lean
def body_fits(
    start_state: Array, end_state: Array, envelope: BodyEnvelope, sign: float, available_s: float
) -> bool:
    """Whether a slew between two states fits; sign 1: surely, -1: nothing proves that it doesn't.

    start_state, end_state: (11,), q_still_from_body_xyzw against axes that don't turn, body rates,
    body accelerations, and 1 where the roll about the boresight is that of the attitude before.
    """
    ends = _ends(start_state, end_state, envelope.boresight_body)
    # Of a roll that is free, what is along which body axis isn't known.
    is_rolled = start_state[10] == 0.0 or envelope.is_round[0]
    if sign < 0.0:
        return _may_fit(ends, envelope, is_rolled, available_s)
    if not ends.is_known:
        return _by_rest_s(ends, math.pi, envelope.least_limits) <= available_s
    if not _may_fit(ends, envelope, is_rolled, available_s):
        return False
    return (
        _by_rest_s(ends, ends.angle_rad, envelope.least_limits) <= available_s
        or _blend_fits(ends, envelope, available_s)
    )  # fmt: skip


@inlined
def _triple(state: Array, first: int) -> Vector:
    return state[first], state[first + 1], state[first + 2]


@inlined
def _turned(axis: Vector, half_cosine: float, v: Vector) -> Vector:
    """A vector turned by a quaternion."""
    across = scaled(2.0, cross(axis, v))
    return plus(plus(v, half_cosine, across), 1.0, cross(axis, across))


@inlined
def _ends(start_state: Array, end_state: Array, boresight_body: Array) -> _Ends:
    axis_0, axis_1 = _triple(start_state, 0), _triple(end_state, 0)
    scalar_0, scalar_1 = start_state[3], end_state[3]
    # q_start_from_end.
    axis = plus(plus(scaled(scalar_0, axis_1), -scalar_1, axis_0), -1.0, cross(axis_0, axis_1))
    scalar = scalar_0 * scalar_1 + dot(axis_0, axis_1)
    omega_1, alpha_1 = _triple(end_state, 4), _triple(end_state, 7)
    is_known = True
    if end_state[10] > 0.0:
        # The end has the roll that the shortest arc between the boresights brings.
        boresight = _triple(boresight_body, 0)
        there = _turned(axis, scalar, boresight)
        angle_rad = angle_between(boresight, there)
        across = cross(boresight, there)
        if norm(across) < 1e-9:
            across = cross(boresight, (boresight[1], boresight[2] + 1.0, boresight[0]))
        arc = scaled(math.sin(0.5 * angle_rad) / norm(across), across)
        back = scaled(-1.0, arc)
        half = math.cos(0.5 * angle_rad)
        omega_1 = _turned(back, half, _turned(axis, scalar, omega_1))
        alpha_1 = _turned(back, half, _turned(axis, scalar, alpha_1))
        axis, scalar = arc, half
    elif start_state[10] > 0.0:
        boresight = _triple(boresight_body, 0)
        is_known = False
        angle_rad = angle_between(boresight, _turned(axis, scalar, boresight))
    if scalar < 0.0:
        axis, scalar = scaled(-1.0, axis), -scalar
    size = norm(axis)
    if is_known:
        angle_rad = 2.0 * math.atan2(size, scalar)
    axis = scaled(1.0 / size, axis) if size > 1e-12 else (1.0, 0.0, 0.0)
    omega_0, alpha_0 = _triple(start_state, 4), _triple(start_state, 7)
    return _Ends(angle_rad, axis, omega_0, alpha_0, omega_1, alpha_1, is_known)


@inlined
def _may_fit(ends: _Ends, envelope: BodyEnvelope, is_rolled: bool, available_s: float) -> bool:
    """Whether nothing proves that a slew doesn't fit."""
    if _needed_s(ends, envelope.length_limits, available_s) > available_s:
        return False
    if not (ends.is_known and is_rolled):
        return True
    if envelope.is_round[0]:
        v, a, j = _about(envelope, ends.axis)
        return _may_twist(ends, ends.axis, (v, a, j), envelope.length_limits[0], available_s)
    for k in range(3):
        axis = (1.0 * (k == 0), 1.0 * (k == 1), 1.0 * (k == 2))
        v, a, j = envelope.by_axis[k, 0], envelope.by_axis[k, 1], envelope.by_axis[k, 2]
        aside = math.hypot(envelope.by_axis[k - 1, 0], envelope.by_axis[k - 2, 0])
        if not _may_twist(ends, axis, (v, a, j), aside, available_s):
            return False
    return True


@inlined
def _may_twist(
    ends: _Ends, axis: Vector, limits: Vector, aside_rad_s: float, available_s: float
) -> bool:
    """Whether the rate about a body axis may turn by the twist about it.

    limits: of rate, acceleration and jerk along the axis.  aside_rad_s: the axis moves no faster.
    The twist is the integral of the rate about the axis, and the solid angle that the axis sweeps.
    """
    swept_rad = aside_rad_s * available_s
    if swept_rad >= math.pi:
        return True
    half = 0.5 * ends.angle_rad
    vector, scalar = math.sin(half) * dot(ends.axis, axis), math.cos(half)
    twist_rad = 2.0 * math.atan2(vector, scalar)
    swing_rad = 2.0 * math.acos(min(math.hypot(vector, scalar), 1.0))
    # Of a curve with its chord, and with its mirror image in the chord.
    slack_rad = math.pi - math.sqrt(math.pi**2 - swept_rad**2)
    around_rad = swept_rad + swing_rad
    if around_rad < 2.0 * math.pi:
        enclosed_rad = 2.0 * math.pi - math.sqrt(4.0 * math.pi**2 - around_rad**2)
        slack_rad = min(slack_rad, enclosed_rad)
    if limits[0] * available_s >= 2.0 * math.pi - abs(twist_rad) - slack_rad:
        return True  # the other way round
    rates = dot(ends.omega_0, axis), dot(ends.omega_1, axis)
    accelerations = dot(ends.alpha_0, axis), dot(ends.alpha_1, axis)
    needed_s = needed_axis_s(rates, accelerations, twist_rad, slack_rad, limits, available_s)
    return bool(needed_s <= available_s)


@inlined
def _needed_s(ends: _Ends, length_limits: Array, available_s: float) -> float:
    """No slew takes less; only as exactly as tells on which side of available_s it is."""
    v, a, j = length_limits[0], length_limits[1], length_limits[2]
    a0, a1 = norm(ends.alpha_0), norm(ends.alpha_1)
    ramp0_s, ramp1_s = a0 / j, a1 / j
    ramps_s = ramp0_s + ramp1_s
    w0, w1 = norm(ends.omega_0), norm(ends.omega_1)
    needed_s = 0.0
    if ends.is_known:
        change = norm(plus(ends.omega_1, -1.0, ends.omega_0))
        needed_s = change_s(change, a, j) - ramps_s
    # Ramps from no acceleration before the start, and to none after the end.
    v0 = min(max(w0 - 0.5 * a0 * ramp0_s, 0.0), v)
    v1 = min(max(w1 - 0.5 * a1 * ramp1_s, 0.0), v)
    moved_rad = ramp0_s * (w0 - a0 * ramp0_s / 3.0) + ramp1_s * (w1 - a1 * ramp1_s / 3.0)
    way_rad = ends.angle_rad + moved_rad
    if way_rad > 0.5 * (v0 + v1) * change_s(v1 - v0, a, j):
        turn_s = by_peak_s(way_rad, v0, v1, v, a, j, available_s + ramps_s)
        needed_s = max(needed_s, turn_s - ramps_s)
    return float(needed_s)


@inlined
def _peak_rad_s(angle_rad: float, v: float, a: float, j: float) -> float:
    """The greatest rate of the quickest turn from rest to rest."""
    peak = (0.25 * angle_rad**2 * j) ** (1.0 / 3.0)
    if peak > a * a / j:
        peak = 0.5 * (math.sqrt((a * a / j) ** 2 + 4.0 * angle_rad * a) - a * a / j)
    return float(min(peak, v))


@inlined
def _by_rest_s(ends: _Ends, angle_rad: float, least_limits: Array) -> float:
    """From the start's motion to rest, about an axis, and from rest to the end's motion."""
    v, a, j = least_limits[0], least_limits[1], least_limits[2]
    total_s = OPTIONS.switching_s
    for rate, acceleration in (
        (norm(ends.omega_0), norm(ends.alpha_0)), (norm(ends.omega_1), norm(ends.alpha_1))
    ):  # fmt: skip
        ramp_s = acceleration / j
        rate += 0.5 * acceleration * ramp_s
        stop_s = change_s(rate, a, j)
        total_s += ramp_s + stop_s
        angle_rad += rate * (ramp_s + 0.5 * stop_s)
    angle_rad = min(angle_rad, math.pi)
    peak = _peak_rad_s(angle_rad, v, a, j)
    rise_s = change_s(peak, a, j)
    return float(total_s + rise_s + max(angle_rad / peak, rise_s))


@inlined
def _mrp_rates(sigma: Vector, omega: Vector, alpha: Vector) -> tuple[Vector, Vector]:
    """The derivatives of Rodrigues parameters; as `planner.base.mrp.mrp_state`."""
    s = dot(sigma, sigma)
    d1 = scaled(0.25, _mrp_inverse(sigma, s, omega))
    s1 = dot(sigma, d1)
    more = 4.0 * s1 / (1.0 + s)
    a1 = scaled(0.25 * (1.0 + s) ** 2, plus(alpha, more, omega))
    d2 = _mrp_inverse(sigma, s, plus(a1, -2.0 * dot(d1, d1), sigma))
    return d1, scaled(1.0 / (1.0 + s) ** 2, d2)


@inlined
def _mrp_inverse(sigma: Vector, s: float, x: Vector) -> Vector:
    return plus(plus(scaled(1.0 - s, x), 2.0, cross(sigma, x)), 2.0 * dot(sigma, x), sigma)


@inlined
def _profile(
    t_s: float, angle_rad: float, peak_rad_s: float, a: float, j: float, span_s: float
) -> tuple[float, float, float, float]:
    """Angle, rate, acceleration and jerk of the quickest turn from rest to rest, at t_s."""
    is_late = t_s > 0.5 * span_s
    t = span_s - t_s if is_late else t_s
    ramp_s = a / j if peak_rad_s >= a * a / j else math.sqrt(peak_rad_s / j)
    rise_s = change_s(peak_rad_s, a, j)
    reached = j * ramp_s
    if t >= rise_s:
        p, v, acceleration, jerk = peak_rad_s * (t - 0.5 * rise_s), peak_rad_s, 0.0, 0.0
    elif t > rise_s - ramp_s:
        left_s = rise_s - t
        v, acceleration, jerk = peak_rad_s - 0.5 * j * left_s**2, j * left_s, -j
        p = peak_rad_s * (t - 0.5 * rise_s) + j * left_s**3 / 6.0
    elif t > ramp_s:
        v, acceleration, jerk = reached * (t - 0.5 * ramp_s), reached, 0.0
        p = reached * (0.5 * (t - 0.5 * ramp_s) ** 2 + ramp_s**2 / 24.0)
    else:
        p, v, acceleration, jerk = j * t**3 / 6.0, 0.5 * j * t**2, j * t, j
    if is_late:
        return angle_rad - p, v, -acceleration, jerk
    return p, v, acceleration, jerk


@inlined
def _blend_fits(ends: _Ends, envelope: BodyEnvelope, available_s: float) -> bool:
    """Whether the blend of that duration keeps the limits; as `eigenaxis.blended`."""
    angle_rad, u = max(ends.angle_rad, OPTIONS.least_rad), ends.axis
    v, a, j = _about(envelope, u)
    peak = _peak_rad_s(angle_rad, v, a, j)
    rise_s = change_s(peak, a, j)
    profile_s = rise_s + max(angle_rad / peak, rise_s)
    if available_s < OPTIONS.shortest_share * profile_s:
        return False
    k = profile_s / available_s
    tangent = math.tan(angle_rad / 8.0)
    s0, s1 = scaled(-tangent, u), scaled(tangent, u)
    v0, a0 = _mrp_rates(s0, ends.omega_0, ends.alpha_0)
    v1, a1 = _mrp_rates(s1, ends.omega_1, ends.alpha_1)
    g = 0.5 / tangent
    for look in range(OPTIONS.looks):
        # From the middle, where the rate is greatest, outwards.
        place = (OPTIONS.looks // 2 + (look + 1) // 2 * (1 if look % 2 else -1)) + 0.5
        t = place / OPTIONS.looks * available_s
        y = t - available_s
        p, p1, p2, p3 = _profile(t * k, angle_rad, peak, a, j, profile_s)
        p1, p2, p3 = p1 * k, p2 * k**2, p3 * k**3
        x = math.tan(0.25 * (p - 0.5 * angle_rad))
        x1 = 0.25 * (1.0 + x**2)
        x2 = 0.5 * x * x1
        x3 = 0.5 * (x1**2 + x * x2)
        share, share1 = g * x + 0.5, g * x1 * p1
        share2 = g * (x2 * p1**2 + x1 * p2)
        share3 = g * (x3 * p1**3 + 3.0 * x2 * p1 * p2 + x1 * p3)
        begin, begin1 = plus(plus(s0, t, v0), 0.5 * t**2, a0), plus(v0, t, a0)
        gap = plus(plus(plus(s1, y, v1), 0.5 * y**2, a1), -1.0, begin)
        gap1 = plus(plus(v1, y, a1), -1.0, begin1)
        gap2 = plus(a1, -1.0, a0)
        sigma = plus(begin, share, gap)
        d1 = plus(plus(begin1, share1, gap), share, gap1)
        d2 = plus(plus(plus(a0, share2, gap), 2.0 * share1, gap1), share, gap2)
        d3 = plus(plus(scaled(share3, gap), 3.0 * share2, gap1), 3.0 * share1, gap2)
        if not _keeps(sigma, d1, d2, d3, envelope):
            return False
    return True


@inlined
def _about(envelope: BodyEnvelope, axis: Vector) -> tuple[float, float, float]:
    """Limits of a turn about one axis."""
    return _most(envelope, 0, axis), _most(envelope, 1, axis), _most(envelope, 2, axis)


@inlined
def _most(envelope: BodyEnvelope, order: int, axis: Vector) -> float:
    return float(1.0 / max(_used_share(envelope, order, axis), 1e-12))


@inlined
def _used_share(envelope: BodyEnvelope, order: int, flown: Vector) -> float:
    """Of the limit of rate, acceleration or jerk."""
    x = abs(flown[0]) / envelope.by_axis[0, order]
    y = abs(flown[1]) / envelope.by_axis[1, order]
    z = abs(flown[2]) / envelope.by_axis[2, order]
    if envelope.is_round[order]:
        return math.sqrt(x * x + y * y + z * z)
    return float(max(x, y, z))


@inlined
def _keeps(sigma: Vector, d1: Vector, d2: Vector, d3: Vector, envelope: BodyEnvelope) -> bool:
    """Whether a motion keeps the limits at an instant; as `planner.base.mrp.body_motion`."""
    s, s1 = dot(sigma, sigma), dot(sigma, d1)
    s2 = dot(d1, d1) + dot(sigma, d2)
    inverse = 1.0 / (1.0 + s)
    f = 4.0 * inverse**2
    f1 = -4.0 * f * inverse * s1
    f2 = f * inverse * (24.0 * inverse * s1**2 - 4.0 * s2)
    turn = plus(plus(scaled(1.0 - s, d1), -2.0, cross(sigma, d1)), 2.0 * s1, sigma)
    turn1 = plus(plus(scaled(1.0 - s, d2), -2.0, cross(sigma, d2)), 2.0 * s2, sigma)
    turn2 = plus(plus(scaled(1.0 - s, d3), -2.0 * s1, d2), -2.0, cross(d1, d2))
    turn2 = plus(plus(turn2, -2.0, cross(sigma, d3)), 2.0 * s2, d1)
    turn2 = plus(turn2, 2.0 * (3.0 * dot(d1, d2) + dot(sigma, d3)), sigma)
    omega = scaled(f, turn)
    alpha = plus(scaled(f1, turn), f, turn1)
    jerk = plus(plus(scaled(f2, turn), 2.0 * f1, turn1), f, turn2)
    for order, flown in enumerate((omega, alpha, jerk)):
        if _used_share(envelope, order, flown) > OPTIONS.within_share:
            return False
    return True
