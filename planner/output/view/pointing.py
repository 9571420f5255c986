"""Pointing errors over time: planned and budgeted distance of the boresight from its targets."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import ROWS_PER_S
from planner.output.view.scene import PlanScene
from planner.output.view.targets import TargetTrack
from planner.planning.sessions.error_ellipse import error_covariance_rad2
from planner.planning.sessions.track_branches import session_rows, sight
from planner.world.scenario import Session
from planner.world.targets import VisibleTarget

INSTANTS = 31  # of a session: errors vary over a pass, not from row to row


@dataclass(frozen=True, kw_only=True, eq=False)
class PointingTrace:
    """The error in the sessions, each (n,); NaN outside and where no target is looked at.

    error_rad: angle between boresight and apparent target on the row.
    sigma_major_rad, sigma_minor_rad: half axes of the 1-sigma ellipse of the target's place in the
    image.  major_turn_rad: from the frame's first side towards its second, in [0, pi).
    """

    error_rad: Array
    sigma_major_rad: Array
    sigma_minor_rad: Array
    major_turn_rad: Array


_ELLIPSE = ("sigma_major_rad", "sigma_minor_rad", "major_turn_rad")
_COLUMNS = ("error_rad", *_ELLIPSE)


def pointing_trace(scene: PlanScene, targets: Sequence[TargetTrack]) -> PointingTrace:
    """Of each session's own target."""
    columns = {name: np.full(len(scene.rows.instants), np.nan) for name in _COLUMNS}
    for track in targets:
        session = scene.plan.scenario.sessions[track.session]
        inside = np.flatnonzero(track.in_session)
        columns["error_rad"][inside] = track.error_rad[inside]
        if len(inside) and isinstance(session.target, VisibleTarget):
            covariance_rad2 = _covariance_rad2(scene, session, session.target, inside)
            for name, values in zip(_ELLIPSE, _ellipse(covariance_rad2), strict=True):
                columns[name][inside] = values
    return PointingTrace(**columns)


def _covariance_rad2(
    scene: PlanScene, session: Session, target: VisibleTarget, inside: Indices
) -> Array:
    """At rows `inside`, linear between instants at which it is found, (k, 2, 2)."""
    scenario, table = scene.plan.scenario, scene.plan.table
    rows = session_rows(session, table.epoch_utc)
    los = sight(scenario, scene.rows.ephemeris, target, rows, INSTANTS)
    at_s = los.instants.t_s
    angle_rad = [np.interp(at_s, table.t_s, angle) for angle in table.angle_rad.T]
    found_rad2 = error_covariance_rad2(
        los,
        scene.rows.ephemeris,
        scenario.attitude,
        target,
        scenario.platform,
        np.stack(angle_rad, axis=1),
    )
    wanted_s = scene.rows.row[inside] / ROWS_PER_S
    parts = [np.interp(wanted_s, at_s, found_rad2[:, i, j]) for i, j in ((0, 0), (0, 1), (1, 1))]
    return np.stack([np.stack(parts[:2], -1), np.stack(parts[1:], -1)], axis=1)


def _ellipse(covariance_rad2: Array) -> tuple[Array, Array, Array]:
    """Half the major and the minor axis, and the turn of the major one, (n,) each."""
    a, b, c = covariance_rad2[:, 0, 0], covariance_rad2[:, 0, 1], covariance_rad2[:, 1, 1]
    middle, reach = (a + c) / 2.0, np.hypot((a - c) / 2.0, b)
    turn_rad = np.arctan2(2.0 * b, a - c) / 2.0 % np.pi
    return np.sqrt(middle + reach), np.sqrt(np.maximum(middle - reach, 0.0)), turn_rad
