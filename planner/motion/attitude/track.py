"""Attitudes that keep a body's camera on a target by a roll rule, if its agility lets them."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Mask, angle_rad, cross
from planner.base.commands import Motion
from planner.base.errors import NotVisible, Refusal, TrackBreaksLimit, Unreachable, figures
from planner.base.mrp import BodyMotion
from planner.base.rotation import Rotation, of_like_sign
from planner.motion.attitude.problem import (
    ORDERS,
    UNIT_TEXTS,
    AgilityLimits,
    between_rows,
    rows_of,
)
from planner.motion.pointing.line_of_sight import STENCIL, difference_stencils
from planner.world.exclusions import ExclusionMargin, Surroundings, exclusion_margins
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import c_enu_from_itrf, geodetic_from_itrf
from planner.world.frames.time_scales import Instants, utc_text
from planner.world.orbits import OrbitStates
from planner.world.platforms.body import (
    AzimuthRoll,
    BodyPlatform,
    LinesAcrossTrack,
    NearestRoll,
    RollRule,
    SunSide,
)
from planner.world.platforms.kept_direction import unit_vector
from planner.world.rules.body import says_roll
from planner.world.targets import BodyTarget, EarthFixedTarget, VisibleTarget


@dataclass(frozen=True, kw_only=True)
class AttitudeTrackOptions:
    """How a track is tried against its limits."""

    shares: tuple[float, ...] = (0.0, 0.5, 1.0)  # of the time between two rows; it turns evenly
    tolerance: float = 1e-9  # of a limit: rounding of degrees to radians
    between_rows_rad: float = 1e-5  # a boresight's path bends less between rows, up to 2 deg/s
    leaving_s: float = 1.0  # the jerk of a slew changes within so much of its ends
    still_m_s: float = 1e-4  # a path goes 10 times as fast; rounding of places is 1e-8 m/s


OPTIONS = AttitudeTrackOptions()


@dataclass(frozen=True, eq=False, kw_only=True)
class TargetSight:
    """A target as seen over n instants: where to look, from where.

    instants: at least 7, uniformly spaced.  los_eci: apparent directions, unit vectors (n, 3) in
    GCRF.
    """

    target: VisibleTarget
    instants: Instants
    states: OrbitStates
    los_eci: Array

    @property
    def step_s(self) -> float:
        """From one instant to the next."""
        return float(self.instants.t_s[-1] - self.instants.t_s[0]) / (len(self.instants) - 1)

    @cached_property
    def surroundings(self) -> Surroundings:
        """What is seen around the spacecraft, whichever way it lies."""
        return Surroundings(self.instants, self.states)


@dataclass(frozen=True, eq=False, kw_only=True)
class AttitudeTrack:
    """A body's motion along a target: the session, and the time around it in which it may go on.

    t_s: (n,), rows on the clock of the sight's instants.  is_reversed: whether the camera's +X lies
    against what the roll rule follows.
    """

    t_s: Array
    motion: Motion
    is_reversed: bool


class _Break(NamedTuple):
    """The first row of a session at which something is broken, and what is said of it."""

    refusal: Refusal
    row: int


def agility_limits(platform: BodyPlatform) -> AgilityLimits:
    """The platform's limits in radians."""
    rate, acceleration, jerk = platform.envelope.by_order_rad
    return AgilityLimits(
        kind=platform.envelope.limits,
        rate_rad_s=rate,
        acceleration_rad_s2=acceleration,
        jerk_rad_s3=jerk,
    )


def roll_rule(platform: BodyPlatform, target: VisibleTarget, asked: RollRule | None) -> RollRule:
    """The rule asked for; else the platform's, or nearest where that says nothing of the target."""
    if asked is not None:
        return asked
    return platform.roll if says_roll(platform.roll, target) else NearestRoll()


