"""A child's work to predict what horizon cameras will see."""

from pydantic import TypeAdapter

from app.answers.horizon import PredictionResponse
from app.answers.provenance import ProvenanceOut
from app.requests.horizon import PredictionRequest
from app.work.horizon_views import views

_PREDICTION = TypeAdapter(PredictionResponse)


def prediction_json(asked: PredictionRequest, made: ProvenanceOut) -> bytes:
    """The whole answer as UTF-8 JSON."""
    found, warnings = views(
        asked.orbit,
        asked.attitude,
        asked.cameras,
        asked.instants,
        body=asked.body,
        attitude_sigma_deg=asked.attitude_sigma_deg,
    )
    answer = PredictionResponse(views=found, warnings=list(warnings), provenance=made)
    return _PREDICTION.dump_json(answer)
