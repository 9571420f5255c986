"""Tracking as near to a target as the limits allow where exact tracking would break one."""

from planner.keyhole.track import nearest_track

__all__ = ["nearest_track"]
