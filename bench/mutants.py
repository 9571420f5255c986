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
import ast
import contextlib
import copy
import functools
import json
import os
import random
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

ROOT = Path(__file__).parents[1]
ROOMS = (
    "planner/verification",
    "planner/spacecraft/verification.py",
    "planner/slew",
    "app/jobs",
    "app/requests",
)
LEFT_OUT = ("app/requests/examples/",)  # what the pages show, compared with their answers as text
OWN = ("slewtrack", "app", "planner", "estimator")

# The tests of a file by the beginning of its path, likeliest and quickest first; the longest
# beginning counts.  Files in tests/ without their .py, one of their tests after `::`.
FIRST = {
    "planner/verification/": "oracles/test_verification_pointing oracles/test_verification_limits "
    "oracles/test_verification_structure oracles/test_verification_sky "
    "published/test_verification_golden",
    "planner/verification/air.py": "oracles/test_verification_refraction",
    "planner/verification/bench_motion.py": "oracles/test_verification_bench_motion",
    "planner/verification/carrier.py": "properties/test_verification_pieces "
    "oracles/test_verification_pointing published/test_verification_golden",
    "planner/verification/clock.py": "properties/test_verification_pieces "
    "oracles/test_verification_structure oracles/test_verification_pointing",
    "planner/verification/earth.py": "properties/test_verification_pieces "
    "oracles/test_verification_pointing",
    "planner/verification/earth_fixed.py": "oracles/test_verification_pointing "
    "properties/test_verification_pieces oracles/test_verification_refraction",
    "planner/verification/hermite.py": "oracles/test_verification_limits "
    "properties/test_verification_pieces",
    "planner/verification/keep_out.py": "end_to_end/test_keep_out_plans",
    "planner/verification/light.py": "properties/test_verification_pieces "
    "properties/test_verification_sky_pieces oracles/test_verification_pointing",
    "planner/verification/limb.py": "oracles/test_verification_sky "
    "properties/test_verification_sky_pieces oracles/test_verification_refraction",
    "planner/verification/limits.py": "oracles/test_verification_limits "
    "properties/test_verification_pieces",
    "planner/verification/pointing.py": "oracles/test_verification_pointing "
    "oracles/test_verification_sky oracles/test_keyhole",
    "planner/verification/sky.py": "oracles/test_verification_sky "
    "properties/test_verification_sky_pieces oracles/test_verification_refraction",
    "planner/verification/solar_system.py": "oracles/test_verification_sky "
    "properties/test_verification_sky_pieces",
    "planner/verification/stars.py": "oracles/test_verification_sky "
    "properties/test_verification_sky_pieces",
    "planner/verification/structure.py": "oracles/test_verification_structure "
    "oracles/test_verification_bench_motion",
    "planner/spacecraft/verification.py": "end_to_end/test_spacecraft_plan",
    "planner/slew/": "contracts/test_slew_methods oracles/test_slew_profiles "
    "published/test_paper_spline properties/test_slew_near_rate_limit::test_found_at_either_end "
    "properties/test_slew_near_rate_limit::"
    "test_what_cannot_be_braked_is_refused_before_anything_else "
    "properties/test_slew_near_rate_limit::"
    "test_a_refused_slew_says_which_of_its_ends_can_not_be_braked "
    "properties/test_slew_near_rate_limit::test_braking_on_rows_is_what_stepping_it_shows "
    "properties/test_slew_near_rate_limit::test_a_stop_forbids_what_meets_it_braked_hardest "
    "properties/test_slew_join oracles/test_vibration oracles/test_schedule_slew_time "
    "properties/test_slews::test_an_axis_that_takes_hours_takes_its_least_time_and_no_less "
    "properties/test_slews::test_with_hours_to_spare_an_axis_rests_where_it_began "
    "properties/test_slews::test_a_slew_proven_to_exist_is_made_although_the_solver_fails "
    "properties/test_slews::test_too_short_a_time_is_refused_and_the_named_time_works "
    "properties/test_slews::test_rows_carry_a_short_slew_whose_jerk_changes_much_from_row_to_row "
    "properties/test_slews::test_rows_carry_the_slew_within_limits_and_to_a_tenth_of_an_arcsecond "
    "properties/test_slew_near_rate_limit::test_where_rows_are_too_few_one_more_is_enough "
    "oracles/test_slew_optimum",
    "planner/slew/spline_": "oracles/test_vibration contracts/test_slew_methods "
    "oracles/test_slew_optimum::test_far_from_limits_the_solver_finds_the_quintic_itself "
    "properties/test_slews::test_rows_carry_the_slew_within_limits_and_to_a_tenth_of_an_arcsecond "
    "properties/test_slew_near_rate_limit::test_found_at_either_end properties/test_keep_out_slews",
    "app/jobs/": "contracts/test_jobs contracts/test_disposable_child",
    "app/jobs/child.py": "contracts/test_disposable_child",
    "app/jobs/dask_": "contracts/test_cluster",
    "app/jobs/disposable.py": "contracts/test_disposable_child contracts/test_jobs",
    "app/jobs/kinds.py": "contracts/test_campaign_jobs contracts/test_http_jobs",
    "app/jobs/settling.py": "contracts/test_jobs contracts/test_campaign_jobs",
    "app/requests/": "contracts/test_text_bounds contracts/test_spacecraft_requests "
    "contracts/test_horizon_request contracts/test_limits contracts/test_leap_second_requests "
    "contracts/test_number_ranges contracts/test_http_refusals",
    "app/requests/horizon": "contracts/test_horizon_request contracts/test_number_ranges "
    "contracts/test_http_horizon",
}
# With --again all of its room, and these.
THEN = {
    "planner/verification/": "oracles/test_keyhole end_to_end/test_every_target",
    "planner/spacecraft/verification.py": "contracts/test_http_spacecraft",
    "planner/slew/": "properties/test_slew_near_rate_limit properties/test_slews "
    "end_to_end/test_effort end_to_end/test_planning",
    "app/jobs/": "contracts/test_http_in_child contracts/test_stopping end_to_end/test_crashes",
    "app/requests/": "contracts/test_keep_out_request contracts/test_http_openapi "
    "contracts/test_http_plans contracts/test_http_opportunities contracts/test_http_spacecraft "
    "end_to_end/test_campaign_command contracts/test_generated_requests",
}

