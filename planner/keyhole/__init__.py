"""Tracking as near to a target as the limits allow where exact tracking would break one."""

from planner.keyhole.track import tracks_near

__all__ = ["tracks_near"]
