"""Stars that pass the outer axis at a chosen distance, for tests of keyholes."""

import math
from dataclasses import replace
from datetime import timedelta

import numpy as np

from planner.world.attitude import LvlhAttitude
from planner.world.frames.time_scales import Instants, utc_from_text
from planner.world.orbits import TleOrbit
from planner.world.platforms import ISS_HRC
from planner.world.scenario import InitialState, Scenario, Session
from planner.world.targets import StarTarget

EPOCH = utc_from_text("2015-02-27T17:34:00Z")
TLE = TleOrbit(
    line1="1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991",
    line2="2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964",
)
MIDDLE_S = 600.0


def passing_star(roll_deg, off_deg):
    """Nearest to the outer axis at MIDDLE_S; with the carrier rolled, the axis sweeps the sky."""
    attitude = LvlhAttitude(roll_deg=roll_deg)
    instants = Instants(EPOCH, MIDDLE_S + np.array([-1.0, 0.0, 1.0]))
    ephemeris = TLE.ephemeris(EPOCH, EPOCH + timedelta(seconds=2.0 * MIDDLE_S))
    q_body_from_eci = attitude.q_body_from_eci(instants, ephemeris.states(instants))
    axis = q_body_from_eci.inv().apply(ISS_HRC.axes_platform[0])
    aside = np.cross(axis[1], axis[2] - axis[0])
    off = math.radians(off_deg)
    star = math.cos(off) * axis[1] + math.sin(off) * aside / np.linalg.norm(aside)
    return StarTarget(
        ra_deg=math.degrees(math.atan2(star[1], star[0])) % 360.0,
        dec_deg=math.degrees(math.asin(star[2])),
    )


def keyhole_scenario(roll_deg, off_deg, *, before_s=150.0, after_s=150.0, platform=ISS_HRC):
    session = Session(
        target=passing_star(roll_deg, off_deg),
        start=EPOCH + timedelta(seconds=MIDDLE_S - before_s),
        stop=EPOCH + timedelta(seconds=MIDDLE_S + after_s),
        keyhole="nearest",
    )
    return Scenario(
        orbit=TLE,
        attitude=LvlhAttitude(roll_deg=roll_deg),
        platform=platform,
        initial_state=InitialState(epoch=EPOCH, angles_deg=dict.fromkeys(platform.axis_names, 0.0)),
        sessions=(session,),
    )


def refusing(scenario):
    """The same, to be followed exactly or not at all."""
    sessions = tuple(replace(session, keyhole="refuse") for session in scenario.sessions)
    return replace(scenario, sessions=sessions)
