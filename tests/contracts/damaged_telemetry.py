"""Damaged telemetry, and what must be reported of each damage.

Each file is made of valid rows of another program (tests/other_platform.py): angles of a
clock 0.37 s ahead.
"""

import random
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

CLOCK_AHEAD_S = 0.37


@dataclass(frozen=True)
class Damaged:
    """content: of the file.  told: whether an answer tells of it.  drops: rows by reason."""

    content: bytes
    told: Callable[[dict], bool] = lambda _: True
    drops: tuple[tuple[str, int], ...] = ()
    offset_within_s: float = 0.005


@dataclass(frozen=True)
class Refused:
    """word: what the refusal says.  field: what it names."""

    content: bytes
    word: str
    field: str = "samples"


def _csv(header, rows, mark=",", end="\n"):
    return end.join([mark.join(header), *(mark.join(row) for row in rows)]).encode() + b"\n"


def _texts(rows):
    return [[f"{row[0]:.6f}", f"{row[1]:.7f}", f"{row[2]:.7f}"] for row in rows]


def _warned(*words):
    return lambda answer: any(all(w in one for w in words) for one in answer["warnings"])


def _unit(name, unit, unit_from="fit"):
    def told(answer):
        columns = {one["name"]: one for one in answer["samples"]["columns"]}
        return (columns[name]["unit"], columns[name]["unit_from"]) == (unit, unit_from)

    return told


def _scaled(rows, factor):
    return [[row[0], row[1] * factor, row[2] * factor] for row in rows]


HEAD = ["t_s", "alpha_deg", "beta_deg"]
DEG_PER_RAD = 57.29577951308232


