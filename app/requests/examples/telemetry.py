"""Example requests for telemetry, for the API's pages: a few samples of the Las Vegas pass.

The plan's id is that of whoever planned it; the tests put theirs in.
"""

from typing import Any

PLAN_ID = "01a203fd-cbae-73f8-8276-319f76b8842c"

# Of a clock that is 0.37 s ahead, 2 arcsec of noise; the axes as planned.
_T_S = [
    20.0,
    32.0,
    44.0,
    56.0,
    68.0,
    80.0,
    92.0,
    104.0,
    116.0,
    128.0,
    140.0,
    152.0,
    164.0,
    176.0,
    188.0,
    200.0,
    212.0,
    224.0,
]
_ALPHA_DEG = [
    -1.38743,
    -4.99546,
    -11.13813,
    -19.36019,
    -28.71990,
    -38.01398,
    -45.98733,
    -51.54044,
    -53.95261,
    -53.08050,
    -49.58866,
    -44.71036,
    -38.58595,
    -30.95152,
    -21.64671,
    -10.81100,
    0.93615,
    12.58754,
]
_BETA_DEG = [
    -0.07258,
    -0.26511,
    -0.59688,
    -1.04996,
    -1.58502,
    -2.14651,
    -2.67763,
    -3.13182,
    -3.48159,
    -3.73254,
    -3.92601,
    -4.13926,
    -4.40430,
    -4.72787,
    -5.11252,
    -5.54073,
    -5.96643,
    -6.33232,
]

COMPARISON_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "angles": (
        "Shaft angles of the Las Vegas pass, one in twelve seconds",
        {
            "plan": PLAN_ID,
            "samples": {
                "epoch": "2015-02-27T17:34:00Z",
                "t_s": _T_S,
                "alpha_deg": _ALPHA_DEG,
                "beta_deg": _BETA_DEG,
            },
        },
    )
}
