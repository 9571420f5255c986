"""The contract of telemetry, and its rows in order: named columns with units, as JSON or CSV."""

import codecs
import csv
import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Any, Literal

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.errors import FieldError, InvalidInput, InvalidRequest
from planner.base.spec import Within, spec
from planner.inflight.telemetry.following import PlannedMotion, sensor_step
from planner.world.frames.time_scales import (
    KNOWN_FROM_UTC,
    KNOWN_TO_UTC,
    elapsed_s,
    utc_from_text,
)

Kind = Literal["angle", "rate"]
AngleUnit = Literal["deg", "rad", "mrad", "arcmin", "arcsec"]
ColumnUnit = AngleUnit | Literal["1"]
Dropped = Literal["no_time", "no_value", "repeated", "held", "outside_plan", "outlier"]
Columns = Mapping[str, str]

RAD_BY_UNIT: dict[AngleUnit, float] = {
    "deg": np.radians(1.0),
    "rad": 1.0,
    "mrad": 1e-3,
    "arcmin": np.radians(1.0 / 60.0),
    "arcsec": np.radians(1.0 / 3600.0),
}
TIMES = ("t_s", "utc", "unix_s")


@dataclass(frozen=True, kw_only=True)
class SampleOptions:
    """How much is read, and which rows measure nothing of their own."""

    rows_max: int = 400_000  # 15 Hz for seven hours
    rows_min: int = 8  # fewer tell nothing of a clock
    columns_max: int = 200  # of a CSV file
    json_columns_max: int = 20
    image_offsets_max: int = 100
    parameters_max: int = 8
    tag_max_s: float = 1e10  # what no clock shows
    value_max: float = 1e9  # what no sensor shows
    same_tag_s: float = 1e-6  # a microsecond, the resolution of a time tag
    coarse_min: float = 0.2  # of the rows; fewer are packets sent again
    # Of the rows in which the plan moves by more than the sensor's steps: rows that repeat the one
    # before come from a sensor that is slower than they are.
    held_min: float = 0.2
    held_runs_min: int = 10  # fewer are an axis that stood
    steps_clear: float = 2.0  # of the sensor, by which the plan must move


OPTIONS = SampleOptions()

_OffsetDeg = Annotated[float, Within(-10.0, 10.0)]
_DATE = re.compile(r"(\d{4}-\d\d-\d\d)[ Tt](\d\d:\d\d:\d\d(?:\.\d+)?)[Zz]?", re.ASCII)


@spec
class ImageOffset:
    """Position of the target in a frame, from its centre.

    epoch: time of the frame, by the plan's clock; UTC. E.g. `"2015-02-27T17:37:00Z"`.
    offset_deg: along the frame's first side and along its second. E.g. `[0.12, -0.05]`.
    sigma_deg: 1-sigma of each.
    """

    epoch: datetime
    offset_deg: tuple[_OffsetDeg, _OffsetDeg]
    sigma_deg: Annotated[float, Within(1e-6, 10.0)] = 0.001


@dataclass(frozen=True, kw_only=True)
class ColumnMeaning:
    """axis: its number.  unit: of an angle, or of a rate's angle per second; 1 of the part of a
    quaternion, whose number is the axis."""

    axis: int
    kind: Kind
    unit: ColumnUnit


@dataclass(frozen=True, kw_only=True)
class ColumnContract:
    """Columns that one platform's telemetry may hold.

    meanings: by names in small letters.  wanted: the names, as a refusal proposes them.  least:
    what there must be one of.  first: what is asked for of JSON that has none.  guesses: a
    contract's name, and the word that a file's own name of it may hold.
    """

    meanings: Mapping[str, ColumnMeaning]
    wanted: str
    least: str
    first: tuple[str, str]
    guesses: tuple[tuple[str, str], ...]

    def meaning_of(self, name: str) -> ColumnMeaning | None:
        """In any case; None of a name that is not of the contract."""
        return self.meanings.get(name.strip().lower())


@dataclass(frozen=True, kw_only=True, eq=False)
class TelemetryColumn:
    """Values as they were sent, (n,), NaN where there is none; in the meaning's unit."""

    name: str
    meaning: ColumnMeaning
    value: Array

    @property
    def value_rad(self) -> Array:
        """In radians, or radians per second; parts of a quaternion as they are."""
        unit = self.meaning.unit
        return self.value if unit == "1" else self.value * RAD_BY_UNIT[unit]


