"""Telemetry as CSV: whatever parts its columns, marks its decimals and names its time."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.inflight.telemetry.columns import (
    ColumnMeaning,
    TelemetryColumn,
    UnitFrom,
    meaning_of,
    unit_of,
    words_of,
)
from planner.inflight.telemetry.request import SAMPLES_MAX
from planner.inflight.telemetry.samples import Samples
from planner.world.frames.time_scales import (
    KNOWN_FROM_UTC,
    KNOWN_TO_UTC,
    TimeNotCovered,
    elapsed_s,
    shifted_utc,
    utc_from_text,
    utc_text,
)

COLUMNS_MAX = 200
_DELIMITERS = (";", "\t", "|", ",")
_MARKS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_UTC_WORDS = {"utc", "timestamp", "datetime", "date", "iso"}
_TIME_WORDS = {"t", "time", "seconds", "sec", "elapsed", "met", "clock", "tag", "timetag"}
_SECONDS = {"ms": 1e-3, "us": 1e-6, "min": 60.0}
_DECIMAL_COMMA = re.compile(r"-?\d+,\d+(?:[eE][-+]?\d+)?")
_JSON = re.compile(r"\s*(?:\{\s*\"|\[\s*[\[{\"\d-])")
_WITH_POINT = re.compile(r"[-+]?\d*\.\d+(?:[eE][-+]?\d+)?")
_DATE = re.compile(r"(\d{4}-\d\d-\d\d)[ Tt](\d\d:\d\d:\d\d(?:[.,]\d+)?)\s*(?:UTC|[Zz])?", re.ASCII)
_LIKE_A_DATE = re.compile(r"[-+]?\d{4,}-\d\d-\d\d[ Tt]\d")
_TO_THE_NANOSECOND = len("2015-02-27T17:34:00.000000000")
_KNOWN_FROM, _KNOWN_TO = (
    np.datetime64(moment_utc.replace(tzinfo=None)) for moment_utc in (KNOWN_FROM_UTC, KNOWN_TO_UTC)
)
_UNIX_MIN_S, _UNIX_MAX_S = 1e8, 1e10  # 1973 to 2286
_UNIX_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_WAY_OUT = "name the columns t_s or utc, and {angles} (or {rates})"


@dataclass(frozen=True, kw_only=True)
class _Cells:
    """delimiter: None for white space."""

    lines: list[str]
    delimiter: str | None

    def row(self, number: int) -> list[str]:
        return _split(self.lines[number], self.delimiter)


def read_csv(
    content: bytes, axis_names: Sequence[str], epoch_utc: datetime | None, plan_epoch_utc: datetime
) -> Samples:
    """Rows in the file's order; raises InvalidInput where no axis or no time can be found.

    epoch_utc: from which a column t_s counts; None: the plan's, which is noted.
    """
    cells, notes = _cells_of(content)
    way_out = _WAY_OUT.format(
        angles=", ".join(f"{name}_deg" for name in axis_names),
        rates=", ".join(f"{name}_rate_deg_s" for name in axis_names),
    )
    names, first, units = _header(cells, way_out)
    _require_one_comma(cells, names)
    places, found, ignored = _axis_columns(names, units, axis_names, notes)
    if not places:
        raise _refusal(f"no column tells of {' or '.join(axis_names)}: {way_out}", names)
    time_place = _time_column(names, places)
    if time_place is None:
        raise _refusal(f"no column tells the time: {way_out}", names)
    body = cells.lines[first:]
    if len(body) > SAMPLES_MAX:
        raise InvalidInput(
            f"has {len(body)} rows; up to {SAMPLES_MAX} are read: cut it to the session, or thin "
            "it",
            field="samples",
        )
    value, texts = _columns(body, cells.delimiter, [time_place, *places], notes)
    t_s, epoch_utc = _times(names[time_place], value[0], texts, epoch_utc, plan_epoch_utc, notes)
    columns = [
        TelemetryColumn(name=names[place], meaning=meaning, value=column, unit_from=unit_from)
        for place, (meaning, unit_from), column in zip(places, found, value[1:], strict=True)
    ]
    taken = {time_place, *places}
    return Samples(
        epoch_utc=epoch_utc,
        t_s=t_s,
        columns=tuple(columns),
        ignored=tuple(
            dict.fromkeys(
                [*ignored, *(name for k, name in enumerate(names) if name and k not in taken)]
            )
        ),
        notes=tuple(notes),
    )


def _cells_of(content: bytes) -> tuple[_Cells, list[str]]:
    notes: list[str] = []
    encoding = next((name for mark, name in _MARKS if content.startswith(mark)), "utf-8")
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError:
        if b"\x00" in content[:4096]:
            raise InvalidInput("is no text; send CSV", field="samples") from None
        text = content.decode("latin-1")
        notes.append("the file is no UTF-8; it was read as Latin-1")
    text = text.replace("\u2212", "-")  # a minus sign of typesetters
    if "\x00" in text[:4096]:
        raise InvalidInput("is no text: it has NUL bytes; send CSV", field="samples")
    if _JSON.match(text):
        raise InvalidInput(
            "is JSON, not CSV: send it as samples of the request itself, with the Content-Type "
            "application/json, or write CSV with a line that names the columns",
            field="samples",
        )
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if lines and re.fullmatch(r"sep=.", lines[0].strip()):  # as spreadsheets write
        lines = lines[1:]
    if len(lines) < 2:
        raise InvalidInput(
            "is empty: send CSV with a line that names the columns and a line per sample",
            field="samples",
        )
    counts = {mark: lines[0].count(mark) for mark in _DELIMITERS}
    delimiter = next((mark for mark in _DELIMITERS if counts[mark]), None)
    if delimiter not in (",", None):
        notes.append(f"columns are parted by {delimiter!r}")
    return _Cells(lines=lines, delimiter=delimiter), notes


def _require_one_comma(cells: _Cells, names: list[str]) -> None:
    """Raises InvalidInput where commas both part columns and mark decimals."""
    if cells.delimiter != ",":
        return
    rows = [_split(line.rstrip(","), ",") for line in cells.lines[1:50]]
    longer = [row for row in rows if len(row) > len(names)]
    if 2 * len(longer) > len(rows) and not any(_WITH_POINT.fullmatch(c) for r in longer for c in r):
        raise InvalidInput(
            f"the first line names {len(names)} columns, but rows have up to "
            f"{max(map(len, longer))} cells: the comma both parts columns and marks decimals; "
            "write decimals with a point, or part columns with a semicolon",
            field="samples",
        )


def _split(line: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return line.split()
    if '"' in line:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]
        except (csv.Error, StopIteration):
            return []
    return [cell.strip() for cell in line.split(delimiter)]


def _header(cells: _Cells, way_out: str) -> tuple[list[str], int, list[str]]:
    """Names, the first row of numbers, and the texts of a row of units, if there is one."""
    names = cells.row(0)
    if len(names) > COLUMNS_MAX:
        raise InvalidInput(
            f"has {len(names)} columns; up to {COLUMNS_MAX} are read", field="samples"
        )
    if all(_is_number(cell) for cell in names if cell):
        raise InvalidInput(f"its first line must name the columns: {way_out}", field="samples")
    second = cells.row(1)
    is_units = not any(_is_number(cell) or _DATE.match(cell) for cell in second) and any(
        unit_of(cell)[0] for cell in second
    )
    return names, 2 if is_units else 1, second if is_units else []


def _axis_columns(
    names: list[str], units: list[str], axis_names: Sequence[str], notes: list[str]
) -> tuple[list[int], list[tuple[ColumnMeaning, UnitFrom]], list[str]]:
    places: list[int] = []
    found: list[tuple[ColumnMeaning, UnitFrom]] = []
    ignored: list[str] = []
    for place, name in enumerate(names):
        meaning = meaning_of(name, axis_names)
        if meaning is None:
            continue
        unit_from: UnitFrom = "name"
        if meaning.unit is None and place < len(units):
            unit, per_s = unit_of(units[place])
            is_rate = meaning.kind == "rate" or per_s is not None
            if unit is not None:
                unit_from = "unit row"
            meaning = replace(
                meaning,
                unit=unit,
                kind="rate" if is_rate else "angle",
                per_s=(per_s or meaning.per_s) if is_rate else 1.0,
            )
        if any((m.axis, m.kind) == (meaning.axis, meaning.kind) for m, _ in found):
            notes.append(f"{name} tells again what an earlier column does, and was left out")
            ignored.append(name)
            continue
        places.append(place)
        found.append((meaning, unit_from))
    return places, found, ignored


def _time_column(names: list[str], taken: list[int]) -> int | None:
    """Seconds before texts of UTC: they are finer."""
    free = [(k, {*words_of(name)}) for k, name in enumerate(names) if k not in taken]
    for wanted in (_TIME_WORDS, _UTC_WORDS):
        for place, words in free:
            if words & wanted and not (wanted is _TIME_WORDS and words & _UTC_WORDS):
                return place
    return next((k for k, words in free if words & {"epoch"}), None)


def _columns(
    lines: list[str], delimiter: str | None, places: list[int], notes: list[str]
) -> tuple[list[Array], list[str]]:
    """Numbers of the wanted columns, NaN where there is none, and the first one's texts."""
    has_comma = delimiter != "," and any(_DECIMAL_COMMA.search(line) for line in lines[:50])
    if has_comma:
        notes.append("numbers have decimal commas")
    plain = [line.replace(",", ".") for line in lines] if has_comma else lines
    try:
        fast = np.loadtxt(
            plain, delimiter=delimiter, usecols=places, ndmin=2, comments=None, quotechar='"'
        )
        return list(fast.T), []
    except (ValueError, IndexError):
        pass  # some cell is no number: cell by cell
    value = np.full((len(places), len(lines)), np.nan)
    texts: list[str] = []
    for number, line in enumerate(plain):
        row = _split(line, delimiter)
        texts.append(row[places[0]] if places[0] < len(row) else "")
        for k, place in enumerate(places):
            if place < len(row):
                value[k, number] = _number(row[place])
    return list(value), texts


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _is_number(text: str) -> bool:
    return bool(re.fullmatch(r"\s*[-+]?[\d.,]+(?:[eE][-+]?\d+)?\s*", text))


