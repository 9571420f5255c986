"""The scenario: one value with everything the planner and its judge need."""

import math
from collections.abc import Mapping
from dataclasses import field
from datetime import datetime
from typing import Annotated, Literal

import numpy as np
from pydantic import Discriminator, Tag

from planner.base.arrays import Array
from planner.base.assumed import Assumed
from planner.base.commands import COMMAND_STEP_S, Motion
from planner.base.errors import NotForPlatform, figures
from planner.base.rotation import Rotation, of_like_sign
from planner.base.spec import UnitPart, Within, spec
from planner.world.attitude import Attitude
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text
from planner.world.orbits import Orbit, OrbitStates
from planner.world.platforms import (
    AngleDeg,
    AnyPlatform,
    AxisLimits,
    JerkDegS3,
    StructuralMode,
    TwoAxisPlatform,
)
from planner.world.platforms.body import AzimuthRoll, BodyPlatform, LinesAcrossMotion, RollRule
from planner.world.targets import (
    BenchMotionTarget,
    EarthFixedTarget,
    KeepOut,
    Target,
    VisibleTarget,
)

KEEP_OUT_MAX = 8  # each makes the detour's problem larger
AVOID_MODES_MAX = 16
OnConflict = Literal["refuse", "shorten_later", "shorten_earlier", "least_loss"]
Keyhole = Literal["refuse", "nearest"]
MotionDeg = Annotated[float, Within(-1e3, 1e3)]  # no axis may have more rate or acceleration
BodyMotionDeg = tuple[MotionDeg, MotionDeg, MotionDeg]
Quaternion = tuple[UnitPart, UnitPart, UnitPart, UnitPart]
OF_BODY = ("q_body_from_eci_xyzw", "omega_body_deg_s", "alpha_body_deg_s2")


@spec
class InitialState:
    """Where the platform is, and how it moves, when the table begins.

    Of two axes one entry per axis, by the axis's name.

    epoch: row 0 of the table; UTC, a whole multiple of 0.2 s after its second.
    angles_deg: of the axes.
    rates_deg_s: of the axes; none are zero.
    accelerations_deg_s2: of the axes; none are zero. E.g. `{"alpha": 0.0, "beta": 0.0}`.
    q_body_from_eci_xyzw: of a body, carries GCRF axes onto the body's, scalar last; unless given,
    the body begins on its idle attitude. E.g. `[0.0, 0.0, 0.0, 1.0]`.
    omega_body_deg_s: of a body against GCRF, in body axes; unless given, it rests. E.g.
    `[0.0, -0.06, 0.0]`.
    alpha_body_deg_s2: of a body, in body axes; zero unless given. E.g. `[0.0, 0.0, 0.01]`.
    assumed: what of it nobody gave.
    """

    epoch: datetime
    angles_deg: Mapping[str, AngleDeg] = field(default_factory=dict)
    rates_deg_s: Mapping[str, MotionDeg] = field(default_factory=dict)
    accelerations_deg_s2: Mapping[str, MotionDeg] = field(default_factory=dict)
    q_body_from_eci_xyzw: Quaternion | None = None
    omega_body_deg_s: BodyMotionDeg | None = None
    alpha_body_deg_s2: BodyMotionDeg | None = None
    assumed: tuple[Assumed, ...] = ()

    def __post_init__(self) -> None:
        if self.epoch.microsecond % round(COMMAND_STEP_S * 1e6):
            before_us = self.epoch.microsecond // 200_000 * 200_000
            before = self.epoch.replace(microsecond=before_us)
            raise ValueError(
                f"epoch must be a multiple of 0.2 s after the UTC second, as row 0 of the table; "
                f"the last one before {utc_text(self.epoch, 6)} is {utc_text(before, 1)}"
            )

    @property
    def body_only(self) -> list[str]:
        """What is given of what only a body has."""
        return [name for name in OF_BODY if getattr(self, name) is not None]

    @property
    def body_motion(self) -> Motion | None:
        """Of a body, one instant; None: that of its idle attitude."""
        if self.q_body_from_eci_xyzw is None:
            return None
        q_eci_from_body = Rotation.from_quat([self.q_body_from_eci_xyzw]).inv()
        rates_deg = (self.omega_body_deg_s or (0.0,) * 3, self.alpha_body_deg_s2 or (0.0,) * 3)
        omega_rad_s, alpha_rad_s2 = np.deg2rad(rates_deg)
        return Motion(
            of_like_sign(q_eci_from_body.as_quat()), omega_rad_s[None], alpha_rad_s2[None]
        )


