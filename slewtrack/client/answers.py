"""The answers of a service as values: plans, tables, windows, campaigns, comparisons.

Each names what is needed most and is a mapping of all of its JSON, under the names of the API's
schema: `plan.passed`, `plan["margins"]`.  Numbers are the doubles that the JSON holds, nothing is
rounded or converted; units stand in the names.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from slewtrack.client.reading import Members

if TYPE_CHECKING:
    import pandas
    import xarray

Column = NDArray[Any]
# Of windows beyond edges and session, and why targets are never seen.
Include = Sequence[Literal["view", "probability", "reasons"]]
OPEN_STATES = ("queued", "running")


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far work is.

    state: queued, running, done, refused, failed or cancelled.  stage: what is being done now;
    done of `of` parts, or percent, where that is known.  Of a campaign's choice value: what the
    best so far is worth; bound: none is worth more.
    """

    state: str
    stage: str | None = None
    done: int | None = None
    of: int | None = None
    percent: float | None = None
    value: float | None = None
    bound: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Answer(Mapping[str, Any]):
    """An answer, equal to another of the same JSON; members: that, as `answer["name"]`, too."""

    members: Members = field(repr=False)

    def __getitem__(self, name: str) -> Any:  # noqa: ANN401 (whatever JSON holds)
        return self.members[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.members)

    def __len__(self) -> int:
        return len(self.members)


@dataclass(frozen=True, kw_only=True, eq=False)
class Job(Answer):
    """The work on a plan, campaign or flights, as it stands.

    problem: members of the reason why it was refused or failed, None otherwise.
    """

    id: str
    state: str
    name: str
    created: str = ""
    problem: Members | None = None

    @property
    def is_open(self) -> bool:
        return self.state in OPEN_STATES


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Columns(Mapping[str, Column]):
    """Arrays by name, whose first axis is the row; the names carry frame and unit.

    epoch: of `t_s` 0, UTC text.  facts: what isn't a column.
    """

    epoch: str
    arrays: Mapping[str, Column]
    facts: Members

    def __repr__(self) -> str:
        names = ", ".join(self.arrays)
        return f"Columns({len(self.t_s)} rows from {self.epoch}: {names})"

    @classmethod
    def of_json(cls, members: Members) -> "Columns":
        """Whatever holds lists as long as its `t_s`: they become arrays, the rest stays beside.

        What lies deeper has a name with dots: `carrier.latitude_deg`, `targets.0.azimuth_deg`.
        Raises one of MISREAD.
        """
        rows, epoch = len(members["t_s"]), members["epoch"]
        if not isinstance(epoch, str):
            raise TypeError
        np.datetime64(epoch.removesuffix("Z"), "ns")  # as `utc` does later
        lists = _lists(members, "")
        arrays = {name: _array(values) for name, values in lists if len(values) == rows}
        if arrays["t_s"].ndim != 1 or arrays["t_s"].dtype.kind != "f":
            raise TypeError
        facts = {name: value for name, value in members.items() if name not in arrays}
        return cls(epoch=epoch, arrays=arrays, facts=facts)

    def __getitem__(self, name: str) -> Column:
        return self.arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __len__(self) -> int:
        return len(self.arrays)

    @property
    def t_s(self) -> NDArray[np.float64]:
        """Seconds of each row since the epoch."""
        return self.arrays["t_s"]

    @property
    def utc(self) -> NDArray[np.datetime64]:
        """Time of each row, to the nanosecond."""
        epoch = np.datetime64(self.epoch.removesuffix("Z"), "ns")
        return epoch + np.round(self.t_s * 1e9).astype("timedelta64[ns]")

    def to_pandas(self) -> "pandas.DataFrame":
        """One row per instant, indexed by UTC; needs pandas.  Vectors become a column a part."""
        import pandas

        flat: dict[str, Column] = {}
        for name, values in self.arrays.items():
            if values.ndim == 1:
                flat[name] = values
            else:
                parts = values.reshape(len(values), -1).T
                flat |= {f"{name}_{part}": one for part, one in enumerate(parts)}
        return pandas.DataFrame(flat, index=pandas.DatetimeIndex(self.utc, tz="UTC", name="utc"))

    def to_xarray(self) -> "xarray.Dataset":
        """Along the dimension `t_s`, with `utc` beside it; needs xarray."""
        import xarray

        data = {
            name: (("t_s", *(f"{name}_{axis}" for axis in range(1, values.ndim))), values)
            for name, values in self.arrays.items()
            if name != "t_s"
        }
        plain = {k: v for k, v in self.facts.items() if isinstance(v, str | int | float)}
        return xarray.Dataset(data, coords={"t_s": self.t_s, "utc": ("t_s", self.utc)}, attrs=plain)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Plan(Answer):
    """A plan: its command table and the verdict of the verification.

    state: `done`; `failed` where its verification didn't pass, as the baseline's may.
    table: columns in degrees, `alpha_deg` and `alpha_rate_deg_s` per axis.
    """

    id: str
    state: str
    name: str
    revision: int
    warnings: tuple[str, ...]
    table: Columns

    @property
    def passed(self) -> bool:
        """Whether the independent verification found no error."""
        return self.state == "done"

    def __repr__(self) -> str:
        verdict = "passed" if self.passed else "FAILED its verification"
        warned = f", {len(self.warnings)} warnings" if self.warnings else ""
        return f"Plan({self.name!r}, {verdict}{warned}, {self.table!r}, id={self.id!r})"


