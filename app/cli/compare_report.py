"""The summary of a comparison of telemetry, on the terminal."""

from rich.console import Console
from rich.text import Text

from app.answers.telemetry import ComparisonResponse
from app.answers.telemetry_axes import AxisComparisonOut
from app.answers.telemetry_samples import SamplesOut
from app.cli.report_parts import or_dash, print_table, print_warnings, report_table

_TIME = slice(11, 23)


def print_comparison(console: Console, answer: ComparisonResponse) -> None:
    """Samples, clock, axes and phases, what they did, what was seen beside."""
    _print_samples(console, answer.samples)
    _print_clock(console, answer)
    table = report_table(
        "errors",
        *(
            "<axis",
            "<phase",
            "<from",
            "samples",
            "rms arcsec",
            "max arcsec",
            "mean arcsec",
            "lag ms",
            "1 sigma",
        ),
    )
    for name, axis in answer.axes.items():
        table.add_row(
            Text(name),
            f"all, of {axis.basis}",
            "",
            str(axis.samples),
            *(f"{size:.2f}" for size in (axis.rms_arcsec, axis.max_arcsec, axis.mean_arcsec)),
            *(
                or_dash(None if size is None else 1e3 * size, ".2f")
                for size in (axis.lag_s, axis.lag_sigma_s)
            ),
        )
        for phase in axis.phases:
            session = "" if phase.session is None else f" {phase.session + 1}"
            table.add_row(
                "",
                f"{phase.kind}{session}",
                phase.start[_TIME],
                str(phase.samples),
                *(
                    or_dash(size, ".2f")
                    for size in (phase.rms_arcsec, phase.max_arcsec, phase.mean_arcsec)
                ),
                "",
                "",
            )
    print_table(console, table)
    for name, axis in answer.axes.items():
        _print_what_it_did(console, name, axis)
    for parts in answer.pointing:
        along, across = parts.attitude_arcsec
        console.print(
            f"{parts.at[_TIME]} by {parts.measured}: attitude moves the target by "
            f"{along:+.1f}, {across:+.1f} arcsec in the frame"
        )
    for one in answer.parameters:
        error = "" if one.sigma is None else f", 1 sigma {one.sigma:.2g}"
        console.print(Text(f"{one.name} {one.found:.4g}{error}; planned with {one.planned:.4g}"))
    print_warnings(console, answer.warnings)


def _print_clock(console: Console, answer: ComparisonResponse) -> None:
    offset, drift = answer.time_offset_s, answer.clock_drift
    console.print(
        f"clock {offset.value:+.6f} s ahead at {answer.epoch}, 1 sigma {offset.sigma:.2g}; "
        f"drift {1e6 * drift.value:+.3f} ppm, 1 sigma {1e6 * drift.sigma:.2g}"
    )
    console.print(f"  if {offset.assumes}")
    if common := answer.common_offset_s:
        console.print(f"clock {common.value:+.6f} s, 1 sigma {common.sigma:.2g}")
        console.print(f"  if {common.assumes}")
    if (ideal := answer.ideal_offset_s) and (ideal_drift := answer.ideal_drift):
        console.print(
            f"clock {ideal.value:+.6f} s, 1 sigma {ideal.sigma:.2g}; "
            f"drift {1e6 * ideal_drift.value:+.3f} ppm, 1 sigma {1e6 * ideal_drift.sigma:.2g}"
        )
        console.print(f"  if {ideal.assumes}")
    for pair in answer.inseparable:
        console.print(
            Text(f"{' and '.join(pair.members)} are hardly told apart: {pair.correlation:+.3f}")
        )


def _print_samples(console: Console, samples: SamplesOut) -> None:
    lost = ", ".join(f"{count} {reason}" for reason, count in samples.dropped.items())
    units = ", ".join(f"{column.name} in {column.unit}" for column in samples.columns)
    console.print(
        Text(
            f"{samples.used} of {samples.read} rows used"
            + (f" (dropped: {lost})" if lost else "")
            + f", {samples.start[_TIME]} to {samples.stop[_TIME]}, {len(samples.gaps)} gaps; "
            + units
        )
    )


def _print_what_it_did(console: Console, name: str, axis: AxisComparisonOut) -> None:
    if axis.gain and axis.bias:
        console.print(
            Text(
                f"{name} gain {axis.gain.value:.7f}, 1 sigma {axis.gain.sigma:.2g}; "
                f"bias {axis.bias.value:+.3f} {axis.bias_unit}, 1 sigma {axis.bias.sigma:.2g}"
            )
        )
    for swing in axis.oscillations:
        console.print(
            Text(
                f"{name} oscillates {swing.start[_TIME]} to {swing.stop[_TIME]}: "
                f"{swing.frequency_hz:.3f} Hz, {swing.amplitude_arcsec:.2f} arcsec"
            )
        )
    for stuck in axis.stick_slip:
        console.print(
            Text(
                f"{name} sticks and slips {stuck.start[_TIME]} to {stuck.stop[_TIME]}: "
                f"{stuck.slips} slips of up to {stuck.slip_arcsec:.2f} arcsec below "
                f"{stuck.rate_arcsec_s:.1f} arcsec/s"
            )
        )
    for beyond in axis.limits_exceeded:
        console.print(
            Text(
                f"{name} {beyond.limit} {beyond.value:g} {beyond.unit} beyond {beyond.bound:g} "
                f"from {beyond.start[_TIME]} to {beyond.stop[_TIME]}",
                style="red",
            )
        )
