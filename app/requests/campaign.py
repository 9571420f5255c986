"""Reads a request for a campaign, of one carrier or of several."""

from app.requests.json_reader import JsonReader, json_document
from planner.planning.campaigns import CampaignRequest, FleetRequest

FLEET_READER = JsonReader(FleetRequest)


class CampaignReader(JsonReader[CampaignRequest | FleetRequest]):
    """Reads what has `carriers` as a fleet's."""

    def __init__(self) -> None:
        super().__init__(CampaignRequest)
        self.others = (FLEET_READER,)

    def read(self, body: bytes) -> CampaignRequest | FleetRequest:
        return FLEET_READER.read(body) if _has_carriers(body) else super().read(body)

    def read_kept(self, body: bytes) -> CampaignRequest | FleetRequest:
        return FLEET_READER.read_kept(body) if _has_carriers(body) else super().read_kept(body)


def _has_carriers(body: bytes) -> bool:
    document = json_document(body) if b"carriers" in body else None
    return isinstance(document, dict) and "carriers" in document


CAMPAIGN_READER = CampaignReader()

read_campaign_request = CAMPAIGN_READER.read
