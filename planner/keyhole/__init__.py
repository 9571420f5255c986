"""How near to a target can the axes keep where following it exactly would break a limit?"""

from planner.keyhole.track import followed

__all__ = ["followed"]
