"""The scenario: one value with everything the planner and its judge need."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from datetime import datetime
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag

from planner.base.arrays import Array
from planner.base.assumed import Assumed
from planner.base.commands import COMMAND_STEP_S, Motion
from planner.base.errors import NotForPlatform, figures
from planner.base.rotation import Rotation, of_like_sign
from planner.base.spec import UnitPart, Within, spec
from planner.world.attitude import Attitude
from planner.world.clouds import Clouds
from planner.world.conditions import Conditions
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Orbit, OrbitStates
from planner.world.platforms import (
    AngleDeg,
    AnyPlatform,
    FinalAngles,
    JerkDegS3,
    StructuralMode,
)
from planner.world.platforms.body import RollRule
from planner.world.resources import Resources
from planner.world.rules.body import BodyRules
from planner.world.rules.keep_out import KeepOut
from planner.world.rules.registry import rules_of
from planner.world.targets import AskedTarget, ImagingMode, ScanWindow, Target
from planner.world.targets.session_target import all_standing_on
from planner.world.targets.terrain import Terrain

KEEP_OUT_MAX = 8  # each makes the detour's problem larger
AVOID_MODES_MAX = 16
OnConflict = Literal["refuse", "shorten_later", "shorten_earlier", "least_loss"]
Keyhole = Literal["refuse", "nearest"]
MotionDeg = Annotated[float, Within(-1e3, 1e3)]  # no axis may have more rate or acceleration
BodyMotionDeg = tuple[MotionDeg, MotionDeg, MotionDeg]
Quaternion = tuple[UnitPart, UnitPart, UnitPart, UnitPart]


@spec
class PastLook:
    """A session that imaged before the table begins, as rules among sessions count it.

    start: from when; UTC. E.g. `"2015-02-27T17:20:00Z"`.
    stop: until when; UTC. E.g. `"2015-02-27T17:21:30Z"`.
    """

    most: ClassVar[int] = 1000  # a week of the busiest days

    start: datetime
    stop: datetime

    def __post_init__(self) -> None:
        if not elapsed_s(self.stop, self.start) > 0.0:
            raise ValueError(
                f"stop ({utc_text(self.stop)}) must come after start ({utc_text(self.start)})"
            )

    @property
    def told(self) -> dict[str, str]:
        """As a request has it."""
        return {"start": utc_text(self.start, 6), "stop": utc_text(self.stop, 6)}


PastLooks = Annotated[tuple[PastLook, ...], Field(max_length=PastLook.most)]


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
    past_looks: sessions of earlier plans that imaged, which `min_gap_s` and `duty_cycle` of
    `conditions` count; of more than a thousand the last.
    assumed: what of it nobody gave.
    """

    epoch: datetime
    angles_deg: Mapping[str, AngleDeg] = field(default_factory=dict)
    rates_deg_s: Mapping[str, MotionDeg] = field(default_factory=dict)
    accelerations_deg_s2: Mapping[str, MotionDeg] = field(default_factory=dict)
    q_body_from_eci_xyzw: Quaternion | None = None
    omega_body_deg_s: BodyMotionDeg | None = None
    alpha_body_deg_s2: BodyMotionDeg | None = None
    past_looks: PastLooks = ()
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
        return [name for name in BodyRules.state_members if getattr(self, name) is not None]

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


