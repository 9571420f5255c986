"""A small satellite that turns as a whole, as its operator writes it down."""

import json

from app.requests.json_reader import JsonReader
from planner.world.platforms.body import BodyPlatform

SMALLSAT = {
    "kind": "body",
    "name": "smallsat-120kg",
    "agility": {
        "limits": "magnitude",
        "rate_max_deg_s": 1.5,
        "acceleration_max_deg_s2": 0.12,
        "jerk_max_deg_s3": 0.06,
        "settle_s": 4.0,
    },
    "off_nadir_max_deg": 40.0,
    "roll": {"rule": "lines_across_motion"},
    "idle": {"law": "sun", "direction_body": [0.0, 0.0, -1.0]},
    "inertia_kg_m2": [[11.0, 0.1, 0.0], [0.1, 13.0, 0.0], [0.0, 0.0, 9.0]],
    "torque_max_n_m": 0.03,
    "camera": {
        "type": "pushbroom",
        "boresight_body": [0.0, 0.0, 1.0],
        "line_body": [0.0, 1.0, 0.0],
        "pixel_arcsec": 0.275,
        "pixels": 8192,
        "tdi_lines": 64,
        "both_ways": False,
        "line_rate_max_hz": 12000.0,
    },
    "knowledge": {
        "sigma_arcsec": 15.0,
        "control_sigma_arcsec": 10.0,
        "jitter_arcsec": 0.3,
        "correlation_s": 20.0,
    },
    "star_trackers": {
        "needed": 1,
        "each": [
            {
                "name": "st1",
                "boresight_body": [0.5, -0.6, -0.6245],
                "sun_deg": 35.0,
                "moon_deg": 10.0,
                "limb_deg": 22.0,
            },
            {
                "name": "st2",
                "boresight_body": [-0.5, -0.6, -0.6245],
                "sun_deg": 35.0,
                "moon_deg": 10.0,
                "limb_deg": 22.0,
            },
        ],
    },
    "exclusions": [
        {"name": "camera Sun", "of": "camera", "away_from": "sun", "min_deg": 30.0},
        {
            "name": "radiator",
            "direction_body": [0.0, 1.0, 0.0],
            "away_from": "sun",
            "min_deg": 60.0,
            "when": "always",
        },
        {
            "name": "glint",
            "of": "camera",
            "away_from": "glint",
            "min_deg": 8.0,
            "when": "imaging",
        },
    ],
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