def says_roll(rule: RollRule, target: Target | VisibleTarget) -> bool:
    """Whether a rule says how the camera lies on a target: no lines across a motion that it doesn't
    have, no azimuth in the sky."""
    is_on_earth = isinstance(target, EarthFixedTarget)
    if isinstance(rule, LinesAcrossMotion):
        return is_on_earth and not target.rests_on_earth
    return is_on_earth or not isinstance(rule, AzimuthRoll)


@spec
class Session:
    """One target held from `start` to `stop`.

    id: your name for it, different from the other sessions'; the plan repeats it. E.g. `"LV-7"`.
    name: name of the session, repeated in the plan and in lists. E.g. `"Las Vegas, east"`.
    target: the target that is tracked.
    start: from when on the target is held; UTC.
    stop: until when it is held; UTC.
    keyhole: treatment of spans where following the target exactly would break a limit, as it does
    near the outer axis: refuse, or follow as near as the limits allow, in the frame.
    roll: of a body, the rule by which its camera lies about the line of sight; the platform's
    unless given.
    """

    id: str | None = None
    name: str | None = None
    target: Target
    start: datetime
    stop: datetime
    keyhole: Keyhole = "refuse"
    roll: RollRule | None = None

    def __post_init__(self) -> None:
        for text in ("id", "name"):
            if getattr(self, text) == "":
                raise ValueError(f"{text} must not be empty; leave it out for none")
        # Bound now, so that a session cut short later keeps the target's timetable.
        object.__setattr__(self, "target", self.target.starting(self.start))
        duration_s = elapsed_s(self.stop, self.start)
        if duration_s <= 0.0:
            raise ValueError(
                f"stop ({utc_text(self.stop)}) must come after start ({utc_text(self.start)})"
            )
        if duration_s < COMMAND_STEP_S:
            raise ValueError(
                "stop must come at least one command step, 0.2 s, after start, not "
                f"{figures(duration_s, COMMAND_STEP_S)} s"
            )
        self.target.require_known("target", self.start, self.stop)

    @property
    def label(self) -> str:
        """What it is called where it is listed; empty for a nameless test motion."""
        return self.name or self.id or self.target.label


@spec
class BoundedLead:
    """Slews no longer than they need be; the axes rest before them.

    max_duration_s: the longest that a slew with the objective "smooth" may last, and any that
    waits for its target; unless given, ten times the least time that the limits allow.
    """

    max_duration_s: Annotated[float, Within(2.0, 86400.0)] | None = None


def _word_or_object(value: object) -> str:
    return "word" if isinstance(value, str) else "object"


Lead = Annotated[
    Annotated[Literal["all"], Tag("word")] | Annotated[BoundedLead, Tag("object")],
    Discriminator(_word_or_object),
]


@spec
class FinalAngles:
    """Angles at which the axes are to rest.

    angles_deg: of each axis, by its name. E.g. `{"alpha": 0.0, "beta": 0.0}`.
    park: name of a park position of the platform. E.g. `"zero"`.
    """

    angles_deg: Mapping[str, AngleDeg] | None = None
    park: str | None = None

    def __post_init__(self) -> None:
        if (self.angles_deg is None) == (self.park is None):
            raise ValueError('give either angles_deg or park; for rest anywhere, "rest" instead')


FinalState = Annotated[
    Annotated[Literal["rest", "idle"], Tag("word")] | Annotated[FinalAngles, Tag("object")],
    Discriminator(_word_or_object),
]


