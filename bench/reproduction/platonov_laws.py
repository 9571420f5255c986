"""The paper's own laws on its own turns, and its misprints: Platonov, Sumarokov 2019."""

from functools import lru_cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.signal import butter, freqz

from planner.base.arrays import Array
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.definition import AGILE_CMG
from reproduction.platonov_errata import (
    ORBITAL_RATE_RAD_S,
    TURN_RATE_RAD_S,
    hold,
    margin_under_null_motion,
    switching_rate_deg_s,
)
from reproduction.platonov_imaging import AREAS, LIMIT_DEG_S, SHOWN, STRIPS, fed_forward_deg_s
from reproduction.platonov_own_turns import SEEDS, Settling, fly, nominal, settling
from reproduction.platonov_own_turns import spacecraft_of as own_spacecraft
from reproduction.platonov_sessions import LONG_START_S, planned
from reproduction.statements import Numbers

CLOCK = "time on the paper's clock, s"
STORED_N_M_S = np.array([40.0, 20.0, 20.0])


def _filter_share(frequency_hz: float) -> float:
    """What the on-board filter leaves of a rate at a frequency."""
    b, a = butter(2, AGILE_CMG.gains.cutoff_hz, fs=1.0 / TICK_S)
    _, response = freqz(b, a, worN=[frequency_hz], fs=1.0 / TICK_S)
    return float(np.abs(response[0]))


@lru_cache(maxsize=1)
def _log_by_own_laws() -> tuple[Array, Array]:
    """Time on the paper's clock and rate errors, deg/s, of an undispersed run of the session."""
    log = fly("eight_areas", nominal(own_spacecraft("eight_areas")))
    errors = np.rad2deg(log.rate_error_rad_s.reshape(-1, 3))
    return np.arange(len(errors)) * 0.005 + LONG_START_S, errors


def numbers() -> Numbers:
    return {**_strip_and_stereo(), **_long_session(), **_errata()}


def _strip_and_stereo() -> Numbers:
    found = settling("strip_and_stereo", dispersed=True)
    ideal = settling("strip_and_stereo", dispersed=False)
    slews = planned("strip_and_stereo").slews
    numbers: Numbers = {}
    for k, (slew, span) in enumerate(zip((0, 2, 3), SHOWN[STRIPS], strict=True)):
        what = ("strip", "first look", "second look")[k]
        numbers |= {
            f"own turn to the {what}": float(np.median(found.needed_s[:, k])),
            f"own laws, {what}": float(np.max(found.worst_deg_s[:, k])),
            f"ideal_{k}_s": float(ideal.needed_s[0, k]),
            f"leaves_{k}_s": slews[slew].first_row / 5.0,
            f"fed_forward_{k}": fed_forward_deg_s(STRIPS, span),
        }
    return numbers


def _long_session() -> Numbers:
    found, ideal = settling("eight_areas", dispersed=True), settling("eight_areas", dispersed=False)
    needed = found.needed_s[:, found.given_s < 30.0]
    numbers: Numbers = {
        "own time of a turn": float(np.median(needed)),
        "own laws over the long session": 100.0 * _share(found.worst_of_11_s_deg_s),
        "needed_least_s": float(needed.min()),
        "needed_most_s": float(needed.max()),
        "steady_percent": 100.0 * _share(found.worst_deg_s),
        "worst_deg_s": float(found.worst_deg_s.max()),
        "ideal_deg_s": float(ideal.worst_deg_s.max()),
        "runs": len(SEEDS),
    }
    for figure, k, span in (("8", 4, SHOWN[AREAS][0]), ("9", 18, SHOWN[AREAS][1])):
        worst = found.worst_deg_s[:, k]
        numbers |= {
            f"own laws in Fig. {figure}": float(np.median(worst)),
            f"least_{figure}": float(worst.min()),
            f"most_{figure}": float(worst.max()),
            f"given_{figure}_s": float(found.given_s[k]),
            f"fed_forward_{figure}": fed_forward_deg_s(AREAS, span),
        }
    return numbers


def _share(worst_deg_s: Array) -> float:
    return float(np.mean(worst_deg_s <= LIMIT_DEG_S))


def _errata() -> Numbers:
    printed, turned = margin_under_null_motion(-1.0), margin_under_null_motion(1.0)
    orbit, turning = (
        [hold(rate, STORED_N_M_S, twice) for twice in (False, True)]
        for rate in (ORBITAL_RATE_RAD_S, TURN_RATE_RAD_S)
    )
    array, gains = AGILE_CMG.array, AGILE_CMG.gains
    return {
        "sign of xi": float(printed[-1]),
        "omega x H twice": turning[1].error_deg,
        "rate at the hand-over": switching_rate_deg_s(30.0),
        "filter of the modes": _filter_share(2.0),
        "servo": float(array.servo_rad_s),
        "printed_s": len(printed) * 0.2,
        "margin_first": float(printed[0]),
        "margin_other": float(turned[-1]),
        "turned_s": len(turned) * 0.2,
        "twice_n_m": turning[1].torque_n_m,
        "least_torques": turning[1].torque_n_m / (array.momentum_n_m_s * array.rate_step_rad_s),
        "once_deg": turning[0].error_deg,
        "orbit_twice_deg": orbit[1].error_deg,
        "orbit_once_deg": orbit[0].error_deg,
        "cutoff_hz": gains.cutoff_hz,
        "passes_2_1_hz": _filter_share(2.1),
        "servo_damping": array.servo_damping,
    }


def pictures(folder: Path) -> None:
    figure = Figure(figsize=(10.0, 6.4), layout="constrained")
    (top, needed), (eight, nine) = figure.subplots(2, 2)
    t_s, errors = _log_by_own_laws()
    for k, axis in enumerate("XYZ"):
        top.plot(t_s[::40], errors[::40, k], lw=0.8, label=axis)
    top.set(title="Fig. 7: rates relative to the goal's", xlabel=CLOCK, ylabel="rate, deg/s")
    top.legend(fontsize="x-small", ncols=3, loc="upper left")
    found: Settling = settling("eight_areas", dispersed=True)
    needed.plot(found.given_s, "k_", ms=8, label="given until imaging")
    for run in found.needed_s:
        needed.plot(run, "C0.", ms=4)
    needed.plot([], "C0.", label="taken until settled, each run")
    needed.set(title="its turns", xlabel="strip", ylabel="duration, s", ylim=(0.0, 60.0))
    needed.legend(fontsize="x-small")
    for panel, name, start_s, stop_s in (
        (eight, "Fig. 8", 866.0, 881.0),
        (nine, "Fig. 9", 1405.0, 1419.0),
    ):
        inside = (t_s >= start_s - 8.0) & (t_s <= stop_s - 0.4)
        for k in range(3):
            panel.plot(t_s[inside], errors[inside, k], lw=0.9)
        panel.axvspan(start_s, stop_s, alpha=0.15)
        for limit in (-LIMIT_DEG_S, LIMIT_DEG_S):
            panel.axhline(limit, color="0.4", lw=0.8, ls="--")
        panel.set(ylim=(-4e-3, 4e-3), title=name, xlabel=CLOCK, ylabel="rate error, deg/s")
    figure.savefig(folder / "reproduction_spacecraft_own_laws.png", dpi=90)