def attitude_tracks(
    platform: BodyPlatform,
    roll: RollRule,
    sight: TargetSight,
    session_start_s: float,
    session_stop_s: float,
    q_eci_from_body_before: Rotation,
) -> tuple[AttitudeTrack, ...]:
    """Every way to hold the camera on the target by the rule, the nearest to the one before first.

    sight: rows that cover the session and may reach before and after it.  session_*_s: on the clock
    of its instants.  q_eci_from_body_before: the attitude before the slew onto the target.
    A way is a sense of the rule: two where the camera images both ways.  Rates and accelerations
    are 7-point differences of the attitude.  Limits of rate, acceleration and jerk are
    tried as flown between rows; off-nadir angle (of targets on the Earth) and exclusions on rows,
    with what a path may bend in between, and those for imaging in the session alone.
    Raises Unreachable (off-nadir angle), NotVisible (exclusion), TrackBreaksLimit where no way is
    left, and where the rule doesn't say how to lie.
    """
    session = _session_rows(sight.instants.t_s, session_start_s, session_stop_s)
    senses = rolled_quaternions(platform, roll, sight, session.start, q_eci_from_body_before)
    tracks: list[tuple[float, AttitudeTrack]] = []
    breaks: list[_Break] = []
    for number, position in enumerate(senses):
        motion = attitude_motion(position, sight.step_s)
        held, broken = _held_rows(platform, sight, motion, session)
        if broken is not None:
            breaks.append(broken)
            continue
        rows = _run_with(held, session)
        turn = q_eci_from_body_before.inv() * Rotation.from_quat(position[session.start])
        track = AttitudeTrack(
            t_s=sight.instants.t_s[rows], motion=rows_of(motion, rows), is_reversed=bool(number)
        )
        tracks.append((float(turn.magnitude()), track))
    if not tracks:
        raise max(breaks, key=lambda broken: broken.row).refusal
    return tuple(track for _, track in sorted(tracks, key=lambda one: round(one[0], 9)))


def held_cells(
    platform: BodyPlatform, roll: RollRule, sight: TargetSight, q_eci_from_body_before: Rotation
) -> Iterator[Mask]:
    """By each sense of the rule, between which rows a session may hold it, (n - 1,).

    All is kept while the body settles, too, and limits of agility for a second longer, in which a
    slew may leave it.
    """
    settled = math.ceil(platform.envelope.settle_s / sight.step_s - 1e-6)
    leaving = math.ceil(OPTIONS.leaving_s / sight.step_s)
    for position in rolled_quaternions(platform, roll, sight, 0, q_eci_from_body_before):
        held = np.ones(len(position) - 1, dtype=bool)
        for check in _checks(platform, sight, attitude_motion(position, sight.step_s)):
            kept = check.margin_share >= 0.0
            if check.is_between_rows:
                kept = np.convolve(~kept, np.ones(leaving))[leaving - 1 :] < 0.5
            else:
                kept = kept[1:] & kept[:-1]
            held &= np.convolve(~kept, np.ones(settled + 1))[: len(kept)] < 0.5
        yield held


def rolled_quaternions(
    platform: BodyPlatform,
    roll: RollRule,
    sight: TargetSight,
    first: int,
    q_eci_from_body_before: Rotation,
) -> list[Array]:
    """By each sense of the rule, the camera on the target: q_eci_from_body_xyzw, (n, 4).

    q_eci_from_body_before: what "nearest" is nearest to, at row `first`.
    Raises TrackBreaksLimit where the rule doesn't say how to lie.
    """
    if isinstance(roll, NearestRoll):
        return [_nearest(platform, sight.los_eci, first, q_eci_from_body_before)]
    aside_eci, aside_body = _aside(platform, roll, sight)
    is_one_way = isinstance(roll, SunSide) or not platform.camera.both_ways
    return [
        pointed_quaternions(sight.los_eci, sign * aside_eci, platform.boresight_body, aside_body)
        for sign in ((1.0,) if is_one_way else (1.0, -1.0))
    ]


