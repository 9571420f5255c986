"""Damaged telemetry, and what must be reported of each damage.

Each file is made of valid rows of another program (tests/other_platform.py): angles of a
clock 0.37 s ahead.
"""

import random
from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import field as member
from itertools import pairwise

CLOCK_AHEAD_S = 0.37


@dataclass(frozen=True)
class Damaged:
    """content: of the file.  told: whether an answer tells of it.  drops: rows by reason.
    columns: what the request says they are."""

    content: bytes
    told: Callable[[dict], bool] = lambda _: True
    drops: tuple[tuple[str, int], ...] = ()
    offset_within_s: float = 0.005
    columns: dict[str, str] = member(default_factory=dict)


@dataclass(frozen=True)
class Refused:
    """words: what the refusal says.  field: what it names."""

    content: bytes
    words: tuple[str, ...]
    field: str = "samples"
    columns: dict[str, str] = member(default_factory=dict)


def _csv(header, rows, mark=",", end="\n"):
    return end.join([mark.join(header), *(mark.join(row) for row in rows)]).encode() + b"\n"


def _texts(rows):
    return [[f"{row[0]:.6f}", f"{row[1]:.7f}", f"{row[2]:.7f}"] for row in rows]


def _warned(*words):
    return lambda answer: any(all(w in one for w in words) for one in answer["warnings"])


def _in_unit(unit):
    return lambda answer: {one["unit"] for one in answer["samples"]["columns"]} == {unit}


HEAD = ["t_s", "alpha_deg", "beta_deg"]


