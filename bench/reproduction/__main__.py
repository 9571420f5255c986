"""Every figure and number the papers state, computed and drawn anew.

    PYTHONPATH=.:bench python -m reproduction [--check | --only SECTION...]

Without options: docs/reproduction.csv, docs/reproduction.md and docs/images/reproduction_*.png.
--check: nothing is written; exit 1 when a number has moved by more than its tolerance, a verdict
has changed or the document isn't that of the kept rows.
--only: sections as statements.toml names them, printed; their pictures into out/.
"""

import argparse
import sys
from pathlib import Path

from reproduction import report


def main() -> int:
    parser = argparse.ArgumentParser(prog="reproduction", description=__doc__)
    parser.add_argument("--check", action="store_true")
    known = [f"{paper}.{name}" for paper, names in report.sections().items() for name in names]
    parser.add_argument("--only", nargs="+", choices=known)
    asked = parser.parse_args()
    if asked.only:
        images = Path("out")
        images.mkdir(exist_ok=True)
        for one in report.rows_of(report.sections(asked.only), images):
            print(f"{one.name}: {one.stated} | {one.ours} {one.unit} | {one.verdict} {one.result}")
            print(f"    {one.why}")
        return 0
    if asked.check:
        before = report.read()
        found = report.differences(report.rows_of(report.sections(), None), before)
        if report.DOCUMENT.read_text(encoding="utf-8") != report.document(before):
            found.append("docs/reproduction.md isn't what docs/reproduction.csv makes")
        print("\n".join(found) or f"{len(before)} statements as kept")
        return 1 if found else 0
    report.write(report.rows_of(report.sections(), report.IMAGES))
    report.DOCUMENT.write_text(report.document(report.read()), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
