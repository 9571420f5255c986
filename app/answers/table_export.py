"""A plan's table by itself, in one of the registered formats."""

import re
from collections.abc import Iterable

from planner.errors import Unverified
from planner.verification import Finding

NAME_MAX = 60


def file_name(name: str, otherwise: str, suffix: str) -> str:
    """From a plan's name, in letters, digits and hyphens."""
    words = re.findall(r"[A-Za-z0-9]+", name)
    return ("-".join(words)[:NAME_MAX] or otherwise) + suffix


def require_verified(findings: Iterable[Finding]) -> None:
    """Raise Unverified when the judge found an error: a file by itself carries no verdict."""
    for finding in findings:
        if finding.severity == "error":
            raise Unverified(
                f"the table failed its verification: {finding.detail}; only the whole answer "
                "holds it, beside the verdict",
                field="slew.method",
                axis=finding.axis,
                limit=finding.limit,
                at_utc=finding.at_utc,
            )
