"""What tests of the planner's page share."""

from pathlib import Path

from playwright.sync_api import Page

ROOT = Path(__file__).parents[2]
LAPTOP = {"width": 1280, "height": 800}
PHONE = {"width": 390, "height": 844}
_AXE = ROOT / "web/node_modules/axe-core/axe.min.js"


def violations(page: Page) -> list[str]:
    """What axe-core finds wrong on the page as it is."""
    page.evaluate(_AXE.read_text())
    found = page.evaluate("axe.run()")
    return [
        f"{one['id']} ({one['impact']}): {node['html'][:200]}"
        for one in found["violations"]
        for node in one["nodes"]
    ]