def pointed_quaternions(
    toward_eci: Array, aside_eci: Array, toward_body: Array, aside_body: Array
) -> Array:
    """Attitudes with one body direction in `toward`, the other as near to `aside` as that lets it.

    toward_eci: unit vectors (n, 3).  aside_eci: (n, 3), of any length.  *_body: unit vectors (3,).
    Returns q_eci_from_body_xyzw, (n, 4), neighbours of like sign, the first w not negative.
    """
    c_eci_from_body = _triads(toward_eci, aside_eci) @ _triads(toward_body, aside_body).T
    return of_like_sign(np.asarray(Rotation.from_matrix(c_eci_from_body).as_quat()))


def attitude_motion(q_eci_from_body_xyzw: Array, step_s: float) -> Motion:
    """Attitudes (n, 4) at uniform steps with their rates and accelerations in body axes.

    7-point differences of the quaternion, of like sign from row to row, one-sided towards the
    ends: omega = 2 q* q', alpha = 2 q* q''; n is at least 7.
    """
    back = q_eci_from_body_xyzw * [-1.0, -1.0, -1.0, 1.0]
    omega, alpha = (
        2.0 * (back[:, 3:] * q[:, :3] + q[:, 3:] * back[:, :3] + cross(back[:, :3], q[:, :3]))
        for q in (_differences(q_eci_from_body_xyzw, step_s, order) for order in (1, 2))
    )
    return Motion(q_eci_from_body_xyzw, omega, alpha)


def _triads(toward_direction: Array, aside_direction: Array) -> Array:
    """Orthonormal columns (..., 3, 3): the first, the second's part across it, their product."""
    along = np.sum(aside_direction * toward_direction, axis=-1, keepdims=True)
    across = aside_direction - along * toward_direction
    across = across / np.linalg.norm(across, axis=-1, keepdims=True)
    columns = [toward_direction, across, np.cross(toward_direction, across)]
    return np.stack(columns, axis=-1)


def _aside(platform: BodyPlatform, roll: RollRule, sight: TargetSight) -> tuple[Array, Array]:
    """The direction in GCRF, (n, 3), that a body direction, (3,), is turned towards by a rule."""
    along_body = platform.camera.c_payload_from_body[0]
    if isinstance(roll, SunSide):
        sun = BodyTarget(name="sun", grazing_altitude_km=0.0)
        sun_eci = sun.apparent(sight.instants, sight.states).direction_eci
        return sun_eci, unit_vector(roll.direction_body)
    c_itrf = c_itrf_from_eci(sight.instants)
    if isinstance(roll, LinesAcrossTrack):
        r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf, sight.states.r_sat_eci_m)
        along_itrf = _differences(r_sat_itrf_m, sight.step_s)
    else:
        along_itrf = _along_ground(roll, sight)
    return np.asarray(np.einsum("nji,nj->ni", c_itrf, along_itrf)), along_body


def _along_ground(roll: RollRule, sight: TargetSight) -> Array:
    """The motion of the looked-at point over the ground, or an azimuth there, ITRF, (n, 3)."""
    if not isinstance(sight.target, EarthFixedTarget):
        raise TrackBreaksLimit(
            f"roll {roll.rule} says nothing of a target in the sky; give the session another rule, "
            "such as nearest",
            field="roll",
        )
    r_target_itrf_m = sight.target.r_target_itrf_m(sight.instants)
    if isinstance(roll, AzimuthRoll):
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(r_target_itrf_m)
        azimuth_rad = math.radians(roll.azimuth_deg)
        east, north, _ = np.moveaxis(c_enu_from_itrf(latitude_rad, longitude_rad), 1, 0)
        return np.asarray(math.sin(azimuth_rad) * east + math.cos(azimuth_rad) * north)
    v_target_itrf_m_s = _differences(r_target_itrf_m, sight.step_s)
    still = np.flatnonzero(np.linalg.norm(v_target_itrf_m_s, axis=1) < OPTIONS.still_m_s)
    if still.size:
        at_utc = sight.instants.utc(int(still[0]))
        raise TrackBreaksLimit(
            f"the image stands still at {utc_text(at_utc)}, where the target doesn't move over the "
            "ground: roll lines_across_motion says nothing there; give the session another rule, "
            "such as nearest",
            field="roll",
            limit="rate",
            at_utc=at_utc,
        )
    return v_target_itrf_m_s