OPPOSITES: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt), ast.LtE: (ast.Lt, ast.Gt), ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.Lt), ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,), ast.In: (ast.NotIn,), ast.NotIn: (ast.In,), ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,), ast.Mult: (ast.Div,), ast.Div: (ast.Mult,), ast.FloorDiv: (ast.Mult,),
    ast.Mod: (ast.Mult,), ast.Pow: (ast.Mult,), ast.BitAnd: (ast.BitOr,), ast.BitOr: (ast.BitAnd,),
    ast.And: (ast.Or,), ast.Or: (ast.And,),
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One change: the source's characters from `first` up to `past` become `new`."""

    file: str
    line: int
    first: int
    past: int
    old: str
    new: str


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
    sample, only = _sample(given.count, given.seed), tuple(given.only)
    chosen = [one for one in sample if one.file.startswith(only)]
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
            tests = {test for one in untried for test in _tests(one.file)}
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


def _tests(file: str) -> list[str]:
    """What pytest calls the tests of a file."""
    return _named(FIRST[max((start for start in FIRST if file.startswith(start)), key=len)])


def _tests_of_room(file: str) -> list[str]:
    """Those of the file, those of its room's other files, and those of `THEN`."""
    room = next(start for start in THEN if file.startswith(start))
    of_room = [names for start, names in FIRST.items() if start.startswith(room)]
    return list(dict.fromkeys([*_tests(file), *_named(" ".join([*of_room, THEN[room]]))]))


def _named(names: str) -> list[str]:
    parts = [name.partition("::") for name in names.split()]
    return [f"tests/{path}.py{colons}{test}" for path, colons, test in parts]


def _copy_project(folder: Path) -> None:
    listed = ["git", "-C", str(ROOT), "ls-files", "-co", "--exclude-standard"]
    for name in subprocess.run(listed, check=True, capture_output=True, text=True).stdout.split():
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    # No mutated file has kernels, so the compiled ones stay.
    compiled = folder / "planner" / "compiled.py"
    compiled.write_text(compiled.read_text().replace("/ _digest(_HERE)", '/ "mutants"'))


# The sample


