"""Reads a request for a campaign."""

from app.requests.json_reader import JsonReader
from planner.planning.campaigns import CampaignRequest

CAMPAIGN_READER = JsonReader(CampaignRequest)

read_campaign_request = CAMPAIGN_READER.read
