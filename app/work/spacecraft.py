"""Imaging sessions of the spacecraft: the plan, its stored table, the answers."""

import json
import zlib
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime
from typing import Literal

import numpy as np

from app.answers.members import PlanHead, ProvenanceOut, provenance, to_json
from app.requests.plan import write_plan_request
from app.requests.spacecraft import read_spacecraft_request
from app.store.job import Listing
from app.store.packed import pack, unpack
from app.work.plan import packed_plan, plan_document, stored_table
from app.work.progress import report
from app.work.result import Result
from planner.base.answer_members import Count, DirectionPart, NotNegative, Signed
from planner.base.arrays import Array
from planner.base.commands import BODY_CHANNELS, COMMAND_STEP_S
from planner.base.rotation import Rotation, continuous
from planner.spacecraft.found import SessionFound
from planner.spacecraft.requests import ImagingPlanRequest
from planner.world.frames.time_scales import utc_text


@dataclass(frozen=True, kw_only=True)
class AttitudeTableOut:
    """One row per 0.2 s; vectors as [x, y, z] in body axes, gimbals 1 to 4.

    Between rows the attitude is the quintic Hermite in modified Rodrigues parameters, and gimbal
    rates are held.

    epoch: of row 0; UTC.
    step_s: from row to row.
    t_s: of each row, since the epoch.
    q_body_from_eci_xyzw: attitude, scalar last, `Rotation.from_quat(q).apply(v_eci)` gives
    `v_body`.
    omega_body_deg_s: body relative to ECI, in body axes.
    alpha_body_deg_s2: its derivative, in body axes.
    gimbal_deg: angles of the four gyros' gimbals.
    gimbal_rate_deg_s: rates of the four gyros' gimbals.
    """

    epoch: str
    step_s: NotNegative
    t_s: list[NotNegative]
    q_body_from_eci_xyzw: list[list[DirectionPart]]
    omega_body_deg_s: list[list[Signed]]
    alpha_body_deg_s2: list[list[Signed]]
    gimbal_deg: list[list[Signed]]
    gimbal_rate_deg_s: list[list[Signed]]


@dataclass(frozen=True, kw_only=True)
class SpacecraftPlanDocument(SessionFound):
    """What is known of a session beside its table."""

    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class SpacecraftPlanResponse(PlanHead, SpacecraftPlanDocument):
    """A session of the imaging spacecraft and the judge's verdict on it."""

    table: AttitudeTableOut


@dataclass(frozen=True, kw_only=True)
class SpacecraftDryRunResponse:
    """The request was planned, and nothing is kept of it.

    A session in which no request fits is refused as the plan itself would be.

    valid: always true; what isn't is refused.
    flies: always true: a session's table passed its verification.
    name: as the request gives it.
    spacecraft: the spacecraft's name.
    requests: number of requests.
    left_out: names of those that don't fit. E.g. `["Corridor"]`.
    warnings: cautions to read before flying it. E.g.
    `["the elements' epoch 2024-05-28T11:40:53Z is 3.9 days from the session"]`.
    """

    valid: Literal[True]
    flies: Literal[True]
    name: str
    spacecraft: str
    requests: Count
    left_out: list[str]
    warnings: list[str]
    provenance: ProvenanceOut


def listing_of_imaging(request: ImagingPlanRequest) -> Listing:
    return Listing(
        platform=request.spacecraft,
        start_utc=request.start,
        stop_utc=request.stop,
        targets=tuple(one.name for one in request.requests),
    )


def plan_and_pack_session(body: bytes, request: ImagingPlanRequest | None = None) -> Result:
    """Read unless that is done, plan, judge, fly and pack; raises a Refusal.

    It is stored as the plan of its body, beside the request for its sessions, which the body isn't.
    """
    from planner.spacecraft.plan import plan_imaging

    origin = provenance(datetime.now(UTC), body)
    plan = plan_imaging(request or read_spacecraft_request(body), report)
    whole = plan.whole
    asked = write_plan_request(whole.scenario, {"orbit": json.loads(body)["orbit"]}, ()).decode()
    packed = packed_plan(whole)
    told = {one.name: getattr(plan, one.name) for one in fields(SessionFound)}
    session = to_json(SpacecraftPlanDocument(**told, provenance=origin))
    document, session_document = map(zlib.compress, (plan_document(whole, (), origin), session))
    table_columns = pack(replace(packed, facts={**packed.facts, "request": asked}))
    return Result(
        content=(document, table_columns, session_document),
        listing=listing_of_imaging(plan.request),
        iterations=sum(run.iterations for run in whole.slews),
    )


def try_session(request: ImagingPlanRequest, provenance: ProvenanceOut) -> bytes:
    """The answer to a dry run: planned, judged and flown, nothing kept; raises a Refusal."""
    from planner.spacecraft.plan import plan_imaging

    plan = plan_imaging(request)
    return to_json(
        SpacecraftDryRunResponse(
            valid=True,
            flies=True,
            name=plan.name,
            spacecraft=plan.spacecraft,
            requests=len(request.requests),
            left_out=[one.name for one in plan.left_out],
            warnings=list(plan.warnings),
            provenance=provenance,
        )
    )


def stored_session_json(table_columns: bytes) -> bytes:
    """The table as the answer holds it."""
    table = stored_table(unpack(table_columns))
    q_body_from_eci_xyzw = continuous(Rotation.from_quat(table.position).inv())
    vectors: dict[str, list[Array]] = {}
    for one, value in table.columns:
        if one.of != "position":
            vectors.setdefault(one.name.rpartition("_")[0], []).append(value)
    return to_json(
        AttitudeTableOut(
            epoch=utc_text(table.epoch_utc, 1),
            step_s=COMMAND_STEP_S,
            t_s=table.t_s.tolist(),
            q_body_from_eci_xyzw=BODY_CHANNELS[0].told(q_body_from_eci_xyzw).tolist(),
            **{name: np.stack(parts, axis=1).tolist() for name, parts in vectors.items()},
        )
    )
