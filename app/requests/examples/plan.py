"""Example requests for plans, for the API's pages; the tests run them all."""

from typing import Any

from app.requests.examples.messages import ATTITUDE, ATTITUDE_HISTORY, OEM, OMM, OPM


def ground(latitude_deg: float, longitude_deg: float, height_m: float) -> dict[str, Any]:
    """A point on the ground, height above the ellipsoid."""
    return {
        "mode": "ground",
        "latitude_deg": latitude_deg,
        "longitude_deg": longitude_deg,
        "height_m": height_m,
    }


def ship(epoch: str) -> dict[str, Any]:
    """Off San Diego, going north-west."""
    return {
        "mode": "ground_moving",
        "epoch": epoch,
        "latitude_deg": 32.5,
        "longitude_deg": -118.0,
        "course_deg": 315.0,
        "speed_m_s": 8.0,
    }


def _session(target: dict[str, Any], start: str, stop: str) -> dict[str, Any]:
    """On the day of the pass, from minute and second to minute and second after 17 h UTC."""
    day = "2015-02-27T17"
    return {"target": target, "start": f"{day}:{start}Z", "stop": f"{day}:{stop}Z"}


_LAS_VEGAS_TARGET = ground(36.1147, -115.1728, 610.0)

# The pass of Sumarokov 2016, Fig. 3, with the elements published for that day.
LAS_VEGAS: dict[str, Any] = {
    "name": "Las Vegas",
    "platform": "iss-hrc",
    "orbit": {
        "source": "tle",
        "line1": "1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991",
        "line2": "2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964",
    },
    "attitude": {"law": "lvlh", "yaw_deg": -4.0, "pitch_deg": -2.0, "roll_deg": 1.0},
    "initial_state": {
        "epoch": "2015-02-27T17:34:00Z",
        "angles_deg": {"alpha": 0.0, "beta": 0.0},
        "rates_deg_s": {"alpha": 0.0, "beta": 0.0},
    },
    "sessions": [_session(_LAS_VEGAS_TARGET, "36:20", "37:50")],
    "slew": {"method": "ocp", "objective": "smooth"},
}


def _request(name: str, **changes: object) -> dict[str, Any]:
    """`LAS_VEGAS` with other members."""
    return {**LAS_VEGAS, "name": name, **changes}


def _request_at(name: str, target: dict[str, Any]) -> dict[str, Any]:
    return _request(name, sessions=[_session(target, "36:20", "37:50")])


def _starting(angles_deg: dict[str, float], **rates: dict[str, float]) -> dict[str, Any]:
    return {"epoch": "2015-02-27T17:34:00Z", "angles_deg": angles_deg, **rates}


# From where the axes meet: forward, to starboard, down.
ARM_M = [
    [0.2, 4.0, 1.2],
    [0.7, 4.0, 1.2],
    [0.8, 1.5, 2.5],
    [1.7, 0.9, 2.4],
    [1.6, 0.6, 2.5],
    [0.5, 1.1, 2.7],
]


def _axis(name: str, axis_platform: list[float]) -> dict[str, Any]:
    return {
        "name": name,
        "axis_platform": axis_platform,
        "angle_min_deg": -175.0,
        "angle_max_deg": 175.0,
        "rate_max_deg_s": 2.0,
        "acceleration_max_deg_s2": 0.8,
        "jerk_max_deg_s3": 0.5,
        "rate_min_deg_s": 0.0166667,
    }


