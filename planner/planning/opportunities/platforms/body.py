"""The search for windows of a spacecraft that turns as a whole."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from planner.base.arrays import Array
from planner.base.interpolation import NODES, UniformTable
from planner.base.rotation import Rotation
from planner.base.vectors import Vector
from planner.motion.attitude.idle import idle_attitude
from planner.motion.attitude.track import agility_limits, roll_rule
from planner.motion.pointing.reach import Reach
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.margins import WindowScene
from planner.planning.opportunities.platforms.lookout import HeldScans, Narrowing, kept_before
from planner.planning.opportunities.request import OpportunityConditions
from planner.planning.opportunities.sights import Sight
from planner.planning.opportunities.sweep import Found
from planner.planning.opportunities.tracking import (
    CELESTIAL,
    INERTIAL,
    NEAREST,
    NO_BODY,
    ROLLS,
    Rows3,
    Tracking,
    follow,
    follow_line,
)
from planner.planning.opportunities.windows import Cause
from planner.world.attitude import AttitudeLaw
from planner.world.exclusions import RADIUS_M, Surroundings, unkept_told
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms import AnyPlatform, BodyPlatform
from planner.world.platforms.body import (
    AzimuthRoll,
    Exclusion,
    MagnitudeAgility,
    SunSide,
)
from planner.world.platforms.kept_direction import unit_vector
from planner.world.targets.body import HIDDEN_RAD


@dataclass(frozen=True, kw_only=True)
class BodyLookoutOptions:
    """How finely what doesn't hang on a target is tabulated."""

    idle_step_s: float = 60.0  # a low orbit's idle attitude turns by 0.066 rad, to 1e-9 rad
    glint_step_s: float = 15.0  # it leaves the horizon at a kink


OPTIONS = BodyLookoutOptions()
ENDLESS = (math.inf, math.inf, math.inf)
# Along the track and across it, as of a view's boresight, in the local orbital frame.
ALONG_ACROSS = Reach(
    outer=(0.0, 1.0, 0.0),
    inner=(-1.0, 0.0, 0.0),
    zero=(0.0, 0.0, 1.0),
    normal=(0.0, 0.0, 1.0),
    square_sine=1.0,
    cosine=0.0,
    along_cosine=0.0,
    low=(-math.pi, -math.pi / 2.0),
    high=(math.pi, math.pi / 2.0),
    limits=(ENDLESS, ENDLESS),
    side_parameters=np.empty((0, 15)),
)


