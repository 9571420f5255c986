"""The lines below a refusal: each fault, each offer, and commands that would work."""

import shlex
from collections.abc import Collection, Iterator, Sequence

from slewtrack.client import Problem, Relaxation


def ways_out(problem: Problem, words: Sequence[str]) -> Iterator[str]:
    """Lines; words: of the command that was refused, the program's name first."""
    for fault in problem.errors[1:]:
        yield f"{fault.field}: {fault.detail}"
    for offer in problem.relaxations:
        yield f"with on_conflict {offer.on_conflict}, {_loss(offer)}"
    if words[1:2] == ["plan"]:
        for number, change in enumerate(_changes(problem)):
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


def _loss(offer: Relaxation) -> str:
    losses = {
        f"starts {offer.start_later_s:.1f} s later": offer.start_later_s,
        f"stops {offer.stop_earlier_s:.1f} s earlier": offer.stop_earlier_s,
    }
    told = " and ".join(text for text, lost_s in losses.items() if lost_s > 0.0)
    return f"session {offer.session + 1} {told or 'loses nothing'}"


def _changes(problem: Problem) -> Iterator[dict[str, str]]:
    """Fields and what to set them to; each was tried by planning the request with it."""
    session = (problem.field or "").rpartition(".")[0]
    start = problem.earliest_feasible_start
    if start is not None and session.startswith("sessions.") and not problem.costs_sessions:
        stop = problem.feasible_stop
        yield {f"{session}.start": start, **({f"{session}.stop": stop} if stop else {})}
    for name in dict.fromkeys(offer.on_conflict for offer in problem.relaxations):
        yield {"on_conflict": name}
