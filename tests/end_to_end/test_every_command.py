"""Every command line of the pages and of --help is run, and every flag of every command.

Here, within a longer line, by the tutorial's test, or, where it takes long or wants other machines,
read here and run in parts by the test that is named below; a new line, flag, command or example
fails until something runs it.
"""

import csv
import json
import os
import re
import shlex
import subprocess
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer
from live_service import SLEWTRACK
from test_tutorial import commands as tutorial_commands
from typer.core import TyperCommand
from typer.testing import CliRunner

import slewtrack
from app.cli import main
from app.requests.examples import LAS_VEGAS, SPACECRAFT_EXAMPLES

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
TREE = typer.main.get_command(main)
START = "2015-02-27T17:35:50Z"
# A short slew, and ten seconds of tracking.
SHORT = LAS_VEGAS | {
    "initial_state": LAS_VEGAS["initial_state"] | {"epoch": START},
    "sessions": [LAS_VEGAS["sessions"][0] | {"stop": "2015-02-27T17:36:30Z"}],
}

# Lines that other tests run, and which: each flag must stand in its file.
ELSEWHERE = {
    "plan examples/las_vegas_2015.json --csv OUT.csv --plot OUT.png --json OUT.json": (
        "test_readme::test_command_line_example"
    ),
    "compare request.json flight.csv --column q_1=QW --column q_2=QX --column q_3=QY "
    "--column q_4=QZ": "test_http_telemetry_body::test_the_command_tells_the_same",
    # It depends on today's date and on elements that are the reader's to bring.
    "plan examples/my_city.json --next-pass": (
        "test_command_ways_out::test_the_next_pass_is_found_and_planned"
    ),
    "fly examples/las_vegas_2015.json --runs 40 --seed 1 --plot OUT.png": (
        "test_fly_command::test_here"
    ),
    "horizon examples/horizon_session.json 0.png 1.png 2.png --json OUT.json": (
        "test_horizon_command::test_frames_of_a_session_show_its_bias"
    ),
    "horizon examples/horizon_session.json film.avi": (
        "test_horizon_command::test_a_video_shows_the_same"
    ),
    "spacecraft examples/spacecraft_eight_areas.json": (
        "test_spacecraft_paper_sessions::test_the_long_session_has_the_papers_moments"
    ),
    "spacecraft examples/spacecraft_strip_and_stereo.json": (
        "test_spacecraft_paper_sessions::"
        "test_strip_and_stereo_pair_are_imaged_when_the_paper_images_them"
    ),
    "campaign examples/campaign_cities.json --export kml=looks.kml": (
        "test_campaign_command::test_report_and_files"
    ),
    "campaign examples/campaign_fleet.json --revises OUT.json --frozen-until "
    "2015-02-27T17:35:00Z": ("test_revision::test_the_command_revises_by_a_file"),
    "export ID zip=plans.zip": "test_command_service::test_a_plan_and_a_campaign_are_followed",
    "serve --host 0.0.0.0 --port 8000": "test_command_line::test_serves_this_machine_only",
    "worker --scheduler tcp://10.0.0.1:8786 --solves 8": (
        "test_cluster::test_work_is_done_in_a_child_of_the_worker"
    ),
    "worker --scheduler tls://10.0.0.1:8786": (
        "test_cluster::test_connections_without_the_certificates_they_need_are_refused"
    ),
}

# Flags that no page shows, on requests that take little; {} are of the fixture `known`.
MORE = """
--version
plan {short} --url {url} --csv OUT.csv --json OUT.json
plan {short} --dry-run --set name=other
fly {short} --runs 2 --moving-object-m-s 20 --course-deg 90 --json OUT.json --url {url}
compare {answer} {telemetry} --request {short} --identify beta.coulomb_deg_s2 --json OUT.json
compare {id} {telemetry} --url {url} --epoch 2015-02-27T17:35:50Z --measurements {offsets}
compare {id} {telemetry} --url {url} --plot OUT.svg --column alpha_deg=alpha_deg
list --wide --state done --name vegas --target vegas --url {url} --json OUT.json
show {id} --url {url} --json OUT.json
export {id} --url {url} csv=OUT.csv
watch {id} --url {url}
campaign examples/campaign_cities.json --dry-run --json OUT.json
campaign examples/campaign_fleet.json --plans OUT --csv OUT.csv --json OUT.json
horizon examples/horizon_estimate.json examples/horizon_ahead.png {right} --json OUT.json
spacecraft {strip} --dry-run --set name=other --json OUT.json
spacecraft {strip} --url {url} --csv OUT.csv
windows examples/opportunities_gallery.json --url {url} --csv OUT.csv --no-probability
campaign examples/campaign_cities.json --url {url} --csv OUT.csv
horizon examples/horizon_estimate.json examples/horizon_ahead.png {right} --url {url}
keys create many --rate-per-minute 60 --concurrency 2
"""