def damaged(rows, utc_of):
    """By name; rows: tag, alpha, beta in seconds and degrees.  utc_of: RFC 3339 of a tag."""
    chance = random.Random(5)
    text = _texts(rows)
    half = len(rows) // 2
    shuffled = text[:]
    chance.shuffle(shuffled)
    spiky = [row[:] for row in text]
    for place in range(40, len(rows), 97):
        spiky[place][1] = "170.0"
    spikes = len(range(40, len(rows), 97))
    holes = [row[:] for row in text]
    for place in range(10, len(rows), 50):
        holes[place][1:] = ["NaN", ""]
    empty_rows = len(range(10, len(rows), 50))
    words = [row[:] for row in text]
    for place in range(5, len(rows), 200):
        words[place][0] = "ERROR"
    timeless = len(range(5, len(rows), 200))
    one_beta_missing = [[*row[:2], "N/A" if k % 3 else row[2]] for k, row in enumerate(text)]
    reset = [
        *text[: half + 200],
        *([f"{float(t) - rows[half][0]:.6f}", a, b] for t, a, b in text[half:]),
    ]
    wrapped = [[row[0], row[1] % 360.0, row[2] % 360.0] for row in rows]
    missing = [
        [t, "0" if (k // 100) % 5 == 0 else a, "-9999" if k % 4 == 0 else b]
        for k, (t, a, b) in enumerate(text)
    ]
    rates = [(after[1] - before[1]) / (after[0] - before[0]) for before, after in pairwise(rows)]
    files = {
        "valid": Damaged(_csv(HEAD, text)),
        "a gap of 20 s": Damaged(
            _csv(HEAD, text[:600] + text[900:]), lambda a: len(a["samples"]["gaps"]) == 1
        ),
        "rows shuffled": Damaged(
            _csv(HEAD, shuffled), lambda a: a["samples"]["reordered"] > len(rows) / 2
        ),
        "every row twice": Damaged(
            _csv(HEAD, [row for row in text for _ in range(2)]), drops=(("repeated", len(rows)),)
        ),
        "a packet sent again": Damaged(
            _csv(HEAD, [*text[:500], *text[300:]]), drops=(("repeated", 200),)
        ),
        "the counter begins anew": Damaged(
            _csv(HEAD, reset), drops=(("clock_reset", len(rows) - half),)
        ),
        "spikes": Damaged(_csv(HEAD, spiky), drops=(("outlier", spikes),)),
        "NaN and empty cells": Damaged(_csv(HEAD, holes), drops=(("no_value", empty_rows),)),
        "numbers beyond all bounds": Damaged(
            _csv(
                HEAD,
                [
                    ["1e300", "inf", "-1e308"] if k % 100 == 50 else row
                    for k, row in enumerate(text)
                ],
            ),
            drops=(("no_time", len(range(50, len(rows), 100))),),
        ),
        "words for times": Damaged(_csv(HEAD, words), drops=(("no_time", timeless),)),
        "most of beta missing": Damaged(_csv(HEAD, one_beta_missing)),
        "wrapped at 360": Damaged(
            _csv(HEAD, _texts(wrapped)), lambda a: a["samples"]["wrapped"] > len(rows) / 2
        ),
        "wrapped at 180, half a turn off": Damaged(
            _csv(HEAD, _texts([[t, a + 360.0, b - 360.0] for t, a, b in rows])),
            lambda a: a["samples"]["wrapped"] == 2 * len(rows),
        ),
        "radians named degrees": Damaged(
            _csv(HEAD, _texts(_scaled(rows, 1.0 / DEG_PER_RAD))), _unit("alpha_deg", "rad")
        ),
        "arcmin without a unit": Damaged(
            _csv(["t_s", "alpha", "beta"], _texts(_scaled(rows, 60.0))), _unit("alpha", "arcmin")
        ),
        "radians by name": Damaged(
            _csv(["time", "alpha_rad", "beta_rad"], _texts(_scaled(rows, 1.0 / DEG_PER_RAD))),
            _unit("alpha_rad", "rad", "name"),
        ),
        "a row of units": Damaged(
            _csv(
                ["time", "alpha", "beta"],
                [["s", "arcsec", "arcsec"], *_texts(_scaled(rows, 3600.0))],
            ),
            _unit("alpha", "arcsec", "unit row"),
        ),
        "a byte order mark": Damaged(b"\xef\xbb\xbf" + _csv(HEAD, text)),
        "UTF-16": Damaged(_csv(HEAD, text).decode().encode("utf-16")),
        "Latin-1": Damaged(
            _csv(["t_s", "alpha [\u00b0]", "beta [\u00b0]"], text).decode().encode("latin-1"),
            _warned("Latin-1"),
        ),
        "semicolons and decimal commas": Damaged(
            _csv(HEAD, [[cell.replace(".", ",") for cell in row] for row in text], ";"),
            _warned("decimal commas"),
        ),
        "tabs": Damaged(_csv(HEAD, text, "\t"), _warned("parted by")),
        "spaces, aligned": Damaged(_csv(HEAD, text, "   ")),
        "CRLF and blank lines": Damaged(_csv(HEAD, text, end="\r\n\r\n")),
        "other names": Damaged(
            _csv(["Time [s]", "Alpha (deg)", "BETA angle, deg".replace(",", "")], text)
        ),
        "quoted cells": Damaged(
            _csv([f'"{name}"' for name in HEAD], [[f'"{cell}"' for cell in row] for row in text])
        ),
        "UTC for times": Damaged(
            _csv(
                ["utc", *HEAD[1:]],
                [[utc_of(row[0]), *cells[1:]] for row, cells in zip(rows, text, strict=True)],
            )
        ),
        "an empty column": Damaged(
            _csv([*HEAD, "beta_rate_deg_s"], [[*row, ""] for row in text]),
            lambda a: a["samples"]["ignored_columns"] == ["beta_rate_deg_s"],
        ),
        "columns of other things": Damaged(
            _csv([*HEAD, "alpha_cmd_deg", "temperature"], [[*row, "0", "21.5"] for row in text]),
            lambda a: a["samples"]["ignored_columns"] == ["alpha_cmd_deg", "temperature"],
        ),
        "a column twice": Damaged(
            _csv([*HEAD, "alpha_deg"], [[*row, "5.0"] for row in text]),
            _warned("alpha_deg", "again"),
        ),
        "cut off in a row": Damaged(_csv(HEAD, text)[:-14]),
        "rows of different length": Damaged(
            _csv(HEAD, [row[: 1 + k % 3] if k % 7 == 0 else row for k, row in enumerate(text)])
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
            (("held", len(rows) - len(text[::15])),),
        ),
        "one value for those missing": Damaged(_csv(HEAD, missing), _warned("one value far from")),
        "tags of whole seconds": Damaged(
            _csv(HEAD, [[f"{float(row[0]) // 1:.0f}", *row[1:]] for row in text]),
            _warned("tags are too coarse"),
            offset_within_s=1.0,
        ),
        "rates of another sign": Damaged(
            _csv(
                [*HEAD, "alpha_rate_deg_s"],
                [[*row, f"{-rate:.7f}"] for row, rate in zip(text, [*rates, 0.0], strict=True)],
            ),
            _warned("alpha's rates don't follow its plan"),
        ),
        "minus signs of a typesetter": Damaged(
            _csv(HEAD, text).decode().replace("-", "\u2212").encode()
        ),
        "a frozen sensor": Damaged(
            _csv(HEAD, [[*row[:2], "0.0"] for row in text]),
            lambda a: a["axes"]["beta"]["max_arcsec"] > 3600,
        ),
    }
    refused = {
        "nothing": Refused(b"", "is empty"),
        "a header alone": Refused(_csv(HEAD, []), "is empty"),
        "no header": Refused(_csv(text[0], text[1:]), "name the columns"),
        "bytes": Refused(bytes(range(256)) * 20, "is no text"),
        "no axis": Refused(_csv(["t_s", "x", "y"], text), "no column tells of alpha or beta"),
        "no time": Refused(_csv(["row", *HEAD[1:]], text), "no column tells the time"),
        "all cells words": Refused(_csv(HEAD, [["a", "b", "c"]] * 50), "no column holds a number"),
        "times of another day": Refused(
            _csv(
                ["utc", *HEAD[1:]],
                [
                    [utc_of(row[0] + 86400), *cells[1:]]
                    for row, cells in zip(rows, text, strict=True)
                ],
            ),
            "the samples run from",
            "samples.epoch",
        ),
        "times all words": Refused(
            _csv(HEAD, [["later", *row[1:]] for row in text]), "time tag", "samples.t_s"
        ),
        "commas for decimals too": Refused(
            _csv(HEAD, [[cell.replace(".", ",") for cell in row] for row in text]),
            "names 3 columns, but rows have up to 6 cells: the comma both parts columns and marks",
        ),
        "JSON": Refused(b'{"t_s": [1, 2],\n "alpha_deg": [1, 2]}', "is JSON, not CSV"),
        "gradians": Refused(_csv(HEAD, _texts(_scaled(rows, 1.0 / 0.9))), "no clock does"),
        "columns swapped": Refused(
            _csv(HEAD, [[t, b, a] for t, a, b in text]), "their names are swapped"
        ),
        "zeros": Refused(_csv(HEAD, [[t, "0", "0"] for t, _, _ in text]), "they stay at 0"),
        "too few rows": Refused(_csv(HEAD, text[500:504]), "needs 8"),
    }
    return files, refused
