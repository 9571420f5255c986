"""Reads CCSDS ephemeris messages (OEM, AEM) in keyword = value notation."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NoReturn

from planner.messages.segments import RawSegment, refuse


@dataclass(frozen=True)
class Grammar:
    """How one kind of message is laid out.

    sections: which section a mark opens, by the section it stands in.  Rows stand in
    `states`; what stands in one of `unread_sections` is not read.  row_columns: how many
    columns a row may have, epoch included, and how a refusal describes it.
    """

    message: str
    versions: tuple[str, ...]
    sections: Mapping[tuple[str, str], str]
    unread_sections: tuple[str, ...]
    row_columns: tuple[int, ...]
    row_layout: str


def raw_kvn(content: str, grammar: Grammar) -> tuple[str | None, list[RawSegment]]:
    """CREATION_DATE and the segments, unconverted."""
    reader = _Reader(grammar)
    for number, text in kvn_lines(content):
        reader.read(number, text)
    if reader.where in ("metadata", *grammar.unread_sections):
        last = content.count("\n") + 1
        refuse(grammar.message, last, f"the message ends inside its {reader.where}")
    return reader.creation, reader.segments


def kvn_lines(content: str) -> Iterator[tuple[int, str]]:
    """The lines that say something, without the space around them, by number."""
    for number, line in enumerate(content.lstrip("\ufeff").splitlines(), start=1):
        text = line.strip()
        if text and text != "COMMENT" and not text.startswith("COMMENT "):
            yield number, text


class _Reader:
    """Where in the message we are, and what was read so far."""

    def __init__(self, grammar: Grammar) -> None:
        self.where = "header"
        self.creation: str | None = None
        self.segments: list[RawSegment] = []
        self._grammar = grammar
        self._message = grammar.message
        self._has_version = False

    def read(self, number: int, text: str) -> None:
        if text.endswith(("_START", "_STOP")) and "=" not in text:
            self._turn_to(number, text)
        elif self.where in self._grammar.unread_sections:
            return
        elif "=" in text:
            key, _, value = (part.strip() for part in text.partition("="))
            self._keyword(number, key.upper(), value)
        elif self.where == "states":
            self._state(number, text)
        else:
            self._refuse(number, f"{text[:60]!r} is no 'KEYWORD = value'")

    def _refuse(self, number: int, what: str) -> NoReturn:
        refuse(self._message, number, what)

    def _turn_to(self, number: int, mark: str) -> None:
        if not self._has_version:
            self._refuse(
                number,
                f"no CCSDS_{self._message}_VERS before the first segment; "
                f"is this an {self._message}?",
            )
        if (self.where, mark) not in self._grammar.sections:
            self._refuse(number, f"{mark[:60]} can't follow in the {self.where}")
        self.where = self._grammar.sections[self.where, mark]
        if mark == "META_START":
            self.segments.append(RawSegment(self._message, number, {}, [], [], []))

    def _keyword(self, number: int, key: str, value: str) -> None:
        if self.where == "states":
            self._refuse(number, f"{key[:60]} stands among the states")
        elif self.where == "metadata":
            self.segments[-1].metadata[key] = value
        elif key == "CREATION_DATE":
            self.creation = value
        elif key == f"CCSDS_{self._message}_VERS":
            versions = self._grammar.versions
            if value.split(".")[0] not in versions:
                self._refuse(
                    number,
                    f"{key} {value!r} is not supported; "
                    f"versions {versions[0]} to {versions[-1]} are",
                )
            self._has_version = True

    def _state(self, number: int, text: str) -> None:
        columns = text.split()
        if len(columns) not in self._grammar.row_columns:
            self._refuse(number, f"{self._grammar.row_layout}, not {len(columns)} columns")
        segment = self.segments[-1]
        segment.epochs.append(columns[0])
        segment.rows.append(columns[1:])
        segment.lines.append(number)