def _times(
    name: str,
    value: Array,
    texts: list[str],
    epoch_utc: datetime | None,
    plan_epoch_utc: datetime,
    notes: list[str],
) -> tuple[Array, datetime]:
    if np.isfinite(value).mean() < 0.5 and texts:
        since_utc = epoch_utc or plan_epoch_utc
        t_s, told = utc_seconds(texts, since_utc, name)
        notes += told
        return t_s, since_utc
    words = {*words_of(name)}
    factor = next((factor for word, factor in _SECONDS.items() if word in words), 1.0)
    t_s = value * factor
    middle = float(np.nanmedian(t_s)) if np.isfinite(t_s).any() else 0.0
    for unix in (factor, 1e-3, 1e-6):
        if _UNIX_MIN_S < middle * unix / factor < _UNIX_MAX_S:
            # Unix time counts no leap seconds: those since 1970 come with the date.
            t_s = value * unix
            in_range = t_s[(t_s > _UNIX_MIN_S) & (t_s < _UNIX_MAX_S)]
            first = float(in_range[0]) if len(in_range) else middle * unix / factor
            start_utc = _unix_utc(first)
            notes.append(f"{name} was read as Unix time; its first row is {utc_text(start_utc)}")
            return t_s - first, start_utc
    if epoch_utc is None:
        notes.append(f"{name} was taken to count from the plan's epoch {utc_text(plan_epoch_utc)}")
    return t_s, epoch_utc or plan_epoch_utc


