"""The summary of a plan on the terminal."""

import json
from collections.abc import Iterator
from datetime import datetime
from operator import itemgetter
from typing import Any

from rich.console import Console
from rich.text import Text

from app.cli.planner import Members
from app.cli.report_parts import print_assumed, print_rows, print_warnings


def print_plan(console: Console, plan: Members, request: bytes | Members) -> None:
    table, total_s = plan["table"], sum(plan["solver"]["stages_wall_s"].values())
    asked = json.loads(request) if isinstance(request, bytes) else request
    console.print(Text(plan["name"] or "Plan", style="bold").append(_identity(plan, asked), "none"))
    console.print(
        f"{len(table['t_s'])} rows from {table['epoch']}, planned in {1e3 * total_s:.0f} ms"
    )
    print_assumed(console, plan["assumed"])
    print_rows(
        console, "segments", plan["segments"],
        ("<kind", "kind"), _SESSION, ("<start", "start"), ("<stop", "stop"),
        ("seconds", _seconds, ".1f"),
    )  # fmt: skip
    print_rows(
        console, "pointing error", plan["pointing"],
        _SESSION, ("max arcsec", "max_arcsec", ".3g"), ("rms arcsec", "rms_arcsec", ".3g"),
        ("ground m", "ground_max_m", ".2g"), ("least elevation deg", "elevation_min_deg", ".2f"),
        ("least range km", "range_min_km", ".6g"),
        ("above the limb deg", "limb_clearance_min_deg", ".2f"), sparse=True,
    )  # fmt: skip
    print_rows(
        console, "pointing budget, 1 sigma", plan["uncertainty"],
        _SESSION, ("arcsec", "sigma_arcsec", ".0f"), ("ground m", "ground_m", ".0f"),
        ("stays in the frame", "probability_in_frame", ".1%"),
        ("~most of it by", lambda one: max(one["contributions"], key=_SIGMA)["cause"]),
    )  # fmt: skip
    print_rows(
        console, "least margins",
        [
            *(
                {"axis": axis, "name": name, **margin}
                for axis, margins in plan["margins"].items()
                for name, margin in margins.items()
            ),
            *({"axis": "-", **reserve} for reserve in plan["resources"]),
            *({"axis": session_number(one["session"]), **kept}
              for one in plan["pointing"] for kept in one["conditions"]),
        ],
        ("<axis", "axis"), ("<limit of", "name"), ("limit", "limit", ".6g"),
        ("closest", "extreme", ".6g"), ("margin", "margin", ".6g"), ("<unit", "unit"), _AT,
        red=lambda margin: margin["margin"] < 0.0,
    )  # fmt: skip
    print_rows(
        console, "cones to keep out of", plan["keep_out"],
        ("<about", "about"), ("half angle deg", "half_angle_deg", "g"),
        ("closest deg", "away_min_deg", ".3f"), _AT, red=_is_entered,
    )  # fmt: skip
    print_rows(
        console, "masks to keep out of", plan["masks"],
        ("<name", "name"), ("asked deg", "asked_deg", "g"), ("closest deg", "away_min_deg", ".3f"),
        _AT, red=_is_entered,
    )  # fmt: skip
    print_rows(
        console, "exclusions of the body", plan["exclusions"],
        ("<name", "name"), ("margin deg", "margin_deg", ".3f"), _AT, red=_is_entered,
    )  # fmt: skip
    print_rows(
        console, "gyros of the body", plan["gyros"],
        ("<limit", "name"), ("most", "limit", "g"), ("reached", "extreme", ".4g"),
        ("<unit", "unit"), _AT, red=lambda one: one["margin"] < 0.0,
    )  # fmt: skip
    print_rows(
        console, "optimal slew against the spline", _methods(plan),
        ("<slew", "session", session_number), ("<axis", "axis"), ("<by", "by"),
        ("deg/s", "peak_rate_deg_s", ".4f"), ("deg/s2", "peak_acceleration_deg_s2", ".4f"),
        ("deg/s3", "peak_jerk_deg_s3", _or_jump),
        ("jerk², deg²/s⁵", "jerk_squared_integral_deg2_s5", _or_jump),
        ("~breaks", "limits_broken", lambda broken: ", ".join(broken) or "-"),
        red=lambda figures: figures["limits_broken"],
    )  # fmt: skip
    print_rows(
        console, "vibration left after the slew",
        (
            {"session": slew["session"], "axis": axis, "mode": mode}
            for slew in plan["comparison"]
            for mode in slew["residual_vibration"]
            for axis in mode["ocp_arcsec"]
        ),
        ("slew", "session", session_number), ("<axis", "axis"),
        ("mode Hz", "mode.frequency_hz", "g"),
        ("ocp arcsec", lambda one: one["mode"]["ocp_arcsec"][one["axis"]], ".2g"),
        ("spline arcsec", lambda one: one["mode"]["spline_arcsec"][one["axis"]], ".2g"),
    )  # fmt: skip
    print_warnings(console, plan["warnings"])
    passed = plan["verification"]["passed"]
    console.print(
        Text(f"verification {'passed' if passed else 'FAILED'}", style="green" if passed else "red")
    )


