"""Reads requests for opportunities, and for the ground track of an orbit."""

from app.requests.json_reader import JsonReader
from planner.output.view.orbit import OrbitTrackRequest
from planner.planning.opportunities import OpportunityRequest

_READER = JsonReader(OpportunityRequest)
_TRACK = JsonReader(OrbitTrackRequest)

read_opportunity_request = _READER.read
opportunity_request_json_schema = _READER.json_schema
read_orbit_track_request = _TRACK.read
orbit_track_request_json_schema = _TRACK.json_schema
