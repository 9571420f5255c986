"""What does an OEM in keyword = value notation say?"""

from planner.messages.oem_raw import RawSegment, refuse

# Which section a mark opens, by the section it stands in.
_SECTIONS = {
    ("header", "META_START"): "metadata",
    ("states", "META_START"): "metadata",
    ("metadata", "META_STOP"): "states",
    ("states", "COVARIANCE_START"): "covariance",
    ("covariance", "COVARIANCE_STOP"): "states",
}


def raw_kvn(content: str) -> tuple[str | None, list[RawSegment]]:
    """CREATION_DATE and the segments, unconverted."""
    reader = _Reader()
    for number, line in enumerate(content.lstrip("\ufeff").splitlines(), start=1):
        text = line.strip()
        if text and text != "COMMENT" and not text.startswith("COMMENT "):
            reader.read(number, text)
    if reader.where in ("metadata", "covariance"):
        refuse(content.count("\n") + 1, f"the message ends inside its {reader.where}")
    return reader.creation, reader.segments


class _Reader:
    """Where in the message we are, and what was read so far."""

    def __init__(self) -> None:
        self.where = "header"
        self.creation: str | None = None
        self.segments: list[RawSegment] = []
        self._has_version = False

    def read(self, number: int, text: str) -> None:
        if text.endswith(("_START", "_STOP")) and "=" not in text:
            self._turn_to(number, text)
        elif self.where == "covariance":
            return
        elif "=" in text:
            key, _, value = (part.strip() for part in text.partition("="))
            self._keyword(number, key.upper(), value)
        elif self.where == "states":
            self._state(number, text)
        else:
            refuse(number, f"{text[:60]!r} is no 'KEYWORD = value'")

    def _turn_to(self, number: int, mark: str) -> None:
        if not self._has_version:
            refuse(number, "no CCSDS_OEM_VERS before the first segment; is this an OEM?")
        if (self.where, mark) not in _SECTIONS:
            refuse(number, f"{mark[:60]} can't follow in the {self.where}")
        self.where = _SECTIONS[self.where, mark]
        if mark == "META_START":
            self.segments.append(RawSegment(number, {}, [], [], []))

    def _keyword(self, number: int, key: str, value: str) -> None:
        if self.where == "states":
            refuse(number, f"{key[:60]} stands among the states")
        elif self.where == "metadata":
            self.segments[-1].metadata[key] = value
        elif key == "CREATION_DATE":
            self.creation = value
        elif key == "CCSDS_OEM_VERS":
            if value.split(".")[0] not in ("1", "2", "3"):
                refuse(number, f"CCSDS_OEM_VERS {value!r} is not supported; versions 1 to 3 are")
            self._has_version = True

    def _state(self, number: int, text: str) -> None:
        columns = text.split()
        if len(columns) not in (7, 10):
            refuse(
                number,
                "a state has an epoch and 6 numbers, or 9 with accelerations, "
                f"not {len(columns)} columns",
            )
        segment = self.segments[-1]
        segment.epochs.append(columns[0])
        segment.rows.append(columns[1:7])
        segment.lines.append(number)
