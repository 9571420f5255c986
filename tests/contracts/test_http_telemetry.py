"""Telemetry over HTTP and by the command reports all that was wrong with it, and never fails."""

import csv
import json

import numpy as np
import other_platform
import pytest
from damaged_telemetry import CLOCK_AHEAD_S, damaged
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from app.cli.command import main
from app.requests.examples import LAS_VEGAS
from planner.world.frames.time_scales import shifted_utc, utc_from_text, utc_text

COMPARISONS = "/v1/telemetry/comparisons"
EPOCH_UTC = utc_from_text(LAS_VEGAS["initial_state"]["epoch"])
ARCSEC_PER_DEG = 3600.0


def rows_of(table_csv, tmp_path):
    """Of a clock ahead of the plan's, 2 arcsec of noise: tag and angles."""
    path = tmp_path / "table.csv"
    path.write_text(table_csv)
    drives = {name: other_platform.Drive() for name in ("alpha", "beta")}
    clock = other_platform.Clock(offset_s=CLOCK_AHEAD_S)
    _, rows = other_platform.measure(
        other_platform.read_table(path), drives, clock, 15.0, 2.0, 0.001, seed=1
    )
    return [row[:3] for row in rows]


@pytest.fixture(scope="module")
def plan(client):
    return client.made("/v1/plans", json=LAS_VEGAS)


@pytest.fixture(scope="module")
def rows(client, plan, tmp_path_factory):
    table = client.get(f"/v1/plans/{plan['id']}/table?format=csv").text
    return rows_of(table, tmp_path_factory.mktemp("flown"))


@pytest.fixture(scope="module")
def files(rows):
    return damaged(rows, lambda tag_s: utc_text(shifted_utc(EPOCH_UTC, tag_s), 6))


def upload(client, plan, content, query="", **head):
    request = json.dumps({"plan": plan["id"], **head})
    parts = {"samples": ("telemetry.csv", content, "text/csv")}
    return client.post(COMPARISONS + query, data={"request": request}, files=parts)


def json_samples(rows):
    t_s, alpha_deg, beta_deg = (list(column) for column in zip(*rows, strict=True))
    return {
        "epoch": LAS_VEGAS["initial_state"]["epoch"],
        "t_s": t_s,
        "alpha_deg": alpha_deg,
        "beta_deg": beta_deg,
    }


def compare(client, plan, samples, **head):
    answer = client.post(COMPARISONS, json={"plan": plan["id"], "samples": samples, **head})
    assert answer.status_code == 200, answer.text
    return answer.json()


@pytest.fixture(scope="module")
def by_json(client, plan, rows):
    """What the valid rows say, sent as JSON."""
    return compare(client, plan, json_samples(rows))


def names(which):
    """Of all files, without any rows."""
    few = [[0.1 * k, 1.0 + k, 2.0] for k in range(2000)]
    return list(damaged(few, lambda _: "2015-02-27T17:34:00Z")[which])


def require_told(answer, file):
    samples = answer["samples"]
    assert samples["read"] == samples["used"] + sum(samples["dropped"].values())
    for reason, count in file.drops:
        assert samples["dropped"][reason] == count
    assert file.told(answer), answer["samples"] | {"warnings": answer["warnings"]}
    offset = answer["time_offset_s"]
    assert offset["value"] == pytest.approx(CLOCK_AHEAD_S, abs=file.offset_within_s)
    # Tags of whole seconds tell the clock to 0.5 ms, in which the axis moves by 1.4 arcsec.
    most_arcsec = 3.0 if file.offset_within_s > 0.1 else 2.2
    assert 1.8 < answer["axes"]["alpha"]["rms_arcsec"] < most_arcsec


@pytest.mark.parametrize("name", names(0))
def test_damage_is_told_and_the_clock_found_all_the_same(client, plan, files, name):
    file = files[0][name]
    answer = upload(client, plan, file.content, columns=file.columns)
    assert answer.status_code == 200, answer.text
    require_told(answer.json(), file)