class BodyLookout:
    """As `Lookout` says; the base is the local orbital frame."""

    angle_names = ("along_track", "across_track")
    has_branches = False
    rests_in_orbit = True
    sees_bodies = True
    reach = ALONG_ACROSS
    causes: tuple[Cause, ...] = ()

    def __init__(self, platform: AnyPlatform, attitude: AttitudeLaw | None) -> None:
        """attitude: none, a body steers itself."""
        assert isinstance(platform, BodyPlatform)  # by the registry
        self.platform = platform
        self.settle_s = platform.envelope.settle_s
        self._tables: dict[tuple[str, Carrier], UniformTable] = {}

    def q_base_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        return q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)

    def warnings_at(self, instants: Instants) -> tuple[str, ...]:
        return ()

    def conditions(self, asked: OpportunityConditions) -> OpportunityConditions:
        most_deg = self.platform.off_nadir_max_deg
        if asked.max_off_nadir_deg is not None:
            most_deg = min(most_deg, asked.max_off_nadir_deg)
        return replace(asked, max_off_nadir_deg=most_deg)

    def hold(
        self, sight: Sight, scene: WindowScene, found: Found, shortest_s: float, looks_limit: float
    ) -> tuple[Found, Array, int]:
        most_rad = self.off_nadir_max_rad(sight)
        return follow(self.tracking(sight), scene, found, most_rad, (shortest_s, looks_limit))

    def held_scans(self, sight: Sight, begins_s: Array, duration_s: float) -> HeldScans:
        most_rad = math.radians(self.platform.off_nadir_max_deg)
        held = follow_line(
            self.tracking(sight), sight.carrier.tables, sight.places, begins_s, duration_s, most_rad
        )
        return HeldScans(*held.T)

    def off_nadir_max_rad(self, sight: Sight) -> float:
        """Of the camera while it images what is on the Earth, else any."""
        return math.radians(self.platform.off_nadir_max_deg) if sight.images else math.pi

    def tracking(self, sight: Sight) -> Tracking:
        """How it lies on targets that are seen alike."""
        platform, carrier = self.platform, sight.carrier
        roll = roll_rule(platform, sight.targets[0], sight.roll)
        aside_body = platform.camera.c_payload_from_body[0]
        if isinstance(roll, SunSide):
            aside_body = unit_vector(roll.direction_body)
        body_from_triad = _triad(platform.boresight_body, aside_body)
        limits = agility_limits(platform).inscribed
        trackers = platform.star_trackers if sight.images else None
        number = ROLLS.index(roll.rule)
        is_one_way = isinstance(roll, SunSide) or number == NEAREST
        tracking = NO_BODY._replace(
            roll=number,
            senses=1 if is_one_way or not platform.camera.both_ways else 2,
            body_from_triad=_rows(body_from_triad),
            kept_parameters=self._kept(body_from_triad, sight.images),
            limits=_rows(limits.by_order.T),
            is_by_axis=limits.kind == "axis",
            settle_s=platform.envelope.settle_s,
            disks_m=(RADIUS_M["sun"], RADIUS_M["moon"]),
            hidden_rad=HIDDEN_RAD,
        )
        if isinstance(roll, AzimuthRoll):
            tracking = tracking._replace(azimuth_rad=math.radians(roll.azimuth_deg))
        if trackers is not None:
            tracking = tracking._replace(needed=trackers.needed, trackers=len(trackers.each))
        if number == NEAREST:
            table = self._table("idle", carrier)
            tracking = tracking._replace(idle_step_s=table.step_s, idle=table.powers)
        if any(one.body in ("glint", "inertial") for one in platform.exclusions):
            table = self._table("sky", carrier)
            tracking = tracking._replace(glint_step_s=table.step_s, glint=table.powers)
        return tracking

    def kept_names(self, images: bool) -> tuple[str, ...]:
        kept = [one for one in self.platform.exclusions if images or one.when == "always"]
        return (*map(_edge_name, kept), "star_trackers")

    def narrowing(self) -> Iterator[Narrowing]:
        platform = self.platform
        # What it may turn by says nothing of its torque here.
        blind = replace(
            platform,
            agility=MagnitudeAgility(
                rate_max_deg_s=1e3, acceleration_max_deg_s2=1e3, jerk_max_deg_s3=1e3
            ),
            gyros=None,
            torque_max_n_m=None,
            exclusions=(),
            star_trackers=None,
        )
        yield Narrowing(
            "off_nadir",
            blind,
            "while it is in sight it stands farther off nadir than the "
            f"{platform.off_nadir_max_deg:g} deg of {platform.name}",
            "off_nadir",
        )
        seen = "whenever the camera can look there"
        for count, one in enumerate(platform.exclusions, start=1):
            kept = replace(blind, exclusions=platform.exclusions[:count])
            because = f"{seen}{kept_before(count)}, {unkept_told(one)}"
            yield Narrowing("exclusion", kept, because, _edge_name(one))
        if platform.star_trackers is not None:
            kept = replace(
                blind, exclusions=platform.exclusions, star_trackers=platform.star_trackers
            )
            because = f"{seen}, too few star trackers see stars with the exclusions kept"
            yield Narrowing("exclusion", kept, because, "star_trackers")
        because = "to follow it the body would have to turn faster than it can"
        yield Narrowing("rate", platform, because, "rate")

    def _kept(self, body_from_triad: Array, images: bool) -> Array:
        """As `Tracking.kept_parameters`."""
        platform, trackers = self.platform, self.platform.star_trackers
        kept = [
            (platform.direction_of(one), self._which(one), one.kept_deg)
            for one in platform.exclusions
            if images or one.when == "always"
        ]
        for tracker in trackers.each if images and trackers is not None else ():
            direction_body = unit_vector(tracker.boresight_body)
            kept += [(direction_body, CELESTIAL.index(c), deg) for c, deg in tracker.least_deg]
        rows = [
            (*(body_from_triad @ direction_body), which, math.radians(deg))
            for direction_body, which, deg in kept
        ]
        return np.array(rows, dtype=np.float64).reshape(-1, 5)

    def _table(self, what: str, carrier: Carrier) -> UniformTable:
        """Of the idle attitude, or of sunglint and stars, over the carrier's time."""
        if (what, carrier) not in self._tables:
            step_s = OPTIONS.idle_step_s if what == "idle" else OPTIONS.glint_step_s
            cells = max(math.ceil(carrier.span_s / step_s), NODES + 1)
            instants = Instants(carrier.start_utc, np.linspace(0.0, carrier.span_s, cells + 1))
            c_itrf = c_itrf_from_eci(instants)
            of = self._idle_itrf if what == "idle" else self._sky_itrf
            columns = of(instants, carrier.states(instants), c_itrf)
            self._tables[what, carrier] = UniformTable(carrier.span_s / cells, columns)
        return self._tables[what, carrier]

    def _idle_itrf(self, instants: Instants, states: OrbitStates, c_itrf: Array) -> Array:
        """Boresight and the camera's +X, (n, 6)."""
        position = idle_attitude(self.platform.idle, instants, states).position
        c_payload = self.platform.q_payload_from_base(position).as_matrix()
        return np.concatenate(
            [np.einsum("nij,nj->ni", c_itrf, c_payload[:, k]) for k in (2, 0)], axis=1
        )

    def _sky_itrf(self, instants: Instants, states: OrbitStates, c_itrf: Array) -> Array:
        """Sunglint's direction and by how much it counts, and those among stars, (n, 4 + 3 k)."""
        direction_eci, counts_rad = Surroundings(instants, states).glint()
        columns = [np.einsum("nij,nj->ni", c_itrf, direction_eci), counts_rad[:, None]]
        columns += [c_itrf @ np.asarray(one.about, float) for one in self._among_stars]
        return np.concatenate(columns, axis=1)

    @property
    def _among_stars(self) -> list[Exclusion]:
        return [one for one in self.platform.exclusions if one.body == "inertial"]

    def _which(self, exclusion: Exclusion) -> int:
        """What it keeps away from, as `Tracking.kept_parameters` has it."""
        if exclusion.body == "inertial":
            return INERTIAL + self._among_stars.index(exclusion)
        return CELESTIAL.index("within_limb" if exclusion.near == "limb" else exclusion.body)


def _triad(toward_body: Array, aside_body: Array) -> Array:
    """Rows: a direction, the part of the other across it, their product, unit vectors (3, 3)."""
    across = aside_body - (aside_body @ toward_body) * toward_body
    across /= np.linalg.norm(across)
    return np.stack([toward_body, across, np.cross(toward_body, across)])


def _rows(matrix: Array) -> Rows3:
    one, two, three = (cast(Vector, tuple(row)) for row in matrix.tolist())
    return one, two, three


def _edge_name(exclusion: Exclusion) -> str:
    """As windows' edges have it: a request's direction has its field already."""
    name = exclusion.name
    return name if name.startswith("directions.") else f"exclusions.{name}"
