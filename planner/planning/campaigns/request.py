"""A request for a campaign: targets that compete for the platform, and their worth."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from typing import Annotated

import numpy as np
from pydantic import Field

from planner.base.assumed import Assumed
from planner.base.commands import COMMAND_STEP_S
from planner.base.spec import Within, require_within, spec
from planner.planning.campaigns.revision import Revision
from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
)
from planner.planning.opportunities.request import BOUNDS as OPPORTUNITY_BOUNDS
from planner.planning.opportunities.request import modes_by_row, require_known_roll
from planner.world.attitude import Attitude
from planner.world.clouds import Clouds
from planner.world.conditions import DutyCycle
from planner.world.frames.time_scales import DAY_S, Instants, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Orbit
from planner.world.platforms import PIXELS_ARCSEC, AngleDeg, AnyPlatform, RollRule
from planner.world.resources import Resources
from planner.world.rules.registry import rules_of
from planner.world.scenario import Quaternion, SlewOptions
from planner.world.targets import ChosenTarget, ImagingMode
from planner.world.targets.session_target import all_standing_on
from planner.world.targets.terrain import Terrain


@dataclass(frozen=True, kw_only=True)
class CampaignBounds:
    """What a campaign may ask for, whose choice then takes some minutes at most."""

    # grids on which observations begin: from two rows of the table on
    steps_s: tuple[float, float] = (0.4, 30.0)
    lengths: int = 3  # lengths of a look that are tried, evenly from the least to the wanted one
    # a table's 21,600 s less ten minutes for the way from rest and back
    session_max_s: float = 21_000.0
    # 1,000 places for 20 days, or two carriers with 10,000 all over the Earth for one: 150 s
    target_days_max: float = 20_000.0
    step_s: float = 2.0  # finer steps count more
    moving_counts: int = 100  # what is not fixed to the Earth is looked at one by one
    # longer looks make passes longer, in which more targets compete, and count more
    session_s: float = 1800.0
    gap_max_s: float = 1800.0  # half a usual pass: a cut between two leaves so much free
    mode_counts: int = 20  # an imaging mode becomes several scans in each pass


BOUNDS = CampaignBounds()

_Weight = Annotated[float, Within(0.0, 10.0)]


@spec
class ViewWeights:
    """Weights of the view's qualities in the worth of a look.

    Qualities lie between 0 and 1; a look is worth their product, each to the power of its
    weight, as a mean over the look.  A weight of 0 leaves one out, 1 counts it in proportion.
    All but the last are 1 for a target in space, all of them for a station.

    ground_sample: weight of the ground sample straight below the carrier over that at the target
    (longer side of a pixel).
    off_nadir: weight of the cosine of the angle from the geocentric nadir.
    sun: weight of the sine of the Sun's elevation at the target, 0 by night.
    probability: weight of the probability that the target is in the frame at an instant; that it
    stays there for the whole look, which a plan states, is less by 0.1 or so.
    """

    ground_sample: _Weight = 1.0
    off_nadir: _Weight = 0.0
    sun: _Weight = 0.0
    probability: _Weight = 0.0


@spec
class CampaignTarget:
    """A target, the look it is to get, and what that is worth.

    A look that lasts from min_session_s to session_s is worth its share of session_s times
    `priority`, times the quality of its view.

    id: your name for it, different from the others'.
    target: the target. An imaging mode becomes scans in every pass, of which all are done in one
    pass, or none, in any order; looks of a stereo lie evenly about its middle.
    priority: worth of one whole look at the best view, of an imaging mode of all its scans.
    session_s: duration of a look; left out for an imaging mode, whose speed says it. E.g. `12.0`.
    min_session_s: least duration of a look; `session_s` unless given.
    looks: no more than so many, and one in a pass.
    roll: of a body, the rule by which its camera lies on the target, as a session's; the platform's
    unless given. E.g. `{"rule": "azimuth", "azimuth_deg": 15.0}`.
    group: targets of the same group are all looked at once, or none of them. E.g. `"stereo 7"`.
    sensor: of several `carriers`, only those with this one may look at it. E.g. `"infrared"`.
    release: looks begin then at the soonest; UTC. E.g. `"2015-02-27T12:00:00Z"`.
    due: looks have ended by then; UTC. E.g. `"2015-02-27T21:00:00Z"`.
    """

    id: str
    target: ChosenTarget
    priority: Annotated[float, Within(1e-3, 1e6)] = 1.0
    session_s: Annotated[float, Within(1.0, BOUNDS.session_max_s)] | None = None
    min_session_s: Annotated[float, Within(1.0, BOUNDS.session_max_s)] | None = None
    looks: Annotated[int, Within(1, 1000)] = 1
    roll: RollRule | None = None
    group: str | None = None
    sensor: str | None = None
    release: datetime | None = None
    due: datetime | None = None

    def __post_init__(self) -> None:
        if self.release and self.due and elapsed_s(self.due, self.release) < 1.0:
            raise ValueError(
                f"due ({utc_text(self.due)}) must come a second or more after release "
                f"({utc_text(self.release)})"
            )
        if isinstance(self.target, ImagingMode):
            self._require_mode(self.target)
            return
        _ = self.opportunity
        if self.session_s is None:
            raise ValueError("session_s is required: it says how long a look lasts")
        if self.group is not None and self.looks > 1:
            raise ValueError(
                f"looks must be 1, not {self.looks}, of a target with a group, which is looked at "
                "once"
            )
        require_within(self, ("min_session_s", 1.0, self.session_s))

    def _require_mode(self, mode: ImagingMode) -> None:
        if not self.id:
            raise ValueError("id must not be empty: looks are reported by it")
        for name, why in (
            ("session_s", "whose speed_m_s says how long its scans last"),
            ("min_session_s", "whose scans are done from end to end"),
            ("group", "whose scans are a group of their own"),
        ):
            if getattr(self, name) is not None:
                raise ValueError(f"{name} must be left out for {mode.label}, {why}")
        require_known_roll(mode, self.roll)

    @cached_property
    def opportunity(self) -> OpportunityTarget:
        """To be searched for when it can be seen, of an imaging mode its middle; one, however many
        carriers search."""
        if isinstance(self.target, ImagingMode):
            return OpportunityTarget(id=self.id, target=self.target.middle)
        return OpportunityTarget(id=self.id, target=self.target, roll=self.roll)

    @cached_property
    def lengths_s(self) -> tuple[float, ...]:
        """The lengths an observation may have, ascending, whole command steps; of no mode."""
        assert self.session_s is not None
        least_s = self.session_s if self.min_session_s is None else self.min_session_s
        wanted = [
            least_s + share / (BOUNDS.lengths - 1) * (self.session_s - least_s)
            for share in range(BOUNDS.lengths)
        ]
        rows = [math.ceil(length_s / COMMAND_STEP_S - 1e-6) for length_s in wanted]
        return tuple(sorted({row * COMMAND_STEP_S for row in rows}))

    def span_s(self, start_utc: datetime) -> tuple[float, float]:
        """From when to when looks lie, in seconds since an instant."""
        return (
            -math.inf if self.release is None else elapsed_s(self.release, start_utc),
            math.inf if self.due is None else elapsed_s(self.due, start_utc),
        )

    def worth_value(self, length_s: float) -> float:
        """The worth of an observation that lasts so long at the best view."""
        assert self.session_s is not None
        return self.priority * min(length_s / self.session_s, 1.0)


@spec
class CampaignCommon:
    """Targets to be looked at from `start` to `stop`, and what a look at them is worth.

    name: your name for it, shown in lists.
    targets: the targets to choose from.
    terrain: heights of the ground under targets that say none themselves; the requests of the
    passes have the heights instead of it.
    start: start of the campaign; UTC, rounded up to a command row. E.g. `"2015-02-27T12:00:00Z"`.
    stop: end of the campaign; UTC. E.g. `"2015-02-28T00:00:00Z"`.
    clouds: a forecast of clouds: a look is worth what it would be in a clear sky, times the
    probability of that, where the forecast says one.
    view: weights of the view's qualities in the worth of a look.
    step_s: looks begin on whole multiples of it after `start`; finer finds more and takes longer.
    revises: the campaign that this one revises: what flies soon stays, later looks are chosen anew.
    """

    name: str = ""
    targets: Annotated[tuple[CampaignTarget, ...], Field(max_length=OPPORTUNITY_BOUNDS.targets_max)]
    start: datetime
    stop: datetime
    terrain: Terrain | None = None
    conditions: OpportunityConditions = OpportunityConditions()
    clouds: Clouds | None = None
    view: ViewWeights = ViewWeights()
    step_s: Annotated[float, Within(*BOUNDS.steps_s)] = BOUNDS.step_s
    revises: Revision | None = None


@spec
class CarrierCommon:
    """A platform in its orbit, as a campaign asks for it.

    attitude: attitude of the carrier that two axes stand on, its local orbital frame unless given;
    a body steers itself and has none.
    rest_angles_deg: angles at which two axes rest before, between and after passes, by axis; 0
    unless given. A body rests on its idle attitude. E.g. `{"alpha": 0.0, "beta": 0.0}`.
    initial_q_body_from_eci_xyzw: of a body, attitude in which it rests at the start, scalar last,
    as of an `initial_state`; its idle attitude unless given. The first pass begins in it, unless
    there is time for the idle attitude before. E.g. `[0.0, 0.0, 0.0, 1.0]`.
    slew: options of its slews between targets.
    pixel_arcsec: angle that a pixel covers, for the ground samples; unless given, that of the
    platform's camera. E.g. `0.68`.
    resources: battery, memory and wheels, from `start` to `stop`; each pass's request begins with
    what the passes before leave.
    """

    platform: AnyPlatform
    orbit: Orbit
    attitude: Attitude | None = None
    rest_angles_deg: Mapping[str, AngleDeg] | None = None
    initial_q_body_from_eci_xyzw: Quaternion | None = None
    slew: SlewOptions = SlewOptions()
    pixel_arcsec: Annotated[float, Within(*PIXELS_ARCSEC)] | None = None
    resources: Resources | None = None


@spec
class CampaignRequest(CarrierCommon, CampaignCommon):
    """A platform, its orbit, and targets to be looked at from `start` to `stop`."""

    def __post_init__(self) -> None:
        steps = self.step_s / COMMAND_STEP_S
        if abs(steps - round(steps)) > 1e-6:
            raise ValueError(
                f"step_s must be a whole multiple of {COMMAND_STEP_S:g} s, the table's step, not "
                f"{self.step_s:g}"
            )
        if self.slew.method != "ocp":
            raise ValueError(
                "slew.method must be ocp: the choice of sessions relies on slews that keep the "
                "limits"
            )
        for number, wanted in enumerate(self.targets):
            if wanted.sensor is not None:
                raise ValueError(
                    f"targets.{number}.sensor must be left out: it chooses among `carriers`, and "
                    "here is but one platform"
                )
        self._require_cadence()
        standing = all_standing_on(self.terrain, self.targets, "targets")
        object.__setattr__(self, "targets", standing)
        rules = rules_of(self.platform)
        begin_q_xyzw = self.initial_q_body_from_eci_xyzw
        rules.require_rest(self.rest_angles_deg, begin_q_xyzw, self.attitude, self.slew)
        rules.require_wheels(self.resources)
        self._require_followed()
        self._require_bounds()
        self.opportunities()
        if self.revises is not None:
            self.revises.require(self.start, self.stop)
        for row, mode in self.modes.items():
            rules.require_roll(f"targets.{row}.roll", self.targets[row].roll, mode.first_path)

    def _require_followed(self) -> None:
        kept = self.resources
        is_used = kept is not None and bool(kept.battery or kept.memory)
        followed = is_used or self.conditions.duty_cycle is not None
        for number, wanted in enumerate(self.targets if followed else ()):
            if not wanted.target.images:
                raise ValueError(
                    f"targets.{number}.target must be no {wanted.target.mode} in a campaign with "
                    "a battery, a memory or a duty cycle, whose choice doesn't follow what a look "
                    "at it sends: give it as a station of resources.memory, or plan a session at "
                    "it after the campaign"
                )

    @property
    def is_kept(self) -> bool:
        """Whether looks use up what there isn't any amount of."""
        return self.resources is not None or self.conditions.duty_cycle is not None

    @cached_property
    def duty_cycle(self) -> DutyCycle | None:
        """With its span, the same in all passes: on the orbit as it is at the start."""
        duty = self.conditions.duty_cycle
        if duty is None or duty.span_s is not None:
            return duty
        first = Instants(self.start, np.zeros(1))
        states = self.orbit.ephemeris(self.start, shifted_utc(self.start, 1.0)).states(first)
        return replace(duty, span_s=duty.lasts_s(first, states))

    def _require_cadence(self) -> None:
        if self.conditions.min_gap_s > BOUNDS.gap_max_s:
            raise ValueError(
                f"conditions.min_gap_s must not exceed {BOUNDS.gap_max_s:g} s in a campaign, not "
                f"{self.conditions.min_gap_s:g}: passes then have no room for two looks"
            )

    @cached_property
    def counted_target_days(self) -> float:
        """Targets times days, what takes longer counted more often."""
        counted = sum(
            1
            if wanted.target.rests_on_earth
            else BOUNDS.mode_counts
            if isinstance(wanted.target, ImagingMode)
            else BOUNDS.moving_counts
            for wanted in self.targets
        )
        finer = max(BOUNDS.step_s / self.step_s, 1.0)
        longer = max(self.longest_s / BOUNDS.session_s, 1.0)
        return counted * self.span_s / DAY_S * finer * longer

    def _require_bounds(self) -> None:
        days = self.span_s / DAY_S
        if self.counted_target_days > BOUNDS.target_days_max:
            raise ValueError(
                f"targets times days must not exceed {BOUNDS.target_days_max:.0f} at a step_s of "
                f"{BOUNDS.step_s:g} s and sessions to {BOUNDS.session_s:g} s (finer and longer "
                "count more, a target that is no point of the ground "
                f"{BOUNDS.moving_counts} times, an imaging mode {BOUNDS.mode_counts}), which these "
                f"{len(self.targets)} over {days:.1f} "
                "days do; ask for fewer at a time"
            )

    def opportunities(self) -> OpportunityRequest:
        """When each target can be seen at all, an imaging mode's middle in its place."""
        return self._opportunities

    @cached_property
    def _opportunities(self) -> OpportunityRequest:
        return OpportunityRequest(
            orbit=self.orbit,
            attitude=self.attitude,
            platform=self.platform,
            targets=tuple(wanted.opportunity for wanted in self.targets),
            start=self.start,
            stop=self.stop,
            conditions=self.conditions,
            samples=2,
            pixel_arcsec=self.pixel_arcsec,
        )

    @property
    def requests(self) -> "Mapping[str, CampaignRequest]":
        """As of several carriers."""
        return {"": self}

    def field_of(self, _carrier: str, field: str) -> str:
        """A field of the carrier's, as this request has it."""
        return field

    @property
    def carrier_ids(self) -> frozenset[str]:
        """As of several carriers."""
        return frozenset({""})

    @property
    def assumed(self) -> tuple[Assumed, ...]:
        """Where the targets are that are given by name."""
        return self.opportunities().assumed

    @property
    def platform_names(self) -> str:
        """Of the one that looks."""
        return self.platform.name

    @cached_property
    def modes(self) -> Mapping[int, ImagingMode]:
        """Targets that are imaging modes, by row."""
        return modes_by_row(wanted.target for wanted in self.targets)

    @property
    def rest_deg(self) -> Mapping[str, float]:
        """Where each axis rests, by its name."""
        if self.rest_angles_deg is None:
            return dict.fromkeys(self.platform.dof_names, 0.0)
        return self.rest_angles_deg

    @property
    def longest_s(self) -> float:
        """Of the looks that are wanted; scans last as long as their lines."""
        return max((wanted.session_s or 0.0 for wanted in self.targets), default=0.0)

    @property
    def span_s(self) -> float:
        """Seconds from start to stop."""
        return elapsed_s(self.stop, self.start)
