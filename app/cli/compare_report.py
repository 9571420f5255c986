"""The summary of a comparison of telemetry, on the terminal."""

from collections.abc import Iterator
from typing import Any

from rich.console import Console
from rich.text import Text

from app.cli.planner import Members
from app.cli.report_parts import print_rows, print_warnings

_TIME = slice(11, 23)


def print_comparison(console: Console, answer: Members) -> None:
    """Samples, clock, axes and phases, what they did, what was seen beside."""
    for line in (*_samples(answer["samples"]), *_clock(answer)):
        console.print(Text(line))
    print_rows(
        console,
        "errors",
        _errors(answer),
        ("<axis", "axis"),
        ("<phase", "phase"),
        ("<from", "from"),
        ("samples", "samples"),
        ("rms arcsec", "rms_arcsec", ".2f"),
        ("max arcsec", "max_arcsec", ".2f"),
        ("mean arcsec", "mean_arcsec", ".2f"),
        ("lag ms", "lag_s", _milliseconds),
        ("1 sigma", "lag_sigma_s", _milliseconds),
    )
    for name, axis in answer["axes"].items():
        for line, style in _what_it_did(name, axis):
            console.print(Text(line, style=style))
    for parts in answer["pointing"]:
        along, across = parts["attitude_arcsec"]
        console.print(
            f"{parts['at'][_TIME]} by {parts['measured']}: attitude moves the target by "
            f"{along:+.1f}, {across:+.1f} arcsec in the frame"
        )
    for one in answer["parameters"]:
        error = "" if one["sigma"] is None else f", 1 sigma {one['sigma']:.2g}"
        told = f"{one['name']} {one['found']:.4g}{error}; planned with {one['planned']:.4g}"
        console.print(Text(told))
    print_warnings(console, answer["warnings"])


def _samples(samples: Members) -> Iterator[str]:
    lost = ", ".join(f"{count} {reason}" for reason, count in samples["dropped"].items())
    units = ", ".join(f"{column['name']} in {column['unit']}" for column in samples["columns"])
    yield (
        f"{samples['used']} of {samples['read']} rows used"
        + (f" (dropped: {lost})" if lost else "")
        + f", {samples['start'][_TIME]} to {samples['stop'][_TIME]}, {len(samples['gaps'])} gaps; "
        + units
    )


def _clock(answer: Members) -> Iterator[str]:
    offset, drift = answer["time_offset_s"], answer["clock_drift"]
    since = f" ahead at {answer['epoch']}"
    yield f"{_ahead(offset, since)}; {_drift(drift)}"
    yield f"  if {offset['assumes']}"
    if common := answer["common_offset_s"]:
        yield _ahead(common)
        yield f"  if {common['assumes']}"
    if (ideal := answer["ideal_offset_s"]) and (ideal_drift := answer["ideal_drift"]):
        yield f"{_ahead(ideal)}; {_drift(ideal_drift)}"
        yield f"  if {ideal['assumes']}"
    for pair in answer["inseparable"]:
        yield f"{' and '.join(pair['members'])} are hardly told apart: {pair['correlation']:+.3f}"


def _ahead(offset: Members, since: str = "") -> str:
    return f"clock {offset['value']:+.6f} s{since}, 1 sigma {offset['sigma']:.2g}"


def _drift(drift: Members) -> str:
    return f"drift {1e6 * drift['value']:+.3f} ppm, 1 sigma {1e6 * drift['sigma']:.2g}"


def _errors(answer: Members) -> Iterator[dict[str, Any]]:
    """Of each axis, then of its phases, which have no lag of their own."""
    for name, axis in answer["axes"].items():
        yield {**axis, "axis": name, "phase": f"all, of {axis['basis']}", "from": ""}
        for phase in axis["phases"]:
            session = "" if phase["session"] is None else f" {phase['session'] + 1}"
            told = {"axis": "", "phase": f"{phase['kind']}{session}", "from": phase["start"][_TIME]}
            yield {**phase, **told, "lag_s": "", "lag_sigma_s": ""}


def _milliseconds(size: float | str | None) -> str:
    return size if isinstance(size, str) else "-" if size is None else f"{1e3 * size:.2f}"


def _what_it_did(name: str, axis: Members) -> Iterator[tuple[str, str]]:
    """Lines, and the style of each."""
    if (gain := axis["gain"]) and (bias := axis["bias"]):
        yield (
            (
                f"{name} gain {gain['value']:.7f}, 1 sigma {gain['sigma']:.2g}; "
                f"bias {bias['value']:+.3f} {axis['bias_unit']}, 1 sigma {bias['sigma']:.2g}"
            ),
            "",
        )
    for swing in axis["oscillations"]:
        yield (
            (
                f"{name} oscillates {_span(swing)}: "
                f"{swing['frequency_hz']:.3f} Hz, {swing['amplitude_arcsec']:.2f} arcsec"
            ),
            "",
        )
    for stuck in axis["stick_slip"]:
        yield (
            (
                f"{name} sticks and slips {_span(stuck)}: "
                f"{stuck['slips']} slips of up to {stuck['slip_arcsec']:.2f} arcsec below "
                f"{stuck['rate_arcsec_s']:.1f} arcsec/s"
            ),
            "",
        )
    for beyond in axis["limits_exceeded"]:
        yield (
            (
                f"{name} {beyond['limit']} {beyond['value']:g} {beyond['unit']} beyond "
                f"{beyond['bound']:g} from {_span(beyond)}"
            ),
            "red",
        )


def _span(stretch: Members) -> str:
    return f"{stretch['start'][_TIME]} to {stretch['stop'][_TIME]}"
