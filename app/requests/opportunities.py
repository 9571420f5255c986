"""Reads a request for opportunities."""

from app.requests.json_reader import JsonReader
from planner.planning.opportunities import OpportunityRequest

_READER = JsonReader(OpportunityRequest)

read_opportunity_request = _READER.read
opportunity_request_json_schema = _READER.json_schema