@spec
class Session:
    """One target held from `start` to `stop`.

    id: your name for it, different from the other sessions'; the plan repeats it. E.g. `"LV-7"`.
    name: name of the session, repeated in the plan and in lists. E.g. `"Las Vegas, east"`.
    target: the target that is tracked. An imaging mode becomes one or more sessions with paths: the
    first begins at start, the others as soon as the slews let them, and all are over by stop.
    start: from when on the target is held; UTC.
    stop: until when it is held; UTC.
    keyhole: treatment of spans where following the target exactly would break a limit, as it does
    near the outer axis: refuse, or follow as near as the limits allow, in the frame.
    roll: of a body, the rule by which its camera lies about the line of sight; the platform's
    unless given, in imaging modes lines_across_motion.
    fits_by: of a session that begins as soon after start as the slew to it lets it, and lasts as
    long: by when it is over; UTC. E.g. `"2024-06-01T10:03:00Z"`.
    of: id of the imaging mode's session that it was made from; of an imaging mode left out.
    E.g. `"area"`.
    """

    id: str | None = None
    name: str | None = None
    if TYPE_CHECKING:
        target: Target
    else:
        target: AskedTarget
    start: datetime
    stop: datetime
    keyhole: Keyhole = "refuse"
    roll: RollRule | None = None
    fits_by: datetime | None = None
    of: str | None = None

    def __post_init__(self) -> None:
        for text in ("id", "name", "of"):
            if getattr(self, text) == "":
                raise ValueError(f"{text} must not be empty; leave it out for none")
        if self.fits_by is None:
            # Bound now, so that a session cut short later keeps the target's timetable.
            object.__setattr__(self, "target", self.target.starting(self.start))
        elif elapsed_s(self.fits_by, self.stop) < 0.0:
            raise ValueError(
                f"fits_by ({utc_text(self.fits_by)}) must not come before stop "
                f"({utc_text(self.stop)}): the session can only begin later"
            )
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
    terrain: heights of the ground under targets that say none themselves.
    final_state: angles at which the axes are brought to rest when the last session is over, or
    "idle" for a body's idle attitude; unless given, the table ends with that session, in motion.
    final_by: by when `final_state` is reached; UTC; unless given, as soon as is smooth. E.g.
    `"2015-02-27T17:40:00Z"`.
    resources: battery, memory and wheels, from row 0 to the table's end.
    conditions: conditions of light and view throughout every session that looks somewhere, and
    rules among these sessions.
    clouds: a forecast of clouds, for the probability that each session is clear.
    """

    name: str = ""
    platform: AnyPlatform
    orbit: Orbit
    attitude: Attitude | None = None
    initial_state: InitialState
    sessions: tuple[Session, ...]
    slew: SlewOptions = SlewOptions()
    on_conflict: OnConflict = "refuse"
    terrain: Terrain | None = None
    final_state: FinalState | None = None
    final_by: datetime | None = None
    resources: Resources | None = None
    conditions: Conditions = Conditions()
    clouds: Clouds | None = None

    def __post_init__(self) -> None:
        if not self.sessions:
            raise ValueError("sessions must hold at least one session")
        kept = self.platform.keeping(self.conditions.directions)
        object.__setattr__(self, "platform", kept)
        standing = all_standing_on(self.terrain, self.sessions, "sessions")
        object.__setattr__(self, "sessions", standing)
        if any(isinstance(session.target, ImagingMode) for session in self.sessions):
            object.__setattr__(self, "sessions", tuple(self._plain_sessions()))
        earliest_utc, what = self.initial_state.epoch, "initial_state.epoch"
        for number, session in enumerate(self.sessions):
            if elapsed_s(session.start, earliest_utc) < 0.0:
                raise ValueError(
                    f"sessions.{number}.start ({utc_text(session.start)}) must not come before "
                    f"{what} ({utc_text(earliest_utc)})"
                )
            earliest_utc, what = session.stop, f"sessions.{number}.stop"
        if self.final_by is not None and self.final_state is None:
            raise ValueError("final_by must be left out, or final_state be given, which it is for")
        self._check_ids()
        rules_of(self.platform).require(self)

    def final_rows(self, last_row: int) -> float:
        """How many rows after its last session's last row the table may end; inf: no bound."""
        if self.final_by is None:
            return math.inf
        by_s = elapsed_s(self.final_by, self.initial_state.epoch)
        return math.floor(by_s / COMMAND_STEP_S + 1e-6) - last_row

    def _plain_sessions(self) -> Iterator[Session]:
        """Each imaging mode's as sessions with paths, in the order of its scans."""
        for number, session in enumerate(self.sessions):
            if not isinstance(session.target, ImagingMode):
                yield session
                continue
            for given in ("of", "fits_by"):
                if getattr(session, given) is not None:
                    raise ValueError(
                        f"sessions.{number}.{given} must be left out of an imaging mode, whose "
                        "stop says by when its sessions are over"
                    )
            yield from self._scanning_sessions(number, session, session.target)

    def _scanning_sessions(
        self, number: int, session: Session, mode: ImagingMode
    ) -> Iterator[Session]:
        window = ScanWindow(
            orbit=self.orbit,
            scanning=self.platform.scanning,
            start_utc=session.start,
            stop_utc=session.stop,
        )
        try:
            scans = mode.scans(window)
        except ValueError as error:
            raise ValueError(f"sessions.{number}.{error}") from None
        of = session.id or session.name or f"{mode.mode}-{number + 1}"
        stop_utc = session.start
        for part, scan in enumerate(scans, start=1):
            start_utc = scan.start_utc or stop_utc
            stop_utc = shifted_utc(start_utc, scan.duration_s)
            is_alone = len(scans) == 1
            yield replace(
                session,
                id=session.id if is_alone or not session.id else f"{session.id}-{part}",
                name=f"{of} {part}/{len(scans)}" if not is_alone else session.name,
                target=scan.target,
                start=start_utc,
                stop=stop_utc,
                roll=session.roll or rules_of(self.platform).scan_roll,
                fits_by=None if scan.start_utc else session.stop,
                of=of,
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
    def last_utc(self) -> datetime:
        """By when the last session is over at the latest."""
        return self.sessions[-1].fits_by or self.sessions[-1].stop

    @property
    def keeps_out(self) -> bool:
        """Whether there are directions that the boresight must not enter."""
        return bool(self.slew.keep_out or self.platform.masks)

    @property
    def needs_orbit_throughout(self) -> bool:
        """Whether the orbit must be known from row 0 on, not over the sessions alone."""
        return bool(self.slew.keep_out or self.resources) or self.attitude is None

    @property
    def assumed(self) -> tuple[Assumed, ...]:
        """What was looked up, or taken where nothing was given."""
        looked_up = (
            session.target.assumed(f"sessions.{number}.target")
            for number, session in enumerate(self.sessions)
        )
        return (*self.initial_state.assumed, *filter(None, looked_up))

    @property
    def law(self) -> Attitude:
        """The attitude of the carrier that two axes stand on; raises NotForPlatform."""
        if self.attitude is None:
            raise self.not_for_platform()
        return self.attitude

    def q_body_from_eci(self, instants: Instants, states: OrbitStates, position: Array) -> Rotation:
        """n attitudes of the carrier by its law, or of a body as its positions (n, 4) are."""
        if self.attitude is None:
            return Rotation.from_quat(position).inv()
        return self.attitude.q_body_from_eci(instants, states)

    def may_wait_after(self, ended: AnyPlatform, end_utc: datetime) -> bool:
        """Whether its platform waits, as a plan of `ended` left it at its end, until the epoch."""
        start = self.initial_state
        is_over = elapsed_s(start.epoch, end_utc) >= 0.0
        return is_over and rules_of(self.platform).may_wait_after(ended, start)

    def not_for_platform(self) -> NotForPlatform:
        """Of what only two axes on a carrier have."""
        return NotForPlatform(
            f"{self.platform.name} is a platform of kind {self.platform.kind}, and this is for two "
            "axes on a carrier only; leave it out, or plan for two axes",
            field="platform.kind",
        )
