"""The summary of a measured vertical on the terminal."""

import math

from rich.console import Console
from rich.text import Text

from app.cli.report_parts import or_dash, print_table, print_warnings, report_table
from app.work.horizon_series import Series, frame_out
from estimator.check import Verdict
from estimator.pipeline import Nadir, VerticalEstimate

_STYLES = {Verdict.INCONSISTENT: "red", Verdict.NOT_OBSERVABLE: "yellow"}


def print_estimate(console: Console, estimate: VerticalEstimate) -> None:
    """Verdict, nadirs, check, cameras, warnings."""
    console.print(_verdict(estimate.verdict, estimate.reason))
    for name, nadir in (("geocentric", estimate.geocentric), ("geodetic", estimate.geodetic)):
        if nadir is not None:
            console.print(_nadir(name, nadir))
    if estimate.limb_height_m is not None and estimate.limb_height_sigma_m is not None:
        console.print(
            f"limb {estimate.limb_height_m / 1e3:.1f} km high, "
            f"1 sigma {estimate.limb_height_sigma_m / 1e3:.1f} km"
        )
    if estimate.check is not None:
        check = estimate.check
        console.print(
            f"off the prediction by {math.degrees(check.angle_rad):.4f} deg "
            f"({math.degrees(check.along_rad):+.4f} along, "
            f"{math.degrees(check.across_rad):+.4f} across), probability {check.probability:.2g}",
        )
    table = report_table(None, "<camera", "arc deg", "residual px", "<used", wrapped="used")
    for camera in estimate.cameras:
        residual = "-" if math.isnan(camera.residual_px) else f"{camera.residual_px:.2f}"
        used = "yes" if camera.used else f"no: {camera.reason or estimate.reason}"
        table.add_row(Text(camera.name), f"{camera.arc_deg:.1f}", residual, used)
    print_table(console, table)
    print_warnings(console, estimate.warnings)


def print_series(console: Console, series: Series) -> None:
    """One line per frame, then the bias."""
    table = report_table(
        None,
        "<UTC",
        "<verdict",
        "sigma deg",
        "along deg",
        "across deg",
        "<reason",
        wrapped="reason",
    )
    for request, estimate in zip(series.requests, series.estimates, strict=True):
        line = frame_out(request, estimate)
        table.add_row(
            line.at,
            line.verdict,
            *(or_dash(value, ".4f") for value in (line.sigma_deg, line.along_deg, line.across_deg)),
            line.reason or "",
        )
    print_table(console, table)
    report = series.report
    console.print(_verdict(report.verdict, None))
    if report.used:
        for name, bias, scatter, variance in zip(
            ("along", "across"),
            report.bias_rad,
            report.scatter_rad,
            report.covariance_rad2.diagonal(),
            strict=True,
        ):
            console.print(
                f"bias {name} {math.degrees(bias):+.4f} deg, 1 sigma "
                f"{math.degrees(math.sqrt(variance)):.4f}, scatter {math.degrees(scatter):.4f}"
            )
        console.print(
            f"{report.used} of {len(series.estimates)} frames used, probability "
            f"{report.probability:.2g}"
        )


def _verdict(verdict: Verdict, reason: str | None) -> Text:
    text = verdict.replace("_", " ") + (f": {reason}" if reason else "")
    return Text(text, style=_STYLES.get(verdict, "green"))


def _nadir(name: str, nadir: Nadir) -> str:
    x, y, z = nadir.nadir_body
    sigma_deg = math.degrees(nadir.sigma_rad)
    return f"{name} nadir in body axes [{x:.6f}, {y:.6f}, {z:.6f}], 1 sigma {sigma_deg:.4f} deg"
