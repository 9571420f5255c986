"""Reads CCSDS messages in XML, so that hostile text can do no harm."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from lxml import etree

from planner.messages.segments import RawSegment, refuse

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

    def segments(self) -> Iterator[tuple[RawSegment, list[etree._Element]]]:
        """Each segment with its metadata filled in, and the elements of its data."""
        for body in children(self.element, "body"):
            for element in children(body, "segment"):
                raw = RawSegment(self.message, self.line(element), {}, [], [], [])
                data: list[etree._Element] = []
                for part in element:
                    if name_of(part) == "metadata":
                        raw.metadata.update((name_of(entry), text_of(entry)) for entry in part)
                    elif name_of(part) == "data":
                        data += part
                yield raw, data

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
    version = elements[0].get("version")
    if (version or "").split(".")[0] not in versions:
        refuse(
            message,
            result.line(elements[0]),
            f"{message} version {version!r} is not supported; "
            f"versions {versions[0]} to {versions[-1]} are",
        )
    return result


def children(element: etree._Element, name: str) -> list[etree._Element]:
    """Children of that name, whatever their namespace."""
    return [child for child in element if name_of(child) == name]


def name_of(element: etree._Element) -> str:
    """The tag without its namespace."""
    return str(element.tag).rpartition("}")[2]


def text_of(element: etree._Element) -> str:
    """The text, without the space around it."""
    return (element.text or "").strip()
