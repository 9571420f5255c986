"""Reads a request for opportunities."""

from app.requests.json_reader import JsonReader
from planner.planning.opportunities import OpportunityRequest

OPPORTUNITY_READER = JsonReader(OpportunityRequest)

read_opportunity_request = OPPORTUNITY_READER.read
