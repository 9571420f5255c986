"""The spacecraft that mechanics and Basilisk are compared with: nothing of it is dispersed."""

import dataclasses

from planner.inflight.simulation.gyros.dispersed import as_designed


def nominal(craft):
    """The spacecraft as designed, without noise."""
    return dataclasses.replace(as_designed(craft, 0), noise=False)
