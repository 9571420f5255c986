"""The API's pages work offline, and the licences of all that the pages ship are stated."""

import json
import re

from browsing import ROOT
from playwright.sync_api import expect

LICENCES = "/assets/licences.txt"


def test_swagger_ui_shows_and_asks(open_page):
    page = open_page("/docs")
    operation = page.locator("#operations-platforms-get_platforms")
    operation.locator("button").first.click()
    operation.get_by_role("button", name="Execute").click()
    expect(operation.locator(".live-responses-table").first).to_contain_text("iss-hrc")


def test_redoc_shows_and_searches(open_page):
    page = open_page("/redoc")
    expect(page.get_by_role("heading", name=re.compile("slewtrack")).first).to_be_visible()
    page.get_by_placeholder("Search...").fill("telemetry")
    expect(page.get_by_role("search").get_by_role("menuitem").first).to_be_visible()


def test_the_page_leads_to_the_licences(open_page):
    page = open_page("/plans")
    link = page.get_by_role("link", name="Licences of the software")
    assert link.evaluate("link => link.pathname") == LICENCES


def test_every_package_that_ships_has_its_licence(open_page):
    told = open_page(LICENCES).request.get(LICENCES).text()
    parts = re.split(r"^={72}\n(\S+ [^:\n]+)(?:: .*)?\n={72}\n", told, flags=re.MULTILINE)
    texts = dict(zip(parts[1::2], parts[2::2], strict=True))
    packages = json.loads((ROOT / "web/package-lock.json").read_text())["packages"]
    shipped = {
        f"{folder.split('node_modules/')[-1]} {one['version']}"
        for folder, one in packages.items()
        if folder and not one.get("dev")
    }
    assert set(texts) == shipped
    names = " ".join(shipped)
    for name in ("preact", "uplot", "d3-geo", "topojson-client", "dompurify", "protobufjs",
                 "@cesium/engine", "swagger-ui-dist", "redoc"):  # fmt: skip
        assert name in names
    for name, text in texts.items():
        assert re.search(r"copyright|permission|license", text, re.IGNORECASE), name
    assert "Third-Party Code" in texts[next(one for one in texts if "cesium/engine" in one)]
