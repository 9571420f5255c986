"""Takes the pictures of README and docs/read_a_plan.md from the page: `make pictures`."""

import json
import tempfile
from pathlib import Path
from typing import Any

from browsing import LAPTOP, ROOT, made
from live_service import live_service
from page_browser import launched
from playwright.sync_api import Page, expect

IMAGES = ROOT / "docs" / "images"
WINDOW = {"width": 1180, "height": 2500}  # the time bar sticks to its end, off all that is shown
FORM = {"width": 1280, "height": 1160}  # all of the form, whose button sticks to the foot
MARGIN_PX = 6
PICTURES = {
    "verdict": [".heading h1", ".identity", ".verdict"],
    "image": [".look-panel >> nth=0", ".look-panel >> nth=1"],
    "motion": [".look-charts"],
    "margins": [".panel:has(h2:text('Margins'))"],
    "budget": [".panel:has(h2:text('Pointing budget'))"],
}


def around(page: Page, selectors: list[str]) -> dict[str, float]:
    """The rectangle that holds the first of each."""
    boxes = [page.locator(selector).first.bounding_box() for selector in selectors]
    left, top = (min(box[side] for box in boxes if box) - MARGIN_PX for side in "xy")
    right = max(box["x"] + box["width"] for box in boxes if box) + MARGIN_PX
    foot = max(box["y"] + box["height"] for box in boxes if box) + MARGIN_PX
    return {"x": left, "y": top, "width": right - left, "height": foot - top}


def take(page: Page, name: str, **part: Any) -> None:
    page.screenshot(path=IMAGES / name, animations="disabled", **part)


def main() -> None:
    expect.set_options(timeout=60_000)
    request = json.loads((ROOT / "examples" / "las_vegas_2015.json").read_text())
    with (
        tempfile.TemporaryDirectory() as folder,
        live_service(Path(folder)) as service,
        launched() as browser,
    ):
        page = browser.new_page(base_url=service.address, viewport=WINDOW, locale="en-GB")
        page.goto(f"/plans/{made(service, '/v1/plans', request)['id']}")
        expect(page.locator(".chart canvas").first).to_be_visible()
        page.get_by_label("Time of the cursor").fill("190")  # in the session
        page.wait_for_timeout(1000.0)
        for name, selectors in PICTURES.items():
            clip = around(page, selectors)
            take(page, f"read_{name}.png", clip=clip)
        page.set_viewport_size(LAPTOP)
        page.wait_for_timeout(3000.0)  # while the globe is drawn anew
        take(page, "page_look.png")
        page.goto("/")
        expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
        expect(page.locator(".days-track")).to_be_visible()
        page.set_viewport_size(FORM)
        take(page, "page_plan.png")


if __name__ == "__main__":
    main()
