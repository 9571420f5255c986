"""The answer to an imaging session: degrees, UTC text and plain numbers."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.answers.members import (
    PlanHead,
    ProvenanceOut,
    degrees_of,
    fill,
    new_head,
    to_json,
    whole_answer,
)
from planner.export.table_states import continuous
from planner.frames.time_scales import shifted_utc, utc_text
from planner.spacecraft.flight.stabilisation import StabilisationReport, WindowSteadiness
from planner.spacecraft.imaging.choice_with_turns import LeftOut
from planner.spacecraft.imaging.timeline import PlannedTurn
from planner.spacecraft.plan import ImagingPlan
from planner.spacecraft.table import TICK_S, AttitudeTable
from planner.spacecraft.verification import SpacecraftVerification, VerifiedWindow

QUATERNION_DECIMALS = 13


@dataclass(frozen=True, kw_only=True)
class AttitudeTableOut:
    """One row per 0.2 s; vectors as [x, y, z] in body axes, gimbals 1 to 4.

    Between rows the attitude is the quintic Hermite in modified Rodrigues parameters, and
    gimbal rates are held.
    """

    epoch: str
    step_s: float
    t_s: list[float]
    q_body_from_eci_xyzw: list[list[float]]
    omega_body_deg_s: list[list[float]]
    alpha_body_deg_s2: list[list[float]]
    gimbal_deg: list[list[float]]
    gimbal_rate_deg_s: list[list[float]]


@dataclass(frozen=True, kw_only=True)
class ImagingWindowOut:
    """One stretch with the camera on, as the judge finds it on the ground.

    look: which strip, look or leg of the request, from 0.  speed_spread: largest deviation
    from the speed asked for, relative.  drift_deg: between the detector's columns and the
    image's motion.  miss_m: of the scanned line from that asked for.
    """

    request: str
    look: int
    start: str
    stop: str
    first_row: int
    last_row: int
    scan_speed_m_s: float
    speed_spread: float
    drift_deg: float
    miss_m: float
    along_deg: float
    across_deg: float


@dataclass(frozen=True, kw_only=True)
class TurnOut:
    """One turn beside its baselines at the same limits.

    onto: number of the window it leads to, null for orbital orientation.  eigenaxis_s: least
    time about the Euler axis with the same torque and torque rate; bang_coast_bang_s: the
    paper's, with any torque rate.  time_from: of a `minimum_time` turn, what found the least time
    it was given: `ocp`, or `eigenaxis` where no shorter turn than that was found; null for turns
    that take the time there is.
    """

    start: str
    stop: str
    onto: int | None
    angle_deg: float
    duration_s: float
    eigenaxis_s: float
    bang_coast_bang_s: float
    torque_rate_peak_n_m_s: float
    eigenaxis_torque_rate_peak_n_m_s: float
    method: str
    time_from: Literal["ocp", "eigenaxis"] | None
    status: str
    solve_s: float


@dataclass(frozen=True, kw_only=True)
class ImagingChoiceOut:
    """How good the choice among the requests is: no choice is worth more than `bound`."""

    value: float
    bound: float
    proven_optimal: bool
    greedy_value: float


@dataclass(frozen=True, kw_only=True)
class SpacecraftVerificationOut:
    """The verdict of a judge that sees the table and the request only; extremes between rows."""

    passed: bool
    findings: list[str]
    rate_max_deg_s: list[float]
    torque_max_n_m: float
    momentum_max_n_m_s: float
    gimbal_rate_max_deg_s: float
    gimbal_margin: float
    momentum_mismatch_n_m_s: float


@dataclass(frozen=True, kw_only=True)
class SteadinessOut:
    """One imaging interval over all dispersed closed-loop runs.

    rate_error_deg_s: largest per body axis; steady: within 0.001 deg/s on every axis in every
    run.  settled_s: from the end of the interval before until steady for good; spare_s: from
    then to the start, negative when the camera starts too early.  smear_px: over one exposure.
    """

    request: str
    look: int
    steady: bool
    rate_error_deg_s: list[float]
    rate_error_rms_deg_s: float
    pointing_error_deg: float
    settled_s: float
    spare_s: float
    smear_px: float
    momentum_margin_n_m_s: float
    gimbal_margin: float
    gimbal_rate_max_deg_s: float


@dataclass(frozen=True, kw_only=True)
class StabilisationOut:
    """Closed-loop runs of the table; share_steady: of intervals times runs."""

    runs: int
    share_steady: float | None
    worst_deg_s: float | None
    windows: list[SteadinessOut]


@dataclass(frozen=True, kw_only=True)
class SpacecraftPlanDocument:
    """What is known of a session beside its table."""

    name: str
    spacecraft: str
    windows: list[ImagingWindowOut]
    left_out: list[LeftOut]
    choice: ImagingChoiceOut
    turns: list[TurnOut]
    verification: SpacecraftVerificationOut
    stabilisation: StabilisationOut
    assumptions: list[str]
    warnings: list[str]
    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class SpacecraftPlanResponse(PlanHead, SpacecraftPlanDocument):
    """A session of the imaging spacecraft and the judge's verdict on it.

    assumptions: what the numbers rest on that the paper doesn't give.
    """

    table: AttitudeTableOut


@dataclass(frozen=True, kw_only=True)
class SpacecraftDryRunResponse:
    """The request can be read; nothing was planned."""

    valid: Literal[True]
    name: str
    spacecraft: str
    requests: int
    provenance: ProvenanceOut


def spacecraft_plan_json(plan: ImagingPlan, provenance: ProvenanceOut) -> bytes:
    """The whole answer as UTF-8 JSON, under a new id."""
    document = spacecraft_document(plan, provenance)
    return whole_answer(new_head("done"), document, attitude_table_json(plan.table))


def spacecraft_document(plan: ImagingPlan, provenance: ProvenanceOut) -> bytes:
    """A SpacecraftPlanDocument as UTF-8 JSON."""
    return to_json(
        SpacecraftPlanDocument(
            name=plan.request.name,
            spacecraft=plan.spacecraft.name,
            windows=[_window(found, plan.table) for found in plan.verification.windows],
            left_out=list(plan.left_out),
            choice=fill(ImagingChoiceOut, plan.choice),
            turns=[_turn(turn, plan.table) for turn in plan.turns],
            verification=_verification(plan.verification),
            stabilisation=_stabilisation(plan.stabilisation),
            assumptions=list(plan.assumptions),
            warnings=list(plan.warnings),
            provenance=provenance,
        )
    )


def row_text(table: AttitudeTable, row: int) -> str:
    """UTC of a row to a tenth of a second."""
    return utc_text(shifted_utc(table.epoch_utc, row * TICK_S), 1)


def attitude_table_json(table: AttitudeTable) -> bytes:
    """An AttitudeTableOut as UTF-8 JSON."""
    q_body_from_eci_xyzw = continuous(table.q_body_from_eci)
    return to_json(
        AttitudeTableOut(
            epoch=utc_text(table.epoch_utc, 1),
            step_s=TICK_S,
            t_s=table.t_s.tolist(),
            q_body_from_eci_xyzw=np.round(q_body_from_eci_xyzw, QUATERNION_DECIMALS).tolist(),
            omega_body_deg_s=degrees_of(table.omega_body_rad_s),
            alpha_body_deg_s2=degrees_of(table.alpha_body_rad_s2),
            gimbal_deg=degrees_of(table.gimbal_rad),
            gimbal_rate_deg_s=degrees_of(table.gimbal_rate_rad_s),
        )
    )


def _window(window: VerifiedWindow, table: AttitudeTable) -> ImagingWindowOut:
    return fill(
        ImagingWindowOut,
        window,
        window.window,
        start=row_text(table, window.window.first_row),
        stop=row_text(table, window.window.last_row),
    )


def _turn(turn: PlannedTurn, table: AttitudeTable) -> TurnOut:
    return fill(
        TurnOut,
        turn.comparison,
        start=row_text(table, turn.first_row),
        stop=row_text(table, turn.last_row),
        onto=turn.window,
    )


def _verification(verdict: SpacecraftVerification) -> SpacecraftVerificationOut:
    return fill(
        SpacecraftVerificationOut,
        verdict,
        rate_max_deg_s=verdict.rate_deg_s.tolist(),
        torque_max_n_m=verdict.torque_n_m,
        momentum_max_n_m_s=verdict.momentum_n_m_s,
        gimbal_rate_max_deg_s=verdict.gimbal_rate_deg_s,
    )


def _stabilisation(report: StabilisationReport) -> StabilisationOut:
    return fill(
        StabilisationOut, report, windows=[_steadiness(window) for window in report.windows]
    )


def _steadiness(worst: WindowSteadiness) -> SteadinessOut:
    return fill(
        SteadinessOut,
        worst,
        worst.window,
        rate_error_deg_s=np.degrees(worst.rate_error_rad_s).tolist(),
        rate_error_rms_deg_s=math.degrees(worst.rms_rad_s),
        gimbal_rate_max_deg_s=math.degrees(worst.gimbal_rate_rad_s),
    )