def _differences(value: Array, step_s: float, order: int = 1) -> Array:
    """Derivative of rows (n, k) at uniform steps."""
    first, weights = difference_stencils(len(value), order)
    nodes = value[first[:, None] + np.arange(STENCIL)]
    return np.asarray(np.einsum("nk,nkj->nj", weights, nodes) / step_s**order)


def _nearest(
    platform: BodyPlatform, los_eci: Array, first: int, q_eci_from_body_before: Rotation
) -> Array:
    """q_eci_from_body_xyzw, (n, 4), turned least from the one before at row `first`, and from row
    to row about axes square to the line of sight: no turn about it."""
    boresight_eci = q_eci_from_body_before.apply(platform.boresight_body)
    onto = Rotation.from_quat(_shortest_arcs(boresight_eci[None], los_eci[first : first + 1]))[0]
    steps = Rotation.from_quat(_shortest_arcs(los_eci[:-1], los_eci[1:])).as_quat()
    turned = Rotation.from_quat(np.vstack([[0.0, 0.0, 0.0, 1.0], steps]))
    span = 1
    while span < len(turned):  # products of all steps before each row, by doubling
        later = (turned[span:] * turned[:-span]).as_quat()
        turned = Rotation.from_quat(np.vstack([turned.as_quat()[:span], later]))
        span *= 2
    begin = turned[first].inv() * onto * q_eci_from_body_before
    return of_like_sign(np.asarray((turned * begin).as_quat()))


def _shortest_arcs(a: Array, b: Array) -> Array:
    """Least rotations that carry unit vectors a onto b, scalar last, (n, 4), of any length.

    About any axis square to a where b is opposite.
    """
    scalar = 1.0 + np.sum(a * b, axis=1)
    spare = np.cross(a, np.roll(a, 1, axis=1) + np.array([0.0, 0.0, 1.0]))
    opposite = scalar < 1e-12
    vector = np.where(opposite[:, None], spare, np.cross(a, b))
    return np.column_stack([vector, np.where(opposite, 0.0, scalar)])


def _held_rows(
    platform: BodyPlatform, sight: TargetSight, motion: Motion, session: slice
) -> tuple[Mask, _Break | None]:
    """Rows (n,) at which the motion may go on, and the first break in the session."""
    held = np.ones(len(sight.instants), dtype=bool)
    breaks: list[_Break] = []
    for check in _checks(platform, sight, motion):
        margin_share = check.margin_share
        if check.is_between_rows:
            margin_share = -_on_rows(-margin_share)
        broken = np.flatnonzero(margin_share[session] < 0.0)
        if broken.size:
            row = session.start + int(broken[0])
            breaks.append(_Break(check.refuse(row), row))
        if not check.imaging_only:
            held &= margin_share >= 0.0
    return held, min(breaks, key=lambda broken: broken.row, default=None)


class _Check(NamedTuple):
    """One thing to keep: its margin on rows (n,), negative where broken, and what is said then.

    imaging_only: kept in the session alone.  is_between_rows: its margin is that of the time
    between two rows, (n - 1,).
    """

    margin_share: Array
    imaging_only: bool
    refuse: Callable[[int], Refusal]
    is_between_rows: bool = False


def _checks(platform: BodyPlatform, sight: TargetSight, motion: Motion) -> Iterator[_Check]:
    images = sight.target.images
    if images and isinstance(sight.target, EarthFixedTarget):
        off_nadir_rad = angle_rad(sight.los_eci, -sight.states.r_sat_eci_m)
        margin_rad = math.radians(platform.off_nadir_max_deg) - off_nadir_rad
        refuse = partial(_refuse_off_nadir, platform, sight, off_nadir_rad)
        yield _Check(margin_rad - OPTIONS.between_rows_rad, True, refuse)
    if platform.exclusions or platform.star_trackers is not None:
        q_eci_from_body = Rotation.from_quat(motion.position)
        for kept in exclusion_margins(platform, q_eci_from_body, sight.surroundings):
            if kept.imaging_only and not images:
                continue
            margin_rad = kept.margin_rad - OPTIONS.between_rows_rad
            yield _Check(margin_rad, kept.imaging_only, partial(_refuse_exclusion, sight, kept))
    limits = agility_limits(platform)
    _, body = between_rows(motion, np.array(OPTIONS.shares))
    used_shares = np.max([limits.shares(flown) for flown in _by_share(body)], axis=0)
    for order in range(len(ORDERS)):
        used_share = used_shares[:, order]
        refuse = partial(_refuse_limit, sight, platform, limits, order, _on_rows(used_share))
        yield _Check(1.0 + OPTIONS.tolerance - used_share, False, refuse, is_between_rows=True)


