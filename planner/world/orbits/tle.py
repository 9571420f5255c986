"""An orbit from a two-line element set, by SGP4."""

import calendar
import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import ClassVar, Literal

import numpy as np
from sgp4.api import SGP4_ERRORS, WGS72, Satrec

from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage, figures
from planner.base.spec import spec
from planner.world.frames.earth_orientation import c_itrf_from_teme, eci_from_frame_state
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.frames.time_scales import DAY_S, Instants, elapsed_s, require_known, utc_text
from planner.world.messages.omm import MEAN_MOTION_REV_DAY
from planner.world.orbits.accuracy import OrbitSigma, reboost_since, tle_sigma
from planner.world.orbits.atmosphere import thickest_kg_m3
from planner.world.orbits.ephemeris import (
    CarrierName,
    Ephemeris,
    OrbitSource,
    OrbitStates,
    turned,
)
from planner.world.orbits.gravity import RADIUS_M

WARN_AGE_DAYS = 3.0
REFUSE_AGE_DAYS = 30.0
ISS_BALLISTIC_M2_KG = 0.0068  # drag coefficient times area over mass
PERIGEE_MIN_KM = 80.0  # air ends every orbit within a revolution there
_LENGTH = 69
_EPHEMERIS_TYPES = " 023"  # those of SGP4 and SDP4, and not said; 4 is SGP4-XP's
_NUMBER = r"[ \dA-HJ-NP-Z][ \d]{4}"  # plain or Alpha-5
_LAYOUT = {
    "1": re.compile(
        rf"1 {_NUMBER}[UCST ] [ \dA-Z]{{8}} \d{{2}}[ \d]{{2}}\d\.\d{{8}} [ +-]\.\d{{8}} "
        r"[ +-][ \d]{5}[ +-]\d [ +-][ \d]{5}[ +-]\d [ \d] [ \d]{4}\d"
    ),
    "2": re.compile(
        rf"2 {_NUMBER} [ \d]{{3}}\.\d{{4}} [ \d]{{3}}\.\d{{4}} [ \d]{{6}}\d "
        r"[ \d]{3}\.\d{4} [ \d]{3}\.\d{4} [ \d]{2}\.\d{8}[ \d]{5}\d"
    ),
}


@spec
class TleOrbit(OrbitSource):
    """Two lines of a NORAD element set, as published: line by line, or whole as `content`.

    SGP4's own error is about 1 km at the epoch and grows by 1-3 km a day.

    line1: the line that begins with 1, its checksum included.
    line2: the line that begins with 2, its checksum included.
    content: both lines in one text, with or without the satellite's name in a line before them,
    instead of `line1` and `line2`. E.g. `"ISS (ZARYA)\\n1 25544U ...\\n2 25544 ..."`.
    """

    search_horizon_s: ClassVar[float] = DAY_S
    source: Literal["tle"] = "tle"
    line1: str = ""
    line2: str = ""
    content: str | None = None

    def __post_init__(self) -> None:
        if self.content is None:
            self._check()
            return
        if self.line1 or self.line2:
            raise ValueError("content holds both lines already; leave out line1 and line2")
        try:
            line1, line2 = _lines_of(self.content)
            object.__setattr__(self, "line1", line1)
            object.__setattr__(self, "line2", line2)
            self._check()
        except ValueError as error:
            raise ValueError(f"content: {error}") from None

    def _check(self) -> None:
        if not (self.line1 and self.line2):
            raise ValueError(
                f"{'line2' if self.line1 else 'line1'} is required; or give both lines as content"
            )
        for name, number, line in (("line1", "1", self.line1), ("line2", "2", self.line2)):
            _check_line(name, number, line)
        if self.line1[2:7] != self.line2[2:7]:
            raise ValueError(
                f"line1 is of satellite {self.line1[2:7]}, line2 of {self.line2[2:7]}; "
                "take both lines from the same set"
            )
        _check_elements(self.line1, self.line2)
        try:
            require_earth_orbit(self._sgp4_elements())
        except ValueError as error:
            raise ValueError(f"line2: {error}") from None

    @property
    def epoch_utc(self) -> datetime:
        """Epoch of the elements."""
        return _epoch_utc(self.line1)

    @property
    def carrier_name(self) -> CarrierName:
        """Catalogue number and, where the lines have it, designator: of 1957 to 2056."""
        launch = self.line1[9:17].strip()
        century = "19" if launch[:2] >= "57" else "20"
        designator = f"{century}{launch[:2]}-{launch[2:]}" if launch[:2].isdigit() else ""
        return CarrierName(f"NORAD {self.line1[2:7].strip()}", designator)

    def ephemeris(self, start_utc: datetime, stop_utc: datetime) -> "TleEphemeris":
        """Raises OutsideCoverage when an instant is 30 days or more from the epoch."""
        return sgp4_ephemeris(
            self._sgp4_elements(), self.epoch_utc, start_utc, stop_utc, field=self._field
        )

    @property
    def _field(self) -> str:
        return "orbit.line1" if self.content is None else "orbit.content"

    def _sgp4_elements(self) -> Satrec:
        return Satrec.twoline2rv(self.line1, self.line2, WGS72)


