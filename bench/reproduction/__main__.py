"""Every figure and number the papers state, computed and drawn anew.

    PYTHONPATH=.:bench python -m reproduction [--check | --only PART...]

Without options: docs/reproduction.csv, docs/reproduction.md and docs/images/reproduction_*.png.
--check: nothing is written; exit 1 when a number has moved by more than its tolerance, a verdict
has changed or the document isn't that of the kept rows.
--only: the parts named, printed; their pictures into out/.
"""

import argparse
import sys
from pathlib import Path

from reproduction import kept
from reproduction.build import PARTS, rows_of


def main() -> int:
    parser = argparse.ArgumentParser(prog="reproduction", description=__doc__)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--only", nargs="+", choices=PARTS)
    asked = parser.parse_args()
    if asked.only:
        images = Path("out")
        images.mkdir(exist_ok=True)
        for one in rows_of(asked.only, images):
            print(f"{one.name}: {one.stated} | {one.ours} {one.unit} | {one.verdict} {one.result}")
            print(f"    {one.why}")
        return 0
    if asked.check:
        before = kept.read()
        found = kept.differences(rows_of(PARTS, None), before)
        if kept.DOCUMENT.read_text(encoding="utf-8") != kept.document(before):
            found.append("docs/reproduction.md isn't what docs/reproduction.csv makes")
        print("\n".join(found) or f"{len(before)} statements as kept")
        return 1 if found else 0
    for old in kept.IMAGES.glob("reproduction_*.png"):
        old.unlink()
    kept.write(rows_of(PARTS, kept.IMAGES))
    kept.DOCUMENT.write_text(kept.document(kept.read()), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
