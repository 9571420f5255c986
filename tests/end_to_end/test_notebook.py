"""The notebook of examples/ runs, and shows what it says it does."""

import re

import nbformat
from live_service import live_service
from run_notebook import NOTEBOOK, run_notebook

VARIES = re.compile(r"[0-9a-f]{8}-[0-9a-f-]{27}|<Figure.*>")  # ids, sizes in the screen's dots


def shown(notebook):
    """By cell; what is printed may come in several pieces."""
    return [
        VARIES.sub("", "".join(map(said, cell.outputs)))
        for cell in notebook.cells
        if cell.cell_type == "code"
    ]


def said(output):
    return output.get("text", output.get("data", {}).get("text/plain", ""))


def pictures(notebook):
    return [
        output
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
        if "image/png" in output.get("data", {})
    ]


def test_it_runs_and_shows_what_it_showed(tmp_path):
    kept = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(kept)
    with live_service(tmp_path) as service:
        run = run_notebook(service.address, tmp_path)
    assert shown(run) == shown(kept)
    assert len(pictures(run)) == len(pictures(kept)) >= 2
    assert (tmp_path / "out" / "ljubljana.geojson").stat().st_size > 10_000
