"""For which targets are opportunities sought, from when to when, and what makes one?"""

import math
from datetime import datetime

from planner.attitude import Attitude
from planner.attitude.lvlh import LvlhAttitude
from planner.frames.time_scales import elapsed_s, require_offset, utc_text
from planner.orbits import Orbit
from planner.platforms import TwoAxisPlatform
from planner.spec import require_within, spec
from planner.targets import GroundTarget, MovingGroundTarget, SkyTarget, Target

HRC_PIXEL_ARCSEC = math.degrees(1.15 / 350e3) * 3600.0  # 1.15 m from 350 km: Sumarokov 2016


@spec
class OpportunityTarget:
    """A target by a name of the user's; greater priority matters more."""

    id: str
    target: Target
    priority: float = 1.0

    def __post_init__(self) -> None:
        if not self.id:
            raise ValueError("id must not be empty: windows are reported by it")
        if not isinstance(self.target, GroundTarget | MovingGroundTarget | SkyTarget):
            raise ValueError(
                f"a {self.target.mode} belongs to a session and has no windows of its own; ask "
                "for those of a ground_path's points, as ground targets"
            )


@spec
class OpportunityConditions:
    """What must hold throughout a window.

    min_elevation_deg: of the carrier in the target's sky, on top of the target's own least
    elevation (the greater counts); without refraction.  sun_elevation_*_deg: of the Sun's
    centre at the target, without refraction; these two and max_off_nadir_deg (from the
    geocentric nadir) apply to targets on the Earth only.
    *_keep_out_deg: least angle between line of sight and the centre of the Sun or Moon,
    wherever the Earth doesn't hide that body.
    """

    min_elevation_deg: float = 0.0
    max_off_nadir_deg: float | None = None
    sun_elevation_min_deg: float | None = None
    sun_elevation_max_deg: float | None = None
    sun_keep_out_deg: float | None = None
    moon_keep_out_deg: float | None = None
    min_duration_s: float = 0.0

    def __post_init__(self) -> None:
        require_within(
            self,
            ("min_elevation_deg", 0.0, 90.0),
            ("max_off_nadir_deg", 0.0, 180.0),
            ("sun_elevation_min_deg", -90.0, 90.0),
            ("sun_elevation_max_deg", -90.0, 90.0),
            ("sun_keep_out_deg", 0.0, 180.0),
            ("moon_keep_out_deg", 0.0, 180.0),
            ("min_duration_s", 0.0, math.inf),
        )
        low, high = self.sun_elevation_min_deg, self.sun_elevation_max_deg
        if low is not None and high is not None and not low < high:
            raise ValueError(
                f"sun_elevation_min_deg ({low:g}) must be less than sun_elevation_max_deg "
                f"({high:g}), or the Sun never stands between them"
            )


@spec
class OpportunityRequest:
    """A carrier, a platform on it, and the targets it may look at from `start` to `stop`.

    samples: instants per window, its edges included, at which angles and the rest are told.
    pixel_arcsec: angle a pixel sees, for the ground sample distance.
    """

    orbit: Orbit
    attitude: Attitude = LvlhAttitude()
    platform: TwoAxisPlatform
    targets: tuple[OpportunityTarget, ...]
    start: datetime
    stop: datetime
    conditions: OpportunityConditions = OpportunityConditions()
    samples: int = 5
    pixel_arcsec: float = HRC_PIXEL_ARCSEC

    def __post_init__(self) -> None:
        require_offset("start", self.start)
        require_offset("stop", self.stop)
        if elapsed_s(self.stop, self.start) < 1.0:
            raise ValueError(
                f"stop ({utc_text(self.stop)}) must come a second or more after start "
                f"({utc_text(self.start)})"
            )
        if not self.targets:
            raise ValueError("targets must hold at least one target")
        seen: set[str] = set()
        for number, wanted in enumerate(self.targets):
            if wanted.id in seen:
                raise ValueError(
                    f"targets.{number}.id {wanted.id!r} is taken already; windows are told by id"
                )
            seen.add(wanted.id)
            if isinstance(wanted.target, MovingGroundTarget):
                wanted.target.require_known(f"targets.{number}.target", self.start, self.stop)
        if self.samples < 2:
            raise ValueError(f"samples must be 2 at least, a window's edges, not {self.samples}")
        if not self.pixel_arcsec > 0.0:
            raise ValueError(f"pixel_arcsec must be positive, not {self.pixel_arcsec}")
