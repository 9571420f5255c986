"""The prediction of the attitude: Sumarokov 2016, eqs. 1 and 2."""

import csv
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.world.attitude import InertialAttitude
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import OrbitStates, TleOrbit
from planner.world.platforms.two_axis import HRC_FRAME_HALF_RAD
from reproduction.statements import Numbers

TELEMETRY = Path(__file__).parents[2] / "tests/data/iss_attitude_rates_2018-285.csv"
CLOCK_UTC = datetime(2017, 12, 31, tzinfo=UTC)
TLE = TleOrbit(
    line1="1 25544U 98067A   18282.68010179  .00001200  00000-0  25646-4 0  9993",
    line2="2 25544  51.6418 168.1582 0003545 263.2788 123.8988 15.53792760136320",
)
TAU_S = 0.1
LEADS_S = (60.0, 300.0, 900.0, 1800.0)
START_EVERY = 5  # of the telemetry's minutes
NEAR_S = 5.0  # a row that near to a lead counts as at it
RATE_BODY_RAD_S = np.deg2rad([-0.003, 0.065, 0.0])  # the ISS's, once an orbit

Quaternion = NDArray[np.float64]


def printed_step(q: Quaternion, omega_rad_s: NDArray, tau_s: float, power: int) -> Quaternion:
    """Eqs. 1 and 2, scalar first, commas restored; |q| to the power 1 as printed, or squared."""
    q_n = (
        1.0 + (1.0 - np.linalg.norm(q) ** power) / 2.0 - tau_s**2 / 8.0 * omega_rad_s @ omega_rad_s
    )
    q0, q1, q2, q3 = q
    x, y, z = 0.5 * tau_s * omega_rad_s
    turned = np.array(
        [-q1 * x - q2 * y - q3 * z, q0 * x + q2 * z - q3 * y, q0 * y + q3 * x - q1 * z,
         q0 * z + q1 * y - q2 * x]
    )  # fmt: skip
    return np.asarray(q * q_n + turned)


def predicted(law: InertialAttitude, at: Instants) -> Rotation:
    """Body from ECI at one instant; an inertial attitude needs no orbit."""
    nowhere = OrbitStates(np.zeros((1, 3)), np.zeros((1, 3)))
    return law.q_law_body_from_eci(at, nowhere)[0]


def recursion_error_arcsec(span_s: float) -> float:
    """Of the paper's steps against the law `inertial`, which is the closed form."""
    law = InertialAttitude(
        epoch=CLOCK_UTC,
        q_body_from_eci_xyzw=(0.0, 0.0, 0.0, 1.0),
        omega_body_deg_s=tuple(np.rad2deg(RATE_BODY_RAD_S).tolist()),
    )
    closed = predicted(law, Instants(CLOCK_UTC, np.array([span_s])))
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for _ in range(int(span_s / TAU_S)):
        q = printed_step(q, RATE_BODY_RAD_S, TAU_S, 2)
    stepped = Rotation.from_quat([*q[1:], q[0]])  # eci from body, as the paper's q
    return float(np.rad2deg((stepped * closed).magnitude()) * 3600.0)


def steps_to_unit_norm(power: int) -> int:
    """From a norm 1 % too large to one within 1e-9."""
    q = np.array([1.01, 0.0, 0.0, 0.0])
    steps = 0
    while abs(np.linalg.norm(q) - 1.0) > 1e-9:
        q = printed_step(q, np.zeros(3), TAU_S, power)
        steps += 1
    return steps


@cache
def telemetry() -> tuple[NDArray, Rotation, NDArray]:
    """Times (n,) since CLOCK_UTC, body from ECI, body rates (n, 3) in deg/s, of the ISS."""
    lines = [line for line in TELEMETRY.read_text("ascii").splitlines() if line[0] != "#"]
    table = np.array([[float(x) for x in row] for row in csv.reader(lines[1:])])
    t_s = table[:, 0]
    instants = Instants(CLOCK_UTC, t_s)
    ends = [shifted_utc(CLOCK_UTC, float(t)) for t in (t_s[0], t_s[-1])]
    states = TLE.ephemeris(*ends).states(instants)
    q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
    return t_s, Rotation.from_quat(table[:, 1:5]).inv() * q_lvlh, table[:, 5:]


@cache
def constant_rate_errors_deg(lead_s: float) -> NDArray:
    """Of attitudes predicted from telemetry by the law `inertial`, each against telemetry, (k,)."""
    t_s, q_body_from_eci, rate_deg_s = telemetry()
    errors = []
    for now in range(0, len(t_s), START_EVERY):
        then = int(np.abs(t_s - t_s[now] - lead_s).argmin())
        if abs(t_s[then] - t_s[now] - lead_s) > NEAR_S:
            continue
        law = InertialAttitude(
            epoch=shifted_utc(CLOCK_UTC, float(t_s[now])),
            q_body_from_eci_xyzw=tuple(q_body_from_eci[now].as_quat().tolist()),
            omega_body_deg_s=tuple(rate_deg_s[now].tolist()),
        )
        at = Instants(CLOCK_UTC, t_s[then : then + 1])
        errors.append((predicted(law, at) * q_body_from_eci[then].inv()).magnitude())
    return np.rad2deg(errors)


def rms(values: NDArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def numbers() -> Numbers:
    at_900_deg = constant_rate_errors_deg(900.0)
    return {
        "recursion": recursion_error_arcsec(900.0),
        "norm correction": float(steps_to_unit_norm(2)),
        "constant rate, 900 s": rms(at_900_deg),
        "constant rate, 60 s": rms(constant_rate_errors_deg(60.0)),
        "as_printed": steps_to_unit_norm(1),
        "count": len(at_900_deg),
        "frame_deg": float(np.rad2deg(min(HRC_FRAME_HALF_RAD))),
    }


def pictures(folder: Path) -> None:
    figure = Figure(figsize=(7.2, 3.6), layout="constrained")
    panel = figure.add_subplot()
    leads_s = np.array([60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0])
    errors = [constant_rate_errors_deg(float(lead)) for lead in leads_s]
    panel.plot(leads_s, [rms(one) for one in errors], "o-", label="rms")
    panel.plot(leads_s, [one.max() for one in errors], "^:", color="0.5", label="largest")
    frame_deg = float(np.rad2deg(min(HRC_FRAME_HALF_RAD)))
    panel.axhline(frame_deg, color="C3", ls="--", lw=1.0)
    panel.text(60.0, frame_deg, "half the frame's height", color="C3", va="bottom", fontsize=9)
    panel.set(xscale="log", yscale="log", xlabel="seconds ahead", ylabel="attitude error, deg")
    panel.set_xticks(leads_s, [f"{lead:.0f}" for lead in leads_s])
    panel.minorticks_off()
    panel.grid(alpha=0.3)
    panel.legend()
    figure.savefig(folder / "reproduction_attitude.png", dpi=100)