def tree(command=TREE, words=()) -> Iterator[tuple[tuple[str, ...], object]]:
    """Every command that can be given, by its words."""
    yield words, command
    for name, below in getattr(command, "commands", {}).items():
        yield from tree(below, (*words, name))


VERBS = dict(tree())


def verb_of(words: list[str]) -> tuple[str, ...]:
    """The command that a line gives."""
    depth = 0
    while tuple(words[: depth + 1]) in VERBS and depth < len(words):
        depth += 1
    return tuple(words[:depth])


def flags_of(command: object) -> Iterator[set[str]]:
    """Each option's names, but for --help."""
    for parameter in command.params:
        if parameter.param_type_name == "option" and "--help" not in parameter.opts:
            yield {*parameter.opts, *parameter.secondary_opts}


def normal(text: str) -> str:
    """A line without what differs from page to page: where it writes."""
    text = re.sub(r"out/\S*?(\.\w+)?(?=\s|$)", r"OUT\1", text)
    return " ".join(shlex.quote(word) for word in shlex.split(text))


def given(line: str) -> str | None:
    """What is given to slewtrack in a line for a shell, None where nothing is."""
    words = shlex.split(re.split(r"\s[>|]\s", line)[0], comments=True)
    names = [k for k, word in enumerate(words) if word.split("/")[-1] == "slewtrack"]
    rest = words[names[-1] + 1 :] if names else []
    if not rest or (names[-1] > 0 and not verb_of(rest)):
        return None  # not given, or slewtrack is what another program is given
    if not rest[0].startswith("-"):
        assert verb_of(rest), f"there is no command {line}"
        if len(verb_of(rest)) == len(rest) and rest[-1] != "list":
            return None  # only named
    return shlex.join(rest)


def shown_in(text: str) -> Iterator[str]:
    text = text.replace("\\\n", " ")
    for line in re.findall(r"^\$ (.*)$", text, re.MULTILINE):
        if found := given(line):
            yield found
    for inline in re.findall(r"(?<!`)`([^`\n]*slewtrack [^`\n]+)`", text):
        if (found := given(inline)) and "…" not in inline and not found.endswith(" -h"):
            yield found


def helps() -> Iterator[str]:
    for command in VERBS.values():
        texts = [command.help, command.epilog, *(getattr(p, "help", "") for p in command.params)]
        yield from filter(None, texts)


TUTORIAL = {normal(command) for command, _ in tutorial_commands()}
SHOWN = {normal(line) for page in PAGES for line in shown_in(page.read_text())} | {
    normal(line) for text in helps() for line in shown_in(text)
}
OF_THE_SHELL = {"--install-completion", "--show-completion"}
TO_RUN = (
    sorted(SHOWN - TUTORIAL - set(ELSEWHERE) - OF_THE_SHELL - {"--help"})
    + MORE.strip().splitlines()
)


def is_within(line: str, other: str) -> bool:
    """Whether the other gives the same command all words of this one, and more."""
    one, more = shlex.split(line), shlex.split(other)
    return verb_of(one) == verb_of(more) and Counter(one) < Counter(more)


WITHIN_OTHERS = [line for line in TO_RUN if any(is_within(line, other) for other in TO_RUN)]
HERE = [line for line in TO_RUN if line not in WITHIN_OTHERS]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("commands")
    (where / "examples").symlink_to(ROOT / "examples")
    return where


@pytest.fixture(scope="module")
def known(folder, service):
    """By name, what lines have between braces: files, a service, a plan that it keeps, a key."""
    files = {name: folder / name for name in ("short", "strip", "answer", "telemetry", "offsets")}
    four_modes = SPACECRAFT_EXAMPLES["four modes"][1]
    files["short"].write_text(json.dumps(SHORT))
    files["strip"].write_text(json.dumps(four_modes | {"requests": four_modes["requests"][:1]}))
    offset = {"epoch": "2015-02-27T17:36:25Z", "offset_deg": [0.1, 0.0], "sigma_deg": 0.01}
    files["offsets"].write_text(json.dumps({"image_offsets": [offset]}))
    with slewtrack.Client(service.address) as client:
        plan = client.plan(files["short"].read_bytes())
        files["answer"].write_text(json.dumps(dict(plan.members)))
        with files["telemetry"].open("w") as file:
            rows = csv.writer(file)
            rows.writerow(["t_s", "alpha_deg", "beta_deg"])
            table = plan.members["table"]
            rows.writerows(
                zip(*(table[name] for name in ("t_s", "alpha_deg", "beta_deg")), strict=True)
            )
        files["right"] = "examples/horizon_right.png"
        yield {**files, "url": service.address, "id": plan.id}


