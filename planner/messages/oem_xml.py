"""What does an OEM in XML say?"""

import re

from lxml import etree

from planner.messages.oem_raw import RawSegment, refuse

_DECLARATION = re.compile(r"^\s*<\?xml[^>]*\?>")
_COLUMNS = ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")
_UNITS = {"km": _COLUMNS[:3], "km/s": _COLUMNS[3:]}
_UNIT_OF = {column: unit for unit, columns in _UNITS.items() for column in columns}


def raw_xml(content: str) -> tuple[str | None, list[RawSegment]]:
    """CREATION_DATE and the segments, unconverted.

    An <oem> may be the root or stand in an <ndm>.  A document type is refused outright: with
    it go entity bombs and references to files.
    """
    content = content.lstrip("\ufeff")
    if "<!DOCTYPE" in content or "<!ENTITY" in content:
        number = content[: content.find("<!")].count("\n") + 1
        refuse(number, "a document type declaration has no place in an OEM; remove it")
    # The declared encoding no longer holds for text that reached us as characters.
    declaration = _DECLARATION.match(content)
    body = content[declaration.end() :] if declaration else content
    skipped = content[: len(content) - len(body)].count("\n")
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        root = etree.fromstring(body.encode(), parser)
    except etree.XMLSyntaxError as error:
        refuse((error.lineno or 1) + skipped, f"the XML is broken: {error.msg}")
    except UnicodeEncodeError as error:
        refuse(content.count("\n", 0, error.start) + 1, "a lone surrogate is no character")
    oems = [root] if _name(root) == "oem" else _children(root, "oem")
    if len(oems) != 1:
        refuse(1, f"the XML holds {len(oems)} <oem> elements; exactly 1 is needed")
    version = (oems[0].get("version") or "").split(".")[0]
    if version not in ("1", "2", "3"):
        refuse(
            _line(oems[0]) + skipped,
            f"OEM version {oems[0].get('version')!r} is not supported; versions 1 to 3 are",
        )
    creation = [
        (date.text or "").strip()
        for header in _children(oems[0], "header")
        for date in _children(header, "CREATION_DATE")
    ]
    segments = [
        _segment(segment, skipped)
        for body_element in _children(oems[0], "body")
        for segment in _children(body_element, "segment")
    ]
    return creation[0] if creation else None, segments


def _segment(element: etree._Element, skipped: int) -> RawSegment:
    segment = RawSegment(_line(element) + skipped, {}, [], [], [])
    for part in element:
        if _name(part) == "metadata":
            for entry in part:
                segment.metadata[_name(entry)] = (entry.text or "").strip()
        elif _name(part) == "data":
            for entry in part:
                if _name(entry) == "stateVector":
                    _state(segment, entry, _line(entry) + skipped)
    return segment


def _state(segment: RawSegment, element: etree._Element, line: int) -> None:
    values: dict[str, str] = {}
    for child in element:
        name = _name(child)
        values[name] = child.text or ""
        unit = child.get("units")
        if unit is not None and name in _UNIT_OF and unit != _UNIT_OF[name]:
            refuse(line, f"{name} is in {unit!r}; it must be in {_UNIT_OF[name]}")
    try:
        segment.epochs.append(values["EPOCH"].strip())
        segment.rows.append([values[column] for column in _COLUMNS])
    except KeyError as error:
        refuse(line, f"the state vector lacks {error.args[0]}")
    segment.lines.append(line)


def _children(element: etree._Element, name: str) -> list[etree._Element]:
    return [child for child in element if _name(child) == name]


def _name(element: etree._Element) -> str:
    """The tag without its namespace."""
    return str(element.tag).rpartition("}")[2]


def _line(element: etree._Element) -> int:
    """Parsed elements always have a line; only ones made by hand lack it."""
    line: int | None = element.sourceline  # type: ignore[assignment]  # untyped in the stubs
    return line or 1
