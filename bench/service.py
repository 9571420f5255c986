"""The cost of storage and jobs beside the bare solve, and the service's memory over time.

Solves the example in this process and posts it to a service on loopback, turn by turn, so that
both meet the same machine.  The bare solve goes as far as the answer's bytes.  Prints p50 and
p95 of both, of their difference pair by pair, and the service's memory along the way.

    python bench/service.py [--pairs 100]
"""

import argparse
import json
import os
import tempfile
import time
import zlib
from pathlib import Path

import httpx2 as httpx
import numpy as np
from plan import EXAMPLE, running_service

from app.answers.members import new_head, whole_answer
from app.work.plan import plan_and_pack, stored_table_json

WARM_UP = 10


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--database-url", default="", help="PostgreSQL in place of SQLite")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ |= {"SLEWTRACK_DATA_DIR": folder, "SLEWTRACK_DATABASE_URL": given.database_url}
        with running_service() as (client, pid):
            _report(*_measured(client, pid, given.pairs))


def _measured(
    client: httpx.Client, pid: int, pairs: int
) -> tuple[list[float], list[float], list[float]]:
    request = json.loads(EXAMPLE.read_text())
    bare_s, whole_s, memory_mib = [], [], []
    for number in range(pairs + WARM_UP):
        # A start of its own for every pair, so that nothing can be answered from memory.
        request["initial_state"]["angles_deg"] = {"alpha": -30.0 + 0.25 * number, "beta": 5.0}
        body = json.dumps(request).encode()
        began_s = time.perf_counter()
        made = plan_and_pack(body)
        table = stored_table_json(made.table_columns)
        whole_answer(new_head(made.state), zlib.decompress(made.document), table)
        bare_s.append(time.perf_counter() - began_s)
        began_s = time.perf_counter()
        answer = client.post(
            "/v1/plans", content=body, headers={"Content-Type": "application/json"}
        )
        whole_s.append(time.perf_counter() - began_s)
        answer.raise_for_status()
        memory_mib.append(_memory_mib(pid))
    return bare_s[WARM_UP:], whole_s[WARM_UP:], memory_mib[WARM_UP:]


def _memory_mib(pid: int) -> float:
    """Resident memory of the service itself."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def _report(bare_s: list[float], whole_s: list[float], memory_mib: list[float]) -> None:
    rows = {
        "bare solve": np.array(bare_s),
        "POST /v1/plans": np.array(whole_s),
        "difference": np.array(whole_s) - np.array(bare_s),
    }
    print(f"{len(bare_s)} pairs\n{'':<16}{'p50 ms':>9}{'p95 ms':>9}")
    for name, seconds in rows.items():
        p50, p95 = np.percentile(seconds, [50, 95]) * 1e3
        print(f"{name:<16}{p50:>9.1f}{p95:>9.1f}")
    ratio = np.median(whole_s) / np.median(bare_s)
    quarter = len(memory_mib) // 4 or 1
    first, last = np.median(memory_mib[:quarter]), np.median(memory_mib[-quarter:])
    print(f"ratio of the medians {ratio:.3f}")
    print(f"memory, first and last quarter: {first:.1f} MiB, {last:.1f} MiB")


if __name__ == "__main__":
    main()