def _sample(count: int, seed: int) -> list[Mutant]:
    """At most one mutant a line, in each room as many as its share of all lines."""
    files = {room: _files(room) for room in ROOMS}
    lines = {room: sum(_lines(file) for file in files[room]) for room in ROOMS}
    chosen = []
    for room in ROOMS:
        draw = random.Random(f"{seed} {room}")  # whatever becomes of the other rooms
        by_line: dict[tuple[str, int], list[Mutant]] = {}
        for file in files[room]:
            for mutant in _mutants(file):
                by_line.setdefault((file, mutant.line), []).append(mutant)
        mutants = [draw.choice(of_a_line) for of_a_line in by_line.values()]
        draw.shuffle(mutants)
        chosen += mutants[: round(count * lines[room] / sum(lines.values()))]
    return chosen


def _files(room: str) -> list[str]:
    path = ROOT / room
    found = [path] if path.is_file() else sorted(path.rglob("*.py"))
    names = [str(one.relative_to(ROOT)) for one in found]
    return [name for name in names if not name.startswith(LEFT_OUT)]


def _lines(file: str) -> int:
    return len((ROOT / file).read_text().splitlines())


def _mutants(file: str) -> Iterator[Mutant]:
    source = (ROOT / file).read_text()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line.encode()))
    text = source.encode()
    for node, changed in _changes(ast.parse(source)):
        assert isinstance(node, ast.expr | ast.stmt)
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        first = starts[node.lineno - 1] + node.col_offset
        past = starts[node.end_lineno - 1] + node.end_col_offset
        new = ast.unparse(changed)
        if isinstance(node, ast.expr) and not isinstance(node, ast.Constant):
            new = f"({new})"
        yield Mutant(file, node.lineno, first, past, text[first:past].decode(), new)


def _changes(node: ast.AST) -> Iterator[tuple[ast.AST, ast.AST]]:
    """Each node that may be changed, and what it becomes."""
    if _is_told(node):
        return
    yield from ((node, changed) for changed in _changed(node))
    if isinstance(node, ast.If | ast.IfExp) and not isinstance(node.test, ast.Compare):
        yield node.test, ast.UnaryOp(ast.Not(), node.test)
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_params", "bases"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _changes(child)


def _is_told(node: ast.AST) -> bool:
    """Wording, logs, imports and types: nothing that the product does."""
    if isinstance(node, ast.JoinedStr | ast.Import | ast.ImportFrom | ast.pattern):
        return True
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        called = ast.unparse(node.value.func)
        return called.startswith(("log.", "_log.", "logger.", "logging.", "warnings."))
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def _changed(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.Constant):
        yield from _other_constants(node)
    elif isinstance(node, ast.Compare):
        for index, operator in enumerate(node.ops):
            for other in OPPOSITES[type(operator)]:
                changed = copy.deepcopy(node)
                changed.ops[index] = other()  # type: ignore[call-overload]  # of the same kind
                yield changed
    elif isinstance(node, ast.BinOp | ast.BoolOp | ast.AugAssign):
        yield from _other_operations(node)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield node.operand
    elif isinstance(node, ast.Return) and node.value and ast.unparse(node.value) != "None":
        yield ast.Return(None)
    elif isinstance(node, ast.Raise | ast.Continue | ast.Break) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    ):
        yield ast.Pass()


def _other_operations(node: ast.BinOp | ast.BoolOp | ast.AugAssign) -> Iterator[ast.AST]:
    for other in OPPOSITES.get(type(node.op), ()):
        changed = copy.deepcopy(node)
        changed.op = other()  # type: ignore[assignment]  # of the same kind
        yield changed
    if isinstance(node, ast.AugAssign):
        yield ast.Pass()


def _other_constants(node: ast.Constant) -> Iterator[ast.AST]:
    if isinstance(node.value, bool):
        yield ast.Constant(not node.value)
    elif isinstance(node.value, int | float):
        others = {node.value + 1, node.value * 2, 0} - {node.value}
        yield from (ast.Constant(other) for other in sorted(others))


# One trial


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
        fork_passes: dict[str, bool] = {}
        for number, mutant in enumerate(self._mutants, start=1):
            unchanged = Mutant(mutant.file, 0, 0, 0, "", "")
            if mutant.file not in fork_passes:
                trial = self._try_in_fork(session, unchanged)
                fork_passes[mutant.file] = trial.outcome == "survived"
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
    tests = _tests(mutant.file)
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
    command = [sys.executable, "-m", "pytest", *options, *_tests_of_room(mutant.file)]
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
