"""The parts, two at a time: a module each, with numbers() and, where it draws, pictures(folder)."""

import importlib
import multiprocessing
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from reproduction.statements import Numbers, Row, read_statements, row

# The longest first: two at a time, none then waits alone at the end.
PARTS = (
    "platonov_laws", "platonov_spacecraft", "platonov_imaging", "sumarokov_sessions",
    "lomaka_vertical", "lomaka_experiment", "sumarokov_flight", "sumarokov_orbit",
    "sumarokov_equipment", "sumarokov_attitude", "sumarokov_angles", "sumarokov_transfer",
    "sumarokov_las_vegas", "sumarokov_boston", "sumarokov_modes",
)  # fmt: skip


def computed(name: str, images: Path | None) -> tuple[Numbers, float]:
    """A part's numbers, its pictures drawn where a folder is given, and its CPU seconds."""
    before_s = time.process_time()
    part = importlib.import_module(f"reproduction.{name}")
    numbers = part.numbers()
    if images and hasattr(part, "pictures"):
        part.pictures(images)
    return numbers, time.process_time() - before_s


def rows_of(names: Sequence[str], images: Path | None) -> list[Row]:
    """Two parts at a time, each in a process of its own so that none warms another's caches."""
    started_s, found = time.perf_counter(), {}
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=spawn, max_tasks_per_child=1) as pool:
        done = pool.map(partial(computed, images=images), names)
        for name, (numbers, cpu_s) in zip(names, done, strict=True):
            print(f"{name}: {cpu_s:.1f} s of CPU", flush=True)
            found[name] = numbers
    print(f"{time.perf_counter() - started_s:.0f} s in all")
    return [
        row(one, found.get(one.function or "", {}))
        for one in read_statements()
        if one.function in found or (one.function is None and len(names) == len(PARTS))
    ]