def damaged(rows, utc_of):
    """By name; rows: tag, alpha, beta in seconds and degrees.  utc_of: RFC 3339 of a tag."""
    text = _texts(rows)
    count = len(rows)
    shuffled = text[:]
    random.Random(5).shuffle(shuffled)
    spiky = [[row[0], "170.0", row[2]] if k % 97 == 40 else row for k, row in enumerate(text)]
    holes = [[row[0], "NaN", ""] if k % 50 == 10 else row for k, row in enumerate(text)]
    words = [["ERROR", *row[1:]] if k % 200 == 5 else row for k, row in enumerate(text)]
    arcsec = [[row[0], row[1] * 3600.0, row[2] * 3600.0] for row in rows]
    in_utc = [[utc_of(row[0]), *cells[1:]] for row, cells in zip(rows, text, strict=True)]
    rates = [(after[1] - before[1]) / (after[0] - before[0]) for before, after in pairwise(rows)]
    own_names = {"t_s": "Time [s]", "alpha_deg": "Winkel, außen", "beta_deg": "inner"}
    own = [f'"{name}"' for name in own_names.values()]
    files = {
        "valid": Damaged(_csv(HEAD, text)),
        "a gap of 20 s": Damaged(
            _csv(HEAD, text[:600] + text[900:]), lambda a: len(a["samples"]["gaps"]) == 1
        ),
        "rows shuffled": Damaged(
            _csv(HEAD, shuffled), lambda a: a["samples"]["reordered"] > count / 2
        ),
        "a packet sent again": Damaged(
            _csv(HEAD, [*text[:500], *text[300:]]), drops=(("repeated", 200),)
        ),
        "spikes": Damaged(_csv(HEAD, spiky), drops=(("outlier", len(range(40, count, 97))),)),
        "NaN and empty cells": Damaged(
            _csv(HEAD, holes), drops=(("no_value", len(range(10, count, 50))),)
        ),
        "words for times": Damaged(
            _csv(HEAD, words), drops=(("no_time", len(range(5, count, 200))),)
        ),
        "wrapped at 360": Damaged(
            _csv(HEAD, _texts([[t, a % 360.0, b % 360.0] for t, a, b in rows])),
            lambda a: a["samples"]["wrapped"] > count / 2,
        ),
        "arcsec by name": Damaged(
            _csv(["t_s", "alpha_arcsec", "beta_arcsec"], _texts(arcsec)), _in_unit("arcsec")
        ),
        "arcsec by the mapping": Damaged(
            _csv(["t_s", "A", "B"], _texts(arcsec)),
            _in_unit("arcsec"),
            columns={"alpha_arcsec": "A", "beta_arcsec": "B"},
        ),
        "other names": Damaged(_csv(own, text), columns=own_names),
        "a mapping before a name": Damaged(
            _csv([*HEAD, "encoder"], [[row[0], "5.0", row[2], row[1]] for row in text]),
            lambda a: a["samples"]["ignored_columns"] == ["alpha_deg"],
            columns={"alpha_deg": "encoder"},
        ),
        "a byte order mark, odd case": Damaged(
            b"\xef\xbb\xbf" + _csv(["T_S", "Alpha_Deg", "BETA_DEG"], text)
        ),
        "UTF-16 and tabs": Damaged(_csv(HEAD, text, "\t").decode().encode("utf-16")),
        "semicolons, CRLF, blank lines": Damaged(_csv(HEAD, text, ";", end="\r\n\r\n")),
        "UTC for times": Damaged(_csv(["utc", *HEAD[1:]], in_utc)),
        "columns of other things": Damaged(
            _csv([*HEAD, "alpha_cmd_deg", "beta_rate_deg_s"], [[*row, "0", ""] for row in text]),
            lambda a: a["samples"]["ignored_columns"] == ["alpha_cmd_deg", "beta_rate_deg_s"],
        ),
        "cut off, and rows of different length": Damaged(
            _csv(HEAD, [row[: 1 + k % 3] if k % 7 == 0 else row for k, row in enumerate(text)])[:-9]
        ),
        "before and after the plan": Damaged(
            _csv(
                HEAD,
                [
                    *([f"{-60 + k:.3f}", "0.0", "0.0"] for k in range(60)),
                    *text,
                    *([f"{rows[-1][0] + 5 + k:.3f}", text[-1][1], text[-1][2]] for k in range(60)),
                ],
            ),
            lambda a: a["samples"]["dropped"]["outside_plan"] >= 118,
        ),
        "values held for a second": Damaged(
            _csv(HEAD, [[row[0], *text[k - k % 15][1:]] for k, row in enumerate(text)]),
            _warned("repeat the row before"),
            (("held", count - len(text[::15])),),
        ),
        "tags of whole seconds": Damaged(
            _csv(HEAD, [[f"{float(row[0]) // 1:.0f}", *row[1:]] for row in text]),
            _warned("tags are too coarse"),
            offset_within_s=1.0,
        ),
        "rates of another plan": Damaged(
            _csv(
                [*HEAD, "alpha_rate_deg_s"],
                [[*row, f"{rate + 3.0 * (k % 600 > 300):.7f}"]
                 for k, (row, rate) in enumerate(zip(text, [*rates, 0.0], strict=True))],
            ),
            _warned("alpha's rates don't follow its plan"),
        ),
        "a frozen sensor": Damaged(
            _csv(HEAD, [[*row[:2], "0.0"] for row in text]),
            lambda a: a["axes"]["beta"]["gain"] is None and not a["axes"]["beta"]["limits_checked"],
        ),
    }  # fmt: skip
    comma = [[cell.replace(".", ",") for cell in row] for row in text]
    refused = {
        "nothing": Refused(b"", ("is empty",)),
        "a header alone": Refused(_csv(HEAD, []), ("is empty",)),
        "no header": Refused(_csv(text[0], text[1:]), ("no column is named", repr(text[0][1]))),
        "bytes": Refused(bytes(range(256)) * 20, ("no text in UTF-8: byte 129 is 0x80",)),
        "other names": Refused(
            _csv(["Time", "Alpha angle", "inner"], text),
            (
                "parted by ',', as 'Time', 'Alpha angle', 'inner'",
                '{"t_s": "Time", "alpha_deg": "Alpha angle", "beta_deg": "inner"}',
            ),
        ),
        "no unit": Refused(_csv(["t_s", "alpha", "beta"], text), ('"alpha_deg": "alpha"',)),
        "no time": Refused(_csv(["row", *HEAD[1:]], text), ("as one of the time",)),
        "a column twice": Refused(
            _csv([*HEAD, "ALPHA_rad"], [[*row, "5.0"] for row in text]),
            ("ALPHA_rad tells the same as alpha_deg",),
        ),
        "a mapping to nothing": Refused(
            _csv(HEAD, text), ("has no column 'A'", "as 't_s',"), "columns.alpha_deg",
            {"alpha_deg": "A"},
        ),
        "a mapping of no axis": Refused(
            _csv(HEAD, text), ("'gamma_deg' is no column",), "columns.gamma_deg",
            {"gamma_deg": "alpha_deg"},
        ),
        "all cells words": Refused(
            _csv(HEAD, [[row[0], "a", "b"] for row in text]),
            ("alpha_deg, row 1: 'a' is no number",),
        ),
        "times all words": Refused(
            _csv(HEAD, [["later", *row[1:]] for row in text]), ("t_s, row 1: 'later'",)
        ),
        "dates all words": Refused(
            _csv(["utc", *HEAD[1:]], [["later", *row[1:]] for row in text]), ("'later' is no time",)
        ),
        "times of another day": Refused(
            _csv(
                ["utc", *HEAD[1:]],
                [[utc_of(row[0] + 86400), *cells[1:]]
                 for row, cells in zip(rows, text, strict=True)],
            ),
            ("the samples run from",),
            "samples.epoch",
        ),
        "decimal commas": Refused(
            _csv(HEAD, comma, ";"), (f"t_s, row 1: {comma[0][0]!r} is no number", "with a point")
        ),
        "one decimal comma": Refused(
            _csv(HEAD, [*text[:9], comma[9], *text[10:]], ";"), ("t_s, row 10",)
        ),
        "commas for decimals too": Refused(
            _csv(HEAD, comma), ("names 3 columns, but rows have 6 cells",)
        ),
        "radians named degrees": Refused(
            _csv(HEAD, _texts([[t, a / 57.29578, b / 57.29578] for t, a, b in rows])),
            ("each fits in rad: name them so",),
        ),
        "columns swapped": Refused(
            _csv(HEAD, [[t, b, a] for t, a, b in text]), ("their names are swapped",)
        ),
        "zeros": Refused(_csv(HEAD, [[t, "0", "0"] for t, _, _ in text]), ("they stay at 0",)),
        "too few rows": Refused(_csv(HEAD, text[500:504]), ("needs 8",)),
    }  # fmt: skip
    return files, refused
