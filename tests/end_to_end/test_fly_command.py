"""`slewtrack fly` reports, draws, and refuses in one line."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.cli import main

LAS_VEGAS = Path(__file__).parents[2] / "examples" / "las_vegas_2015.json"


def fly(*words):
    return CliRunner().invoke(main, ["fly", str(LAS_VEGAS), *map(str, words)])


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fly")
    answer, picture = folder / "told.json", folder / "flights.png"
    car = ("--moving-object-m-s", 75.0 / 3.6, "--course-deg", 90.0)
    result = fly("--runs", 4, "--seed", 2, *car, "--json", answer, "--plot", picture)
    assert result.exit_code == 0, result.stderr
    assert "4 flights (seed 2)" in result.stdout
    titles = {line.strip() for line in result.stdout.splitlines()}
    assert {"under errors", "as planned", "causes of the errors"} <= titles
    assert picture.read_bytes().startswith(b"\x89PNG")
    return json.loads(answer.read_text())


def test_here(told):
    assert (told["runs"], told["flown"], told["seed"]) == (4, 4, 2)
    nominal = told["sessions"][0]["nominal"]
    assert nominal["frames"] == 270
    assert nominal["moving_object_ground_m"] == pytest.approx(
        208.0, abs=0.5
    )  # a car at 75 km/h, in 10 s
    # Across the lean of the line of sight a pixel is narrowest, along it longest.
    sizes = zip(
        nominal["ground_sample_across_m"],
        nominal["moving_object_px"],
        nominal["ground_sample_along_m"],
        strict=True,
    )
    assert all(
        across <= 208.0 / px * 1.005 and 208.0 / px <= along * 1.005 for across, px, along in sizes
    )


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("--runs", 1), "runs"),
        (("--plot", "flights.gif"), "--plot"),
        (("--moving-object-m-s", 1e6), "moving_object.speed_m_s"),
    ],
)
def test_refusals_are_one_line(words, named):
    result = fly(*words)
    assert result.exit_code == 2
    assert named in result.stderr.splitlines()[0]
