"""How soon is the planner's page seen and usable, and how much of it is loaded for that?

    make web && PYTHONPATH=.:tests:tests/page .venv/bin/python bench/page.py [--throttle 4]

Loads `/` in Debian's Chromium with an empty cache, as often as `--times` says, from a service on
loopback.  Interactive is when the button "Plan" can be pressed and the windows are drawn.
"""

import argparse
import statistics
import tempfile
from pathlib import Path

from live_service import live_service
from page_browser import launched
from playwright.sync_api import Browser

_PAINT = "performance.getEntriesByName('first-contentful-paint')[0].startTime"


def main() -> None:
    """Print medians and worst."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--times", type=int, default=9)
    parser.add_argument("--throttle", type=float, default=1.0, help="of the processor")
    asked = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as folder,
        live_service(Path(folder)) as service,
        launched() as browser,
    ):
        runs = [_load(browser, service.address, asked.throttle) for _ in range(asked.times + 1)][1:]
    for name, unit in (("paint", "ms"), ("usable", "ms"), ("windows", "ms"), ("bytes", "B")):
        values = [run[name] for run in runs]
        print(f"{name:8} median {statistics.median(values):8.0f} {unit}, most {max(values):8.0f}")


def _load(browser: Browser, address: str, throttle: float) -> dict[str, float]:
    context = browser.new_context()
    page = context.new_page()
    session = context.new_cdp_session(page)
    session.send("Network.enable")
    session.send("Emulation.setCPUThrottlingRate", {"rate": throttle})
    sizes: list[float] = []
    session.on("Network.loadingFinished", lambda event: sizes.append(event["encodedDataLength"]))
    page.goto(address, wait_until="commit")
    page.locator("button.big:enabled").wait_for()
    usable = page.evaluate("performance.now()")
    page.locator(".session-bar").wait_for()
    windows = page.evaluate("performance.now()")
    measured = {"paint": page.evaluate(_PAINT), "usable": usable, "windows": windows}
    page.wait_for_load_state("networkidle")
    context.close()
    return measured | {"bytes": sum(sizes)}


if __name__ == "__main__":
    main()