@pytest.fixture
def run(folder, known, monkeypatch):
    monkeypatch.chdir(folder)
    monkeypatch.setenv("SLEWTRACK_DATA_DIR", str(folder / "keys"))
    monkeypatch.setenv("SLEWTRACK_URL", known["url"])

    def line(text):
        if "3f1c9a52b7e0" in text:
            made = CliRunner().invoke(main, ["keys", "create", "one"])
            text = text.replace("3f1c9a52b7e0", made.stderr.split()[1])
        text = re.sub(r"\bFILE\b", "{short}", text).replace("PATH", "OUT.it")
        text = text.format(**known).replace("OUT", "out/it")
        return text, CliRunner().invoke(main, shlex.split(text))

    return line


@pytest.mark.parametrize("text", HERE)
def test_every_line_runs(run, folder, text):
    line, done = run(text)
    assert done.exit_code == 0, done.stderr
    if "--dry-run" not in line:
        for suffix in re.findall(r"out/it(\.\w+)", line):
            [*written] = (folder / "out").glob(f"it*{suffix}")  # a picture a camera
            assert written
            for file in written:
                assert file.stat().st_size > 0
                file.unlink()
    if "--identify" in line:
        assert "beta.coulomb_deg_s2" in done.stdout


def test_completion_is_installed(tmp_path):
    given = [f"{SLEWTRACK} {flag}; true" for flag in sorted(OF_THE_SHELL)]
    for command in given:  # it asks which shell called it
        environment = os.environ | {"HOME": str(tmp_path)}
        done = subprocess.run(["bash", "-c", command], capture_output=True, env=environment)
        assert b"completion" in done.stdout, done.stderr
    assert "slewtrack" in (tmp_path / ".bashrc").read_text()


@pytest.mark.parametrize("words", VERBS, ids=" ".join)
def test_every_command_tells_its_help(words):
    done = CliRunner().invoke(main, [*words, "--help"])
    assert done.exit_code == 0
    assert "Usage" in done.stdout


IMPERATIVE = re.compile(
    r"(Allow|Ask|Begin|Change|Choose|Compare|Count|Draw|Estimate|Fly|Follow|Install|Keep|List|Listen|"
    r"Make|Manage|Move|Name|Only|Plan|Print|Read|Refuse|Report|Revise|Search|Serve|Set|Show|Solve|"
    r"Take|Write)\b"
)


def test_help_is_imperative():
    texts = [*helps()]
    assert len(texts) > 60
    assert [text for text in texts if not IMPERATIVE.match(text)] == []


def test_every_flag_is_run():
    run_lines = [*TUTORIAL, *HERE, *ELSEWHERE, *OF_THE_SHELL]
    for words, command in VERBS.items():
        lines = [line for line in run_lines if verb_of(shlex.split(line)) == words]
        used = {word.split("=")[0] for line in lines for word in shlex.split(line)}
        for names in flags_of(command):
            assert names & used, f"{' '.join(words)} {'/'.join(names)} is run by no test"
        assert lines or hasattr(command, "commands"), f"{words} is run by no test"


@pytest.mark.parametrize("line", [*ELSEWHERE, *WITHIN_OTHERS])
def test_what_is_run_elsewhere_or_within_a_longer_line_is_read_as_it_stands(line, monkeypatch):
    """Every word of it, by the command that it names, which then does nothing."""
    begun = []
    monkeypatch.setattr(TyperCommand, "invoke", lambda command, _: begun.append(command.name))
    monkeypatch.chdir(ROOT)
    done = CliRunner().invoke(main, shlex.split(line))
    assert done.exit_code == 0, done.stderr
    assert (*begun,) == verb_of(shlex.split(line))


def test_what_is_run_elsewhere_is_there():
    for line, test in ELSEWHERE.items():
        file, name = test.split("::")
        [path] = (ROOT / "tests").rglob(f"{file}.py")
        text = path.read_text()
        assert f"def {name}(" in text, test
        for flag in re.findall(r"--[\w-]+", line):
            assert flag in text or "README" in text, (flag, test)  # or the line is taken from it
        unshown = [normal(line)] if "/" in line else []
        assert set(unshown) <= SHOWN, f"{line} is shown by no page any more"


# Flags that pages name of Docker, Dask and our own benches.
OF_OTHERS = {
    *("--build-arg", "--no-healthcheck", "--profile", "--no-dashboard", "--dashboard-address"),
    *("--again", "--ground-sample", "--rows"),
}


def test_every_flag_that_pages_name_is_one():
    flags = {name for command in VERBS.values() for names in flags_of(command) for name in names}
    for page in PAGES:
        for flag in re.findall(r"`(--[\w-]+)[^`]*`", page.read_text()):
            assert flag in flags | OF_OTHERS, f"{page.name} names {flag}"


def test_every_example_is_read_by_a_test():
    lines = "\n".join([*TUTORIAL, *HERE, *ELSEWHERE])
    tests = "\n".join(file.read_text() for file in (ROOT / "tests").rglob("*.py"))
    for file in (ROOT / "examples").rglob("*.*"):
        name = file.relative_to(ROOT).as_posix()
        assert name in lines or file.name in tests or file.parent.name in tests, name
