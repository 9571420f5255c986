"""Scenarios on the real pass over Las Vegas, 27 Feb 2015."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import cache

from planner.planning.sessions.pipeline import make_plan
from planner.world.attitude import AttitudeUncertainty, LvlhAttitude
from planner.world.orbits import TleOrbit
from planner.world.platforms import PLATFORMS
from planner.world.scenario import InitialState, Scenario, Session, SlewOptions
from planner.world.targets import GroundTarget

TLE = TleOrbit(
    line1="1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991",
    line2="2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964",
)
EPOCH = datetime(2015, 2, 27, 17, 34, tzinfo=UTC)
LAS_VEGAS = GroundTarget(latitude_deg=36.1147, longitude_deg=-115.1728, height_m=610.0)
SALT_LAKE = GroundTarget(latitude_deg=40.76, longitude_deg=-111.89, height_m=1288.0)
LARAMIE = GroundTarget(latitude_deg=41.31, longitude_deg=-105.59, height_m=2184.0)

# On a carrier that flies level.
HRC = replace(PLATFORMS["iss-hrc"], usual_yaw_pitch_roll_deg=None)
STILL = AttitudeUncertainty(sigma_body_deg=(0.0, 0.0, 0.0), swing_rms_body_deg=(0.0, 0.0, 0.0))


def at(seconds):
    return EPOCH + timedelta(seconds=seconds)


def session(target, start_s, stop_s):
    return Session(target=target, start=at(start_s), stop=at(stop_s))


def moved(asked, start, stop, number=0):
    """The request with a session at other times."""
    sessions = list(asked.sessions)
    sessions[number] = replace(sessions[number], start=start, stop=stop)
    return replace(asked, sessions=tuple(sessions))


def advised(asked, refusal, number=0):
    """The request with its session at the times that a refusal names."""
    times = refusal.earliest_feasible_start_utc, refusal.feasible_stop_utc
    return moved(asked, *times, number)


def scenario(*sessions, alpha=(0.0, 0.0, 0.0), beta=(0.0, 0.0, 0.0), epoch_s=0, slew=None, **more):
    motion = {
        what: {"alpha": alpha[order], "beta": beta[order]}
        for order, what in enumerate(("angles_deg", "rates_deg_s", "accelerations_deg_s2"))
    }
    return Scenario(
        orbit=TLE,
        attitude=LvlhAttitude(uncertainty=STILL),
        platform=HRC,
        initial_state=InitialState(epoch=at(epoch_s), **motion),
        sessions=sessions,
        slew=slew or SlewOptions(),
        **more,
    )


# Two sessions with nothing in the way.
FREE = scenario(
    session(LAS_VEGAS, 140, 230),
    session(SALT_LAKE, 290, 330),
    alpha=(-60.0, 0, 0),
    beta=(40.0, 0, 0),
)


@cache
def free_plan():
    return make_plan(FREE)
