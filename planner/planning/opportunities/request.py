"""A request for opportunities: targets, a span of time, and the conditions to be met."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from typing import Annotated

from pydantic import Field

from planner.base.assumed import Assumed
from planner.base.spec import Within, spec
from planner.world.attitude import Attitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.clouds import Clouds
from planner.world.conditions import Conditions
from planner.world.frames.time_scales import DAY_S, elapsed_s, utc_text
from planner.world.orbits import Orbit
from planner.world.platforms import PIXELS_ARCSEC, AnyPlatform, RollRule
from planner.world.rules.registry import rules_of
from planner.world.targets import ChosenTarget, ImagingMode
from planner.world.targets.session_target import all_standing_on
from planner.world.targets.terrain import Terrain


@dataclass(frozen=True, kw_only=True)
class OpportunityBounds:
    """What a search for opportunities may ask for."""

    samples: tuple[int, int] = (2, 1000)  # a window's edges at least
    targets_max: int = 10_000  # whole catalogues of cities, an operator's day
    days_max: float = 31.0  # elements say nothing of a month later
    # Targets times days times samples and what a window costs without any: the memory they take.
    # 1,000 places for 10 days with 5 samples: 2 s as a rule; the work itself is counted.
    work_max: int = 200_000
    window_counts: int = 15  # as samples
    moving_counts: int = 150  # as places: what is not fixed to the Earth is looked at one by one


BOUNDS = OpportunityBounds()


@spec
class OpportunityTarget:
    """A target by a name of the user's; greater priority matters more.

    id: your name for it, different from the others'; windows repeat it.
    target: the target. An imaging mode becomes scans in every pass, each with windows of its own.
    priority: weight of the target beside the others.
    roll: of a body, the rule by which its camera lies on the target, as a session's; the platform's
    unless given. E.g. `{"rule": "azimuth", "azimuth_deg": 15.0}`.
    """

    id: str
    target: ChosenTarget
    priority: Annotated[float, Within(-1e6, 1e6)] = 1.0
    roll: RollRule | None = None

    def __post_init__(self) -> None:
        if not self.id:
            raise ValueError("id must not be empty: windows are reported by it")
        if isinstance(self.target, ImagingMode):
            require_known_roll(self.target, self.roll)
        elif not self.target.has_windows:
            raise ValueError(
                f"`{self.target.mode}` belongs to a session and has no windows of its own; ask "
                "for those of a ground_path's points, as ground targets, or of an imaging mode"
            )


def modes_by_row(targets: Iterable[object]) -> Mapping[int, ImagingMode]:
    """Those of targets that are imaging modes, by row."""
    return {row: target for row, target in enumerate(targets) if isinstance(target, ImagingMode)}


def require_known_roll(mode: ImagingMode, roll: RollRule | None) -> None:
    """Raises ValueError where a rule hangs on what isn't known before a plan."""
    if roll is not None and roll.rule == "nearest":
        raise ValueError(
            f"roll.rule must not be nearest for {mode.label}: the attitude before a scan isn't "
            "known before a plan; give another rule, or leave roll out"
        )


@spec
class OpportunityConditions(Conditions):
    """Conditions that hold throughout a window.

    Those of off nadir, ground sample, the Sun's elevation and glint apply to targets on the Earth
    only.

    min_duration_s: shorter windows are left out.
    """

    min_duration_s: Annotated[float, Within(0.0, 86400.0)] = 0.0