@dataclass(frozen=True, eq=False, kw_only=True)
class TleEphemeris(Ephemeris):
    """SGP4 at any instant of the span; TEME is taken to ITRF and on to ECI.

    Leaves out the slow turning of TEME itself in the velocity (7e-5 m/s).
    drag_in_a_day_m, air_in_a_day_m: as `tle_sigma` takes them.
    """

    drag_in_a_day_m: float
    air_in_a_day_m: float
    satrec: Satrec
    field: str

    def interpolate(self, instants: Instants) -> OrbitStates:
        """Raises OutsideCoverage where SGP4 itself gives up."""
        return OrbitStates(*eci_from_frame_state("TEME", *self._in_teme(instants), instants))

    def states_in_itrf_axes(self, instants: Instants) -> tuple[Array, Array]:
        """Without the way by ECI, which costs as much as SGP4 does."""
        self._require_within(instants)
        r_teme_m, v_teme_m_s = self._in_teme(instants)
        c_itrf = c_itrf_from_teme(instants)
        return turned(c_itrf, r_teme_m), turned(c_itrf, v_teme_m_s)

    def _in_teme(self, instants: Instants) -> tuple[Array, Array]:
        since_days = instants.since_s(self.epoch_utc) / DAY_S
        errors, r_teme_km, v_teme_km_s = self.satrec.sgp4_array(
            np.full(len(instants), self.satrec.jdsatepoch), self.satrec.jdsatepochF + since_days
        )
        failed = np.flatnonzero(errors)
        if len(failed):
            at_utc = instants.utc(failed[0])
            raise OutsideCoverage(
                f"SGP4 gives up at {utc_text(at_utc, 0)}: {SGP4_ERRORS[int(errors[failed[0]])]}; "
                "take newer elements",
                field=self.field,
                at_utc=at_utc,
            )
        return r_teme_km * 1e3, v_teme_km_s * 1e3

    def sigma(self, instants: Instants) -> OrbitSigma:
        """Errors by what of the drag in the elements is wrong."""
        return tle_sigma(self.age_s(instants), self.drag_in_a_day_m, self.air_in_a_day_m)


def require_earth_orbit(satrec: Satrec) -> None:
    """Refuse elements that SGP4 takes but no satellite of the Earth can have."""
    if satrec.error:
        raise ValueError(f"these elements are no orbit: {SGP4_ERRORS[satrec.error]}")
    perigee_km = satrec.altp * satrec.radiusearthkm
    if not perigee_km >= PERIGEE_MIN_KM:
        raise ValueError(
            f"the perigee of these elements is {figures(perigee_km, PERIGEE_MIN_KM)} km high, "
            f"below {PERIGEE_MIN_KM:.0f} km; check mean motion and eccentricity"
        )


def sgp4_ephemeris(
    satrec: Satrec, epoch_utc: datetime, start_utc: datetime, stop_utc: datetime, *, field: str
) -> TleEphemeris:
    """Elements made ready for a span; `field` is the request field they came in.

    Raises OutsideCoverage when an instant is 30 days or more from the epoch.
    """
    age_days = max(abs(elapsed_s(t, epoch_utc)) for t in (start_utc, stop_utc)) / DAY_S
    age = figures(age_days, REFUSE_AGE_DAYS, WARN_AGE_DAYS, digits=max(3, len(f"{age_days:.0f}")))
    epoch = utc_text(epoch_utc, 0)
    sentence = f"the elements' epoch {epoch} is {age} days from the farthest instant asked for"
    if age_days >= REFUSE_AGE_DAYS:
        raise OutsideCoverage(
            f"{sentence}; those {REFUSE_AGE_DAYS:.0f} days old are of no use; take newer ones",
            field=field,
        )
    warnings: tuple[str, ...] = ()
    drag_in_a_day_m, air_in_a_day_m = _drag_in_a_day_m(satrec), _air_in_a_day_m(satrec)
    if age_days >= WARN_AGE_DAYS:
        sigma = tle_sigma(np.array(age_days * DAY_S), drag_in_a_day_m, air_in_a_day_m)
        sigma_km = float(sigma.along_m) / 1e3
        share, reboost_m = reboost_since(age_days * DAY_S, drag_in_a_day_m, air_in_a_day_m)
        warnings = (
            f"{sentence}: expect an error of some {sigma_km:.0f} km (1 sigma) along the track; if "
            f"the satellite is reboosted as the ISS is, it was with a probability of {share:.2f}, "
            f"which makes it some {reboost_m / 1e3:.0f} km",
        )
    return TleEphemeris(
        epoch_utc=epoch_utc,
        start_utc=start_utc,
        stop_utc=stop_utc,
        warnings=warnings,
        drag_in_a_day_m=drag_in_a_day_m,
        air_in_a_day_m=air_in_a_day_m,
        satrec=satrec,
        field=field,
    )


