"""No text of a CSV that anything of ours writes is taken for a formula by a spreadsheet."""

import ast
import csv
import io
import json
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from test_export_formats import CREATED_UTC, plan_of

from app.cli.windows import windows_csv
from app.requests.examples import OPPORTUNITY_EXAMPLES
from app.work.campaign import looks_csv
from app.work.searches import CSV, opened, read_opportunity_request
from planner.base.answer_members import member_names
from planner.base.csv_cells import comment_lines, csv_lines
from planner.inflight.telemetry.following import PlannedMotion
from planner.inflight.telemetry.table import write_comparison_csv
from planner.output.export import EXPORTERS
from planner.output.windows.forms import pass_table_csv
from planner.output.windows.rows import rows_json, window_columns
from planner.planning.campaigns.chosen import ChosenLook
from planner.planning.opportunities import find_opportunities

ROOT = Path(__file__).parents[2]
FOUND = find_opportunities(
    read_opportunity_request(json.dumps(OPPORTUNITY_EXAMPLES["cities"][1]).encode())
)
FORMULAS = (
    *("=cmd|' /C calc'!A0", "+1+1", "-1+cmd|' /C calc'!A0", "@SUM(1+1)", "\t=1+1", "\r=1+1"),
    *('=HYPERLINK("http://evil","x")', "a,=1+1", "a;@x", "＝1+1", '"=1', "a\n=1", "-1"),
)
STARTS = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")
NUMBER = re.compile(r"[+-]?\d+(\.\d+)?(e[+-]?\d+)?\]?")


def cells_of(content: str):
    """As a spreadsheet reads them, whichever separator it takes for one."""
    for line in csv.reader(io.StringIO(content, newline="")):
        yield from line
    for delimiter in ",;\t":
        for line in content.split("\n"):
            if line.startswith("#"):
                yield from (cell.strip() for cell in line.split(delimiter))


def assert_no_formula(content: str) -> None:
    cells = [*cells_of(content)]
    assert cells
    for cell in cells:
        assert NUMBER.fullmatch(cell) or not cell.startswith(STARTS), cell


def table_csv(text):
    return EXPORTERS["csv"].write(plan_of(name=text, outer=text), CREATED_UTC).decode()


def windows_of(text):
    ids = [text] * len(FOUND.ids)
    told = SimpleNamespace(angle_names=(text, "beta"), has_branches=True)
    return rows_json(window_columns(FOUND.start_utc, ids, told, FOUND.windows))


def opportunities_csv(text):
    return opened(CSV, "", b"", None).decode() + pass_table_csv(windows_of(text))


def search_csv(text):
    return windows_csv([json.loads(one) for one in windows_of(text)])


def campaign_csv(text):
    look = dict.fromkeys(member_names(ChosenLook).values(), -0.5)
    return looks_csv([{"pass": 1, "carrier": text, **look, "target": text}])


def compared_csv(text):
    plan = plan_of(name=text, outer=text)
    motion = PlannedMotion(plan.table, 0)
    followed = SimpleNamespace(motion=motion, t_s=plan.table.t_s, error_rad=-plan.table.t_s)
    axes = (SimpleNamespace(name=text, followed=followed),)
    return write_comparison_csv(SimpleNamespace(plan=plan, axes=axes), CREATED_UTC).decode()


WRITERS = {
    "write_csv": table_csv,
    "pass_table_csv": opportunities_csv,
    "windows_csv": search_csv,
    "looks_csv": campaign_csv,
    "write_comparison_csv": compared_csv,
}
# What these are made with, what only shortens the CSV of a service, and what reads.
PARTS = {"_looks_csv", "table_csv", "rows_csv", "read_csv", "_csv"}
ANY_CSV = re.compile("csv|savetxt")


@pytest.mark.parametrize("text", FORMULAS)
@pytest.mark.parametrize("name", WRITERS)
def test_no_text_is_a_formula(name, text):
    content = WRITERS[name](text)
    assert_no_formula(content)
    rows = [line for line in csv.reader(io.StringIO(content, newline="")) if len(line) > 3]
    header, *body = [row for row in rows if not row[0].startswith("#")]
    assert body
    assert all(len(row) == len(header) for row in body)
    if name in ("pass_table_csv", "windows_csv", "looks_csv"):
        texts = {cell for row in body for cell in row}
        assert texts & {text, f"'{text}"}  # nothing of it is lost


def test_numbers_stay_numbers():
    assert csv_lines([["a", -1.5, -1e-7, 3, None, True, "2015-02-27"]]) == (
        "a,-1.5,-1e-07,3,,True,2015-02-27\n"
    )
    assert comment_lines(["zero [0, -1, -0.5e-3], a,-1+x"]) == "# zero [0, -1, -0.5e-3], a,'-1+x\n"


def test_every_writer_of_csv_is_one_of_these():
    """None writes cells by itself, and none goes without the test above."""
    for package in ("app", "planner", "estimator", "slewtrack"):
        for file in (ROOT / package).rglob("*.py"):
            text = file.read_text()
            if not ANY_CSV.search(text):
                continue  # to parse all would take seconds
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.Attribute) and node.attr in ("writer", "DictWriter"):
                    assert not (isinstance(node.value, ast.Name) and node.value.id == "csv"), file
                if isinstance(node, ast.Attribute):
                    assert node.attr not in ("savetxt", "to_csv"), file
                if isinstance(node, ast.FunctionDef) and node.name.endswith("_csv"):
                    assert node.name in WRITERS.keys() | PARTS, f"{file}: {node.name}"
