"""Reads requests for opportunities, and for the ground track of an orbit."""

from app.requests.json_reader import JsonReader
from planner.output.view.orbit import OrbitTrackRequest
from planner.planning.opportunities import OpportunityRequest

OPPORTUNITY_READER = JsonReader(OpportunityRequest)
ORBIT_TRACK_READER = JsonReader(OrbitTrackRequest)

read_opportunity_request = OPPORTUNITY_READER.read
