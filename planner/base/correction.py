"""A measured correction of an attitude, as answers hold it and the next request takes it."""

from dataclasses import dataclass

from planner.base.answer_members import Signed


@dataclass(frozen=True, kw_only=True)
class CorrectionOut:
    """The measured turn of the body from the predicted one, as `attitude.corrections` of a plan
    takes it where the attitude predicted is that of its law.

    epoch: time of the measurement; UTC.
    turn_body_deg: the rotation vector from the predicted body to the measured one, body axes.
    covariance_deg2: of its components; 180 deg about nadir, which was not measured.
    """

    epoch: str
    turn_body_deg: list[Signed]
    covariance_deg2: list[list[Signed]]