@dataclass(frozen=True, kw_only=True, eq=False)
class Window(Answer):
    """When a target can be seen.

    session: the `start` and `stop` that a plan's session takes as they stand, None if too short.
    scan: of an imaging mode, which of its scans, and its `target` and `roll` for such a session.
    probability_in_frame: that the target stays in it over that session, None where not known.
    highest_deg: the carrier's greatest elevation.  closest: the view then, in degrees and
    kilometres, its members those of the API's schema.  Both only where the view was asked for.
    """

    target: str
    rise: datetime
    set: datetime
    highest_deg: float = math.nan
    session: Mapping[str, str] | None
    scan: Members | None = None
    probability_in_frame: float | None = None
    closest: Members = field(default_factory=dict, repr=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class Unseen(Answer):
    """A target that can't be seen; because: the condition that fails, closed_by: its name."""

    target: str
    closed_by: str
    because: str
    best_elevation_deg: float
    best_time: datetime

    def __str__(self) -> str:
        return f"{self.target} ({self.because})"


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Opportunities(Answer):
    """Windows in the order of the request's targets.

    id: under which the service keeps them.  count: of all there are.  unseen: targets without any.
    reasons: why, where they were asked for.
    """

    id: str
    count: int
    windows: tuple[Window, ...]
    unseen: tuple[str, ...]
    reasons: tuple[Unseen, ...] = ()
    warnings: tuple[str, ...]

    def __repr__(self) -> str:
        targets = dict.fromkeys(window.target for window in self.windows)
        unseen = f", unseen: {', '.join(self.unseen)}" if self.unseen else ""
        return f"Opportunities({len(self.windows)} windows of {', '.join(targets)}{unseen})"


@dataclass(frozen=True, kw_only=True, eq=False)
class Look(Answer):
    """A look at a target as a campaign chose it; times as UTC text."""

    target: str
    start: str
    stop: str
    value: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Pass(Answer):
    """Looks planned together; plan: id of their plan.  problem: why there is none.

    carrier: id of the one that flies it, of a campaign of several.
    """

    number: int
    plan: str
    state: str
    start: str
    stop: str
    looks: tuple[Look, ...]
    problem: Members | None = None
    carrier: str | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice(Answer):
    """The looks chosen together; value: their worth.  bound: no choice is worth more."""

    value: float
    bound: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Campaign(Answer):
    """A campaign with its passes, in order of time."""

    id: str
    state: str
    name: str
    choice: Choice = field(repr=False)
    passes: tuple[Pass, ...]

    @property
    def value(self) -> float:
        """Worth of the looks chosen."""
        return self.choice.value

    @property
    def bound(self) -> float:
        """No choice is worth more."""
        return self.choice.bound


@dataclass(frozen=True, kw_only=True, eq=False)
class Contributor(Answer):
    """A cause of the errors in flight; share: of their variance, by this cause and with others."""

    cause: str
    share: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Flights(Answer):
    """Flights of a plan, each with errors drawn anew.

    probability_in_frame: that every frame of every session holds its target.  probability_sharp:
    that each is smeared over less than a pixel, too.  contributors: causes of the errors, the
    largest first; sessions: the same of each.
    """

    id: str
    state: str
    flown: int
    probability_in_frame: float
    probability_sharp: float
    contributors: tuple[Contributor, ...]
    warnings: tuple[str, ...]
    sessions: tuple[Members, ...] = field(repr=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimate(Answer):
    """A number measured in flight, with its 1-sigma error; units stand in its member's name."""

    value: float
    sigma: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison(Answer):
    """Telemetry beside the plan that was flown.

    plan: id of the plan.  time_offset_s: by how much the telemetry's clock is ahead; clock_drift:
    by how much it gains, a share of time.  axes: by the axis's name, members of the API's schema.
    """

    plan: str
    time_offset_s: Estimate
    clock_drift: Estimate
    axes: Mapping[str, Members] = field(repr=False)
    warnings: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Check(Answer):
    """The request was planned and nothing is kept; flies: whether its verification passed."""

    flies: bool
    name: str
    warnings: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Vertical(Answer):
    """The local vertical in body axes; nadir_body: a unit vector, None where nothing was seen.

    verdict: of the attitude, by the images.  sigma_deg: rms of nadir's angle to the true one.
    reason: why nothing was measured, None where it was.
    """

    verdict: str
    reason: str | None = None
    nadir_body: tuple[float, ...] | None = None
    sigma_deg: float | None = None
    warnings: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Known(Answer):
    """A platform, place or star that a request can name."""

    name: str


def _lists(members: Members, prefix: str) -> Iterator[tuple[str, Sequence[Any]]]:
    for name, value in members.items():
        if isinstance(value, Mapping):
            yield from _lists(value, f"{prefix}{name}.")
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for number, one in enumerate(value):
                yield from _lists(one, f"{prefix}{name}.{number}.")
        elif isinstance(value, list):
            yield prefix + name, value


def _array(values: Sequence[Any]) -> Column:
    """Doubles, NaN for null; texts, flags and what has no common shape as they are."""
    try:
        array = np.array(values)
    except ValueError:  # rows of several lengths
        array = np.empty(len(values), dtype=object)
        array[:] = values
        return array
    if array.dtype == object and all(type(one) in (int, float, type(None)) for one in array.flat):
        return array.astype(np.float64)
    return array.astype(np.float64) if array.dtype.kind == "i" else array