@spec
class OpportunityRequest:
    """A platform, its orbit, and the targets it may look at from `start` to `stop`.

    name: your name for it, shown in lists.
    attitude: attitude of the carrier that two axes stand on, its local orbital frame unless given;
    a body steers itself and has none.
    targets: the targets to search for.
    terrain: heights of the ground under targets that say none themselves.
    start: start of the search; UTC.
    stop: end of the search; UTC.
    clouds: a forecast of clouds, for the probability that each window is clear.
    samples: instants per window, its edges included, at which angles and the rest are given.
    pixel_arcsec: angle a pixel sees, for the ground sample distance; unless given, that of the
    platform's camera. E.g. `0.68`.
    """

    name: str = ""
    platform: AnyPlatform
    orbit: Orbit
    attitude: Attitude | None = None
    targets: Annotated[tuple[OpportunityTarget, ...], Field(max_length=BOUNDS.targets_max)]
    start: datetime
    stop: datetime
    terrain: Terrain | None = None
    conditions: OpportunityConditions = OpportunityConditions()
    clouds: Clouds | None = None
    samples: Annotated[int, Within(*BOUNDS.samples)] = 5
    pixel_arcsec: Annotated[float, Within(*PIXELS_ARCSEC)] | None = None

    def __post_init__(self) -> None:
        if elapsed_s(self.stop, self.start) < 1.0:
            raise ValueError(
                f"stop ({utc_text(self.stop)}) must come a second or more after start "
                f"({utc_text(self.start)})"
            )
        kept = self.platform.keeping(self.conditions.directions)
        object.__setattr__(self, "platform", kept)
        rules = rules_of(self.platform)
        rules.require_attitude(self.attitude)
        if not self.targets:
            raise ValueError("targets must hold at least one target")
        standing = all_standing_on(self.terrain, self.targets, "targets")
        object.__setattr__(self, "targets", standing)
        seen: set[str] = set()
        for number, wanted in enumerate(self.targets):
            if wanted.id in seen:
                raise ValueError(
                    f"targets.{number}.id {wanted.id!r} is taken already; windows are told by id"
                )
            seen.add(wanted.id)
            wanted.target.require_known(f"targets.{number}.target", self.start, self.stop)
            target = wanted.target
            path = target.first_path if isinstance(target, ImagingMode) else target
            rules.require_roll(f"targets.{number}.roll", wanted.roll, path)
        self._require_bounds()

    @property
    def platform_names(self) -> str:
        """Of the one that looks."""
        return self.platform.name

    @property
    def ids(self) -> tuple[str, ...]:
        """Of the targets, in order."""
        return tuple(wanted.id for wanted in self.targets)

    def least_elevation_deg(self, target: ChosenTarget) -> float:
        """From which on a target is seen; of one in space above the limb."""
        asked_deg = self.conditions.min_elevation_deg if target.images else 0.0
        return max(asked_deg, getattr(target, "min_elevation_deg", 0.0))

    @cached_property
    def modes(self) -> Mapping[int, ImagingMode]:
        """Targets that are imaging modes, by row."""
        return modes_by_row(wanted.target for wanted in self.targets)

    def with_middles(self) -> "OpportunityRequest":
        """The same of each imaging mode's middle in its place."""
        middles = {
            row: OpportunityTarget(id=self.targets[row].id, target=mode.middle)
            for row, mode in self.modes.items()
        }
        if not middles:
            return self
        targets = (middles.get(row, wanted) for row, wanted in enumerate(self.targets))
        return replace(self, targets=tuple(targets))

    def roll_on_scans(self, row: int) -> RollRule | None:
        """How the platform lies on the lines of a mode."""
        return self.targets[row].roll or rules_of(self.platform).scan_roll

    @property
    def law(self) -> Attitude:
        """The attitude of the carrier that two axes stand on."""
        return self.attitude or LvlhAttitude()

    @property
    def pixel_rad(self) -> float:
        """Angle a pixel sees."""
        if self.pixel_arcsec is None:
            return self.platform.camera.pixel_rad
        return math.radians(self.pixel_arcsec / 3600.0)

    @property
    def assumed(self) -> tuple[Assumed, ...]:
        """Where the targets are that are given by name."""
        looked_up = (
            wanted.target.assumed(f"targets.{number}.target")
            for number, wanted in enumerate(self.targets)
        )
        return tuple(filter(None, looked_up))

    def _require_bounds(self) -> None:
        days = elapsed_s(self.stop, self.start) / DAY_S
        if days > BOUNDS.days_max:
            raise ValueError(
                f"stop must come within {BOUNDS.days_max:.0f} days of start, not {days:.1f}"
            )
        counted = sum(
            1 if wanted.target.rests_on_earth else BOUNDS.moving_counts for wanted in self.targets
        )
        if counted * days * (BOUNDS.window_counts + self.samples) > BOUNDS.work_max:
            raise ValueError(
                f"targets times days times ({BOUNDS.window_counts} + samples) must not exceed "
                f"{BOUNDS.work_max} (a target that is no point of the ground counts "
                f"{BOUNDS.moving_counts} times), which these {len(self.targets)} over {days:.1f} "
                f"days with {self.samples} samples do; ask for fewer at a time"
            )
