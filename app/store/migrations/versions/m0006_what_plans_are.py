"""What each job is of, to be listed and found by; the same in each plan; searches that are kept."""

import json
import unicodedata
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa
from alembic import op

from app.store.columns import PlainText, UtcDateTime

revision = "0006"
down_revision = "0005"

_CHARACTERS_MAX, _TARGETS_LISTED = 200, 20
_HIDDEN, _JOINERS = {"Cc", "Cf", "Cs", "Zl", "Zp"}, "\u200c\u200d"
_ADDED: dict[str, Any] = {
    "platform": PlainText(),
    "start_utc": UtcDateTime(),
    "stop_utc": UtcDateTime(),
    "targets": sa.JSON(none_as_null=True),
    "target_count": sa.Integer(),
    "probability_in_frame": sa.Double(),
    "words": PlainText(),
    "target_words": PlainText(),
}
_JOBS = sa.table(
    "jobs",
    *(sa.column(name) for name in ("id", "kind", "name")),
    sa.column("request", sa.LargeBinary()),
    sa.column("options", sa.JSON()),
    *(sa.column(name, kind) for name, kind in _ADDED.items()),
)
_PLANS = sa.table("plans", sa.column("id"), sa.column("document", sa.LargeBinary()))


def upgrade() -> None:
    """Add the columns and fill them, one job at a time; names of now are shorter and all visible.

    A plan's document gains what its request and it have said already: nothing else of it changes.
    """
    for name, kind in _ADDED.items():
        op.add_column("jobs", sa.Column(name, kind))
    op.create_table(
        "searches",
        sa.Column("id", sa.String(36), nullable=False),
        sa.Column("head", sa.LargeBinary(), nullable=False),
        sa.Column("window_count", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(["id"], ["jobs.id"], name="fk_searches_id", ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("id", name="pk_searches"),
    )
    op.create_table(
        "search_pages",
        sa.Column("search_id", sa.String(36), nullable=False),
        sa.Column("number", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("windows", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(
            ["search_id"], ["searches.id"], name="fk_search_pages_search_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("search_id", "number", name="pk_search_pages"),
    )
    jobs = op.get_bind().scalars(sa.select(_JOBS.c.id)).all()
    if jobs:
        with _plans_may_change():
            for job_id in jobs:
                _tell_of(job_id)


def _tell_of(job_id: str) -> None:
    connection, this = op.get_bind(), _JOBS.c.id == job_id
    job = connection.execute(
        sa.select(*(_JOBS.c[name] for name in ("kind", "name", "request", "options"))).where(this)
    ).one()
    request = _object(zlib.decompress(job.request))
    plan = connection.scalar(sa.select(_PLANS.c.document).where(_PLANS.c.id == job_id))
    document = _object(b"{}" if plan is None else zlib.decompress(plan))
    name = _visible(job.name)
    columns = _columns(name, request, document, job)
    connection.execute(sa.update(_JOBS).where(this).values(name=name, **columns))
    summary_of = {"plan": _summary, "spacecraft": _imaging_summary}.get(job.kind)
    if summary_of is not None and plan is not None and "summary" not in document:
        summary = summary_of(name, request, document, columns)
        told = {**document, "summary": summary}
        packed = zlib.compress(json.dumps(told).encode())
        connection.execute(sa.update(_PLANS).where(_PLANS.c.id == job_id).values(document=packed))


def _columns(
    name: str, request: dict[str, Any], document: dict[str, Any], job: sa.Row[Any]
) -> dict[str, Any]:
    platform, (start, stop) = _platform(request), _times(request, document)
    targets = list(dict.fromkeys(filter(None, map(_visible, _targets(request, job)))))
    told = [one["probability_in_frame"] for one in document.get("uncertainty", ())]
    return {
        "platform": platform,
        "start_utc": _utc(start),
        "stop_utc": _utc(stop),
        "targets": targets[:_TARGETS_LISTED],
        "target_count": len(targets),
        "probability_in_frame": min(told, default=None),
        "words": "\n".join((name, platform, *targets)).casefold(),
        "target_words": "\n".join(targets).casefold(),
    }


def _summary(
    name: str, request: dict[str, Any], document: dict[str, Any], columns: Mapping[str, Any]
) -> dict[str, Any]:
    told = {one["session"]: one["probability_in_frame"] for one in document.get("uncertainty", ())}
    sessions = [
        {
            "session": number,
            "id": None,
            "name": None,
            "mode": asked["target"]["mode"],
            "target": _label(asked["target"]),
            "start": start,
            "stop": stop,
            "best_elevation_deg": None,
            "best_at": None,
            "probability_in_frame": told.get(number),
        }
        for number, (asked, (start, stop)) in enumerate(
            zip(request["sessions"], _session_times(request, document), strict=True)
        )
    ]
    return {
        "name": name,
        "platform": columns["platform"],
        "targets": columns["targets"],
        "start": sessions[0]["start"],
        "stop": sessions[-1]["stop"],
        "probability_in_frame": columns["probability_in_frame"],
        "sessions": sessions,
    }


def _imaging_summary(
    name: str, request: dict[str, Any], document: dict[str, Any], columns: Mapping[str, Any]
) -> dict[str, Any]:
    def told(one: Mapping[str, Any]) -> dict[str, Any]:
        looks = [look for look in document["windows"] if look["request"] == one["name"]]
        return {
            "request": one["name"],
            "mode": one["mode"],
            "looks": len(looks),
            "start": min((look["start"] for look in looks), default=None),
            "stop": max((look["stop"] for look in looks), default=None),
        }

    return {
        "name": name,
        "platform": columns["platform"],
        "targets": columns["targets"],
        "start": request["start"],
        "stop": request["stop"],
        "requests": [told(one) for one in _imaging_requests(request)],
    }


def _imaging_requests(request: Mapping[str, Any]) -> list[dict[str, Any]]:
    """As fields, also of a FeatureCollection."""
    requests = request.get("requests", [])
    if isinstance(requests, dict):
        return [feature["properties"] for feature in requests["features"]]
    return list(requests)


def _object(text: bytes) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except ValueError:  # of a job that was never read
        return {}
    return found if isinstance(found, dict) else {}


def _platform(request: Mapping[str, Any]) -> str:
    platform = request.get("platform", request.get("spacecraft", ""))
    return _visible(platform["name"] if isinstance(platform, dict) else platform)


def _session_times(
    request: Mapping[str, Any], document: Mapping[str, Any]
) -> list[tuple[str, str]]:
    """As planned where they are told, else as asked for."""
    planned = {one["session"]: one for one in document.get("pointing", ())}
    return [
        (one["start"], one["stop"])
        for one in (planned.get(k, asked) for k, asked in enumerate(request["sessions"]))
    ]


def _times(
    request: Mapping[str, Any], document: Mapping[str, Any]
) -> tuple[str | None, str | None]:
    if sessions := request.get("sessions"):
        times = _session_times({"sessions": sessions}, document)
        return times[0][0], times[-1][1]
    return request.get("start"), request.get("stop")


def _targets(request: Mapping[str, Any], job: sa.Row[Any]) -> Iterator[str]:
    part: Mapping[str, Any] = (job.options or {}).get("campaign", {})
    if part:
        yield from (look["target"] for look in part["looks"])
        return
    yield from (_label(session["target"]) for session in request.get("sessions", ()))
    yield from (one["id"] for one in request.get("targets", ()))
    yield from (one["name"] for one in _imaging_requests(request))


def _label(target: Mapping[str, Any]) -> str:
    match target["mode"]:
        case "ground":
            return _place(target)
        case "ground_moving":
            return f"moving from {_place(target)}"
        case "ground_path":
            points: Sequence[Mapping[str, Any]] = target["points"]
            return f"path from {_place(points[0])} to {_place(points[-1])}"
        case "star" if target.get("hip") is not None:
            return f"HIP {target['hip']}"
        case "star":
            return f"RA {target['ra_deg']:.4f}, Dec {target['dec_deg']:.4f}"
        case "body":
            return str(target["name"])
    return ""


def _place(point: Mapping[str, Any]) -> str:
    return f"{point['latitude_deg']:.4f}, {point['longitude_deg']:.4f}"


def _visible(text: str) -> str:
    kept = (c for c in text if unicodedata.category(c) not in _HIDDEN or c in _JOINERS)
    return "".join(kept)[:_CHARACTERS_MAX]


def _utc(text: str | None) -> datetime | None:
    """A leap second as the second before it: lists need no more."""
    if text is None:
        return None
    return datetime.fromisoformat(text.upper().replace(":60", ":59", 1)).astimezone(UTC)


@contextmanager
def _plans_may_change() -> Iterator[None]:
    """The database refuses it before and after."""
    if op.get_bind().dialect.name != "sqlite":
        op.execute("ALTER TABLE plans DISABLE TRIGGER plans_are_immutable")
        yield
        op.execute("ALTER TABLE plans ENABLE TRIGGER plans_are_immutable")
        return
    op.execute("DROP TRIGGER plans_are_immutable")
    yield
    op.execute(
        "CREATE TRIGGER plans_are_immutable BEFORE UPDATE ON plans "
        "BEGIN SELECT RAISE(ABORT, 'plans are immutable'); END"
    )
