"""The report of the papers' numbers holds what it says, and notices what moves."""

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from reproduction import report
from reproduction.platonov import gyro_reach_deg_s, needed_gyro_n_m_s, spin_up_s
from reproduction.report import Statement, read_statements, row

from planner.world.platforms.cmg_array import CmgArray

ROOT = Path(__file__).parents[2]

ORBIT = Statement(
    paper="Sumarokov 2016",
    place="eqs. 3-7",
    name="orbit",
    says="the error after 900 s | from NASA's ephemeris",
    stated=56.0,
    unit="m",
    function="sumarokov.orbit",
    tolerance=0.5,
    verdict="reproduced",
    within=1.0,
    why="8 starts",
)
FIGURE = replace(ORBIT, name="figure", stated=None, function=None, verdict="ours", within=None)
NUMBERS = {"orbit": 56.7}
STATEMENTS = read_statements()


def rows(*statements: Statement, **numbers: float) -> list:
    return [row(one, NUMBERS | numbers) for one in statements]


@pytest.fixture
def accepted(tmp_path):
    file = tmp_path / "kept.csv"
    report.write(rows(ORBIT, FIGURE), file)
    return report.read(file)


def test_what_was_accepted_is_still_so(accepted):
    assert accepted == rows(ORBIT, FIGURE)
    assert report.differences(rows(ORBIT, FIGURE), accepted) == []
    assert (
        report.differences(rows(replace(ORBIT, why="9 starts"), FIGURE, orbit=56.9), accepted) == []
    )


@pytest.mark.parametrize(
    ("now", "told"),
    [
        (rows(ORBIT, FIGURE, orbit=57.3), "57.3 m, kept 56.7, may move 0.5"),
        (rows(ORBIT, FIGURE, orbit=57.1), "result is differs, kept agrees"),
        (rows(replace(ORBIT, verdict="set", within=None), FIGURE), "verdict is set"),
        (rows(replace(ORBIT, says="the error after 60 s"), FIGURE), "says is"),
        (rows(replace(ORBIT, stated=57.0), FIGURE), "stated is 57.0, kept 56.0"),
        (rows(ORBIT), "kept, no longer stated"),
        (rows(ORBIT, FIGURE, replace(FIGURE, name="new")), "stated now, not kept"),
        (rows(ORBIT, replace(FIGURE, function="x"), figure=1.0), "1.0 m, kept None"),
    ],
)
def test_whatever_moves_is_told(accepted, now, told):
    assert any(told in line for line in report.differences(now, accepted))


def test_the_last_digits_of_what_may_not_move_are_the_processors(accepted):
    exact = replace(ORBIT, tolerance=0.0)
    before = rows(exact, orbit=3.0)
    assert report.differences(rows(exact, orbit=3.0000000000000004), before) == []
    assert report.differences(rows(exact, orbit=3.00001), before) != []


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"stated": float("inf")}, "isn't one"),
        ({"tolerance": -1.0}, "tolerance of -1.0"),
        ({"verdict": "agrees", "within": None}, "the verdict agrees"),
        ({"stated": None}, "without a number of the paper's"),
        ({"within": None}, "one of within and sense"),
        ({"sense": "at most"}, "one of within and sense"),
        ({"verdict": "ours", "within": None}, "that is ours alone"),
        ({"verdict": "set", "within": None, "function": None}, "nothing computed"),
        ({"function": None, "ours": 56.0}, "nothing computed"),
        ({"ours": 56.0}, "beside the function"),
    ],
)
def test_no_verdict_without_its_numbers(changes, why):
    with pytest.raises(ValueError, match=f"Sumarokov 2016, orbit: .*{why}"):
        replace(ORBIT, **changes)


def test_a_number_that_is_none_is_refused():
    with pytest.raises(ValueError, match="Sumarokov 2016, orbit: nan"):
        rows(ORBIT, orbit=float("nan"))


