"""The parts, computed and drawn two at a time."""

import multiprocessing
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from reproduction.parts import load, text
from reproduction.report import Section


def section(name: str, images: Path | None) -> tuple[Section, float]:
    """One part of the report, drawn where a folder is given, and its CPU seconds."""
    before_s = time.process_time()
    part = load(name)
    stated = part.statements()
    pictures = part.pictures(images) if images else []
    return Section(text(name), stated, pictures), time.process_time() - before_s


def build(names: Sequence[str], images: Path | None) -> list[Section]:
    """Two parts at a time, each in a process of its own so that none warms another's caches."""
    started_s = time.perf_counter()
    sections = []
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=spawn, max_tasks_per_child=1) as pool:
        built = pool.map(partial(section, images=images), names)
        for name, (one, cpu_s) in zip(names, built, strict=True):
            print(f"{name}: {len(one.statements)} statements, {cpu_s:.1f} s of CPU", flush=True)
            sections.append(one)
    print(f"{time.perf_counter() - started_s:.0f} s in all")
    return sections
