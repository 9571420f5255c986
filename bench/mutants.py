"""Which small faults in the judges, the slews, the jobs and the requests do the tests notice?

A sample of one-place changes (operators, numbers, conditions, statements left out), drawn with
a seed and spread over the rooms by their lines.  Each is made in a copy of the project and the
tests of its file are run there, the likeliest first, until one fails: in a fork of a process that
has collected the tests already.  What nobody noticed is either equivalent or a hole in the tests;
read it and say which.

    python bench/mutants.py COPY RESULTS.jsonl [--count 200] [--seed 12] [--again]

COPY is a folder outside the project which is overwritten.  Mutants named in RESULTS are not
tried again, so a run may be stopped and resumed; `--again` tries those which were not killed
on all tests of their room, as the tests are now, each in a new interpreter.
"""

import argparse
import contextlib
import functools
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import types
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mutant_sample import ROOMS, ROOT, Mutant, sample
from mutant_tests import tests_of, tests_of_room

OWN = ("slewtrack", "app", "planner", "estimator")


@dataclass(frozen=True)
class Trial:
    """What the tests made of a mutant; `by` is the first test that failed."""

    mutant: Mutant
    outcome: str
    by: str
    seconds: float


def main() -> None:
    """Try the sample, one mutant at a time."""
    parser = argparse.ArgumentParser(description="Which small faults do the tests notice?")
    parser.add_argument("copy", type=Path)
    parser.add_argument("results", type=Path)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=12)
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--limit", type=float, default=600.0, help="seconds a mutant")
    parser.add_argument("--only", nargs="+", default=[""], help="beginnings of files to mutate")
    given = parser.parse_args()
    results = given.results.resolve()
    before = _read(results)
    only = tuple(given.only)
    chosen = [one for one in sample(given.count, given.seed) if one.file.startswith(only)]
    _copy_project(given.copy)
    os.chdir(given.copy)
    os.environ.update(PYTHONPATH=os.getcwd(), OMP_NUM_THREADS="1")
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # it would be compiled for each mutant anew
    sys.dont_write_bytecode = False
    if given.again:
        chosen = [one for one in chosen if one in before and before[one].outcome != "killed"]
        for number, mutant in enumerate(chosen, start=1):
            _note(_try_afresh(mutant, given.limit), results, f"{number}/{len(chosen)}")
    else:
        import pytest

        sys.path.insert(0, os.getcwd())
        for room in ROOMS:
            untried = [one for one in chosen if one.file.startswith(room) and one not in before]
            tests = {test for one in untried for test in tests_of(one.file)}
            if untried:
                trials = Trials(untried, results, given.limit)
                pytest.main(["-q", "-s", "-n0", "-p", "no:cacheprovider", *sorted(tests)], [trials])
    _report(_read(results))


def _note(trial: Trial, results: Path, number: str) -> None:
    with results.open("a") as out:
        out.write(json.dumps(asdict(trial)) + "\n")
    print(f"{number} {trial.outcome} {trial.seconds:.0f} s {_text(trial.mutant)}")
    print(f"      {trial.by}", flush=True)


def _report(trials: dict[Mutant, Trial]) -> None:
    for room in ROOMS:
        outcomes = [one.outcome for one in trials.values() if one.mutant.file.startswith(room)]
        print(f"{room}: {len(outcomes)} tried, {dict(Counter(outcomes))}")
    for mutant, trial in trials.items():
        if trial.outcome != "killed":
            print(trial.outcome, _text(mutant))


def _text(mutant: Mutant) -> str:
    return f"{mutant.file}:{mutant.line}: {mutant.old!r} -> {mutant.new!r}"


def _read(results: Path) -> dict[Mutant, Trial]:
    """The latest trial of each mutant."""
    if not results.exists():
        return {}
    rows = [json.loads(line) for line in results.read_text().splitlines()]
    trials = [Trial(**{**row, "mutant": Mutant(**row["mutant"])}) for row in rows]
    return {trial.mutant: trial for trial in trials}