def _unix_utc(unix_s: float) -> datetime:
    days, rest_s = divmod(unix_s, 86400.0)
    moment = datetime.fromtimestamp(days * 86400.0, tz=UTC)
    return shifted_utc(moment, rest_s)


def utc_seconds(
    texts: Sequence[str], since_utc: datetime, column: str | None = None
) -> tuple[Array, tuple[str, ...]]:
    """Seconds of texts such as 2015-02-27T17:34:00.2Z, (n,), NaN of those that are none; notes.

    column: of a CSV, None for a list in JSON.  Raises InvalidInput for a date that there is not.
    """
    notes: tuple[str, ...] = ()
    plain = [_DATE.fullmatch(text.strip().replace(",", ".")) for text in texts]
    if any(match and not re.search(r"(?:UTC|[Zz])\s*$", match[0]) for match in plain):
        notes = ("times without an offset were read as UTC",)
    t_s = np.full(len(texts), np.nan)
    clear = {k: f"{match[1]}T{match[2]}" for k, match in enumerate(plain) if match is not None}
    try:
        stamps = np.array([*clear.values()], dtype="datetime64[us]")
    except ValueError:  # a leap second, or no such day: one by one
        stamps = np.array([], dtype="datetime64[us]")
    if len(stamps) and stamps.min() >= _KNOWN_FROM and stamps.max() <= _KNOWN_TO:
        first_utc = stamps[0].item().replace(tzinfo=UTC)
        last_utc = stamps[-1].item().replace(tzinfo=UTC)
        since_first_s = (stamps - stamps[0]) / np.timedelta64(1, "s")
        if elapsed_s(last_utc, first_utc) == since_first_s[-1]:  # no leap second between
            t_s[[*clear]] = elapsed_s(first_utc, since_utc) + since_first_s
    for row in np.flatnonzero(np.isnan(t_s)).tolist():
        text = texts[row].strip().replace(" ", "T", 1)
        if row in clear:
            text = clear[row][:_TO_THE_NANOSECOND] + "Z"
        try:
            t_s[row] = elapsed_s(utc_from_text(text), since_utc)
        except TimeNotCovered:
            continue
        except ValueError as error:
            if _LIKE_A_DATE.match(text):
                raise _no_such_time(str(error), row, column) from None
    return t_s, notes


def _no_such_time(detail: str, row: int, column: str | None) -> InvalidInput:
    """The row as a spreadsheet counts rows under those that name the columns, from 1."""
    if column is None:
        return InvalidInput(detail, field=f"samples.utc.{row}")
    return InvalidInput(f"row {row + 1}, column {column[:40]}: {detail}", field="samples")


def _refusal(detail: str, names: list[str]) -> InvalidInput:
    shown = ", ".join(name[:40] for name in names[:12])
    return InvalidInput(f"{detail}; the file has {shown or 'none'}", field="samples")
