"""Reads a request for flights of a plan."""

from typing import Annotated

from app.requests.json_reader import JsonReader
from planner.base.spec import Within, spec
from planner.inflight.flights.request import SEED_MAX, MovingObject


@spec
class FlightsRequest:
    """A plan's table flown many times, with errors drawn anew for each run.

    name: your name for it, shown in lists. E.g. `"Las Vegas, before uplink"`.
    runs: number of runs; 400 give a probability to 0.05 with 95 % confidence, 1,000 to 0.03.
    seed: of the errors; the same seed draws the same ones, run by run, however many runs there are.
    moving_object: something that moves over the ground at the target, whose shift from frame to
    frame is given.
    """

    name: str = ""
    runs: Annotated[int, Within(2, 20_000)] = 400
    seed: Annotated[int, Within(0, SEED_MAX)] = 0
    moving_object: MovingObject | None = None


FLIGHTS_READER = JsonReader(FlightsRequest)

read_flights_request = FLIGHTS_READER.read