def _copy_project(folder: Path) -> None:
    listed = ["git", "-C", str(ROOT), "ls-files", "-co", "--exclude-standard"]
    for name in subprocess.run(listed, check=True, capture_output=True, text=True).stdout.split():
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    # No mutated file has kernels, so the compiled ones stay.
    compiled = folder / "planner" / "compiled.py"
    compiled.write_text(compiled.read_text().replace("/ _digest(_HERE)", '/ "mutants"'))


class Trials:
    """A plugin of pytest: instead of running the tests collected, tries mutants on them."""

    def __init__(self, mutants: list[Mutant], results: Path, limit_s: float) -> None:
        self._mutants, self._results, self._limit_s = mutants, results, limit_s

    def pytest_runtestloop(self, session: Any) -> bool:  # noqa: ANN401 (pytest's)
        """Each mutant in a fork that has all modules and tests loaded.

        Of one file's tests the first is run before, so that its module's fixtures are made once;
        not where they are of threads and children, which a fork doesn't have.
        """
        of_jobs = self._mutants[0].file.startswith("app/jobs/")
        if len({item.path for item in session.items}) == 1 and not of_jobs:
            first, *session.items = session.items
            first.config.hook.pytest_runtest_protocol(item=first, nextitem=session.items[0])
        unchanged = {one.file: Mutant(one.file, 0, 0, 0, "", "") for one in self._mutants}
        fork_passes = {
            file: self._try_in_fork(session, same).outcome == "survived"
            for file, same in unchanged.items()
        }
        for number, mutant in enumerate(self._mutants, start=1):
            if fork_passes[mutant.file]:
                trial = self._try_in_fork(session, mutant)
            else:  # what fails without a change says nothing of one
                trial = _try_afresh(mutant, self._limit_s)
            _note(trial, self._results, f"{number}/{len(self._mutants)}")
        return True

    def _try_in_fork(self, session: Any, mutant: Mutant) -> Trial:  # noqa: ANN401 (pytest's)
        with _written(mutant):
            began_s = time.monotonic()
            outcome, by = _outcome(functools.partial(_run_tests, session, mutant), self._limit_s)
            return Trial(mutant, outcome, by, round(time.monotonic() - began_s, 1))


def _run_tests(session: Any, mutant: Mutant) -> bool:  # noqa: ANN401 (pytest's)
    """In the fork: whether all tests pass.  Those that draw examples take longer and come last."""
    sys.modules["__main__"] = types.ModuleType("__main__")  # children of tests need no mutants
    _put_in(mutant)
    tests = tests_of(mutant.file)
    items = [item for test in tests for item in session.items if item.nodeid.startswith(test)]
    items.sort(key=lambda item: hasattr(item.obj, "hypothesis"))
    for item, following in zip(items, [*items[1:], None], strict=True):
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        if session.testsfailed:
            print(f"\nFAILED {item.nodeid}", flush=True)
            return False
    return True


def _put_in(mutant: Mutant) -> None:
    """Make the module that is loaded what its changed source says, as far as that goes.

    What it can't reach (a class's fields, what another module made of it as it was loaded) stays
    as it was, so that a mutant may survive which `--again` kills.
    """
    name = mutant.file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    loaded = sys.modules.get(name)
    if loaded is None:
        return
    fresh = types.ModuleType(name)
    fresh.__file__, fresh.__package__ = loaded.__file__, loaded.__package__
    sys.modules[name] = fresh  # where dataclasses look for it
    try:
        exec(compile(Path(mutant.file).read_bytes(), mutant.file, "exec"), vars(fresh))
    finally:
        sys.modules[name] = loaded
    _merge(vars(loaded), vars(fresh), name)