def _identity(plan: Members, asked: Members) -> str:
    from planner.world.frames.time_scales import utc_from_text

    start_utc, stop_utc = (utc_from_text(plan["summary"][name]) for name in ("start", "stop"))
    stop = _day_and_time(stop_utc).removeprefix(f"{start_utc:%-d %b %Y} ")
    parts = [f"{_day_and_time(start_utc)} to {stop} UTC", plan["platform"]]
    parts += [_orbit(asked["orbit"], start_utc, stop_utc), _attitude(asked.get("attitude") or {})]
    parts += [f"revision {plan['revision']}", plan["id"]]
    return ", ".join(["", *parts])


def _day_and_time(utc: datetime) -> str:
    return f"{utc:%-d %b %Y %H:%M:%S}"


def _orbit(asked: Members, start_utc: datetime, stop_utc: datetime) -> str:
    """Its source, and how old what it rests on is as the sessions begin."""
    from app.requests.json_reader import JsonReader
    from planner.world.frames.time_scales import elapsed_s
    from planner.world.orbits import ORBITS

    orbit = JsonReader(ORBITS[asked["source"]]).read(json.dumps(asked).encode())
    epoch_utc = orbit.ephemeris(start_utc, stop_utc).epoch_utc
    age_h = elapsed_s(start_utc, epoch_utc) / 3600.0
    told = f"{abs(age_h):.{'1f' if abs(age_h) < 1.0 else '0f'}} h"
    of = f"{asked['source'].upper()} of {epoch_utc:%-d %b %Y %H:%M}"
    return f"{of} ({told} old)" if age_h >= 0.0 else f"{of} ({told} after the start)"


def _attitude(asked: Members) -> str:
    law = asked.get("law", "its own attitude")
    if law != "lvlh":
        return str(law)
    angles = (asked.get(f"{turn}_deg", 0.0) for turn in ("yaw", "pitch", "roll"))
    return f"LVLH {'/'.join(f'{angle:.3g}' for angle in angles)}"


def session_number(number: int | None) -> str:
    """Counted from 1, as everything that people read; the answer's own number is an index."""
    return "final" if number is None else str(number + 1)


_SIGMA = itemgetter("sigma_arcsec")
_SESSION = ("session", "session", session_number)
_AT = ("<at UTC", "at", lambda at: "-" if at is None else at[11:-3])  # to a tenth of a second


def _seconds(segment: Members) -> float:
    from planner.world.frames.time_scales import elapsed_s, utc_from_text

    return elapsed_s(utc_from_text(segment["stop"]), utc_from_text(segment["start"]))


def _is_entered(keep_out: Members) -> bool:
    return keep_out["margin_deg"] is not None and keep_out["margin_deg"] < 0.0


def _methods(plan: Members) -> Iterator[dict[str, Any]]:
    for slew in plan["comparison"]:
        for axis in slew["ocp"]:
            for method in ("ocp", "spline"):
                yield {"session": slew["session"], "axis": axis, "by": method, **slew[method][axis]}


def _or_jump(value: float | None) -> str:
    return "jump" if value is None else f"{value:.3g}"
