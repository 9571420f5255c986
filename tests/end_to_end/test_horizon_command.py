"""`slewtrack horizon` measures one frame, and finds a bias over a session's frames or video."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from app.cli import main
from app.requests.examples import ESTIMATE_EXAMPLE, PICTURE_EXAMPLES, SESSION_EXAMPLE
from app.work.horizon import PICTURE_READER, picture

EXAMPLES = Path(__file__).parents[2] / "examples"
ESTIMATE = EXAMPLES / "horizon_estimate.json"
PICTURES = [EXAMPLES / f"horizon_{name}.png" for name in ("ahead", "right")]
SESSION = EXAMPLES / "horizon_session.json"
ROLL_DEG = 0.3


def horizon(*words):
    return CliRunner().invoke(main, ["horizon", *map(str, words)])


def test_one_frame(tmp_path):
    overlay, answer = tmp_path / "out" / "seen.png", tmp_path / "answer.json"
    result = horizon(ESTIMATE, *PICTURES, "--overlay", overlay, "--json", answer)
    assert result.exit_code == 0, result.stderr
    assert result.stdout.startswith("consistent")
    for name in ("ahead", "right"):
        drawn = cv2.imread(str(tmp_path / "out" / f"seen-{name}.png"))
        assert drawn.shape == (480, 640, 3)
    found = json.loads(answer.read_text())
    assert found["verdict"] == "consistent"
    assert [camera["used"] for camera in found["cameras"]] == [True, True]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((ESTIMATE, PICTURES[0]), "1 images for 2 cameras"),
        ((ESTIMATE, PICTURES[0], ESTIMATE), "images.1: this is no image"),
        ((ESTIMATE, PICTURES[0], "nowhere.png"), "nowhere.png"),
        ((PICTURES[0], PICTURES[0]), "UTF-8"),
        ((SESSION, ESTIMATE), "no image"),
    ],
)
def test_bad_files_are_refused_in_one_line(words, says):
    result = horizon(*words)
    assert result.exit_code == 2
    [line] = result.stderr.splitlines()
    assert says in line


@pytest.fixture(scope="module")
def frames():
    """What the camera sees of a carrier that rolls 0.3 deg more than planned."""
    attitude = {**SESSION_EXAMPLE["attitude"], "roll_deg": ROLL_DEG}
    taken = []
    for k, at in enumerate(("2015-02-27T17:37:00Z", "2015-02-27T17:37:05Z")):
        request = {**PICTURE_EXAMPLES["ahead"][1], "attitude": attitude, "at": at, "seed": k}
        taken.append(picture(PICTURE_READER.read(json.dumps(request).encode())))
    return taken


def found_bias(result, answer):
    assert result.exit_code == 0, result.stderr
    assert "2 of 2 frames used" in result.stdout
    series = json.loads(answer.read_text())
    assert series["used"] == 2
    assert [frame["at"][17:19] for frame in series["frames"]] == ["00", "05"]
    sigma_deg = np.sqrt(np.diag(series["covariance_deg2"]))
    # Roll about X turns nadir, +Z, along body Y: across.
    assert np.all(np.abs(series["bias_deg"] - np.array([0.0, ROLL_DEG])) < 4.0 * sigma_deg)
    assert sigma_deg[1] < ROLL_DEG / 4.0  # else nothing would be shown
    return series


def test_frames_of_a_session_show_its_bias(tmp_path, frames):
    files = [tmp_path / f"{k}.png" for k in range(len(frames))]
    for file, content in zip(files, frames, strict=True):
        file.write_bytes(content)
    answer = tmp_path / "series.json"
    series = found_bias(horizon(SESSION, *files, "--json", answer), answer)
    assert series["verdict"] == "inconsistent"


def test_a_video_shows_the_same(tmp_path, frames):
    film = cv2.VideoWriter(
        str(tmp_path / "film.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 2.0, (640, 480)
    )
    for content in frames:
        pixels = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
        for _ in range(10):  # 5 s
            film.write(pixels)
    film.release()
    answer = tmp_path / "series.json"
    found_bias(horizon(SESSION, tmp_path / "film.avi", "--json", answer), answer)


def test_a_list_of_requests(tmp_path):
    asked = tmp_path / "list.json"
    asked.write_text(json.dumps([ESTIMATE_EXAMPLE, ESTIMATE_EXAMPLE]))
    answer = tmp_path / "series.json"
    result = horizon(asked, *PICTURES, *PICTURES, "--json", answer)
    assert result.exit_code == 0, result.stderr
    series = json.loads(answer.read_text())
    assert series["verdict"] == "consistent"
    # Frames alike: no scatter, to the answer's nine digits.
    np.testing.assert_allclose(series["scatter_deg"], 0.0, atol=1e-9)
    assert horizon(asked, *PICTURES).exit_code == 2
