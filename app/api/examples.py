"""What do requests look like?  Worked examples for the API's pages; the tests run them all."""

from typing import Any

_SESSION = {
    "target": {
        "mode": "ground",
        "latitude_deg": 36.1147,
        "longitude_deg": -115.1728,
        "height_m": 610.0,
    },
    "start": "2015-02-27T17:36:20Z",
    "stop": "2015-02-27T17:37:50Z",
}

# The pass of Sumarokov 2016, Fig. 3, with the elements published for that day.
LAS_VEGAS: dict[str, Any] = {
    "name": "Las Vegas",
    "platform": "iss-hrc",
    "orbit": {
        "source": "tle",
        "line1": "1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991",
        "line2": "2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964",
    },
    "attitude": {"law": "lvlh", "yaw_deg": 0.0, "pitch_deg": 0.0, "roll_deg": 0.0},
    "initial_state": {
        "epoch": "2015-02-27T17:34:00Z",
        "angles_deg": {"alpha": 0.0, "beta": 0.0},
        "rates_deg_s": {"alpha": 0.0, "beta": 0.0},
    },
    "sessions": [_SESSION],
    "slew": {"method": "ocp", "objective": "smooth"},
}

# The same elements by SGP4, rotated to EME2000.
_OEM = """\
CCSDS_OEM_VERS = 2.0
CREATION_DATE = 2015-02-27T12:00:00
ORIGINATOR = EXAMPLE
META_START
OBJECT_NAME = ISS
OBJECT_ID = 1998-067-A
CENTER_NAME = EARTH
REF_FRAME = EME2000
TIME_SYSTEM = UTC
START_TIME = 2015-02-27T17:28:00
STOP_TIME = 2015-02-27T17:44:00
META_STOP
2015-02-27T17:28:00 925.780574 -6623.959487 1086.910448 4.651735117 1.627633291 5.884549990
2015-02-27T17:29:00 1202.533148 -6511.086799 1437.194233 4.569792423 2.133345345 5.787089464
2015-02-27T17:30:00 1473.733697 -6368.152922 1780.823463 4.466737619 2.629282605 5.662817258
2015-02-27T17:31:00 1738.129218 -6195.813966 2116.206003 4.343045130 3.113133056 5.512306750
2015-02-27T17:32:00 1994.498115 -5994.863102 2441.787873 4.199287037 3.582641895 5.336255826
2015-02-27T17:33:00 2241.655979 -5766.226805 2756.060613 4.036130130 4.035622610 5.135483262
2015-02-27T17:34:00 2478.461164 -5510.960422 3057.568413 3.854332464 4.469967629 4.910924488
2015-02-27T17:35:00 2703.820153 -5230.243138 3344.914973 3.654739448 4.883658459 4.663626734
2015-02-27T17:36:00 2916.692669 -4925.372335 3616.770049 3.438279501 5.274775263 4.394743638
2015-02-27T17:37:00 3116.096516 -4597.757401 3871.875664 3.205959326 5.641505833 4.105529336
2015-02-27T17:38:00 3301.112127 -4248.913015 4109.051953 2.958858824 5.982153916 3.797332119
2015-02-27T17:39:00 3470.886792 -3880.451958 4327.202605 2.698125712 6.295146864 3.471587674
2015-02-27T17:40:00 3624.638562 -3494.077482 4525.319903 2.424969868 6.579042596 3.129811985
2015-02-27T17:41:00 3761.659799 -3091.575285 4702.489313 2.140657451 6.832535853 2.773593942
2015-02-27T17:42:00 3881.320376 -2674.805129 4857.893634 1.846504832 7.054463743 2.404587690
2015-02-27T17:43:00 3983.070496 -2245.692148 4990.816675 1.543872366 7.243810582 2.024504777
2015-02-27T17:44:00 4066.443148 -1806.217893 5100.646459 1.234158045 7.399712032 1.635106139
"""

_AXIS = {
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
        {**LAS_VEGAS, "name": "OEM", "orbit": {"source": "oem", "content": _OEM}},
    ),
    "state": (
        "The orbit from a state vector, propagated numerically",
        {
            **LAS_VEGAS,
            "name": "state vector",
            "orbit": {
                "source": "state",
                "frame": "GCRF",
                "epoch": "2015-02-27T17:34:00Z",
                "position_km": [2478.460528, -5510.960698, 3057.568431],
                "velocity_km_s": [3.854332385, 4.469967194, 4.910924946],
            },
        },
    ),
    "inertial": (
        "An attitude measured at an epoch and a constant body rate",
        {
            **LAS_VEGAS,
            "name": "inertial attitude",
            "attitude": {
                "law": "inertial",
                "epoch": "2015-02-27T17:36:00Z",
                "q_body_from_eci_xyzw": [0.702681592, 0.52279416, 0.050583198, 0.479964776],
                "omega_body_deg_s": [0.0, -0.06497, 0.0],
            },
        },
    ),
    "platform": (
        "A platform of one's own: the paper's effective limits, mounted with a yaw of 90 deg",
        {
            **LAS_VEGAS,
            "name": "own platform",
            "platform": {
                "name": "bench model",
                "outer": {
                    "name": "azimuth",
                    "axis_platform": [0.0, -1.0, 0.0],
                    **_AXIS,
                },
                "inner": {"name": "tilt", "axis_platform": [1.0, 0.0, 0.0], **_AXIS},
                "q_platform_from_body_xyzw": [0.0, 0.0, 0.7071067811865476, 0.7071067811865476],
            },
            "initial_state": {
                "epoch": "2015-02-27T17:34:00Z",
                "angles_deg": {"azimuth": 0.0, "tilt": 0.0},
            },
        },
    ),
    "spline": (
        "The paper's cubic spline in place of the optimal slew",
        {**LAS_VEGAS, "name": "spline", "slew": {"method": "spline"}},
    ),
    "minimum_time": (
        "As fast as the limits allow, from a moving start",
        {
            **LAS_VEGAS,
            "name": "minimum time",
            "initial_state": {
                "epoch": "2015-02-27T17:34:00Z",
                "angles_deg": {"alpha": 40.0, "beta": -20.0},
                "rates_deg_s": {"alpha": -0.5, "beta": 0.25},
            },
            "slew": {"method": "ocp", "objective": "minimum_time"},
        },
    ),
}
