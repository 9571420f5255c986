"""The cache of compiled code holds nothing that was compiled from other sources."""

import re
from pathlib import Path

import planner
from planner.base.compiled import _ROOMS

PLANNER = Path(planner.__file__).parent


def test_every_room_with_kernels_counts_in_the_caches_name() -> None:
    files = [
        path.relative_to(PLANNER).as_posix()
        for path in PLANNER.rglob("*.py")
        if re.search(r"^@(compiled|nested|lean|inlined)$", path.read_text(), re.MULTILINE)
    ]
    assert {room for room in _ROOMS for file in files if file.startswith(room)} == set(_ROOMS)
    assert [file for file in files if not file.startswith(_ROOMS)] == []
