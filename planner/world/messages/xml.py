"""Reads CCSDS messages in XML, so that hostile text can do no harm."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from lxml import etree

from planner.world.messages.segments import RawSegment, refuse, require_version

_STATES = {"stateVector": "state vector", "attitudeState": "attitude state"}
_DECLARATION = re.compile(r"^\s*<\?xml[^>]*\?>")


@dataclass(frozen=True, eq=False)
class MessageElement:
    """The element of one message; the parser did not see the lines before it."""

    message: str
    element: etree._Element
    lines_before: int

    @property
    def creation(self) -> str | None:
        """CREATION_DATE as it stands."""
        for header in children(self.element, "header"):
            for date in children(header, "CREATION_DATE"):
                return text_of(date)
        return None

    def segments(
        self,
        state: str,
        columns: Callable[[RawSegment], tuple[str, ...]],
        units: Mapping[str, str],
    ) -> list[RawSegment]:
        """Each segment with its metadata and rows.

        state: the element of a row.  columns: names of its numbers, by the segment's metadata.
        units: the only ones that some numbers may state.
        """
        segments = []
        for body in children(self.element, "body"):
            for element in children(body, "segment"):
                raw = RawSegment(self.message, self.line(element), {}, [], [], [])
                for metadata in children(element, "metadata"):
                    raw.metadata.update((name_of(entry), text_of(entry)) for entry in metadata)
                names = columns(raw)
                for data in children(element, "data"):
                    for row in children(data, state):
                        self._append_row(raw, row, names, units)
                segments.append(raw)
        return segments

    def _append_row(
        self,
        raw: RawSegment,
        row: etree._Element,
        names: tuple[str, ...],
        units: Mapping[str, str],
    ) -> None:
        line, texts = self.line(row), {}
        # An attitude's numbers lie deeper, among elements of their own.
        for element in row if name_of(row) == "stateVector" else row.iter():
            name, unit = _keyword_of(element), element.get("units")
            if unit is not None and unit != units.get(name, unit):
                raw.refuse(f"{name} is in {unit!r}; it must be in {units[name]}", line)
            texts[name] = text_of(element)
        for name in ("EPOCH", *names):
            if name not in texts:
                raw.refuse(f"the {_STATES[name_of(row)]} lacks {name}", line)
        raw.epochs.append(texts["EPOCH"])
        raw.rows.append([texts[name] for name in names])
        raw.lines.append(line)

    def line(self, element: etree._Element) -> int:
        """Parsed elements always have a line; only ones made by hand lack it."""
        line: int | None = element.sourceline  # type: ignore[assignment]  # untyped in the stubs
        return (line or 1) + self.lines_before


def message_element(content: str, message: str, versions: tuple[str, ...]) -> MessageElement:
    """The one element of this kind: the root, or inside an <ndm>.

    A document type is refused outright: with it go entity bombs and references to files.
    """
    content = content.lstrip("\ufeff")
    doctype = re.search(r"<!(DOCTYPE|ENTITY)", content)
    if doctype:
        number = content.count("\n", 0, doctype.start()) + 1
        what = f"a document type declaration has no place in an {message}; remove it"
        refuse(message, number, what)
    # The declared encoding no longer holds for text that reached us as characters.
    declaration = _DECLARATION.match(content)
    body = content[declaration.end() :] if declaration else content
    lines_before = content[: len(content) - len(body)].count("\n")
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        remove_comments=True,
        remove_pis=True,
        remove_blank_text=True,
        collect_ids=False,
    )
    try:
        root = etree.fromstring(body.encode(), parser)
    except etree.XMLSyntaxError as error:
        refuse(message, (error.lineno or 1) + lines_before, f"the XML is broken: {error.msg}")
    except UnicodeEncodeError as error:
        number = content.count("\n", 0, error.start) + 1
        refuse(message, number, "a lone surrogate is no character")
    tag = message.lower()
    elements = [root] if name_of(root) == tag else children(root, tag)
    if len(elements) != 1:
        refuse(message, 1, f"the XML holds {len(elements)} <{tag}> elements; exactly 1 is needed")
    result = MessageElement(message, elements[0], lines_before)
    version, line = elements[0].get("version"), result.line(elements[0])
    require_version(message, f"{message} version {version!r}", version or "", versions, line)
    return result


def children(element: etree._Element, name: str) -> list[etree._Element]:
    """Children of that name, whatever their namespace."""
    return [child for child in element if name_of(child) == name]


def name_of(element: etree._Element) -> str:
    """The tag without its namespace."""
    return str(element.tag).rpartition("}")[2]


def _keyword_of(element: etree._Element) -> str:
    """The name; version 1's rotation1 of an AEM's rotationAngles is version 2's ANGLE_1."""
    parent = element.getparent()
    is_angle = parent is not None and name_of(parent) == "rotationAngles"
    return name_of(element).replace("rotation", "ANGLE_") if is_angle else name_of(element)


def text_of(element: etree._Element) -> str:
    """The text, without the space around it."""
    return (element.text or "").strip()