@dataclass(frozen=True, kw_only=True, eq=False)
class SentSamples:
    """Of JSON.  t_s: (n,), NaN for null; None where utc tells the time.  columns: (n,) each."""

    t_s: Array | None
    utc: tuple[str, ...]
    columns: Mapping[str, Array]


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """Rows in the order in which they came.

    epoch_utc: from which t_s counts by the telemetry's clock.  t_s: (n,), NaN where there is no
    time tag.  columns: each (n,).  ignored: names of columns that were not read.
    """

    epoch_utc: datetime
    t_s: Array
    columns: tuple[TelemetryColumn, ...]
    ignored: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class CleanSamples:
    """Rows that are used, in the order of their time tags, in radians.

    tag_s: (n,), the telemetry's clock less the table's epoch, strictly increasing.
    angle_rad, rate_rad_s: (n, d), NaN where an axis has none.
    """

    tag_s: Array
    angle_rad: Array
    rate_rad_s: Array


def angle_meanings(template: str, axis: int, kind: Kind) -> dict[str, ColumnMeaning]:
    """Of one axis, by names that the template makes with each unit."""
    return {
        template.format(unit).lower(): ColumnMeaning(axis=axis, kind=kind, unit=unit)
        for unit in RAD_BY_UNIT
    }


def other_units() -> str:
    """Words on the units that may stand for deg."""
    return f"or in {', '.join(unit for unit in RAD_BY_UNIT if unit != 'deg')}"


def read_csv(
    content: bytes,
    contract: ColumnContract,
    epoch_utc: datetime | None,
    plan_epoch_utc: datetime,
    columns: Columns | None = None,
) -> Samples:
    """Rows in the file's order; raises InvalidInput for what is not as the contract has it.

    epoch_utc: from which a column t_s counts; None: the plan's.  columns: the file's name of a
    column by the contract's.
    """
    lines, delimiter = _lines_of(content)
    reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
    try:
        names = [name.strip() for name in next(reader)]
        if len(names) > OPTIONS.columns_max:
            raise _refusal(f"has {len(names)} columns; up to {OPTIONS.columns_max} are read")
        place_by_name = _recognised(names, contract, columns or {}, delimiter)
        cells = _cells(reader, [*place_by_name.values()], len(names))
    except csv.Error as error:
        raise _refusal(f"can't be read as CSV: {error}") from None
    texts = dict(zip(place_by_name, cells, strict=True))
    time, *rest = place_by_name
    t_s, since_utc = _times(time, texts[time], epoch_utc or plan_epoch_utc)
    taken = {*place_by_name.values()}
    return Samples(
        epoch_utc=since_utc,
        t_s=t_s,
        columns=tuple(
            TelemetryColumn(
                name=names[place_by_name[name]],
                meaning=contract.meanings[name.strip().lower()],
                value=_numbers(names[place_by_name[name]], texts[name]),
            )
            for name in rest
        ),
        ignored=tuple(
            dict.fromkeys(name for k, name in enumerate(names) if name and k not in taken)
        ),
    )


def sent_samples(members: dict[str, Any]) -> SentSamples:
    """Of a request's JSON, by the contract's names; raises InvalidRequest."""
    if len(members) > (most := OPTIONS.json_columns_max):
        raise _unreadable("samples", f"has {len(members)} columns; at most {most} are read")
    times = [name for name in TIMES[:2] if members.get(name)]
    if len(times) != 1:
        raise _unreadable("samples.t_s", "is required, or utc instead: a time tag for each sample")
    utc = members.pop("utc", None) or []
    if not (isinstance(utc, list) and all(isinstance(text, str) for text in utc)):
        raise _unreadable("samples.utc", "must be a list of texts such as 2015-02-27T17:36:20.000Z")
    t_s = members.pop("t_s", None)
    count = len(utc or t_s) if isinstance(utc or t_s, list) else 0
    if count > OPTIONS.rows_max:
        raise _unreadable(
            f"samples.{times[0]}", f"has {count} tags; at most {OPTIONS.rows_max} are read"
        )
    columns = {name: _column(name, value) for name, value in members.items()}
    for name, column in columns.items():
        if len(column) != count:
            raise _unreadable(
                f"samples.{name}"[:80],
                f"must have a value for each of the {count} time tags, null where there is none; "
                f"it has {len(column)}",
            )
    return SentSamples(t_s=None if utc else _column("t_s", t_s), utc=tuple(utc), columns=columns)


