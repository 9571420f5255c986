"""Passes of the imaging spacecraft as rows of JSON."""

from datetime import datetime

import numpy as np

from planner.output.windows.rows import Column, pass_columns, spread, texts_of, times_of
from planner.planning.opportunities import WindowEdges
from planner.spacecraft.opportunities import PassEdges
from planner.spacecraft.opportunity_request import ImagingOpportunityRequest
from planner.spacecraft.table import TICK_S


def imaging_columns(
    request: ImagingOpportunityRequest, passes: WindowEdges, told: WindowEdges
) -> dict[str, Column]:
    """All that is told of passes, by name; told: the passes, or more of them."""
    assert isinstance(passes, PassEdges)
    asked = [request.requests[row] for row in passes.target]
    is_whole = np.flatnonzero(~np.isnan(passes.whole_from_s))
    whole = {
        "start": times_of(request.start, passes.whole_from_s[is_whole]),
        "stop": times_of(request.start, passes.whole_to_s[is_whole]),
    }
    return pass_columns(request.start, request.ids, ("along", "across"), told) | {
        "session": _sessions(request.start, passes),
        "mode": texts_of([one.mode for one in asked]),
        "geometry": texts_of([one.geometry for one in asked]),
        "whole": spread(is_whole, len(passes), whole),
    }


def _sessions(start_utc: datetime, passes: WindowEdges) -> Column:
    """On rows of a table, which begin on multiples of 0.2 s after the second."""
    # From orbital orientation to the farthest look and back: 54 deg at 1.58 deg/s about each axis,
    # the build-up of the rate and the settling beside it.
    turn_s = 60.0
    before_s = start_utc.microsecond / 1e6
    first = np.floor((passes.rise_s - turn_s + before_s) / TICK_S) * TICK_S - before_s
    last = np.ceil((passes.set_s + turn_s + before_s) / TICK_S) * TICK_S - before_s
    return {"start": times_of(start_utc, first, 1), "stop": times_of(start_utc, last, 1)}
