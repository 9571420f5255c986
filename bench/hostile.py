"""Does the service stay upright, quick and discreet under those who wish it ill?

Families of attacks on a service of its own, on SQLite and, with --postgresql, on a server that
this script may make databases on.  Prints per family what was tried, answers 5xx that nothing
called for, answers that took over 2 s, lines of the log that hold a secret, body or query, and
what else was not as documented; ends with 1 unless all of these are zero.

    .ci/with-postgresql sh -c 'python bench/hostile.py --postgresql "$SLEWTRACK_TEST_DATABASE_URL"'
"""

import argparse
import contextlib
import itertools
import json
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from hostile_connections import held_connections, lock_out, stops_in_the_middle
from hostile_database import DATABASES
from hostile_servers import Server
from hostile_siege import Siege, Toll, besieged
from hostile_starts import few_descriptors, impossible_starts

from app.requests.examples.campaign import CAMPAIGN_EXAMPLES
from app.requests.examples.opportunities import OPPORTUNITY_EXAMPLES
from app.requests.examples.plan import LAS_VEGAS, PLAN_EXAMPLES
from app.requests.examples.spacecraft import SPACECRAFT_EXAMPLES

CASES = Path(__file__).parents[1] / "tests" / "data" / "cases"
EXTREMES = (1e300, -1e300, 1e9, -1e9, 5e-324, -1, 0)
# What no name may hold: null, line feed, escape, a right-to-left override, a lone surrogate; and
# more than a name is.
NO_NAMES = ("a\0b", "a\nb", "\x1b[31m", "a\u202eb", "a\ud800b", "n" * 201, "n" * 5_000_000)
QUERIES = (
    "/v1/plans?limit=1&limit=2",
    "/v1/plans?limit=1_0",
    "/v1/plans?limit=%201",
    "/v1/plans?nonsense=1",
    "/v1/plans?name=%00",
    "/v1/plans?name=%0a",
    "/v1/plans?name=%e2%80%ae",
    "/v1/campaigns?limit=1&limit=2",
    "/v1/platforms?x=1",
    "/metrics?x=1",
    "/healthz?x=1",
    "/openapi.json?x=1",
)
NO_TIMES = (
    "2015-02-27T17:36:20Z\n",
    " 2015-02-27T17:36:20Z",
    "2015-02-27T17:36:20,5Z",
    "2015-02-27 17:36:20Z",
    "2" * 5_000_000,
)
ANSWER_BYTES_MAX = 16 * 1024  # of a refusal, whatever it refuses

Family = Callable[[Siege], Toll]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--postgresql", default="", help="URL of a server; SQLite only without")
    parser.add_argument("--log-formats", nargs="*", default=["json", "console"])
    parser.add_argument("--postgresql-only", action="store_true")
    parser.add_argument("--families", nargs="*", help="only these, by the names that are printed")
    asked = parser.parse_args()
    print(f"{'':<44}{'tried':>7}{'5xx':>5}{'>2 s':>6}{'leaks':>7}{'wrong':>7}", flush=True)
    tolls = []
    urls = [*([] if asked.postgresql_only else [""]), *filter(None, [asked.postgresql])]
    for server in map(Server, urls):
        for log_format in asked.log_formats:
            for name, toll in _tolls(server, log_format, asked.families):
                tolls.append(toll)
                print(f"{server.name} {log_format} {name:<30}{toll}", flush=True)
                for complaint in toll.complaints[:5]:
                    print(f"    {complaint[:300]}", flush=True)
    sys.exit(0 if all(toll.is_clean for toll in tolls) else 1)


def _tolls(server: Server, log_format: str, wanted: list[str] | None) -> Iterator[tuple[str, Toll]]:
    families: dict[str, Family] = {
        "names": names,
        "queries": queries,
        "times": times,
        "extreme numbers": extremes,
        "named cases": named_cases,
        "HEAD": heads,
        "twenty deletes at once": deletes,
        "connections held": held_connections,
        "lock-out": lock_out,
        **{f"database {fault}": attack for fault, attack in DATABASES[server.kind].items()},
        "stopped in the middle": stops_in_the_middle,
        "few descriptors": few_descriptors,
        "impossible starts": impossible_starts,
    }
    for name, attack in families.items():
        if wanted and name not in wanted:
            continue
        with tempfile.TemporaryDirectory(prefix="slewtrack-hostile-") as folder:
            with server.database() as database, besieged(Path(folder), database, log_format) as it:
                toll = attack(it)
            yield name, toll.with_leaks(it.leaks())