def _column(name: str, value: object) -> Array:
    field = f"samples.{name}"[:80]
    if not isinstance(value, list):
        raise _unreadable(field, "must be a list of numbers, null where there is none")
    kinds = {*map(type, value)}
    if not kinds <= {int, float, type(None)}:
        number = next(k for k, one in enumerate(value) if type(one) not in (int, float, type(None)))
        raise _unreadable(f"{field}.{number}", "must be a number, or null where there is none")
    try:
        return np.array(value, dtype=np.float64)
    except OverflowError:
        raise _unreadable(field, "holds a whole number too large to be measured") from None


def _unreadable(field: str, detail: str) -> InvalidRequest:
    return InvalidRequest(FieldError(field=field, detail=detail))


def samples_of(sent: SentSamples, contract: ColumnContract, since_utc: datetime) -> Samples:
    """Columns by the contract's names."""
    columns: list[TelemetryColumn] = []
    seen: dict[tuple[int, Kind], str] = {}
    for name, value in sent.columns.items():
        meaning = contract.meaning_of(name)
        if meaning is None:
            raise _fault(
                name,
                f"is of no axis of this platform; give t_s, {contract.wanted}, or name this "
                "column in `columns`",
            )
        if other := seen.get((meaning.axis, meaning.kind)):
            raise _fault(name, f"tells the same as {other[:80]}; send one of them")
        seen[meaning.axis, meaning.kind] = name
        columns.append(TelemetryColumn(name=name, meaning=meaning, value=value))
    if not columns:
        raise _fault(*contract.first)
    t_s = utc_seconds(sent.utc, since_utc) if sent.t_s is None else sent.t_s
    return Samples(epoch_utc=since_utc, t_s=t_s, columns=tuple(columns))


def _lines_of(content: bytes) -> tuple[list[str], str]:
    """Without comments and empty ones, and the mark that parts columns."""
    is_utf16 = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = content.decode("utf-16" if is_utf16 else "utf-8-sig")
    except UnicodeDecodeError as error:
        raise _refusal(
            f"is no text in UTF-8: byte {error.start + 1} is 0x{content[error.start]:02x}; save it "
            "as CSV in UTF-8"
        ) from None
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if len(lines) < 2:
        raise _refusal(
            "is empty: send CSV with a line that names the columns and a line per sample"
        )
    if len(lines) - 1 > OPTIONS.rows_max:
        raise _refusal(
            f"has {len(lines) - 1} rows; up to {OPTIONS.rows_max} are read: cut it to the session, "
            "or thin it"
        )
    return lines, max(",;\t", key=lines[0].count)


def _recognised(
    names: Sequence[str], contract: ColumnContract, columns: Columns, delimiter: str
) -> dict[str, int]:
    """Places of the columns that are read by the contract's names, the time's first."""
    named = {}
    for name, own in columns.items():
        if name not in TIMES and contract.meaning_of(name) is None:
            raise InvalidInput(
                f"{name[:60]!r} is no column that is read; name t_s, {contract.wanted}",
                field=f"columns.{name}"[:80],
            )
        if own not in names:
            raise InvalidInput(
                f"the file has no column {own[:60]!r}; {_read_as(names, delimiter)}",
                field=f"columns.{name}"[:80],
            )
        named[own] = name
    found: dict[str, int] = {}
    of_axis: dict[tuple[int, Kind], str] = {}
    for place in sorted(range(len(names)), key=lambda place: names[place] not in named):
        name = named.get(names[place], names[place].lower())
        if name in TIMES:
            found.setdefault(name, place)
        elif meaning := contract.meaning_of(name):
            key = (meaning.axis, meaning.kind)
            if key not in of_axis:
                of_axis[key] = names[place]
                found[name] = place
            elif of_axis[key] not in named or names[place] in named:
                raise _refusal(f"{names[place][:40]} tells the same as {of_axis[key][:40]}; "
                               "send one of them, or say which in `columns`")  # fmt: skip
    time = next((name for name in (*columns, *TIMES) if name in TIMES and name in found), None)
    if time is None or not of_axis:
        lacks = "the time" if time is None else contract.least
        sent = json.dumps(_proposed(names, contract), ensure_ascii=False)
        raise _refusal(
            f"no column is named as one of {lacks}: name it t_s, {contract.wanted}. "
            f"{_read_as(names, delimiter)}. Where the file names them otherwise, send `columns` "
            f"with the request, such as {sent}, with each one's own unit"
        )
    return {time: found[time]} | {name: k for name, k in found.items() if name not in TIMES}