def test_two_statements_of_one_name_are_refused(tmp_path):
    file = tmp_path / "statements.toml"
    one = '[["Lomaka 2016"]]\nname = "a"\nplace = "p"\nsays = "s"\nverdict = "ours"\nwhy = "w"\n'
    file.write_text(one + one, encoding="utf-8")
    with pytest.raises(ValueError, match="Lomaka 2016 has two statements named a"):
        read_statements(file)


@pytest.mark.parametrize(
    ("sense", "ours", "result"),
    [
        (None, 56.99, "agrees"),
        (None, 57.01, "differs"),
        ("at most", 12.0, "agrees"),
        ("at most", 56.1, "differs"),
        ("at least", 56.1, "agrees"),
        ("at least", 55.9, "differs"),
    ],
)
def test_what_is_reproduced_agrees_as_near_as_it_says(sense, ours, result):
    one = ORBIT if sense is None else replace(ORBIT, within=None, sense=sense)
    assert rows(one, orbit=ours)[0].result == result


def test_every_statement_is_computed_by_a_section_and_kept():
    modules = {paper: report.FILE.with_name(f"{paper}.py").read_text() for paper in report.PAPERS}
    computed = {
        f"{paper}.{name}"
        for paper, source in modules.items()
        for name in re.findall(r"^def (\w+)_numbers\(\)", source, re.MULTILINE)
    }
    assert {one.function for one in STATEMENTS} - {None} == computed
    kept_names = [(one.paper, one.name, one.verdict) for one in report.read()]
    assert kept_names == [(one.paper, one.name, one.verdict) for one in STATEMENTS]


def test_the_published_page_is_made_of_the_kept_rows_and_counts_them():
    page, before = report.DOCUMENT.read_text(encoding="utf-8"), report.read()
    assert page == report.document(before)
    for paper in {one.paper for one in before}:
        verdicts = Counter(one.verdict for one in before if one.paper == paper)
        results = Counter(one.result for one in before if one.paper == paper)
        assert verdicts["reproduced"] == results["agrees"] + results["differs"]
        counts = (verdicts["reproduced"], results["agrees"], results["differs"])
        told = " | ".join(map(str, (paper, *counts, verdicts["set"], verdicts["ours"])))
        assert f"| {told} |" in page


def test_nothing_is_called_reproduced_that_the_paper_has_no_number_of():
    """The report's second review: 44 of 98 "agrees" tested nothing of the papers."""
    for one in report.read():
        assert (one.verdict == "ours") == (one.stated is None), one.name
        assert bool(one.result) == (one.verdict == "reproduced"), one.name
        assert "our first study" not in one.says


def test_the_published_page_shows_pictures_that_exist():
    page = report.DOCUMENT.read_text(encoding="utf-8")
    shown = {part.split(")")[0] for part in page.split("](images/")[1:]}
    assert shown
    assert {name for name in shown if not (report.IMAGES / name).exists()} == set()
    assert {file.name for file in report.IMAGES.glob("reproduction_*.png")} <= shown


def test_four_channels_reach_sqrt_3_of_one():
    assert gyro_reach_deg_s() == pytest.approx(1.6 * np.sqrt(3.0), rel=1e-6)


def test_spin_up_takes_the_momentum_over_the_torque_and_the_torque_its_rise():
    # J w / M + M / M': a trapezoid of torque.
    expected = 800.0 * np.deg2rad(3.5) / 30.0 + 30.0 / 40.0
    assert spin_up_s(3.5, 30.0) == pytest.approx(expected, rel=0.03)


def test_the_least_gyro_for_a_momentum_along_z_is_a_quarter_of_it():
    array = CmgArray()
    rows = np.array([array.gimbal_angles(np.array([0.0, 0.0, h])) for h in (0.0, 20.0)])
    assert needed_gyro_n_m_s(rows) == pytest.approx(5.0, abs=0.02)
