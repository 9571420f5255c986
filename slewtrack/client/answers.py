"""The answers of a service as values: plans, tables, windows, campaigns.

What can't be read so raises one of `slewtrack.problems.MISREAD`.

Each names what is needed most and has the rest, under the names of the API's schema, in
`members`.  Numbers are the doubles that the JSON holds, nothing is rounded or converted.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas
    import xarray

Members = Mapping[str, Any]
Column = NDArray[Any]
OPEN_STATES = ("queued", "running")
_STATES = frozenset({*OPEN_STATES, "done", "refused", "failed", "cancelled"})
_ID = re.compile(r"[0-9A-Za-z-]{1,100}")


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far work is.

    state: queued, running, done, refused, failed or cancelled.  stage: what is being done now;
    done of `of` parts, or percent, where that is known.
    """

    state: str
    stage: str | None = None
    done: int | None = None
    of: int | None = None
    percent: float | None = None


@dataclass(frozen=True, kw_only=True)
class Job:
    """Where the work on a plan or campaign stands.

    problem: members of the reason why it was refused or failed, None otherwise.
    """

    id: str
    state: str
    name: str
    created: str
    problem: Members | None
    members: Members = field(repr=False)

    @property
    def is_open(self) -> bool:
        """Whether it waits or runs."""
        return self.state in OPEN_STATES


@dataclass(frozen=True, kw_only=True)
class Columns(Mapping[str, Column]):
    """Arrays by name, whose first axis is the row; the names carry frame and unit.

    epoch: of `t_s` 0, UTC text.  facts: what isn't a column.
    """

    epoch: str
    arrays: Mapping[str, Column] = field(repr=False)
    facts: Members = field(repr=False)

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


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A plan as the service keeps it.

    state: `done`; `failed` where its verification didn't pass, as the baseline's may.
    table: columns in degrees, `alpha_deg` and `alpha_rate_deg_s` per axis.
    """

    id: str
    state: str
    name: str
    revision: int
    passed: bool
    warnings: tuple[str, ...]
    table: Columns
    members: Members = field(repr=False)


@dataclass(frozen=True, kw_only=True)
class Window:
    """When a target can be seen.

    session: the `start` and `stop` that a plan's session takes as they stand, None if too short.
    """

    target: str
    rise: datetime
    set: datetime
    highest_deg: float
    session: Mapping[str, str] | None
    members: Members = field(repr=False)


@dataclass(frozen=True, kw_only=True)
class Opportunities:
    """Windows in the order of the request's targets.

    id: under which the service keeps them.  unseen: targets without any.
    """

    id: str
    windows: tuple[Window, ...]
    unseen: tuple[Any, ...]
    warnings: tuple[str, ...]
    members: Members = field(repr=False)


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """A campaign with its passes; each names its plan in `plan`, and its `looks`."""

    id: str
    state: str
    name: str
    value: float
    bound: float
    passes: tuple[Members, ...] = field(repr=False)
    members: Members = field(repr=False)


@dataclass(frozen=True, kw_only=True)
class Flights:
    """Flights of a plan, each with errors drawn anew.

    probability_in_frame: that every frame of every session holds its target.  probability_sharp:
    that each is smeared over less than a pixel, too.  contributors: causes, the most to blame
    first; sessions: the same of each.
    """

    id: str
    state: str
    flown: int
    probability_in_frame: float
    probability_sharp: float
    contributors: tuple[Members, ...]
    warnings: tuple[str, ...]
    sessions: tuple[Members, ...] = field(repr=False)
    members: Members = field(repr=False)


def id_of(members: Members) -> str:
    """Such as is put into an address."""
    if not _ID.fullmatch(members["id"]):
        raise ValueError
    return str(members["id"])


def state_of(members: Members) -> str:
    """One of those there are."""
    if members["state"] not in _STATES:
        raise ValueError
    return str(members["state"])


def _text(members: Members, name: str) -> str:
    if not isinstance(members[name], str):
        raise TypeError
    return str(members[name])


def objects_of(members: Members, name: str) -> list[Members]:
    """A list of objects, one after the other."""
    found = members[name]
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise TypeError
    return found


def job_of(members: Members) -> Job:
    """A JobResponse, an entry of a list."""
    return Job(
        id=id_of(members),
        state=state_of(members),
        name=_text(members, "name"),
        created=members.get("created", ""),
        problem=members.get("problem"),
        members=members,
    )


def columns_of(members: Members) -> Columns:
    """Whatever holds lists as long as its `t_s`: they become arrays, the rest stays beside.

    What lies deeper has a name with dots: `carrier.latitude_deg`, `targets.0.azimuth_deg`.
    """
    rows = len(members["t_s"])
    np.datetime64(_text(members, "epoch").removesuffix("Z"), "ns")  # as `utc` does later
    arrays = {name: _array(values) for name, values in _lists(members, "") if len(values) == rows}
    if arrays["t_s"].ndim != 1 or arrays["t_s"].dtype.kind != "f":
        raise TypeError
    facts = {name: value for name, value in members.items() if name not in arrays}
    return Columns(epoch=members["epoch"], arrays=arrays, facts=facts)


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
    if array.dtype == object and all(one is None or _is_number(one) for one in array.flat):
        return array.astype(np.float64)
    return array.astype(np.float64) if array.dtype.kind == "i" else array


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def plan_of(members: Members) -> Plan:
    """A PlanResponse, or the spacecraft's."""
    verification = members.get("verification") or {}
    return Plan(
        id=id_of(members),
        state=state_of(members),
        name=_text(members, "name"),
        revision=members["revision"],
        passed=verification.get("passed", members["state"] == "done"),
        warnings=tuple(members["warnings"]),
        table=columns_of(members["table"]),
        members=members,
    )


def opportunities_of(members: Members) -> Opportunities:
    """An OpportunitiesResponse."""
    return Opportunities(
        id=id_of(members),
        windows=tuple(map(window_of, objects_of(members, "windows"))),
        unseen=tuple(members["unseen"]),
        warnings=tuple(members["warnings"]),
        members=members,
    )


def window_of(members: Members) -> Window:
    """A window of a search, of the platform or the spacecraft."""
    return Window(
        target=members["target"],
        rise=datetime.fromisoformat(members["rise"]),
        set=datetime.fromisoformat(members["set"]),
        highest_deg=members["highest_deg"],
        session=members["session"],
        members=members,
    )


def campaign_of(members: Members) -> Campaign:
    """A CampaignResponse whose choice is made."""
    choice = members["choice"]
    return Campaign(
        id=id_of(members),
        state=state_of(members),
        name=_text(members, "name"),
        value=choice["value"],
        bound=choice["bound"],
        passes=tuple(objects_of(members, "passes")),
        members=members,
    )


def flights_of(members: Members) -> Flights:
    """A FlightsResponse of runs that are all flown."""
    return Flights(
        id=id_of(members),
        state=state_of(members),
        flown=members["flown"],
        probability_in_frame=members["probability_in_frame"],
        probability_sharp=members["probability_sharp"],
        contributors=tuple(objects_of(members, "contributors")),
        warnings=tuple(members["warnings"]),
        sessions=tuple(objects_of(members, "sessions")),
        members=members,
    )
