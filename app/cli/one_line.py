"""Errors of a command: one line on stderr, the ways out below it, and an exit code."""

import os
import shlex
import sys
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from app.log.exceptions import describe_error
from planner.base.errors import Refusal, Unverified

if TYPE_CHECKING:
    from slewtrack.client import Problem, Relaxation

FAILED, REFUSED = 1, 2
_CHARACTERS_MAX = 2000


@contextmanager
def one_line_for_what_goes_wrong(words: Sequence[str] = ()) -> Iterator[None]:
    """Turn whatever is raised inside into that line and the exit; words: the command's."""
    try:
        yield
    except (typer.Exit, typer.Abort, typer.TyperException):
        raise  # Typer's own
    except Refusal as refusal:
        ours = refusal.blame == "ours" or getattr(refusal, "is_failure", False)
        failed = ours or isinstance(refusal, Unverified)
        say(_with_field(refusal))
        _say_ways_out(refusal, words)
        raise typer.Exit(FAILED if failed else REFUSED) from None
    except BrokenPipeError:  # who reads our output has enough, as `head` has
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(FAILED) from None
    except OSError as error:
        say(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        raise typer.Exit(REFUSED) from None
    except Exception as error:  # noqa: BLE001 (the edge: a user gets one line, not a traceback)
        by_driver = type(error).__module__.startswith(("sqlalchemy", "psycopg", "sqlite3"))
        text = describe_error(error) if by_driver else f"{type(error).__name__}: {error}"
        say(f"internal error: {text}")
        raise typer.Exit(FAILED) from None


def say(text: str) -> None:
    """One line that steers no terminal, whatever the text holds."""
    print(f"slewtrack: {_printable(text)}", file=sys.stderr)


def _printable(text: str) -> str:
    line = " ".join(text.split())[:_CHARACTERS_MAX]
    return "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in line)


def _say_ways_out(refusal: Refusal, words: Sequence[str]) -> None:
    from app.answers.problem import problem_of as members_of
    from slewtrack.client import problem_of

    problem = getattr(refusal, "problem", None) or problem_of(members_of(refusal))
    for line in _ways_out(problem, words):
        print(f"  {_printable(line)}", file=sys.stderr)


def _ways_out(problem: "Problem", words: Sequence[str]) -> Iterator[str]:
    """Lines; words: of the command that was refused, the program's name first."""
    for fault in problem.errors[1:]:
        yield f"{fault.field}: {fault.detail}"
    for offer in problem.relaxations:
        yield f"with on_conflict {offer.on_conflict}, {_loss(offer)}"
    if words[1:2] in (["plan"], ["fly"]):
        for number, change in enumerate(problem.ways_out):
            sets = [f"--set={field}={value}" for field, value in change.items()]
            kept = _without(words, change)
            yield f"{'or:  ' if number else 'try: '}{shlex.join([*kept, *sets])}"


def _without(words: Sequence[str], fields: Collection[str]) -> list[str]:
    """The words but for those that set one of these fields."""
    kept: list[str] = []
    for word in words:
        whole = f"--set={word}" if kept[-1:] == ["--set"] else word
        if whole.startswith("--set=") and whole[6:].partition("=")[0] in fields:
            del kept[len(kept) - (whole != word) :]
        else:
            kept.append(word)
    return kept


def _loss(offer: "Relaxation") -> str:
    losses = {
        f"starts {offer.start_later_s:.1f} s later": offer.start_later_s,
        f"stops {offer.stop_earlier_s:.1f} s earlier": offer.stop_earlier_s,
    }
    told = " and ".join(text for text, lost_s in losses.items() if lost_s > 0.0)
    return f"session {offer.session + 1} {told or 'loses nothing'}"


def _with_field(refusal: Refusal) -> str:
    if refusal.field is None or refusal.detail.startswith(refusal.field):
        return refusal.detail
    return f"{refusal.field}: {refusal.detail}"