def _drag_in_a_day_m(satrec: Satrec) -> float:
    """How far along the track SGP4's drag takes a satellite in a day, by its mean motion."""
    mean_motion_rad_min = []
    for since_min in (-1.0, 1.0):
        satrec.sgp4_tsince(since_min)
        mean_motion_rad_min.append(satrec.nm)
    before, after = mean_motion_rad_min
    day_min = DAY_S / 60.0
    a_m = satrec.a * satrec.radiusearthkm * 1e3
    return float(0.25 * (after - before) * day_min**2 * a_m)


def _air_in_a_day_m(satrec: Satrec) -> float:
    """How far along the track the thickest air on its way would take the ISS in a day."""
    a_m, e = satrec.a * satrec.radiusearthkm * 1e3, satrec.ecco
    way = 1.0 - e * np.cos(np.linspace(0.0, 2.0 * np.pi, 73)[:-1])  # radius and time, over a
    density_kg_m3 = thickest_kg_m3(a_m * way - RADIUS_M)
    decelerated_m_s2 = 0.5 * ISS_BALLISTIC_M2_KG * MU_EARTH_M3_S2 / a_m * density_kg_m3
    return float(1.5 * np.mean(way * decelerated_m_s2) * DAY_S**2)


def _lines_of(content: str) -> tuple[str, str]:
    """The two lines of one set, a line with its name before them passed over."""
    lines = [line.rstrip() for line in content.splitlines() if line.strip()]
    if len(lines) not in (2, 3):
        raise ValueError(
            "send the two lines of one satellite, those that begin with 1 and 2, after its name if "
            f"you like; lines sent: {len(lines)}"
        )
    return lines[-2], lines[-1]


def checksum(line: str) -> int:
    """The digit that a line is to end in."""
    return sum(int(c) if c.isdigit() else c == "-" for c in line[:68]) % 10


def _check_line(name: str, number: str, line: str) -> None:
    """Length, number and checksum: ValueError names what is wrong."""
    foreign = next((c for c in line if not c.isascii()), None)
    if foreign is not None:
        raise ValueError(f"{name} has the character {foreign!r}; a TLE is plain ASCII")
    if len(line) != _LENGTH:
        raise ValueError(f"{name} has {len(line)} characters; a TLE line has {_LENGTH}")
    if not line.startswith(f"{number} "):
        raise ValueError(f"{name} begins with {line[:2]!r}, not {number!r}; are the lines swapped?")
    total = checksum(line)
    if line[68] != str(total):
        raise ValueError(
            f"{name} ends in checksum {line[68]!r}, its digits give {total}; copy the line again"
        )
    if not _LAYOUT[number].fullmatch(line):
        raise ValueError(f"{name} has a character where it doesn't belong; copy the line again")


def _epoch_utc(line1: str) -> datetime:
    year = int(line1[18:20])
    start_utc = datetime(year + (2000 if year < 57 else 1900), 1, 1, tzinfo=UTC)
    return start_utc + timedelta(days=float(line1[20:32]) - 1.0)


def _check_elements(line1: str, line2: str) -> None:
    """Numbers that no set can have, which SGP4 would take: ValueError names line and element."""
    if line1[62] not in _EPHEMERIS_TYPES:
        raise ValueError(
            f"line1 is of ephemeris type {line1[62]}, not for SGP4 (SGP4-XP is another "
            "propagator); take a set of type 0"
        )
    year = int(line1[18:20])
    year += 2000 if year < 57 else 1900
    for line, element, text, low, high in (
        ("line1", "day of the year", line1[20:32], 1.0, 366.0 + calendar.isleap(year)),
        ("line2", "inclination", line2[8:16], 0.0, 180.0),
        ("line2", "right ascension of the node", line2[17:25], 0.0, 360.0),
        ("line2", "argument of perigee", line2[34:42], 0.0, 360.0),
        ("line2", "mean anomaly", line2[43:51], 0.0, 360.0),
        ("line2", "mean motion", line2[52:63], *MEAN_MOTION_REV_DAY),
    ):
        value = float(text.replace(" ", ""))
        if not low <= value <= high:
            raise ValueError(
                f"{line} gives {figures(value, low, high)} as its {element}, outside "
                f"{low:g}..{high:g}"
            )
    try:
        require_known(_epoch_utc(line1))
    except ValueError as error:
        raise ValueError(f"line1 has its epoch out of range: {error}") from None