def _by_share(body: BodyMotion) -> Iterator[BodyMotion]:
    """Of body rates (cells, k, 3) those of each share, (cells, 3)."""
    for k in range(body.omega_body_rad_s.shape[1]):
        yield BodyMotion(*(part[:, k] for part in body))


def _on_rows(cell_shares: Array) -> Array:
    """At each row the larger value of the two cells that meet there."""
    before, after = np.append(cell_shares[0], cell_shares), np.append(cell_shares, cell_shares[-1])
    return np.asarray(np.maximum(before, after))


def _session_rows(t_s: Array, start_s: float, stop_s: float) -> slice:
    """Rows that enclose the session; a bug, not a refusal, if they don't."""
    first = int(np.searchsorted(t_s, start_s + 1e-9, side="right")) - 1
    last = int(np.searchsorted(t_s, stop_s - 1e-9, side="left")) + 1
    if first < 0 or last > len(t_s):
        raise IndexError(f"sight {t_s[0]}..{t_s[-1]} s, session {start_s}..{stop_s} s")
    return slice(first, max(last, first + 2))


def _run_with(held: Mask, session: slice) -> slice:
    """The run of held rows around the session."""
    lost_before = np.flatnonzero(~held[: session.start])
    lost_after = np.flatnonzero(~held[session.stop :])
    start = int(lost_before[-1]) + 1 if lost_before.size else 0
    return slice(start, session.stop + int(lost_after[0]) if lost_after.size else len(held))


def _refuse_off_nadir(
    platform: BodyPlatform, sight: TargetSight, off_nadir_rad: Array, row: int
) -> Refusal:
    at_utc = sight.instants.utc(row)
    value_deg, most_deg = math.degrees(off_nadir_rad[row]), platform.off_nadir_max_deg
    return Unreachable(
        f"the target stands {figures(value_deg, most_deg)} deg off nadir at {utc_text(at_utc)}, "
        f"more than the {figures(most_deg, value_deg)} deg of {platform.name}; choose other times",
        limit="off_nadir",
        at_utc=at_utc,
    )


def _refuse_exclusion(sight: TargetSight, kept: ExclusionMargin, row: int) -> Refusal:
    at_utc = sight.instants.utc(row)
    short_deg = math.degrees(OPTIONS.between_rows_rad - kept.margin_rad[row])
    return NotVisible(
        f"{kept.name} stands {short_deg:.2g} deg {kept.side} {kept.title} than allowed at "
        f"{utc_text(at_utc)}; choose other times, or another roll",
        limit="exclusion",
        at_utc=at_utc,
    )


def _refuse_limit(
    sight: TargetSight,
    platform: BodyPlatform,
    limits: AgilityLimits,
    order: int,
    used_share: Array,
    row: int,
) -> Refusal:
    at_utc = sight.instants.utc(row)
    of_what = "its limits by axis"
    if limits.kind == "magnitude":
        of_what = f"the {math.degrees(limits.lengths[order]):.6g} {UNIT_TEXTS[order]} it has"
    share = figures(float(used_share[row]), 1.0, digits=3)
    return TrackBreaksLimit(
        f"following the target needs {share} times {of_what} in {ORDERS[order]} of "
        f"{platform.name} at {utc_text(at_utc)}; choose other times, a shorter session, or another "
        "roll",
        limit=ORDERS[order],
        at_utc=at_utc,
    )