def names(siege: Siege) -> Toll:
    """In every place of a request where a name goes."""
    return _texts(siege, NO_NAMES, lambda where, _: where[-1] == "name")


def queries(siege: Siege) -> Toll:
    """Repeated, unknown, or of a form that the documentation doesn't have."""
    toll = Toll()
    for path in QUERIES:
        toll.require(siege.get(path, toll), 422, 400)
    plan = LAS_VEGAS
    for query in ("dry_run=true&dry_run=false", "dry_run=1&x=2", "format=csv&format=json"):
        toll.require(siege.post(f"/v1/plans?{query}", plan, toll), 422, 400)
    return toll


def times(siege: Siege) -> Toll:
    """That RFC 3339 doesn't have, wherever a time goes."""
    return _texts(siege, NO_TIMES, lambda _, text: text[:2] == "20" and text.endswith("Z"))


def _texts(siege: Siege, texts: tuple[str, ...], goes: Callable[[tuple, str], bool]) -> Toll:
    """Each text in each place of the worked requests where it goes."""
    toll = Toll()
    for path, body in _worked():
        for where, value in _leaves(body):
            if not (isinstance(value, str) and goes(where, value)):
                continue
            for text in texts:
                answer = siege.post(path, _with(body, where, text), toll)
                toll.require(answer, 422, 413)
                toll.require_short(answer, ANSWER_BYTES_MAX)
    return toll


def extremes(siege: Siege) -> Toll:
    """Each number of each worked request, far outside what it can be."""
    toll = Toll()
    for path, body in _worked():
        for where, value in _leaves(body):
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            for number in EXTREMES:
                siege.post(path, _with(body, where, number), toll)
    siege.require_no_bug_in_jobs(toll)
    return toll


def named_cases(siege: Siege) -> Toll:
    """Requests that once took minutes or found a bug."""
    toll = Toll()
    for case in sorted(CASES.glob("*.json")):
        siege.post("/v1/plans", json.loads(case.read_bytes()), toll)
    siege.require_no_bug_in_jobs(toll)
    return toll


def heads(siege: Siege) -> Toll:
    """Wherever GET is, with the same headers and no body."""
    toll = Toll()
    for path, methods in siege.get("/openapi.json", toll).json()["paths"].items():
        if "get" in methods:
            known = path.replace("{", "").replace("}", "")
            asked = siege.get(known, toll)
            answer = siege.ask("HEAD", known, toll)
            toll.require(answer, asked.status_code)
            if answer.content:
                toll.complain(f"HEAD {known} answers a body")
    return toll


def deletes(siege: Siege) -> Toll:
    """Of twenty that ask at the same time one has deleted it."""
    toll = Toll()
    for _ in range(5):
        plan = siege.post("/v1/plans", LAS_VEGAS, toll).json()
        siege.wait_for_jobs()
        answers = siege.at_once("DELETE", f"/v1/plans/{plan['id']}", 20, toll)
        gone = sum(answer.status_code == 204 for answer in answers)
        if gone != 1:
            toll.complain(f"{gone} of 20 answered 204")
    return toll


def _worked() -> list[tuple[str, dict[str, object]]]:
    """A worked request of each kind that is JSON alone."""
    kinds = (
        ("/v1/plans", PLAN_EXAMPLES),
        ("/v1/opportunities", OPPORTUNITY_EXAMPLES),
        ("/v1/campaigns", CAMPAIGN_EXAMPLES),
        ("/v1/spacecraft/plans", SPACECRAFT_EXAMPLES),
    )
    return [(path, next(iter(examples.values()))[1]) for path, examples in kinds]


def _leaves(node: object, where: tuple[str | int, ...] = ()) -> Iterator[tuple[tuple, object]]:
    """Every value that is no object and no list; of long lists the first two."""
    if isinstance(node, dict):
        for name, value in node.items():
            yield from _leaves(value, (*where, name))
    elif isinstance(node, list | tuple):
        for number, value in enumerate(itertools.islice(node, 2)):
            yield from _leaves(value, (*where, number))
    else:
        yield where, node


def _with(body: dict[str, object], where: tuple[str | int, ...], value: object) -> object:
    changed = json.loads(json.dumps(body))
    place = changed
    for step in where[:-1]:
        place = place[step]
    place[where[-1]] = value
    return changed


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
