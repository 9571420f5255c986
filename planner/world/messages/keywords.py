"""Values of a CCSDS message of one satellite at one epoch (OMM, OPM)."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import NoReturn

from planner.base.errors import figures
from planner.world.frames.time_scales import utc_from_tai_us
from planner.world.messages.epochs import TIME_SYSTEMS, tai_ns
from planner.world.messages.kvn import kvn_lines
from planner.world.messages.segments import EARTH_NAMES, is_xml, plain, refuse, require_size
from planner.world.messages.xml import message_element, name_of, text_of

MAX_CHARACTERS = 200_000  # a hundred times a long one

_UNIT = re.compile(r"^(?P<value>.*?)\s*\[(?P<unit>[^\[\]]*)\]$")


@dataclass(frozen=True)
class Entry:
    """One keyword as it stands; unit: "" if not stated."""

    key: str
    text: str
    unit: str
    line: int


@dataclass(frozen=True)
class Keywords:
    """The entries of one message, in its order."""

    message: str
    entries: tuple[Entry, ...]

    def refuse(self, what: str, line: int = 1) -> NoReturn:
        """Say what is wrong with the message, and in which line."""
        refuse(self.message, line, what)

    def all(self, key: str) -> Iterator[Entry]:
        """Every entry of that keyword, for blocks that repeat."""
        return (entry for entry in self.entries if entry.key == key)

    def only(self, key: str) -> Entry | None:
        """The entry of a keyword that stands once or not at all; two are two satellites."""
        entries = list(self.all(key))
        if len(entries) > 1:
            self.refuse(f"{key} stands here for the second time; send one state", entries[1].line)
        return entries[0] if entries else None

    def require(self, key: str) -> Entry:
        """The entry as `only` finds it, refused when absent."""
        return self.only(key) or self.refuse(f"{key} is missing")

    def text(self, key: str, default: str | None = None) -> str:
        """The entry's text; refused when absent and without default."""
        entry = self.only(key) if default is not None else self.require(key)
        return default or "" if entry is None else entry.text

    def number(
        self, key: str, *units: str, limits: tuple[float, float] = (-math.inf, math.inf)
    ) -> float:
        """A finite number in a closed range; a stated unit must be one of `units`."""
        entry = self.require(key)
        if entry.unit and entry.unit.lower() not in units:
            self.refuse(f"{key} is in {entry.unit!r}; it must be in {units[0]}", entry.line)
        try:
            value = float(plain(entry.text))
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self.refuse(f"{key} = {entry.text[:40]!r} is no finite number", entry.line)
        low, high = limits
        if not low <= value <= high:
            self.refuse(
                f"{key} must lie in {low:g}..{high:g}, not {figures(value, low, high)}", entry.line
            )
        return value

    def epoch_utc(self, entry: Entry, time_system: str) -> datetime:
        """The epoch an entry states, rounded down to the microsecond."""
        if time_system not in TIME_SYSTEMS:
            self.refuse(f"TIME_SYSTEM {time_system!r} is not supported; use one of {TIME_SYSTEMS}")
        try:
            return utc_from_tai_us(tai_ns(entry.text, time_system) // 1000)
        except ValueError as error:
            self.refuse(str(error), entry.line)

    def require_earth(self) -> None:
        """Refuse orbits about anything else."""
        center = self.text("CENTER_NAME", "EARTH")
        if center.upper() not in EARTH_NAMES:
            self.refuse(f"CENTER_NAME is {center!r}; only orbits about EARTH are supported")


def read_keywords(content: str, message: str, versions: tuple[str, ...]) -> Keywords:
    """Read KVN or XML.  Raises InvalidMessage naming the line."""
    require_size(message, content, MAX_CHARACTERS, "one satellite")
    if is_xml(content):
        return Keywords(message, tuple(_from_xml(content, message, versions)))
    keywords = Keywords(message, tuple(_from_kvn(content, message)))
    version = keywords.text(f"CCSDS_{message}_VERS")
    if version.split(".")[0] not in versions:
        keywords.refuse(f"CCSDS_{message}_VERS {version!r} is not supported")
    return keywords


def _from_kvn(content: str, message: str) -> Iterator[Entry]:
    for number, text in kvn_lines(content):
        key, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            refuse(message, number, f"{text[:60]!r} is no 'KEYWORD = value'")
        with_unit = _UNIT.match(value)
        if with_unit:
            yield Entry(key.upper(), with_unit["value"], with_unit["unit"], number)
        else:
            yield Entry(key.upper(), value, "", number)


def _from_xml(content: str, message: str, versions: tuple[str, ...]) -> Iterator[Entry]:
    root = message_element(content, message, versions)
    for element in root.element.iter():
        if len(element) == 0 and name_of(element) != "COMMENT":
            yield Entry(
                name_of(element), text_of(element), element.get("units") or "", root.line(element)
            )
