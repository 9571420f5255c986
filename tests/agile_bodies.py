"""The small satellite that turns as a whole, as its operator writes it down, with a radiator."""

import json

from pydantic import TypeAdapter

from app.requests.json_reader import JsonReader
from planner.world.platforms.body import BodyPlatform
from planner.world.platforms.smallsat_120kg import SMALLSAT_120KG

_SHIPPED = TypeAdapter(BodyPlatform).dump_python(SMALLSAT_120KG, mode="json", exclude_none=True)
_RADIATOR = {
    "name": "radiator",
    "direction_body": [0.0, 1.0, 0.0],
    "away_from": "sun",
    "min_deg": 60.0,
    "when": "always",
}
SMALLSAT = _SHIPPED | {
    "knowledge": _SHIPPED["knowledge"] | {"correlation_s": 20.0},
    "exclusions": [_SHIPPED["exclusions"][0], _RADIATOR, _SHIPPED["exclusions"][1]],
}

GYROS = {
    "array": {"type": "scissored_pairs", "rotor_n_m_s": 0.5, "gimbal_rate_max_deg_s": 60.0},
    "turns": {
        "rate_max_deg_s": 1.2,
        "torque_max_n_m": 0.1,
        "torque_rate_max_n_m_s": 0.2,
        "momentum_max_n_m_s": 0.5,
        "settle_s": 4.0,
    },
    "start_n_m_s": [0.05, 0.0, 0.0],
}
GYRO_SAT = {
    key: value for key, value in SMALLSAT.items() if key not in ("agility", "torque_max_n_m")
}
GYRO_SAT |= {"name": "gyrosat-120kg", "gyros": GYROS}


def smallsat(**changes):
    """The satellite with members of it changed; None takes one away."""
    document = {key: value for key, value in (SMALLSAT | changes).items() if value is not None}
    return JsonReader(BodyPlatform).read(json.dumps(document).encode())
