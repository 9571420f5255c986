"""Does the report of the papers' numbers hold what it says, and notice what moves?"""

import sys
from dataclasses import replace
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "bench"))

from reproduction import kept, parts, report  # noqa: E402
from reproduction.statements import Statement, judge  # noqa: E402

PUBLISHED = (ROOT / "docs/reproduction.md").read_text(encoding="utf-8")
ORBIT = Statement(
    paper="Sumarokov 2016",
    place="eqs. 3-7",
    name="orbit",
    says="the error after 900 s | from NASA's ephemeris",
    stated=56.0,
    ours=56.7,
    unit="m",
    tolerance=0.5,
    verdict="agrees",
    why="real ephemeris",
)
FIGURE = replace(
    ORBIT, name="figure", stated=None, ours=None, verdict="can't be reproduced", why="no orbit"
)


@pytest.fixture
def accepted(tmp_path):
    file = tmp_path / "kept.json"
    kept.write([ORBIT, FIGURE], file)
    text = report.document([report.Section("## Orbit", [ORBIT, FIGURE], [])])
    return kept.read(file), text


def test_what_was_accepted_is_still_so(accepted):
    assert kept.differences([ORBIT, FIGURE], *accepted) == []
    within = replace(ORBIT, ours=57.1, why="another reason")
    assert kept.differences([within, FIGURE], *accepted) == []


@pytest.mark.parametrize(
    ("now", "told"),
    [
        ([replace(ORBIT, ours=57.3), FIGURE], "57.3 m, kept 56.7, may move 0.5"),
        ([replace(ORBIT, verdict="differs"), FIGURE], "differs, kept agrees"),
        ([ORBIT, replace(FIGURE, ours=1.0, verdict="agrees")], "1.0 m, kept None"),
        ([ORBIT], "kept, no longer stated"),
        ([ORBIT, FIGURE, replace(ORBIT, name="new")], "stated now, not kept"),
        ([replace(ORBIT, says="the error after 60 s"), FIGURE], "doesn't list it"),
    ],
)
def test_whatever_moves_is_told(accepted, now, told):
    assert any(told in line for line in kept.differences(now, *accepted))


def test_a_number_that_left_the_document_is_told(accepted):
    numbers, text = accepted
    [line] = kept.differences([ORBIT, FIGURE], numbers, text.replace("56.7", "56.1"))
    assert "doesn't list it" in line


def test_two_statements_of_one_name_are_refused(tmp_path):
    with pytest.raises(ValueError, match="two statements named orbit"):
        kept.write([ORBIT, ORBIT], tmp_path / "kept.json")


@pytest.mark.parametrize(
    "wrong", [{"ours": float("nan")}, {"ours": None}, {"tolerance": -1.0}, {"stated": float("inf")}]
)
def test_no_verdict_without_numbers(wrong):
    with pytest.raises(ValueError, match="Sumarokov 2016, orbit"):
        replace(ORBIT, **wrong)


def test_judgement_is_by_the_papers_rounding():
    assert judge(0.22, 0.2249, 0.005) == "agrees"
    assert judge(0.22, 0.2251, 0.005) == "differs"


def test_the_published_document_has_every_part_and_every_kept_verdict():
    for name in parts.PARTS:
        assert parts.text(name).splitlines()[0] in PUBLISHED
    verdicts = [one["verdict"] for of_paper in kept.read().values() for one in of_paper.values()]
    for verdict in report.VERDICTS:
        assert PUBLISHED.count(f"| **{verdict}**: ") == verdicts.count(verdict)


def test_the_published_document_shows_pictures_that_exist():
    shown = {part.split(")")[0] for part in PUBLISHED.split("](images/")[1:]}
    assert shown
    assert {name for name in shown if not (ROOT / "docs/images" / name).exists()} == set()
    drawn = {file.name for file in (ROOT / "docs/images").glob("reproduction_*.png")}
    assert drawn <= shown
