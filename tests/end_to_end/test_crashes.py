"""An accepted campaign is finished, once, when the service or a solver is killed in the middle."""

import os
import subprocess
import sys
import uuid
from pathlib import Path

from databases import own_postgresql

ROOT = Path(__file__).parents[2]


def test_kill_9_in_the_middle_of_a_campaign_loses_and_doubles_nothing():
    """One round of resilience.py, which audits the database and fails where it is wrong."""
    small = ["--rounds", "1", "--kills", "2", "--targets", "40", "--days", "0.1"]
    database = ["--database", own_postgresql(uuid.uuid4().hex)]
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("resilience.py")), *small, *database],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": f"{ROOT}:{ROOT / 'tests'}"},
        capture_output=True,
        text=True,
        timeout=580,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "none lost, none doubled" in done.stdout