@spec
class SlewOptions:
    """Options of the slews.

    The spline knows neither `keep_out` nor `avoid_modes`; the judge says what it enters, the
    comparison what it excites.

    method: `ocp` keeps every limit; `spline` is the paper's baseline, for comparison only.
    objective: of `ocp`: `smooth` takes all the time there is and spends the least jerk;
    `minimum_time` is on the target as early as its limits and the target's visibility allow.
    jerk_max_deg_s3: replaces the platform's own jerk limit on both axes. E.g. `0.5`.
    filter_cutoff_hz: of the spline's first-order low-pass (Sumarokov 2016, p. 91); null for none.
    filter_lag_compensation: true to aim the spline's join ahead by the filter's lag.
    lead: time before a session that its slew may take: "all", or a bounded time; before it
    the axes are brought to rest, if they move, and wait.
    keep_out: cones the boresight must not enter, on the way or on a target.
    avoid_modes: structural modes that slews leave at rest as well as their time allows: it takes
    two periods or so, and more than the least time.
    """

    method: Literal["ocp", "spline"] = "ocp"
    objective: Literal["smooth", "minimum_time"] = "smooth"
    lead: Lead = BoundedLead()
    jerk_max_deg_s3: JerkDegS3 | None = None
    filter_cutoff_hz: Annotated[float, Within(1e-3, 1e3)] | None = 2.0
    filter_lag_compensation: bool = True
    keep_out: tuple[KeepOut, ...] = ()
    avoid_modes: tuple[StructuralMode, ...] = ()

    def __post_init__(self) -> None:
        for name, most in (("keep_out", KEEP_OUT_MAX), ("avoid_modes", AVOID_MODES_MAX)):
            count = len(getattr(self, name))
            if count > most:
                raise ValueError(f"{name} must hold at most {most} entries, not {count}")

    @property
    def keeps_limits(self) -> bool:
        """Whether slews keep every limit and both ends, or only say what they break."""
        return self.method == "ocp"

    def axis_limits(self, platform: TwoAxisPlatform) -> tuple[AxisLimits, ...]:
        """The platform's limits with the jerk limit asked for, in the order of its axes."""
        return platform.limits_with_jerk(self.jerk_max_deg_s3)


def asked_of_axes(attitude: Attitude | None, slew: SlewOptions) -> dict[str, bool]:
    """Whether a request gives what only two axes on a carrier have, by field."""
    return {
        "attitude": attitude is not None,
        "slew.method": slew.method != "ocp",
        "slew.jerk_max_deg_s3": slew.jerk_max_deg_s3 is not None,
        "slew.keep_out": bool(slew.keep_out),
        "slew.avoid_modes": bool(slew.avoid_modes),
    }


def refuse_axes_only(platform: str, is_given: Mapping[str, bool]) -> None:
    """Raises ValueError for the first field that is given though this platform is a body."""
    for name, is_there in is_given.items():
        if is_there:
            raise ValueError(
                f"{name} must be left out for {platform}: only two axes on a carrier have it, and "
                "a body steers itself"
            )