PLAN_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "tle": ("Las Vegas from the ISS by a TLE, 27 February 2015", LAS_VEGAS),
    "oem": (
        "The orbit from a CCSDS OEM",
        _request("OEM", orbit={"source": "oem", "content": OEM}),
    ),
    "state": (
        "The orbit from a state vector, propagated numerically",
        _request(
            "state vector",
            orbit={
                "source": "state",
                "frame": "GCRF",
                "epoch": "2015-02-27T17:34:00Z",
                "position_km": [2478.460528, -5510.960698, 3057.568431],
                "velocity_km_s": [3.854332385, 4.469967194, 4.910924946],
            },
        ),
    ),
    "inertial": (
        "An attitude measured at an epoch and a constant body rate",
        _request(
            "inertial attitude",
            attitude={
                "law": "inertial",
                "epoch": "2015-02-27T17:36:00Z",
                "q_body_from_eci_xyzw": [0.702681592, 0.52279416, 0.050583198, 0.479964776],
                "omega_body_deg_s": [0.0, -0.06497, 0.0],
            },
        ),
    ),
    "platform": (
        "A platform of one's own: the paper's effective limits, mounted with a yaw of 90 deg",
        _request(
            "own platform",
            platform={
                "name": "bench model",
                "outer": _axis("azimuth", [0.0, -1.0, 0.0]),
                "inner": _axis("tilt", [1.0, 0.0, 0.0]),
                "q_platform_from_body_xyzw": [0.0, 0.0, 0.7071067811865476, 0.7071067811865476],
            },
            initial_state=_starting({"azimuth": 0.0, "tilt": 0.0}),
        ),
    ),
    "spline": (
        "The paper's cubic spline in place of the optimal slew",
        _request("spline", slew={"method": "spline"}),
    ),
    "minimum_time": (
        "As fast as the limits allow, from a moving start",
        _request(
            "minimum time",
            initial_state=_starting(
                {"alpha": 40.0, "beta": -20.0}, rates_deg_s={"alpha": -0.5, "beta": 0.25}
            ),
            slew={"method": "ocp", "objective": "minimum_time"},
        ),
    ),
    "omm": (
        "The orbit from a CCSDS OMM as catalogues send it",
        _request("OMM", orbit={"source": "omm", "content": OMM}),
    ),
    "opm": (
        "The orbit from a CCSDS OPM, propagated numerically",
        _request("OPM", orbit={"source": "opm", "content": OPM}),
    ),
    "aem": (
        "The attitude from a CCSDS AEM",
        _request("AEM", attitude={"law": "aem", "content": ATTITUDE}),
    ),
    "harmonic": (
        "An attitude history that ends before the session, extrapolated",
        _request(
            "attitude extrapolated",
            attitude={"law": "harmonic", "content": ATTITUDE_HISTORY},
        ),
    ),
    "refraction": (
        "Aimed where the standard atmosphere makes the target appear",
        _request_at(
            "refraction", {**_LAS_VEGAS_TARGET, "min_elevation_deg": 10.0, "refraction": "standard"}
        ),
    ),
    "ground_moving": (
        "A ship off San Diego under way",
        _request_at("ship", ship("2015-02-27T17:00:00Z")),
    ),
    "ground_path": (
        "A strip with a bend, scanned at 200 m/s over the ground",
        _request_at(
            "strip",
            {
                "mode": "ground_path",
                "points": [
                    {"latitude_deg": 36.05, "longitude_deg": -115.25, "height_m": 600.0},
                    {"latitude_deg": 36.12, "longitude_deg": -115.17, "height_m": 600.0},
                    {"latitude_deg": 36.15, "longitude_deg": -115.03, "height_m": 550.0},
                ],
                "speed_m_s": 200.0,
            },
        ),
    ),
    "place": (
        "A town by its name, from rest at zero in time for the slew",
        _request(
            "Las Vegas by its name",
            initial_state={},
            sessions=[
                _session(
                    {"mode": "place", "name": "Las Vegas, Nevada, US", "min_elevation_deg": 15.0},
                    "36:20",
                    "37:50",
                )
            ],
        ),
    ),
    "star_name": ("Vega by its name", _request_at("Vega", {"mode": "star", "name": "Vega"})),
    "star": ("Vega by its Hipparcos number", _request_at("Vega", {"mode": "star", "hip": 91262})),
    "star_coordinates": (
        "Barnard's star by Gaia's coordinates, proper motion and parallax",
        _request_at(
            "Barnard's star",
            {
                "mode": "star",
                "ra_deg": 269.4485,
                "dec_deg": 4.7394,
                "epoch_jyear": 2016.0,
                "pm_ra_cosdec_mas_yr": -801.551,
                "pm_dec_mas_yr": 10362.394,
                "parallax_mas": 546.976,
                "radial_velocity_km_s": -110.47,
            },
        ),
    ),
    "body": (
        "Saturn, from JPL's ephemeris",
        _request_at("Saturn", {"mode": "body", "name": "saturn"}),
    ),
    "test_motion": (
        "Signals to identify the platform on the bench: a chirp and a multisine",
        _request_at(
            "identification",
            {
                "mode": "test_motion",
                "axes": {
                    "alpha": {
                        "kind": "chirp",
                        "angle_deg": 10.0,
                        "amplitude_deg": 0.2,
                        "start_frequency_hz": 0.01,
                        "stop_frequency_hz": 0.2,
                        "sweep_s": 80.0,
                    },
                    "beta": {
                        "kind": "multisine",
                        "amplitudes_deg": [0.1, 0.1, 0.1],
                        "frequencies_hz": [0.02, 0.05, 0.11],
                    },
                },
            },
        ),
    ),
    "sequence": (
        "Three cities in one pass, too close together: sessions shortened by the least time",
        _request(
            "Las Vegas, Salt Lake City, Laramie",
            sessions=[
                _session(_LAS_VEGAS_TARGET, "36:20", "37:20"),
                _session(ground(40.76, -111.89, 1288.0), "37:28", "38:30"),
                _session(ground(41.31, -105.59, 2184.0), "38:35", "39:50"),
            ],
            on_conflict="least_loss",
        ),
    ),
    "long_lead": (
        "Hours before the session: the axes wait, slew within two minutes, and are parked after it",
        _request(
            "wait and park",
            initial_state={
                "epoch": "2015-02-27T14:34:00Z",
                "angles_deg": {"alpha": 0.0, "beta": 0.0},
            },
            slew={"method": "ocp", "lead": {"max_duration_s": 120.0}},
            final_state={"park": "zero"},
        ),
    ),
    "keep_out": (
        "Led around the Sun, which the straight slew would pass at 2 deg",
        _request(
            "around the Sun",
            initial_state=_starting({"alpha": 40.0, "beta": -170.0}),
            slew={"method": "ocp", "keep_out": [{"body": "sun", "half_angle_deg": 25.0}]},
        ),
    ),
    "masks": (
        "Led around a robotic arm in the platform's view, given by its corners in metres",
        _request(
            "around the arm",
            platform={
                "name": "HRC beside an arm",
                "outer": _axis("alpha", [0.0, -0.996194698, 0.087155743]),
                "inner": _axis("beta", [1.0, 0.0, 0.0]),
                "masks": [{"name": "arm", "corners_platform": ARM_M, "margin_deg": 1.0}],
            },
            initial_state=_starting({"alpha": 30.0, "beta": -50.0}),
        ),
    ),
    "keyhole": (
        "Kochab past the outer axis of the platform, tracked as near as its limits allow",
        _request(
            "keyhole",
            attitude={"law": "lvlh", "yaw_deg": 0.0, "pitch_deg": 0.0, "roll_deg": 45.4},
            sessions=[
                _session({"mode": "star", "hip": 72607}, "42:00", "46:00") | {"keyhole": "nearest"}
            ],
        ),
    ),
    "avoid_modes": (
        "A slew that leaves two modes of the structure at rest",
        _request(
            "modes suppressed",
            slew={
                "method": "ocp",
                "avoid_modes": [{"frequency_hz": 0.1}, {"frequency_hz": 0.35, "damping": 0.01}],
            },
        ),
    ),
}