def _cells(reader: Iterable[list[str]], places: Sequence[int], width: int) -> list[list[str]]:
    """Of the columns at these places; empty of a row that is too short or too long."""
    found: list[list[str]] = [[] for _ in places]
    longer, example = 0, [""]
    for row in reader:
        while len(row) > width and not row[-1]:
            row.pop()
        if len(row) > width:
            longer, example = longer + 1, row
            row = []
        for cells, place in zip(found, places, strict=True):
            cells.append(row[place] if place < len(row) else "")
    if 2 * longer > len(found[0]):
        raise _refusal(
            f"the first line names {width} columns, but rows have {len(example)} cells, such as "
            f"{', '.join(map(repr, example))[:100]}; write decimals with a point, and a name for "
            "each column"
        )
    return found


def _numbers(name: str, cells: list[str]) -> Array:
    """NaN where there is none; raises InvalidInput for decimal commas, and for no number at all."""
    try:
        return np.array(cells, dtype=np.float64)
    except ValueError:
        value = np.array([_number(cell) for cell in cells])
    filled = [row for row, cell in enumerate(cells) if cell.strip()]
    wrong = [row for row in filled if "," in cells[row] and np.isnan(value[row])]
    wrong = [row for row in wrong if np.isfinite(_number(cells[row].replace(",", ".", 1)))]
    if not wrong and filled and not np.isfinite(value).any():
        wrong = filled
    if wrong:
        raise _refusal(
            f"column {name[:40]}, row {wrong[0] + 1}: {cells[wrong[0]][:40]!r} is no number; write "
            "numbers such as -12.5, with a point, and nothing where there is none"
        )
    return value


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _times(name: str, cells: list[str], since_utc: datetime) -> tuple[Array, datetime]:
    """Seconds, and since when."""
    if name == "utc":
        t_s = utc_seconds(cells, since_utc)
        if any(cells) and not np.isfinite(t_s).any():
            row = next(row for row, cell in enumerate(cells) if cell)
            raise _refusal(
                f"column utc, row {row + 1}: {cells[row][:40]!r} is no time; write UTC such as "
                "2015-02-27T17:34:00.2Z"
            )
        return t_s, since_utc
    t_s = _numbers(name, cells)
    if name == "t_s":
        return t_s, since_utc
    # Unix time counts no leap seconds: those since 1970 come with the date of its first row.
    is_known = (t_s > KNOWN_FROM_UTC.timestamp()) & (t_s < KNOWN_TO_UTC.timestamp())
    if not is_known.any():
        return np.full(len(t_s), np.nan), since_utc
    first_s = float(np.floor(t_s[is_known][0]))
    return np.where(is_known, t_s - first_s, np.nan), datetime.fromtimestamp(first_s, tz=UTC)


def utc_seconds(texts: Sequence[str], since_utc: datetime) -> Array:
    """Seconds of texts such as 2015-02-27T17:34:00.2Z, (n,); NaN of what is no time."""
    t_s = np.full(len(texts), np.nan)
    plain = [_DATE.fullmatch(text.strip()) for text in texts]
    clear = {k: f"{match[1]}T{match[2]}" for k, match in enumerate(plain) if match is not None}
    try:
        stamps = np.array([*clear.values()], dtype="datetime64[us]")
    except ValueError:  # a leap second, or no such day: one by one
        stamps = np.array([], dtype="datetime64[us]")
    low, high = (np.datetime64(one.replace(tzinfo=None)) for one in (KNOWN_FROM_UTC, KNOWN_TO_UTC))
    if len(stamps) and stamps.min() >= low and stamps.max() <= high:
        first_utc, last_utc = (stamps[k].item().replace(tzinfo=UTC) for k in (0, -1))
        since_first_s = (stamps - stamps[0]) / np.timedelta64(1, "s")
        if elapsed_s(last_utc, first_utc) == since_first_s[-1]:  # no leap second between
            t_s[[*clear]] = elapsed_s(first_utc, since_utc) + since_first_s
    for row in np.flatnonzero(np.isnan(t_s)).tolist():
        text = f"{clear[row][:29]}Z" if row in clear else texts[row].strip()  # 29: nanoseconds
        try:
            t_s[row] = elapsed_s(utc_from_text(text), since_utc)
        except ValueError:
            continue  # counted as no_time
    return t_s


def _read_as(names: Sequence[str], delimiter: str) -> str:
    shown = ", ".join(repr(name[:40]) for name in names[:12])
    return f"its first line was read, parted by {delimiter!r}, as {shown}"


def _proposed(names: Sequence[str], contract: ColumnContract) -> dict[str, str]:
    """A mapping such as is meant, of the file's own names, taken in their order at worst."""
    left, found = [name[:40] for name in names if name], {}
    for name, word in (("t_s", "time"), *contract.guesses):
        own = next((one for one in left if word in one.lower()), left[0] if left else "...")
        left = [one for one in left if one != own]
        found[name] = own
    return found


