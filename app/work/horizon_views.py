"""Predicted views of horizon cameras, and the sessions of a plan that they can check."""

from collections.abc import Callable, Sequence
from datetime import datetime

import numpy as np

from app.answers.horizon import PredictionResponse
from app.answers.members import ProvenanceOut, to_json
from app.requests.horizon import ATTITUDE_SIGMA_DEG, PredictionRequest
from estimator.camera import HorizonCamera
from estimator.found import HorizonCheck, HorizonView
from estimator.request import Body, HorizonRequest, Position
from estimator.surroundings import Surroundings
from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.base.rotation import Rotation
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, tai_us, utc_text
from planner.world.orbits import Orbit, OrbitStates
from planner.world.plan import FlightPlan

SEEN_AT = (0.0, 0.5, 1.0)  # shares of a session


def attitudes_at(
    orbit: Orbit,
    q_body_from_eci: Callable[[Instants, OrbitStates], Rotation],
    moments: Sequence[datetime],
) -> tuple[Array, Rotation, tuple[str, ...]]:
    """r_sat_eci_m (n, 3) and q_body_from_eci (n) at any n moments, and the orbit's warnings.

    Raises OutsideCoverage.
    """
    first = min(moments, key=tai_us)
    t_s, place = np.unique([elapsed_s(moment, first) for moment in moments], return_inverse=True)
    instants = Instants(first, t_s)
    ephemeris = orbit.ephemeris(first, max(moments, key=tai_us))
    states = ephemeris.states(instants)
    turned = q_body_from_eci(instants, states)
    return states.r_sat_eci_m[place], turned[place], ephemeris.warnings


def surroundings(
    moment: datetime, r_sat_eci_m: Array, cameras: tuple[HorizonCamera, ...], body: Body
) -> Surroundings:
    """The limb and the Sun as seen from there; raises InvalidInput inside the body."""
    x, y, z = (r_sat_eci_m / 1e3).tolist()
    position = Position(frame="GCRF", position_km=(x, y, z))
    try:
        HorizonRequest(epoch=moment, position=position, cameras=cameras, body=body)
    except ValueError as error:
        raise InvalidInput(f"at {utc_text(moment)} {error}", field="body", at_utc=moment) from None
    return Surroundings(moment, position, body)


def _views(
    r_sat_eci_m: Array,
    q_body_from_eci: Rotation,
    cameras: tuple[HorizonCamera, ...],
    moments: Sequence[datetime],
    body: Body,
    attitude_sigma_deg: float,
) -> list[HorizonView]:
    """Moment by moment every camera's, from (n, 3) positions with n attitudes."""
    from estimator.prediction import predict_horizon

    found = []
    for moment, r_m, q in zip(moments, r_sat_eci_m, q_body_from_eci, strict=True):
        around = surroundings(moment, r_m, cameras, body)
        found += [predict_horizon(camera, around, q, attitude_sigma_deg) for camera in cameras]
    return found


def prediction_json(request: PredictionRequest, provenance: ProvenanceOut) -> bytes:
    """The whole answer as UTF-8 JSON."""
    law, moments = request.attitude, request.instants
    r_m, q, warnings = attitudes_at(request.orbit, law.q_body_from_eci, moments)
    found = _views(r_m, q, request.cameras, moments, request.body, request.attitude_sigma_deg)
    since_s = np.array([elapsed_s(moment, moments[0]) for moment in moments])
    warnings = (*warnings, *law.warnings_at(Instants(moments[0], since_s)))
    told = list(dict.fromkeys(warnings))
    return to_json(PredictionResponse(views=found, warnings=told, provenance=provenance))


def horizon_checks(plan: FlightPlan, cameras: tuple[HorizonCamera, ...]) -> list[HorizonCheck]:
    """Session by session every camera's part; none without cameras."""
    if not cameras:
        return []
    scenario = plan.scenario
    moments = [
        shifted_utc(session.start, share * elapsed_s(session.stop, session.start))
        for session in scenario.sessions
        for share in SEEN_AT
    ]
    r_m, q, _ = attitudes_at(scenario.orbit, plan.q_body_from_eci, moments)
    seen = _views(r_m, q, cameras, moments, Body(), ATTITUDE_SIGMA_DEG)
    count = len(cameras)
    per_session = len(SEEN_AT) * count
    return [
        _check(number, seen[number * per_session + k : (number + 1) * per_session : count])
        for number in range(len(scenario.sessions))
        for k in range(count)
    ]


def _check(session: int, seen: list[HorizonView]) -> HorizonCheck:
    worst = next((view for view in seen if not view.usable), seen[0])
    return HorizonCheck(
        session=session,
        camera=worst.camera,
        usable=worst.usable,
        reason=worst.reason,
        explanation=worst.explanation,
        views=tuple(seen),
    )
