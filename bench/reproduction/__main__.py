"""Every figure and number the papers state, computed and drawn anew.

    PYTHONPATH=.:bench python -m reproduction [--check | --only PART...]

Without options: docs/reproduction.md, docs/images/reproduction_*.png and the kept numbers.
--check: nothing is written; exit 1 when a number has moved by more than its tolerance.
--only: the parts named, printed; their pictures into out/.
"""

import argparse
import sys
from pathlib import Path

from reproduction import kept
from reproduction.build import build
from reproduction.parts import PARTS
from reproduction.report import document

ROOT = Path(__file__).parents[2]
DOCUMENT = ROOT / "docs/reproduction.md"
IMAGES = ROOT / "docs/images"


def main() -> int:
    parser = argparse.ArgumentParser(prog="reproduction", description=__doc__)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--only", nargs="+", choices=PARTS)
    asked = parser.parse_args()
    if asked.only:
        images = ROOT / "out"
        images.mkdir(exist_ok=True)
        print(document(build(asked.only, images)))
        return 0
    if asked.check:
        stated = [one for section in build(PARTS, None) for one in section.statements]
        found = kept.differences(stated, kept.read(), DOCUMENT.read_text(encoding="utf-8"))
        print("\n".join(found) or f"{len(stated)} statements as kept")
        return 1 if found else 0
    for old in IMAGES.glob("reproduction_*.png"):
        old.unlink()
    sections = build(PARTS, IMAGES)
    kept.write(one for section in sections for one in section.statements)
    DOCUMENT.write_text(document(sections), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