@pytest.mark.parametrize("name", names(1))
def test_files_that_break_the_contract_are_refused_by_what_was_read(client, plan, files, name):
    file = files[1][name]
    answer = upload(client, plan, file.content, columns=file.columns)
    assert answer.status_code == 422, answer.text
    assert answer.json()["field"] == file.field
    for word in file.words:
        assert word in answer.json()["detail"]


def test_the_command_tells_the_same(plan, files, tmp_path):
    request, answered = tmp_path / "request.json", tmp_path / "plan.json"
    request.write_text(json.dumps(LAS_VEGAS))
    answered.write_text(json.dumps(plan))
    telemetry, told = tmp_path / "telemetry.csv", tmp_path / "told.json"
    words = ["compare", str(answered), str(telemetry), "--request", str(request)]
    for name in ("spikes", "arcsec by the mapping"):
        file = files[0][name]
        telemetry.write_bytes(file.content)
        columns = [part for one in file.columns.items() for part in ("--column", "=".join(one))]
        run = CliRunner().invoke(main, [*words, "--json", str(told), *columns])
        assert run.exit_code == 0, (name, run.output)
        require_told(json.loads(told.read_bytes()), file)
        for line in ("clock +0.3", "if both axes are equally late", "alpha gain 1.000"):
            assert line in run.output
    telemetry.write_bytes(files[1]["other names"].content)
    run = CliRunner().invoke(main, words)
    assert run.exit_code == 2, run.output
    run = CliRunner().invoke(main, [*words, "--column", "alpha_deg"])
    assert run.exit_code == 2, run.output


def test_json_and_csv_tell_the_same(client, plan, rows, files, by_json):
    by_csv = upload(client, plan, files[0]["valid"].content).json()
    assert by_json["time_offset_s"]["value"] == pytest.approx(
        by_csv["time_offset_s"]["value"], abs=1e-5
    )
    assert by_json["axes"]["beta"]["rms_arcsec"] == pytest.approx(
        by_csv["axes"]["beta"]["rms_arcsec"], rel=1e-3
    )
    in_utc = json_samples(rows)
    in_utc["utc"] = [utc_text(shifted_utc(EPOCH_UTC, t_s), 6) for t_s in in_utc.pop("t_s")]
    del in_utc["epoch"]
    in_utc["AZ"] = in_utc.pop("alpha_deg")
    found = compare(client, plan, in_utc, columns={"alpha_deg": "AZ"})
    assert found["time_offset_s"]["value"] == pytest.approx(
        by_json["time_offset_s"]["value"],
        abs=1e-6,  # of the texts' last digit
    )


def test_the_contract_as_it_is_pinned(rows, by_json):
    answer = by_json
    for estimate in ("time_offset_s", "clock_drift", "common_offset_s", "ideal_offset_s"):
        assert {"value", "sigma", "assumes"} == set(answer[estimate])
    # The less is free beside it, the sharper the clock.
    sigmas = [answer[f"{which}_offset_s"]["sigma"] for which in ("ideal", "common", "time")]
    assert sigmas == sorted(sigmas)
    assert answer["ideal_drift"]["sigma"] < answer["clock_drift"]["sigma"]
    assert set(answer["axes"]) == {"alpha", "beta"}
    for axis in answer["axes"].values():
        assert {
            *("rms_arcsec", "max_arcsec", "gain", "bias", "lag_s", "oscillations", "stick_slip"),
            *("limits_exceeded", "limits_checked"),
        } <= set(axis)
    assert answer["samples"]["read"] == answer["samples"]["used"] == len(rows)
    assert answer["samples"]["dropped"] == {}
    # Beta hardly measures the time: alpha's lag behind it is all but the offset's own error.
    for pair in answer["inseparable"]:
        assert len(pair["members"]) == 2
        assert 0.98 < abs(pair["correlation"]) <= 1.0


def test_a_form_may_give_plan_and_epoch_without_json(client, plan, files):
    parts = {"samples": ("telemetry.csv", files[0]["valid"].content, "text/csv")}
    form = {"plan": plan["id"], "epoch": "2015-02-27T17:33:50Z"}
    answer = client.post(COMPARISONS, data=form, files=parts)
    assert answer.status_code == 200, answer.text
    assert answer.json()["time_offset_s"]["value"] == pytest.approx(CLOCK_AHEAD_S - 10.0, abs=0.005)


