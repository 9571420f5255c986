"""Example requests about the horizon, for the API's pages."""

from typing import Any

from app.requests.examples.plan import LAS_VEGAS

_CARRIER = {name: LAS_VEGAS[name] for name in ("orbit", "attitude")}
_EPOCH = "2015-02-27T17:37:00Z"


def _camera(name: str, q_camera_from_body_xyzw: list[float]) -> dict[str, Any]:
    """60 deg wide, its axis 20 deg below the carrier's XY plane, image rows down to nadir."""
    return {
        "name": name,
        "width_px": 640,
        "height_px": 480,
        "fx_px": 554.256,
        "fy_px": 554.256,
        "cx_px": 319.5,
        "cy_px": 239.5,
        "distortion": [0.0, 0.0, 0.0, 0.0, 0.0],
        "q_camera_from_body_xyzw": q_camera_from_body_xyzw,
        "lens_sigma": 0.0,
    }


AHEAD = _camera("ahead", [0.405579788, 0.405579788, 0.579227965, -0.579227965])
RIGHT = _camera("right", [0.0, 0.573576436, 0.819152044, 0.0])

PREDICTION_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "pass": (
        "Two cameras on the ISS as it passes Las Vegas by day, then in the Earth's shadow",
        {
            **_CARRIER,
            "attitude_sigma_deg": 0.5,
            "cameras": [AHEAD, RIGHT],
            "instants": [_EPOCH, "2015-02-27T18:15:00Z"],
        },
    )
}

PICTURE_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "ahead": (
        "The view ahead over Las Vegas, half clouded",
        {
            **_CARRIER,
            "camera": AHEAD,
            "at": _EPOCH,
            "scene": {"cloud_cover": 0.5, "roughness_m": 800.0},
            "sensor": {"blur_px": 0.7, "bits": 8},
            "seed": 1,
        },
    )
}

# Of the pictures examples/horizon_ahead.png and horizon_right.png, rendered as above; the
# attitude is the truth.
ESTIMATE_EXAMPLE: dict[str, Any] = {
    "epoch": _EPOCH,
    "position": {"frame": "ITRF", "position_km": [-2538.113892, -4936.6113, 3876.686538]},
    "cameras": [AHEAD, RIGHT],
    "predicted": {
        "q_body_from_eci_xyzw": [0.704013089744, 0.538794111602, 0.026635987714, 0.461905833402],
        "sigma_deg": 0.5,
    },
    "overlay": False,
}

# A session's frames by one camera, as `slewtrack horizon` takes it with images or a video.
SESSION_EXAMPLE: dict[str, Any] = {
    **_CARRIER,
    "attitude_sigma_deg": 0.05,
    "cameras": [AHEAD],
    "start": _EPOCH,
    "step_s": 5.0,
}
