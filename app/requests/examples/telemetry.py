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
    -1.42441,
    -5.12898,
    -11.43738,
    -19.88363,
    -29.50297,
    -39.06241,
    -47.27596,
    -53.01767,
    -55.55040,
    -54.72995,
    -51.24114,
    -46.35344,
    -40.21676,
    -32.56721,
    -23.24575,
    -12.39542,
    -0.64058,
    11.00870,
]
_BETA_DEG = [
    -0.16305,
    -0.59180,
    -1.32903,
    -2.33014,
    -3.49839,
    -4.70350,
    -5.80996,
    -6.70189,
    -7.30527,
    -7.61531,
    -7.71247,
    -7.74828,
    -7.75364,
    -7.70021,
    -7.55470,
    -7.28553,
    -6.88581,
    -6.39504,
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