def _refusal(detail: str) -> InvalidInput:
    return InvalidInput(detail, field="samples")


def _fault(name: str, detail: str) -> InvalidInput:
    return InvalidInput(f"{name[:60]} {detail}", field=f"samples.{name}"[:80])


@dataclass(frozen=True, eq=False)
class OrderedRows:
    """row: numbers of the rows kept, by their tags.  dropped: rows by reason.  reordered: how
    many of the kept came before an earlier one.  notes: on tags too coarse."""

    row: Indices
    dropped: Counter[Dropped]
    reordered: int
    notes: tuple[str, ...]


def order_rows(tag_s: Array, value: Array) -> OrderedRows:
    """Sorted, each time once.  tag_s: (n,), NaN where unreadable.  value: (n, k), NaN likewise."""
    dropped: Counter[Dropped] = Counter()
    has_time, has_value = np.isfinite(tag_s), np.isfinite(value).any(axis=1)
    dropped["no_time"] = int(np.sum(~has_time))
    dropped["no_value"] = int(np.sum(has_time & ~has_value))
    row = np.flatnonzero(has_time & has_value)
    reordered = int(np.sum(tag_s[row] < np.maximum.accumulate(tag_s[row]))) if len(row) else 0
    row = row[np.argsort(tag_s[row], kind="stable")]
    is_new = np.diff(tag_s[row], prepend=-np.inf) > OPTIONS.same_tag_s
    dropped["repeated"] = int(np.sum(~is_new))
    notes = _notes_on_tags(tag_s[row], value[row], is_new)
    return OrderedRows(row[is_new], dropped, reordered, notes)


def _notes_on_tags(tag_s: Array, value: Array, is_new: Mask) -> tuple[str, ...]:
    """tag_s: increasing, as are the rows of value."""
    first = np.maximum.accumulate(np.where(is_new, np.arange(len(is_new)), 0))
    differs = ~is_new & ~((value == value[first]) | ~np.isfinite(value)).all(axis=1)
    if differs.sum() < OPTIONS.coarse_min * len(is_new):
        return ()
    step_s = float(np.median(np.diff(tag_s[is_new]))) if is_new.sum() > 1 else 0.0
    return (
        f"{int(differs.sum())} rows have the time tag of another row, and other values: the tags "
        f"are too coarse; time_offset_s may be off by {step_s:.3g} s, whatever its sigma",
    )


def leave_out_held(
    values: dict[Kind, Array],
    t_s: Array,
    motions: Sequence[PlannedMotion],
    names: Sequence[str],
    dropped: Counter[Dropped],
) -> list[str]:
    """Sets values that only repeat the row before to NaN, and counts the rows left without any.

    values: (n, d) each, in order of t_s, (n,), which is about the plan's time.
    """
    notes = []
    any_held = np.zeros(len(t_s), dtype=bool)
    for kind, value in values.items():
        for motion, name in zip(motions, names, strict=True):
            own = value[:, motion.axis]
            planned = motion.angle_rad(t_s) if kind == "angle" else motion.rate_rad_s(t_s)
            held = held_rows(own, planned)
            if held.any():
                notes.append(
                    f"{int(held.sum())} {kind}s of {name} repeat the row before while the plan "
                    "moves on: the sensor gives its values less often than rows come, and only "
                    "the first of each was used"
                )
            own[held] = np.nan
            any_held |= held
    has_value = np.isfinite(np.hstack([*values.values()])).any(axis=1)
    dropped["held"] += int(np.sum(any_held & ~has_value))
    return notes


def held_rows(value: Array, planned_value: Array) -> Mask:
    """Rows of a column whose value is an earlier row's, (n,); none where values don't come so.

    value: (n,) in order of time, NaN where there is none.  planned_value: of the same rows.
    """
    held = np.zeros(len(value), dtype=bool)
    own = np.flatnonzero(np.isfinite(value))
    is_same = np.diff(value[own]) == 0.0
    if not is_same.any():
        return held
    # An encoder's values stay the same, too, while the plan moves by less than its step.
    is_clear = np.abs(np.diff(planned_value[own])) > OPTIONS.steps_clear * sensor_step(value[own])
    stays = is_same & is_clear
    runs = int(np.sum(np.diff(stays.astype(np.int8), prepend=0) == 1))
    if runs >= OPTIONS.held_runs_min and stays.sum() > OPTIONS.held_min * is_clear.sum():
        held[own[1:][is_same]] = True
    return held
