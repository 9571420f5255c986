"""The report of flights on the terminal."""

from rich.console import Console
from rich.text import Text

from app.cli.plan_report import session_number
from app.cli.planner import Members
from app.cli.report_parts import print_rows, print_warnings


def print_flights(console: Console, found: Members) -> None:
    """Probabilities, sessions, what is to blame, warnings."""
    console.print(
        Text.assemble(
            (f"{found['flown']} flights", "bold"),
            f" (seed {found['seed']}): all frames hold their target with a probability of ",
            (_in_frame(found), "bold"),
            ", sharp as well ",
            (_sharp(found), "bold"),
            "; between brackets 95 % confidence",
        )
    )
    print_rows(
        console,
        "under errors",
        found["sessions"],
        ("session", "session", session_number),
        ("<target", "label"),
        ("told", "budget_probability_in_frame", ".3f"),
        ("in frame", _in_frame),
        ("sharp", _sharp),
        ("frames held", "frames_held", ".1%"),
        ("frames sharp", "frames_sharp", ".1%"),
        ("smear px", lambda one: one["smear_px"] and one["smear_px"][1], ".2f"),
        ("miss m", lambda one: one["miss_m"] and one["miss_m"][1], ".0f"),
    )
    print_rows(
        console,
        "as planned",
        ({"session": one["session"], **one["nominal"]} for one in found["sessions"]),
        ("session", "session", session_number),
        ("frames", "frames"),
        ("held", "held"),
        ("sharp", "sharp"),
        ("error arcsec", lambda one: max(one["error_arcsec"]), ".2f"),
        ("smear px", lambda one: max(one["smear_px"]), ".2f"),
        ("sample m", lambda one: min(one["ground_sample_across_m"] or (), default=None), ".2f"),
        ("object px", "moving_object_px", _range),
    )
    print_rows(
        console,
        "to blame",
        found["contributors"],
        ("<cause", "cause"),
        ("of misses", "share", ".1%"),
        ("+-", "share_sigma", ".1%"),
        ("of smear", "smear_share", ".1%"),
        ("+-", "smear_share_sigma", ".1%"),
    )
    print_warnings(console, found["warnings"])


def _in_frame(one: Members) -> str:
    return _probability(one["probability_in_frame"], one["in_frame_interval"])


def _sharp(one: Members) -> str:
    return _probability(one["probability_sharp"], one["sharp_interval"])


def _probability(value: float | None, share_interval: list[float] | None) -> str:
    if value is None or share_interval is None:
        return "-"
    return f"{value:.3f} ({share_interval[0]:.3f}..{share_interval[1]:.3f})"


def _range(moved_px: list[float] | None) -> str:
    return f"{min(moved_px):.0f}..{max(moved_px):.0f}" if moved_px else "-"
