"""The planner's page as tests see it: in a browser, served by a real service, offline.

`make test-page` names the browser; without one they are skipped.
"""

import json
import os
from collections.abc import Callable, Iterator
from urllib.parse import urlsplit

import pytest
from browsing import LAPTOP, ROOT, made
from live_service import Service, live_service
from page_browser import launched
from playwright.sync_api import Browser, BrowserContext, Page, expect

PATIENCE_MS = 60_000.0  # more than a plan takes, kernels compiled beside it

# A browser that draws nothing in three dimensions.
_FLAT = """
const { getContext } = HTMLCanvasElement.prototype;
HTMLCanvasElement.prototype.getContext = function (kind, ...given) {
  return kind.startsWith("webgl") ? null : getContext.call(this, kind, ...given);
};
"""

OpenPage = Callable[..., Page]
expect.set_options(timeout=PATIENCE_MS)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Debian's Chromium."""
    if not os.environ.get("SLEWTRACK_TEST_CHROMIUM"):
        pytest.skip("no browser: `make test-page` brings one")
    with launched() as browser:
        yield browser


@pytest.fixture(scope="session")
def service(browser, tmp_path_factory) -> Iterator[Service]:
    """One for all tests, with data of its own."""
    with live_service(tmp_path_factory.mktemp("service")) as service:
        yield service


@pytest.fixture(scope="session")
def plan(service) -> str:
    """The id of the Las Vegas pass, which every test leaves as it is."""
    request = json.loads((ROOT / "examples/las_vegas_2015.json").read_text())
    return made(service, "/v1/plans", request)["id"]


@pytest.fixture
def open_page(browser, service) -> Iterator[OpenPage]:
    """Opens addresses of the service in fresh browsers; at the end nothing must have gone wrong.

    No request may leave for another origin, nothing be refused by the content policy, and no
    exception be left to the browser.  Plans are seen on the flat map: the globe, without a graphics
    card, takes most of a plan's page's time; who tests it, or with it, asks for it.
    """
    contexts: list[BrowserContext] = []
    faults: list[str] = []

    def open_page(
        path: str = "/", *, at: Service = service, globe: bool = False, **settings: object
    ) -> Page:
        options = {"base_url": at.address, "viewport": LAPTOP, "locale": "en-GB", **settings}
        context = browser.new_context(**options)
        contexts.append(context)
        if not globe:
            context.add_init_script(_FLAT)
        context.set_default_timeout(PATIENCE_MS)
        page = context.new_page()

        def look_at(url: str) -> None:
            parts = urlsplit(url)
            if parts.scheme not in ("blob", "data") and not url.startswith(f"{at.address}/"):
                faults.append(f"asked elsewhere: {url}")

        page.on("request", lambda request: look_at(request.url))
        page.on("pageerror", lambda error: faults.append(f"exception: {error.stack or error}"))
        page.on(
            "console",
            lambda message: (
                "Content Security Policy" in message.text and faults.append(message.text)
            ),
        )
        page.goto(at.address + path)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert faults == []
