"""Does a cache of compiled code hold nothing that was compiled from other sources?"""

import re
from pathlib import Path

import planner
from planner.compiled import _ROOMS

PLANNER = Path(planner.__file__).parent


def test_every_room_with_kernels_counts_in_the_caches_name() -> None:
    rooms = {
        path.relative_to(PLANNER).parts[0]
        for path in PLANNER.rglob("*.py")
        if re.search(r"^@compiled$", path.read_text(), re.MULTILINE)
    }
    assert rooms == set(_ROOMS)