def _merge(old: Mapping[str, object], new: Mapping[str, object], module: str) -> None:
    for name in old.keys() & new.keys():
        before, after = old[name], new[name]
        if isinstance(after, type):
            if after.__module__ == module:
                _merge(vars(before), vars(after), module)
        elif functions := _functions(after):
            for function, other in zip(_functions(before), functions, strict=False):
                if other.__module__ == module:
                    function.__code__ = other.__code__
                    function.__defaults__ = other.__defaults__
                    function.__kwdefaults__ = other.__kwdefaults__
            getattr(before, "cache_clear", lambda: None)()
        elif isinstance(old, dict) and not name.startswith("__") and not callable(after):
            for everywhere in list(sys.modules.values()):
                if everywhere.__name__.startswith(OWN) and vars(everywhere).get(name) is before:
                    setattr(everywhere, name, after)


def _functions(member: object) -> list[types.FunctionType]:
    """The functions a member of a module or class is made of."""
    if isinstance(member, staticmethod | classmethod):
        member = member.__func__
    if isinstance(member, property):
        return [member.fget] if isinstance(member.fget, types.FunctionType) else []
    if isinstance(member, functools.cached_property):
        member = member.func
    own = [member] if isinstance(member, types.FunctionType) else []
    wrapped = getattr(member, "__wrapped__", None)
    return own if wrapped is None else own + _functions(wrapped)


def _try_afresh(mutant: Mutant, limit_s: float) -> Trial:
    """All tests of its room, in an interpreter that knows nothing."""
    options = ["-x", "-q", "-n0", "--tb=no", "-p", "no:cacheprovider"]
    command = [sys.executable, "-m", "pytest", *options, *tests_of_room(mutant.file)]
    with _written(mutant):
        began_s = time.monotonic()
        outcome, by = _outcome(
            lambda: subprocess.run(command, check=False).returncode == 0, limit_s
        )
        return Trial(mutant, outcome, by, round(time.monotonic() - began_s, 1))


@contextlib.contextmanager
def _written(mutant: Mutant) -> Iterator[None]:
    """Inside, the copy's file has the change, for processes that tests start."""
    path = Path(mutant.file)
    source, stat = path.read_bytes(), path.stat()
    path.write_bytes(source[: mutant.first] + mutant.new.encode() + source[mutant.past :])
    try:
        yield
    finally:
        path.write_bytes(source)
        os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))  # byte code compares times


def _outcome(all_pass: Callable[[], bool], limit_s: float) -> tuple[str, str]:
    """What comes of it in a fork and its process group, and which test failed."""
    with tempfile.TemporaryDirectory(prefix="mutant-", ignore_cleanup_errors=True) as scratch:
        log = Path(scratch) / "log"
        pid = os.fork()
        if pid == 0:
            exit_code = 1
            try:
                os.setsid()
                signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in background
                os.environ["TMPDIR"], tempfile.tempdir = scratch, None
                out = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
                for descriptor in (1, 2):
                    os.dup2(out, descriptor)
                exit_code = 0 if all_pass() else 1
            except BaseException as error:  # noqa: BLE001 (it can't even be loaded)
                print(f"\nFAILED {error!r}", flush=True)
            finally:
                os._exit(exit_code)
        exit_code = _wait(pid, limit_s)
        lines = log.read_text(errors="replace").splitlines() if log.exists() else []
    by = next((line for line in lines if line.startswith(("FAILED", "ERROR"))), "")
    return {None: "timed out", 0: "survived"}.get(exit_code, "killed"), by[:160]


def _wait(pid: int, limit_s: float) -> int | None:
    """The exit code of a fork; None where it was killed at its limit.  Its group ends with it."""
    until_s = time.monotonic() + limit_s
    while not (ended := os.waitpid(pid, os.WNOHANG))[0] and time.monotonic() < until_s:
        time.sleep(0.02)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)
    if ended[0]:
        return os.waitstatus_to_exitcode(ended[1])
    os.waitpid(pid, 0)
    return None


if __name__ == "__main__":
    main()
