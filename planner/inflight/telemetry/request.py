"""The request to compare telemetry with a plan."""

from collections.abc import Mapping
from dataclasses import field
from datetime import datetime
from typing import Annotated

from pydantic import Field

from planner.base.spec import Within, spec
from planner.inflight.telemetry.samples import OPTIONS, ImageOffset
from planner.world.attitude.corrections import Corrections

_Second = Annotated[float, Within(-OPTIONS.tag_max_s, OPTIONS.tag_max_s)] | None


@spec
class TelemetrySamples:
    """Time tags by the telemetry's own clock, and per axis NAME of the platform a column of angles
    (`NAME_deg`), of rates (`NAME_rate_deg_s`) or both; of a body its attitude's quaternion (`q_1`
    to `q_4`), its rates (`omega_body_deg_s_x`, `_y`, `_z`) or both.

    Rows may be in any order, doubled, damaged or missing; null is no value. What was done with
    them is told.

    epoch: from which t_s counts; unless given, the plan's; UTC. E.g. `"2015-02-27T17:34:00Z"`.
    t_s: time tags, at most 400,000, which take 20 s of a processor; where JSON of so many is too
    long for a request, send CSV by multipart. E.g. `[100.0, 100.2, 100.4]`.
    utc: time tags instead of t_s; UTC. E.g. `["2015-02-27T17:35:40.000Z"]`.
    """

    epoch: datetime | None = None
    t_s: tuple[_Second, ...] = ()
    utc: tuple[str, ...] = ()


@spec
class ComparisonRequest:
    """Telemetry of the axes while a plan was flown, with corrections and image offsets of the same
    time.

    plan: id of the plan that was flown. E.g. `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    columns: names of columns that the samples call otherwise, by what they hold: t_s, utc, unix_s,
    an axis's NAME_deg, NAME_rate_deg_s or the like in its own unit, or a body's q_1. E.g.
    `{"t_s": "Time", "alpha_arcsec": "AZ encoder"}`.
    corrections: measured rotations of the carrier of two axes during the plan, each as a horizon
    estimate answers its `correction`. E.g. `[{"epoch": "2015-02-27T17:37:00Z", "turn_body_deg":
    [0.25, 0.05, 0.0], "covariance_deg2": [[4e-4, 0.0, 0.0], [0.0, 4e-4, 0.0],
    [0.0, 0.0, 32400.0]]}]`.
    image_offsets: positions of the target in frames of the session of two axes. E.g.
    `[{"epoch": "2015-02-27T17:37:00Z", "offset_deg": [0.12, -0.05], "sigma_deg": 0.001}]`.
    identify: parameters of the platform's drives to find, each `axis.field`, of plans up to 600 s;
    it takes 15 to 30 s of a processor. E.g. `["alpha.coulomb_deg_s2", "beta.coulomb_deg_s2"]`.
    """

    plan: str
    samples: TelemetrySamples | None = None
    columns: Annotated[Mapping[str, str], Field(max_length=OPTIONS.json_columns_max)] = field(
        default_factory=dict
    )
    corrections: Corrections = ()
    image_offsets: Annotated[
        tuple[ImageOffset, ...], Field(max_length=OPTIONS.image_offsets_max)
    ] = ()
    identify: Annotated[tuple[str, ...], Field(max_length=OPTIONS.parameters_max)] = ()

    def __post_init__(self) -> None:
        if not self.plan:
            raise ValueError("plan is required: the id of the plan that was flown")