def test_plan_and_flight_are_a_table(client, plan, files):
    """Its rms is the comparison's, its planned angles are the plan's where a sample is on a row."""
    content = files[0]["a gap of 20 s"].content
    axes = upload(client, plan, content).json()["axes"]
    table = upload(client, plan, content, "?format=csv")
    assert table.headers["content-type"].startswith("text/csv")
    lines = [line for line in table.text.splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    for name, axis in axes.items():
        of_axis = [row for row in rows if row["axis"] == name]
        error = np.array([float(row["error_arcsec"]) for row in of_axis])
        assert np.sqrt(np.mean(error**2)) == pytest.approx(axis["rms_arcsec"], rel=1e-3)
        flown, planned = ([float(row[f"{k}_deg"]) for row in of_axis] for k in ("flown", "planned"))
        np.testing.assert_allclose(3600.0 * np.subtract(flown, planned), error, atol=1e-5)


def sampled(alpha_deg=(1, 2), t_s=(1, 2), **more):
    return {"samples": {"t_s": t_s, "alpha_deg": alpha_deg} | more}


REFUSED = {
    "no plan": ({}, "plan"),
    "no samples": ({"plan": "x"}, "samples"),
    "a list": ([], None),
    "no such plan": ({"plan": "x"} | sampled([1.0], [1.0]), "plan"),
    "no times": ({"samples": {"alpha_deg": [1.0]}}, "samples.t_s"),
    "both times": (sampled([1.0], [1.0], utc=["2015-02-27T17:34:00Z"]), "samples.t_s"),
    "another length": (sampled([1.0]), "samples.alpha_deg"),
    "words": (sampled([1.0, "a"]), "samples.alpha_deg.1"),
    "true": (sampled([1.0, True]), "samples.alpha_deg.1"),
    "no list": (sampled(5.0), "samples.alpha_deg"),
    "times no list": (sampled([], 5.0), "samples.t_s"),
    "no axis of it": ({"samples": {"t_s": [1, 2], "gamma_deg": [1, 2]}}, "samples.gamma_deg"),
    "an axis twice": (sampled(alpha_rad=[1, 2]), "samples.alpha_rad"),
    "a mapping to nothing": (sampled() | {"columns": {"beta_deg": "B"}}, "columns.beta_deg"),
    "times alone": ({"samples": {"t_s": [1, 2]}}, "samples.alpha_deg"),
    "all null": (sampled([None, None]), "samples"),
    "a huge whole number": (sampled([1, 10**70]), "samples"),
    "an epoch without offset": (sampled([1], [1], epoch="2015-02-27T17:34:00"), "samples.epoch"),
    "a misspelled member": (sampled([1], [1]) | {"correction": []}, "correction"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_requests_are_refused_by_field(client, plan, name):
    request, field = REFUSED[name]
    if isinstance(request, dict) and "samples" in request:
        request = {"plan": plan["id"]} | request
    answer = client.post(COMPARISONS, json=request)
    assert answer.status_code == 422, answer.text
    assert answer.json().get("field") == field, answer.json()


# What NumPy reads and no calendar has, what neither reads, and years that no text has room for.
NO_TIMES = (
    *("0000-01-01T00:00:00Z", "0000-02-29 17:34:00", "-0001-01-01T00:00:00Z"),
    *("+12015-02-27T17:34:00Z", "10000-01-01T00:00:00Z", "2015-02-29T17:34:00Z"),
    *("2015-13-01T17:34:00Z", "2015-02-27T24:00:00Z", "2015-02-27T17:34:60Z"),
    *("1969-12-31T23:59:59Z", "9999-01-01T00:00:00Z", "now", ""),
)


def in_utc(rows, texts):
    """Rows of CSV with UTC; texts: instead of that of a row, by its number from 0."""
    tags = [utc_text(shifted_utc(EPOCH_UTC, row[0]), 6) for row in rows]
    lines = [
        f"{texts.get(k, tag)},{row[1]},{row[2]}"
        for k, (tag, row) in enumerate(zip(tags, rows, strict=True))
    ]
    return "\n".join(["utc,alpha_deg,beta_deg", *lines]).encode()


def test_a_time_that_there_is_not_is_no_time(client, plan, rows):
    """As of a receiver without a fix, or a bit that fell over; in CSV and JSON alike."""
    texts = dict(enumerate(NO_TIMES))
    sent = json_samples(rows)
    tags = [utc_text(shifted_utc(EPOCH_UTC, t_s), 6) for t_s in sent.pop("t_s")]
    sent["utc"] = [texts.get(k, tag) for k, tag in enumerate(tags)]
    by_csv = upload(client, plan, in_utc(rows, texts))
    assert by_csv.status_code == 200, by_csv.text
    for found in (by_csv.json(), compare(client, plan, sent)):
        assert found["samples"]["dropped"]["no_time"] == len(NO_TIMES)
        assert found["time_offset_s"]["value"] == pytest.approx(0.37, abs=0.005)


def test_wild_tags_among_unix_times_are_left_out(client, plan, rows):
    wild = ("1e300", "-1e300", "1e18", "0", "253402300800", "-62135596801", "nan")
    unix_s = EPOCH_UTC.timestamp()
    lines = [f"{unix_s + t:.6f},{alpha},{beta}" for t, alpha, beta in rows]
    for k, tag in enumerate(wild):
        lines[k] = f"{tag},{rows[k][1]},{rows[k][2]}"
    content = "\n".join(["unix_s,alpha_deg,beta_deg", *lines]).encode()
    answer = upload(client, plan, content)
    assert answer.status_code == 200, answer.text
    assert answer.json()["samples"]["dropped"]["no_time"] == len(wild)
    assert answer.json()["time_offset_s"]["value"] == pytest.approx(0.37, abs=0.005)


def test_uploads_are_refused_by_part(client, plan):
    csv = ("t.csv", b"t_s,alpha_deg\n1,1\n", "text/csv")
    request = json.dumps({"plan": plan["id"]})
    for form, parts, field in (
        ({}, {"samples": csv}, "request"),
        ({"request": request}, {"other": csv}, "other"),
        ({"request": request, "plan": plan["id"]}, {"samples": csv}, "plan"),
        ({"request": "{"}, {"samples": csv}, None),
    ):
        answer = client.post(COMPARISONS, data=form, files=parts)
        assert answer.status_code == 422, answer.text
        assert answer.json().get("field") == field, answer.json()
    assert client.post(COMPARISONS, content=b"x").status_code == 415
    answer = client.post(COMPARISONS, data={"request": request}, files={"other": csv})
    for part in ("samples", "request", "plan", "epoch"):
        assert part in answer.json()["detail"]


def test_json_too_long_is_told_of_csv(client):
    head = {"Content-Type": "application/json"}
    answer = client.post(COMPARISONS, content=b" " * (8 * 2**20 + 1), headers=head)
    assert answer.status_code == 413
    assert "CSV by multipart/form-data" in answer.json()["detail"]


def boresight(plan_answer, at):
    """Angles of a plan's table at a UTC, degrees."""
    table = plan_answer["table"]
    row = round((utc_from_text(at) - utc_from_text(table["epoch"])).total_seconds() * 5)
    return np.array([table["alpha_deg"][row], table["beta_deg"][row]])


def test_what_was_found_is_pasted_into_the_next_request(client, plan, rows):
    """The target was 0.1 deg off along the frame's first side, which lies along beta's axis, and
    -0.05 along the second: the next plan, told so, points there but for what it doesn't believe.

    The attitude is uncertain by 0.05 deg and more, the image by 0.001: it believes all but a
    thousandth, and forgets some of it in the seconds between.
    """
    at = "2015-02-27T17:37:00Z"
    found = compare(
        client, plan, json_samples(rows), image_offsets=[{"epoch": at, "offset_deg": [0.1, -0.05]}]
    )
    [parts] = found["pointing"]
    assert parts["measured"] == "image"
    assert parts["target_arcsec"] == pytest.approx([360.0, -180.0], abs=0.01)
    np.testing.assert_allclose(
        np.subtract(parts["attitude_arcsec"], parts["axes_arcsec"]), [360.0, -180.0], atol=0.01
    )
    attitude = LAS_VEGAS["attitude"] | {"corrections": found["corrections"]}
    answer = client.post("/v1/plans", json=LAS_VEGAS | {"attitude": attitude})
    assert answer.status_code == 201, answer.text
    after = answer.json()
    turned = boresight(after, at) - boresight(plan, at)
    # By a separate road: the inner axis turns the view across itself, which is the second side.
    alpha_deg, beta_deg = boresight(plan, at)
    tilt = np.radians(5.0)
    outer, inner = np.array([0.0, -np.cos(tilt), np.sin(tilt)]), np.array([1.0, 0.0, 0.0])

    def look(angles_deg):
        first = Rotation.from_rotvec(np.radians(angles_deg[0]) * outer)
        second = Rotation.from_rotvec(np.radians(angles_deg[1]) * inner)
        return (first * second).apply([0.0, 0.0, 1.0]), first.apply(inner)

    before, side = look((alpha_deg, beta_deg))
    side = side - (side @ before) * before
    side /= np.linalg.norm(side)
    moved = look((alpha_deg + turned[0], beta_deg + turned[1]))[0] - before
    wanted = np.array(parts["attitude_arcsec"]) / ARCSEC_PER_DEG
    np.testing.assert_allclose(
        np.degrees([moved @ side, moved @ np.cross(before, side)]), wanted, atol=0.003
    )


def test_a_horizon_estimate_beside_the_axes_says_where_the_target_was(client, plan, rows):
    """A rotation of 0.02 deg about the line of sight moves nothing; across it, all of it."""
    at = "2015-02-27T17:37:00.000Z"
    covariance = [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]]
    found = compare(
        client,
        plan,
        json_samples(rows),
        corrections=[
            {"epoch": at, "turn_body_deg": [0.3, 0.1, 0.2], "covariance_deg2": covariance}
        ],
    )
    [parts] = found["pointing"]
    assert parts["measured"] == "rotation"
    assert parts["session"] == 0
    np.testing.assert_allclose(parts["attitude_sigma_arcsec"], [36.0, 36.0], rtol=1e-6)
    assert 0.0 < np.hypot(*parts["attitude_arcsec"]) < 0.375 * ARCSEC_PER_DEG
    [pasted] = found["corrections"]
    assert pasted["turn_body_deg"] == [0.3, 0.1, 0.2]


def test_angles_alone_say_nothing_of_the_attitude(by_json):
    assert by_json["corrections"] == by_json["pointing"] == []


def test_the_platform_found_is_pasted_into_the_next_request(client, plan, rows):
    found = compare(client, plan, json_samples(rows), identify=["beta.viscous_per_s"])
    [one] = found["parameters"]
    assert one["name"] == "beta.viscous_per_s"
    assert found["platform"]["inner"]["drive"]["viscous_per_s"] == one["found"]
    answer = client.post("/v1/plans?dry_run=true", json=LAS_VEGAS | {"platform": found["platform"]})
    assert answer.status_code == 200, answer.text


@pytest.mark.parametrize("name", ["gamma.lag_s", "alpha.colour", "alpha", "alpha.inertia_kg_m2"])
def test_parameters_that_no_flight_shows_are_refused(client, plan, rows, name):
    samples = json_samples(rows[:200])
    request = {"plan": plan["id"], "samples": samples, "identify": [name]}
    answer = client.post(COMPARISONS, json=request)
    assert answer.status_code == 422
    assert answer.json()["field"] == "identify.0"


def test_a_frame_outside_of_any_session_is_refused(client, plan, rows):
    for at, field in (
        ("2015-02-27T17:35:00Z", "image_offsets.0.epoch"),
        ("2015-02-27T18:35:00Z", "image_offsets.0.epoch"),
    ):
        request = {
            "plan": plan["id"],
            "samples": json_samples(rows),
            "image_offsets": [{"epoch": at, "offset_deg": [0.1, 0.0]}],
        }
        answer = client.post(COMPARISONS, json=request)
        assert answer.status_code == 422
        assert answer.json()["field"] == field
