"""Counts and timings of a running service, for Prometheus at /metrics.

One registry per application, so that two in one process don't count each other's requests.
Labels take few values whatever is sent: route templates, known methods, registered kinds.
"""

from collections.abc import Callable, Iterable, Mapping

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.registry import Collector

from app.versions import versions

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
UNMATCHED = "unmatched"

# Up to the longest deadline a solve has.
_SOLVE_BUCKETS_S = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0, 1800.0)
_HTTP_BUCKETS_S = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 60.0)
_ITERATION_BUCKETS = (5, 10, 20, 30, 50, 75, 100, 200, 500, 1000, 3000)

# (kind, state) -> how many
JobCounts = Mapping[tuple[str, str], int]


class Metrics:
    """All we count, and its text form."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        self.http_s = Histogram(
            "slewtrack_http_request_seconds",
            "Time from a request's head to the end of its answer",
            ("method", "route", "status"),
            buckets=_HTTP_BUCKETS_S,
            registry=self.registry,
        )
        self.http_in_flight = Gauge(
            "slewtrack_http_requests_in_flight", "Requests being answered", registry=self.registry
        )
        self.refusals = Counter(
            "slewtrack_refusals",
            "Answers above 399 by problem type; http-NNN for those of HTTP itself",
            ("type",),
            registry=self.registry,
        )
        self.solve_s = Histogram(
            "slewtrack_solve_seconds",
            "Time a job's work took in its child process, by kind and how it ended",
            ("kind", "state"),
            buckets=_SOLVE_BUCKETS_S,
            registry=self.registry,
        )
        self.iterations = Histogram(
            "slewtrack_solver_iterations",
            "Iterations of the slew solver over all slews of one plan",
            ("kind",),
            buckets=_ITERATION_BUCKETS,
            registry=self.registry,
        )
        build = Gauge(
            "slewtrack_build_info",
            "Always 1; the labels tell the versions at work",
            ("version", "python"),
            registry=self.registry,
        )
        build.labels(versions()["slewtrack"], versions()["python"]).set(1)

    def count_jobs_by(self, jobs: Callable[[], JobCounts]) -> None:
        """Ask `jobs` at each reading: the database knows, other services on it included."""
        self.registry.register(_Jobs(jobs))

    def count_answer(
        self, *, method: str, route: str, status: int, took_s: float, problem: str | None
    ) -> None:
        """One answer; `problem` is the problem's type, None for a good answer."""
        known = method if method in METHODS else "other"
        self.http_s.labels(known, route, str(status)).observe(took_s)
        if problem is not None:
            kind = problem.rsplit(":", 1)[-1]
            self.refusals.labels(f"http-{status}" if kind == "blank" else kind).inc()

    def text(self) -> bytes:
        """In Prometheus's text format."""
        return generate_latest(self.registry)


class _Jobs(Collector):
    """Jobs by kind and state, and those waiting, at the moment of reading."""

    def __init__(self, jobs: Callable[[], JobCounts]) -> None:
        self._jobs = jobs

    def collect(self) -> Iterable[GaugeMetricFamily]:
        counts = self._jobs()
        by_state = GaugeMetricFamily(
            "slewtrack_jobs", "Jobs in the database by kind and state", labels=("kind", "state")
        )
        for (kind, state), count in sorted(counts.items()):
            by_state.add_metric((kind, state), count)
        yield by_state
        waiting = sum(count for (_, state), count in counts.items() if state == "queued")
        yield GaugeMetricFamily("slewtrack_queue_depth", "Jobs nobody works on yet", value=waiting)

    def describe(self) -> Iterable[GaugeMetricFamily]:
        return ()