@spec
class Scenario:
    """A carrier, a platform on it, its state, and the sessions to fly in order of time.

    name: your name for it, repeated in the plan and its files.
    initial_state: state of the platform when the table begins.
    sessions: the sessions, in order of time.
    slew: options of the slews between targets.
    on_conflict: treatment of a slew that doesn't fit between two sessions: refuse, begin the later
    one late, end the earlier one early, or whatever of both loses the least time.
    attitude: attitude of the carrier that two axes stand on; a body steers itself and has none.
    final_state: angles at which the axes are brought to rest when the last session is over, or
    "idle" for a body's idle attitude; unless given, the table ends with that session, in motion.
    """

    name: str = ""
    platform: AnyPlatform
    orbit: Orbit
    attitude: Attitude | None = None
    initial_state: InitialState
    sessions: tuple[Session, ...]
    slew: SlewOptions = SlewOptions()
    on_conflict: OnConflict = "refuse"
    final_state: FinalState | None = None

    def __post_init__(self) -> None:
        if not self.sessions:
            raise ValueError("sessions must hold at least one session")
        earliest_utc, what = self.initial_state.epoch, "initial_state.epoch"
        for number, session in enumerate(self.sessions):
            if elapsed_s(session.start, earliest_utc) < 0.0:
                raise ValueError(
                    f"sessions.{number}.start ({utc_text(session.start)}) must not come before "
                    f"{what} ({utc_text(earliest_utc)})"
                )
            earliest_utc, what = session.stop, f"sessions.{number}.stop"
        self._check_ids()
        if isinstance(self.platform, BodyPlatform):
            self._check_body(self.platform)
            return
        for number, session in enumerate(self.sessions):
            if session.roll is not None:
                raise ValueError(
                    f"sessions.{number}.roll must be left out for {self.platform.name}: only a "
                    "body can lie any way about the line of sight"
                )
        if self.attitude is None:
            raise ValueError(f"attitude is required: {self.platform.name} stands on a carrier")
        self._check_initial_state()
        if self.final_state == "idle":
            raise ValueError('final_state must be "rest" or angles: two axes have no idle attitude')
        if isinstance(self.final_state, FinalAngles):
            self._check_final_state(self.final_state)

    def _check_body(self, platform: BodyPlatform) -> None:
        """What only two axes on a carrier have is refused."""
        state = self.initial_state
        given = asked_of_axes(self.attitude, self.slew) | {
            "initial_state.angles_deg": bool(state.angles_deg),
            "initial_state.rates_deg_s": bool(state.rates_deg_s),
            "initial_state.accelerations_deg_s2": bool(state.accelerations_deg_s2),
            "final_state": self.final_state not in (None, "idle"),
        }
        for number, session in enumerate(self.sessions):
            given[f"sessions.{number}.keyhole"] = session.keyhole != "refuse"
            mode = session.target.mode
            given[f"sessions.{number}.target.mode"] = mode == BenchMotionTarget.mode
            if session.roll is not None:
                platform.require_roll(f"sessions.{number}.roll", session.roll)
                if not says_roll(session.roll, session.target):
                    raise ValueError(
                        f"sessions.{number}.roll must not be {session.roll.rule}, which says "
                        f"nothing of {session.target.label}: give another rule, such as nearest, "
                        "or leave it out"
                    )
        refuse_axes_only(platform.name, given)
        self._check_initial_body(platform)

    def _check_initial_body(self, platform: BodyPlatform) -> None:
        state, asked = self.initial_state, self.initial_state.body_only
        if state.q_body_from_eci_xyzw is None:
            if asked:
                raise ValueError(
                    f"initial_state.{asked[0]} must be given together with q_body_from_eci_xyzw: "
                    "without it the body begins on its idle attitude"
                )
            return
        norm = math.hypot(*state.q_body_from_eci_xyzw)
        if not abs(norm - 1.0) <= 1e-6:
            raise ValueError(
                "initial_state.q_body_from_eci_xyzw must have unit length, not "
                f"{norm:.9g}; divide it by its norm"
            )
        rate_max, acceleration_max, _ = np.rad2deg(platform.envelope.by_order_rad)
        for name, given, most in (
            ("omega_body_deg_s", state.omega_body_deg_s, rate_max),
            ("alpha_body_deg_s2", state.alpha_body_deg_s2, acceleration_max),
        ):
            size = np.abs(given or (0.0,) * 3)
            if platform.envelope.limits == "magnitude":
                size = np.full(3, np.linalg.norm(size))
            worst = int(np.argmax(size / most))
            if size[worst] > most[worst] * (1.0 + 1e-9):
                raise ValueError(
                    f"initial_state.{name} reaches {figures(*(size[worst], most[worst]))}, beyond "
                    f"the {most[worst]:.6g} that agility of {platform.name} allows"
                )

    def _check_ids(self) -> None:
        seen: dict[str, int] = {}
        for number, session in enumerate(self.sessions):
            if session.id is not None and seen.setdefault(session.id, number) != number:
                raise ValueError(
                    f"sessions.{number}.id {session.id!r} is that of session "
                    f"{seen[session.id] + 1} already; ids must differ"
                )

    @property
    def keeps_out(self) -> bool:
        """Whether there are directions that the boresight must not enter."""
        return bool(self.slew.keep_out or self.platform.masks)

    @property
    def needs_orbit_throughout(self) -> bool:
        """Whether the orbit must be known from row 0 on, not over the sessions alone."""
        return bool(self.slew.keep_out) or self.attitude is None

    def _check_initial_state(self) -> None:
        if of_body := self.initial_state.body_only:
            raise ValueError(
                f"initial_state.{of_body[0]} must be left out for {self.platform.name}: only a "
                "body has it; give angles_deg of the axes"
            )
        names = self.two_axis.axis_names
        fields = ("angles_deg", "rates_deg_s", "accelerations_deg_s2")
        for what in fields:
            given = getattr(self.initial_state, what)
            at_rest = what != "angles_deg" and not given
            if not at_rest and set(given) != set(names):
                raise ValueError(
                    f"initial_state.{what} must name the axes {', '.join(names)} of "
                    f"{self.platform.name}, not {', '.join(given) or 'none'}"
                )
        for axis, limits in zip(names, self.two_axis.axis_limits, strict=True):
            motion_rad = self.initial_motion(axis)
            for what, value, (low, high) in zip(fields, motion_rad, limits.bounds, strict=False):
                if not low <= value <= high:
                    raise ValueError(
                        f"initial_state.{what}.{axis} is "
                        f"{figures(*np.rad2deg([value, low, high]).tolist())}, outside its limits "
                        f"{math.degrees(low):.6g}..{math.degrees(high):.6g}"
                    )

    def _check_final_state(self, final: FinalAngles) -> None:
        if final.park is not None:
            known = [position.name for position in self.two_axis.park_positions]
            if final.park not in known:
                raise ValueError(
                    f"final_state.park must be a position of {self.platform.name} "
                    f"({', '.join(known) or 'it has none'}), not {final.park!r}; or give angles_deg"
                )
            return
        names, angles_deg = self.two_axis.axis_names, final.angles_deg or {}
        if set(angles_deg) != set(names):
            raise ValueError(
                f"final_state.angles_deg must name the axes {', '.join(names)} of "
                f"{self.platform.name}, not {', '.join(angles_deg) or 'none'}"
            )
        for axis, limits in zip(names, self.two_axis.axis_limits, strict=True):
            low_deg = math.degrees(limits.angle_min_rad)
            high_deg = math.degrees(limits.angle_max_rad)
            if not limits.angle_min_rad <= math.radians(angles_deg[axis]) <= limits.angle_max_rad:
                raise ValueError(
                    f"final_state.angles_deg.{axis} is "
                    f"{figures(angles_deg[axis], low_deg, high_deg)}, outside its limits "
                    f"{low_deg:.6g}..{high_deg:.6g}"
                )

    @property
    def assumed(self) -> tuple[Assumed, ...]:
        """What was looked up, or taken where nothing was given."""
        looked_up = (
            session.target.assumed(f"sessions.{number}.target")
            for number, session in enumerate(self.sessions)
        )
        return (*self.initial_state.assumed, *filter(None, looked_up))

    @property
    def two_axis(self) -> TwoAxisPlatform:
        """The platform, for what knows two axes only; raises NotForPlatform."""
        if not isinstance(self.platform, TwoAxisPlatform):
            raise self._not_for_platform()
        return self.platform

    @property
    def law(self) -> Attitude:
        """The attitude of the carrier that two axes stand on; raises NotForPlatform."""
        if self.attitude is None:
            raise self._not_for_platform()
        return self.attitude

    def q_body_from_eci(self, instants: Instants, states: OrbitStates, position: Array) -> Rotation:
        """n attitudes of the carrier by its law, or of a body as its positions (n, 4) are."""
        if self.attitude is None:
            return Rotation.from_quat(position).inv()
        return self.attitude.q_body_from_eci(instants, states)

    def _not_for_platform(self) -> NotForPlatform:
        return NotForPlatform(
            f"{self.platform.name} is a platform of kind {self.platform.kind}, and this is for two "
            "axes on a carrier only; leave it out, or plan for two axes",
            field="platform.kind",
        )

    @property
    def final_angle_rad(self) -> tuple[float, ...] | None:
        """Where the axes are to rest in the end, in their order; None: anywhere, or unasked."""
        final = self.final_state
        if not isinstance(final, FinalAngles):
            return None
        if final.angles_deg is not None:
            return tuple(math.radians(final.angles_deg[axis]) for axis in self.two_axis.axis_names)
        return next(
            position.angle_rad
            for position in self.two_axis.park_positions
            if position.name == final.park
        )

    @property
    def axis_limits(self) -> tuple[AxisLimits, ...]:
        """The platform's limits with the jerk limit asked for, in the order of its axes."""
        return self.slew.axis_limits(self.two_axis)

    def initial_motion(self, axis: str) -> Array:
        """Angle, rate and acceleration of one axis at the epoch, rad, rad/s, rad/s2."""
        state = self.initial_state
        return np.deg2rad(
            [
                state.angles_deg[axis],
                state.rates_deg_s.get(axis, 0.0),
                state.accelerations_deg_s2.get(axis, 0.0),
            ]
        )
