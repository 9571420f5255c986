"""Reads a request for a campaign."""

from app.requests.json_reader import JsonReader
from planner.planning.campaigns import CampaignRequest

_READER = JsonReader(CampaignRequest)

read_campaign_request = _READER.read
campaign_request_json_schema = _READER.json_schema
