"""Reads CCSDS ephemeris messages (OEM, AEM) in keyword = value notation."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from planner.world.messages.segments import RawSegment, refuse, require_version


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
    header: dict[str, str] = {}
    segments: list[RawSegment] = []
    section, version_key = "header", _version_key(grammar)
    for number, text in kvn_lines(content):
        key, equals, value = (part.strip() for part in text.partition("="))
        key = key.upper()
        if text.endswith(("_START", "_STOP")) and not equals:
            section = _next_section(grammar, header, section, text, number)
            if text == "META_START":
                segments.append(RawSegment(grammar.message, number, {}, [], [], []))
        elif section == "states":
            _append_row(grammar, segments[-1], text, number)
        elif section in grammar.unread_sections:
            continue
        elif not equals:
            refuse(grammar.message, number, f"{text[:60]!r} is no 'KEYWORD = value'")
        elif section == "metadata":
            segments[-1].metadata[key] = value
        else:
            if key == version_key:
                stated = f"{key} {value!r}"
                require_version(grammar.message, stated, value, grammar.versions, number)
            header[key] = value
    if section in ("metadata", *grammar.unread_sections):
        last = content.count("\n") + 1
        refuse(grammar.message, last, f"the message ends inside its {section}")
    return header.get("CREATION_DATE"), segments


def kvn_lines(content: str) -> Iterator[tuple[int, str]]:
    """The lines that say something, without the space around them, by number."""
    for number, line in enumerate(content.lstrip("\ufeff").splitlines(), start=1):
        text = line.strip()
        if text and text != "COMMENT" and not text.startswith("COMMENT "):
            yield number, text


def _version_key(grammar: Grammar) -> str:
    return f"CCSDS_{grammar.message}_VERS"


def _next_section(
    grammar: Grammar, header: Mapping[str, str], section: str, mark: str, number: int
) -> str:
    message, version_key = grammar.message, _version_key(grammar)
    if version_key not in header:
        what = f"no {version_key} before the first segment; is this an {message}?"
        refuse(message, number, what)
    if (section, mark) not in grammar.sections:
        refuse(message, number, f"{mark[:60]} can't follow in the {section}")
    return grammar.sections[section, mark]


def _append_row(grammar: Grammar, segment: RawSegment, text: str, number: int) -> None:
    if "=" in text:
        key = text.partition("=")[0].strip().upper()
        segment.refuse(f"{key[:60]} stands among the states", number)
    epoch, *numbers = text.split()
    if len(numbers) + 1 not in grammar.row_columns:
        segment.refuse(f"{grammar.row_layout}, not {len(numbers) + 1} columns", number)
    segment.epochs.append(epoch)
    segment.rows.append(numbers)
    segment.lines.append(number)
