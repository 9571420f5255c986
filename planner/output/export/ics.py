"""Sessions of a plan as events of a calendar.  Source: RFC 5545."""

import hashlib
from collections.abc import Iterator, Sequence
from datetime import datetime

import numpy as np

from planner.output.export.description import notes, session_label
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants, shifted_utc, utc_text
from planner.world.plan import FlightPlan
from planner.world.scenario import Session
from planner.world.targets import EarthFixedTarget


def write_ics(plan: FlightPlan, created_utc: datetime) -> bytes:
    """A VCALENDAR with a VEVENT a session, in UTC.

    A calendar counts whole seconds: an event begins with the second in which its session begins and
    ends with the one in which that ends.  The description has the times to the millisecond.  The
    UID is the same whenever the same plan is written.
    """
    remarks = notes(plan, created_utc)
    lines = [
        "BEGIN:VCALENDAR",
        "VERSION:2.0",
        "PRODID:-//slewtrack//plan//EN",
        "CALSCALE:GREGORIAN",
        *(
            line
            for number in range(len(plan.scenario.sessions))
            for line in _event(plan, number, created_utc, remarks)
        ),
        "END:VCALENDAR",
    ]
    return b"".join(_folded(line) for line in lines)


def _event(
    plan: FlightPlan, number: int, created_utc: datetime, remarks: Sequence[str]
) -> Iterator[str]:
    scenario, session = plan.scenario, plan.scenario.sessions[number]
    told = [
        f"{utc_text(session.start)} to {utc_text(session.stop)}, target {session.target.label}",
        *remarks,
    ]
    yield "BEGIN:VEVENT"
    yield f"UID:{_uid(plan, number, created_utc)}"
    yield f"DTSTAMP:{_second(created_utc)}"
    yield f"DTSTART:{_second(session.start)}"
    yield f"DTEND:{_second(shifted_utc(session.stop, 0.999))}"
    yield f"SUMMARY:{_text(f'{session_label(session, number)}, {scenario.platform.name}')}"
    yield f"DESCRIPTION:{_text(chr(10).join(told))}"
    yield from _place(session)
    yield f"CATEGORIES:{_text(scenario.platform.name)}"
    yield "END:VEVENT"


def _place(session: Session) -> Iterator[str]:
    if isinstance(session.target, EarthFixedTarget) and session.target.rests_on_earth:
        r_itrf_m = session.target.r_target_itrf_m(Instants(session.start, np.zeros(1)))
        latitude_deg, longitude_deg, _ = np.degrees(geodetic_from_itrf(r_itrf_m))
        yield f"GEO:{latitude_deg[0]:.6f};{longitude_deg[0]:.6f}"


def _uid(plan: FlightPlan, number: int, created_utc: datetime) -> str:
    """Of the plan's table and the time it was made at, which no other plan shares."""
    made = hashlib.sha256(utc_text(created_utc, 6).encode())
    made.update(plan.table.position.tobytes())
    return f"{made.hexdigest()[:32]}-{number}@slewtrack"


def _second(moment_utc: datetime) -> str:
    """DATE-TIME, form 2: the second that the moment lies in, a leap second as 60."""
    return utc_text(moment_utc, 6)[:19].replace("-", "").replace(":", "") + "Z"


def _text(value: str) -> str:
    """TEXT, section 3.3.11, of what may hold any character."""
    for plain, escaped in (("\\", "\\\\"), (";", "\\;"), (",", "\\,"), ("\n", "\\n")):
        value = value.replace(plain, escaped)
    return "".join(" " if ord(c) < 32 or ord(c) == 127 else c for c in value)


def _folded(line: str, octets_max: int = 75) -> bytes:
    """Lines of at most so many octets (section 3.1), none of which ends within a character."""
    parts, part, room = [], b"", octets_max
    for character in line:
        octets = character.encode("utf-8", "replace")
        if len(part) + len(octets) > room:
            parts.append(part)
            part, room = b"", octets_max - 1
        part += octets
    return b"\r\n ".join([*parts, part]) + b"\r\n"
