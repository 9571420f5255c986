"""Runs the notebook of examples/ against a service of its own; by itself it keeps what it shows.

PYTHONPATH=.:tests python tests/end_to_end/run_notebook.py
"""

import os
import tempfile
from pathlib import Path

import nbformat
from live_service import live_service
from nbclient import NotebookClient

ROOT = Path(__file__).parents[2]
NOTEBOOK = ROOT / "examples" / "planners_day.ipynb"


def run_notebook(address: str, folder: Path) -> nbformat.NotebookNode:
    """As it is after all its cells have run, in a folder that has the examples."""
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    (folder / "examples").symlink_to(ROOT / "examples")
    runner = NotebookClient(
        notebook,
        timeout=300,
        kernel_name="python3",
        resources={"metadata": {"path": str(folder)}},
        record_timing=False,
    )
    runner.execute(env=os.environ | {"SLEWTRACK_URL": address, "PYTHONPATH": str(ROOT)})
    return notebook


def main() -> None:
    with tempfile.TemporaryDirectory() as name, live_service(Path(name)) as service:
        notebook = run_notebook(service.address, Path(name))
    notebook.metadata.pop("language_info", None)
    nbformat.write(notebook, NOTEBOOK)


if __name__ == "__main__":
    main()
