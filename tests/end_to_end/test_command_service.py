"""The command plans by a running service, and lists, shows, exports and follows what it keeps."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner
from waiting import eventually

import slewtrack
from app.cli import main

EXAMPLES = Path(__file__).parents[2] / "examples"
LAS_VEGAS = str(EXAMPLES / "las_vegas_2015.json")
NOBODY = "01a203fd-cbae-73f8-8276-319f76b8842c"


@pytest.fixture(scope="module")
def url(service):
    return service.address


@pytest.fixture
def run(url, monkeypatch):
    monkeypatch.setenv("SLEWTRACK_URL", url)
    monkeypatch.delenv("COLUMNS", raising=False)  # as in a pipe, which knows no width

    def command(*words, **options):
        return CliRunner().invoke(main, [*map(str, words)], **options)

    return command


@pytest.fixture(scope="module")
def plan_id(url):
    with slewtrack.Client(url) as client:
        return client.plan(Path(LAS_VEGAS).read_bytes()).id


def without_times(report):
    return [
        line for line in report.splitlines() if "planned in" not in line and "revision" not in line
    ]


def test_a_service_plans_what_is_planned_here(run, url, tmp_path):
    here = run("plan", LAS_VEGAS, "--csv", tmp_path / "here.csv")
    words = ["--csv", tmp_path / "there.csv", "--json", tmp_path / "plan.json"]
    there = run("plan", LAS_VEGAS, "--url", url, *words)
    assert there.exit_code == 0, there.stderr
    *report, kept = without_times(there.stdout)
    assert report == without_times(here.stdout)
    assert (tmp_path / "there.csv").read_text() == (tmp_path / "here.csv").read_text()
    plan_id = json.loads((tmp_path / "plan.json").read_text())["id"]
    assert kept == f"kept as {plan_id}"
    listed = run("list", "--limit", "1")
    assert listed.stdout.split()[6:8] == [plan_id, "done"]
    assert "2015-02-27 17:36:20  Las Vegas" in listed.stdout


def test_where_a_service_listens_is_told_with_its_pages(service):
    told = eventually(service.output.read_text)
    assert told == (
        f"serving {service.address}/, the API's pages at {service.address}/docs; Ctrl+C ends it\n"
    )


@pytest.mark.parametrize(("suffix", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml")])
def test_a_service_draws_the_plot(run, url, tmp_path, suffix, begins):
    picture = tmp_path / f"plan.{suffix}"
    done = run("plan", LAS_VEGAS, "--url", url, "--plot", picture)
    assert done.exit_code == 0, done.stderr
    assert picture.read_bytes().startswith(begins)


def test_a_plan_goes_on_where_a_kept_one_ends(run, url, plan_id, tmp_path):
    """Las Vegas again, a moment later: planned by the service, refused without it."""
    document = json.loads(Path(LAS_VEGAS).read_text())
    document["initial_state"] = {"after": plan_id}
    document["sessions"][0] |= {"start": "2015-02-27T17:38:00Z", "stop": "2015-02-27T17:38:20Z"}
    file = tmp_path / "after.json"
    file.write_text(json.dumps(document))
    refused = run("plan", file)
    assert refused.exit_code == 2
    assert "slewtrack plan --url" in refused.stderr
    done = run("plan", file, "--url", url, "--json", tmp_path / "plan.json")
    assert done.exit_code == 0, done.stderr
    assert f"taken for initial_state.after: the end of plan {plan_id}: " in done.stdout
    begins, ended = (
        json.loads(text)["table"]
        for text in (
            (tmp_path / "plan.json").read_text(),
            run("show", plan_id, "--json", "-").stdout,
        )
    )
    assert begins["alpha_deg"][0] == pytest.approx(ended["alpha_deg"][-1], abs=1e-9)
    # Hours later the axes still stand where that plan left them, not at zero.
    later = run("plan", file, "--url", url, "--next-pass", "--start", "2015-02-28T00:00:00Z")
    assert later.exit_code == 0, later.stderr
    [alpha_deg] = re.findall(rf"the end of plan {plan_id}: alpha (\S+),", later.stdout)
    assert float(alpha_deg) == pytest.approx(ended["alpha_deg"][-1], rel=1e-5)  # six digits


def test_lists_are_narrowed(run, plan_id):
    words = ["list", "--text", "las vegas", "--after", "2015-02-27T17:00:00Z", "--limit", "200"]
    assert plan_id in run(*words, "--before", "2015-02-27T18:00:00Z").stdout
    assert run(*words, "--target", "Paris").stdout == "there are none\n"
    refused = run("list", "--after", "noon")
    assert refused.exit_code == 2
    assert "after" in refused.stderr


def test_an_id_may_be_cut(run, plan_id):
    """As `list` cuts it where there is little room; where several begin so, none is taken."""
    narrow = run("list", "--limit", "200", env={"COLUMNS": "80"}).stdout.splitlines()
    assert max(map(len, narrow)) <= 80
    [short] = {line.split()[0] for line in narrow if plan_id.startswith(line.split()[0])}
    assert short != plan_id
    assert json.loads(run("show", short, "--json", "-").stdout)["id"] == plan_id
    assert plan_id in run("list", "--limit", "200", "--wide", env={"COLUMNS": "80"}).stdout
    assert run("show", "0").exit_code == run("show", "nobody's").exit_code == 2


def test_a_dry_run_keeps_nothing(run, url):
    before = run("list", "--limit", "1").stdout
    done = run("plan", LAS_VEGAS, "--url", url, "--dry-run")
    assert "flies: 1151 rows" in done.stdout
    assert run("list", "--limit", "1").stdout == before


def test_a_refusal_is_told_as_here(run, url, tmp_path):
    soon = ["plan", LAS_VEGAS, "--set=sessions.0.start=2015-02-27T17:34:02Z"]
    here = run(*soon)
    there = run(*soon, "--url", url, "--json", tmp_path / "problem.json")
    assert there.exit_code == 2
    assert there.stderr.splitlines()[:3] == here.stderr.splitlines()[:3]
    assert f"--url {url} " in there.stderr
    problem = json.loads((tmp_path / "problem.json").read_text())
    assert problem["earliest_feasible_start"] == "2015-02-27T17:34:27.200Z"


def test_a_table_that_fails_is_told_as_here(run, url, tmp_path):
    """With what breaks; it is drawn beside the verdict here, and by no service."""
    document = json.loads(Path(LAS_VEGAS).read_text()) | {"slew": {"method": "spline"}}
    document["initial_state"]["epoch"] = "2015-02-27T17:35:50Z"
    file = tmp_path / "spline.json"
    file.write_text(json.dumps(document))
    here = run("plan", file, "--plot", tmp_path / "here.png", "--csv", tmp_path / "here.csv")
    words = ["--plot", tmp_path / "there.png", "--csv", tmp_path / "there.csv"]
    there = run("plan", file, "--url", url, *words)
    assert here.exit_code == there.exit_code == 1
    assert "the table failed its verification: alpha reaches" in here.stderr
    assert there.stderr.splitlines()[0] == here.stderr.splitlines()[0]
    assert [one.name for one in tmp_path.iterdir() if one != file] == ["here.png"]


def test_what_is_kept_is_shown_and_exported(run, plan_id, tmp_path):
    shown = run("show", plan_id, "--json", "-")
    assert json.loads(shown.stdout)["id"] == plan_id
    assert "verification passed" in shown.stderr
    done = run("export", plan_id, f"netcdf={tmp_path}/plan.nc", "csv=-")
    assert done.exit_code == 0, done.stderr
    assert "alpha_deg" in done.stdout
    assert (tmp_path / "plan.nc").read_bytes().startswith(b"CDF")


def test_a_plan_and_a_campaign_are_followed(run, url, plan_id):
    followed = run("watch", plan_id)
    assert followed.exit_code == 0
    assert followed.stdout.splitlines()[-1] == "done"
    with slewtrack.Client(url) as client, pytest.raises(slewtrack.NotFinished) as late:
        client.campaign((EXAMPLES / "campaign_cities.json").read_bytes(), timeout_s=0.0)
    followed = run("watch", late.value.job_id)
    assert followed.exit_code == 0
    assert "running: plans 2 of 2" in followed.stdout
    exported = run("export", late.value.job_id, "kml=-")
    assert exported.exit_code == 0, exported.stderr
    assert exported.stdout.startswith("<?xml")


@pytest.mark.parametrize("words", [["show"], ["watch"], ["export", "csv=-"]])
def test_what_is_not_kept(run, words):
    verb, *rest = words
    refused = run(verb, NOBODY, *rest)
    assert refused.exit_code == 2
    assert "there is no" in refused.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["list", "--url", "http://127.0.0.1:9"], "slewtrack serve"),
        (["list", "--url", "somewhere"], "http://HOST:PORT"),
        (["list", "--state", "lost"], "state"),
        (["plan", LAS_VEGAS, "--url", "http://127.0.0.1:9", "--plot", "x.pdf"], ".svg"),
    ],
)
def test_a_service_that_can_not_be_asked(run, monkeypatch, words, said):
    """At once, without asking again."""
    monkeypatch.setattr("slewtrack.client.asking.PAUSE_S", 3600.0)
    refused = run(*words)
    assert refused.exit_code == 2
    [line] = refused.stderr.splitlines()
    assert said in line
