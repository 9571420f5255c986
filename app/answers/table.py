"""A plan's table by itself, as one of the formats that it is exported in has it."""

from typing import Any

from pydantic import BaseModel

from app.answers.ranges import NotNegative


class TableAlone(BaseModel, extra="allow"):
    """The table by itself, as `format=json` asks: a list per column, and what they mean.

    name: of the plan, as its request gives it.
    epoch: of row 0; UTC.
    step_s: from row to row.
    t_s: of each row, since the epoch.
    description: frames, units and the interpolation.
    """

    name: str
    epoch: str
    step_s: NotNegative
    t_s: list[NotNegative]
    description: dict[str, Any]
