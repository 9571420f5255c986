"""Cases of the spacecraft tests: a Sun-synchronous orbit and requests along its track."""

import imaging_cases
from imaging_cases import EPOCH, positions, session_request, sun_synchronous

from planner.spacecraft.requests import CorridorRequest, GeoLineString, StereoRequest, StripRequest

__all__ = ["EPOCH", "ORBIT", "area", "four_modes", "line", "positions", "session"]
ORBIT = sun_synchronous(640.0)


def line(t_s, half_km=30.0, across_km=0.0, azimuth_deg=0.0):
    ends = imaging_cases.line(ORBIT, t_s, half_km, across_km, azimuth_deg)
    return GeoLineString(coordinates=ends)


def area(t_s, name="area"):
    return imaging_cases.area(ORBIT, t_s, name)


def four_modes():
    return (
        StripRequest(name="strip", priority=2.0, geometry=line(90.0, across_km=100.0)),
        StereoRequest(name="stereo", priority=4.0, geometry=line(230.0, across_km=-40.0)),
        CorridorRequest(name="corridor", priority=2.0, geometry=line(360.0, azimuth_deg=45.0)),
        area(480.0),
    )


def session(requests, seconds, **more):
    return session_request(ORBIT, seconds, tuple(requests), **more)
