"""Windows of imaging modes over HTTP: told scan by scan, kept, and planned as they stand."""

import copy

import pytest

from app.requests.examples import OPPORTUNITY_EXAMPLES

ASKED = OPPORTUNITY_EXAMPLES["modes"][1]
PATH = "/v1/opportunities"
STRIP = ASKED["targets"][0]
FAR = {"type": "LineString", "coordinates": [[100.0, -20.0], [100.1, -20.4]]}
GEOJSON = {"Accept": "application/geo+json"}


@pytest.fixture(scope="module")
def found(client):
    answer = client.post(f"{PATH}?include=view,probability", json=ASKED)
    assert answer.status_code == 200, answer.text
    return answer.json()


def changed(target, **members):
    return copy.deepcopy(ASKED) | {"targets": [STRIP | target]} | members


def test_each_scan_has_its_windows(found):
    parts = {}
    for window in found["windows"]:
        scan = window["scan"]
        parts.setdefault(window["target"], []).append((scan["part"], scan["parts"]))
        assert window["rise"] <= scan["first_start"] <= window["session"]["start"]
        assert window["session"]["start"] <= scan["last_start"] < window["set"]
        assert scan["target"]["mode"] == "ground_path"
        assert scan["roll"] == {"rule": "lines_across_motion"}
        assert window["closest"]["off_nadir_deg"] <= 40.0
        assert window["probability_in_frame"] > 0.9
    assert {name: sorted(told) for name, told in parts.items()} == {
        "strip": [(1, 1)],
        "stereo": [(1, 2), (2, 2)],
        "corridor": [(1, 2), (2, 2)],
        "area": [(1, 2), (2, 2)],
        "tri-stereo": [(1, 3), (2, 3), (3, 3)],
    }
    assert found["unseen"] == []


def test_what_made_the_edges_is_told(found):
    causes = {(window["target"], window["opened_by"]) for window in found["windows"]}
    assert causes == {
        ("strip", "off_nadir"),
        ("corridor", "off_nadir"),
        ("area", "off_nadir"),
        ("stereo", "look"),
        ("tri-stereo", "look"),
    }


def test_their_sessions_are_planned_as_they_stand(client, found):
    """The strip and both looks of the pair, one after the other."""
    windows = [one for one in found["windows"] if one["target"] in ("strip", "stereo")]
    sessions = [
        {name: one["scan"][name] for name in ("target", "roll")} | one["session"] for one in windows
    ]
    asked = {
        "platform": ASKED["platform"],
        "orbit": ASKED["orbit"],
        "initial_state": {"epoch": "2024-06-01T10:00:00Z"},
        "sessions": sessions,
    }
    plan = client.post("/v1/plans", json=asked)
    assert plan.status_code == 201, plan.text
    assert plan.json()["state"] == "done"


def test_the_strip_itself_is_planned_in_the_session_of_its_window(client, found):
    asked = {
        "platform": ASKED["platform"],
        "orbit": ASKED["orbit"],
        "initial_state": {"epoch": "2024-06-01T10:00:00Z"},
        "sessions": [{"target": STRIP["target"]} | found["windows"][0]["session"]],
    }
    checked = client.post("/v1/plans?dry_run=true", json=asked)
    assert checked.status_code == 200, checked.text


def test_they_are_kept_and_told_again(client, found):
    at = f"{PATH}/{found['id']}"
    assert client.get(f"{at}?include=view,probability").json() == found
    page = client.get(f"{at}?target=area&limit=1&include=view").json()
    assert [one["target"] for one in page["windows"]] == ["area"]
    features = client.get(at, headers=GEOJSON).json()["features"]
    assert len({feature["id"] for feature in features}) == len(found["windows"])
    for feature, window in zip(features, found["windows"], strict=True):
        line = [
            [point["longitude_deg"], point["latitude_deg"]]
            for point in window["scan"]["target"]["points"]
        ]
        assert feature["geometry"] == {"type": "LineString", "coordinates": line}


def test_beside_other_targets_only_modes_have_scans(client):
    place = {"mode": "ground", "latitude_deg": 20.7, "longitude_deg": -12.4}
    asked = changed({}, stop="2024-06-01T10:20:00Z")
    asked["targets"].append({"id": "place", "target": place})
    windows = client.post(PATH, json=asked).json()["windows"]
    told = [(window["target"], window["scan"] is None) for window in windows]
    assert told == [("strip", False), ("place", True)]


@pytest.mark.parametrize(
    ("target", "members", "closed_by", "because"),
    [
        ({"geometry": FAR}, {"stop": "2024-06-01T10:20:00Z"}, "elevation", "stays below"),
        # 22 deg ahead of a strip that is passed 9 deg aside: farther off nadir than that.
        ({"mode": "stereo", "look_angle_deg": 22.0},
         {"conditions": {"max_off_nadir_deg": 20.0}}, "scan", "deg ahead"),
    ],
)  # fmt: skip
def test_why_a_mode_is_unseen(client, target, members, closed_by, because):
    asked = changed({"target": STRIP["target"] | target}, **members)
    answer = client.post(f"{PATH}?include=reasons", json=asked).json()
    assert (answer["windows"], answer["unseen"]) == ([], ["strip"])
    [reason] = answer["reasons"]
    assert reason["closed_by"] == closed_by, reason
    assert because in reason["because"], reason


BENT = FAR | {"coordinates": [[1, 2], [2, 3], [4, 5]]}
NORTH = [{"latitude_deg": 1, "longitude_deg": 1}, {"latitude_deg": 2, "longitude_deg": 1}]


@pytest.mark.parametrize(
    ("target", "field", "says"),
    [
        ({"mode": "strip", "geometry": BENT}, "geometry", "a corridor has more"),
        (
            {"mode": "stereo", "geometry": FAR, "look_angle_deg": 9.0, "gap_s": 9.0},
            "look_angle_deg",
            "leave one out",
        ),
        ({"mode": "ground_path", "speed_m_s": 9.0, "points": NORTH}, "mode", "strip"),
    ],
)
def test_modes_are_refused_by_field(client, target, field, says):
    answer = client.post(PATH, json=changed({"target": target}))
    assert answer.status_code == 422, answer.text[:300]
    problem = answer.json()
    assert problem["field"] == f"targets.0.target.{field}", problem
    assert says in problem["detail"], problem


def test_a_roll_that_hangs_on_a_plan_is_refused(client):
    answer = client.post(PATH, json=changed({"roll": {"rule": "nearest"}}))
    assert answer.status_code == 422, answer.text[:300]
    assert answer.json()["field"] == "targets.0.roll.rule"
    assert "give another rule" in answer.json()["detail"]
