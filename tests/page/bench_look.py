"""Measures the look at a plan: frames while a long table is dragged, memory over many plans.

SLEWTRACK_TEST_CHROMIUM=$(command -v chromium) PYTHONPATH=.:tests:tests/page \\
    python tests/page/bench_look.py [frames] [weight] [map] [globe]
"""

import json
import os
import sys
import tempfile
import urllib.request
from pathlib import Path
from typing import Any

from browsing import LAPTOP, ROOT
from live_service import live_service
from playwright.sync_api import Browser, Page, sync_playwright

FLAGS = ["--headless=new", "--no-sandbox", "--disable-quic", "--no-first-run"]
SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
NO_GL = ["--disable-gpu", "--disable-3d-apis"]
SLOWER = 4
DRAG_MS = 3000
PLANS = 100
# A chart begins each of its drawings by clearing its canvas.
COUNT_DRAWINGS = """
() => {
  window.drawn = 0;
  const first = document.querySelector(".chart canvas");
  const clear = CanvasRenderingContext2D.prototype.clearRect;
  CanvasRenderingContext2D.prototype.clearRect = function (...given) {
    if (this.canvas === first) window.drawn++;
    return clear.apply(this, given);
  };
  window.frames_seen = 0;
  const count = () => { window.frames_seen++; requestAnimationFrame(count); };
  requestAnimationFrame(count);
}
"""
# Moves once a frame, as a mouse does.
DRAG = """
async ([shift, lasting_ms]) => {
  const over = document.querySelector(".chart .u-over");
  const box = over.getBoundingClientRect();
  const at = (type, x) => over.dispatchEvent(new PointerEvent(type, {
    bubbles: true, pointerId: 1, button: 0, shiftKey: shift,
    clientX: box.left + x * box.width, clientY: box.top + 30,
  }));
  over.setPointerCapture = () => {};
  const [drawn, frames, start] = [window.drawn, window.frames_seen, performance.now()];
  at("pointerdown", 0.5);
  await new Promise((resolve) => {
    const step = (now) => {
      const since = now - start;
      at("pointermove", 0.5 + 0.4 * Math.sin(since / 300));
      since < lasting_ms ? requestAnimationFrame(step) : resolve();
    };
    requestAnimationFrame(step);
  });
  at("pointerup", 0.5);
  const lasted = (performance.now() - start) / 1000;
  return [(window.frames_seen - frames) / lasted, (window.drawn - drawn) / lasted];
}
"""

GO_TO = """
path => {
  document.querySelector(".chart canvas").dataset.old = "";
  history.pushState(null, "", path);
  dispatchEvent(new PopStateEvent("popstate"));
}
"""

ANEW = """
() => document.querySelector(".chart canvas") && !document.querySelector(".chart canvas[data-old]")
"""


def post(address: str, document: dict[str, Any]) -> str:
    """Makes a plan; its id."""
    body = json.dumps(document).encode()
    request = urllib.request.Request(
        f"{address}/v1/plans", body, {"Content-Type": "application/json"}
    )
    with urllib.request.urlopen(request, timeout=120) as answer:
        return str(json.load(answer)["id"])


def las_vegas(**changed: Any) -> dict[str, Any]:
    """The example's request."""
    return json.loads((ROOT / "examples/las_vegas_2015.json").read_text()) | changed


def long_table() -> dict[str, Any]:
    """900 s, 4501 rows: the example begun earlier."""
    document = las_vegas()
    document["initial_state"]["epoch"] = "2015-02-27T17:22:50Z"
    return document


def opened(browser: Browser, url: str) -> Page:
    """A page that shows the plan's charts."""
    page = browser.new_context(viewport=LAPTOP).new_page()
    page.set_default_timeout(120_000)
    page.goto(url)
    page.wait_for_selector(".chart canvas")
    page.wait_for_timeout(1500)
    return page


def frames(browser: Browser, address: str, plan_id: str) -> None:
    """Of the cursor dragged, and of all charts redrawn while their stretch of time is dragged."""
    page = opened(browser, f"{address}/plans/{plan_id}")
    page.get_by_role("button", name="Shorter time").click()
    page.evaluate(COUNT_DRAWINGS)
    session = page.context.new_cdp_session(page)
    for slower in (1, SLOWER):
        session.send("Emulation.setCPUThrottlingRate", {"rate": slower})
        for told, shift in (("cursor dragged", False), ("charts dragged", True)):
            shown, drawn = page.evaluate(DRAG, [shift, DRAG_MS])
            print(f"CPU / {slower}, {told}: {shown:.0f} frames/s, {drawn:.0f} drawings/s")
    session.send("Emulation.setCPUThrottlingRate", {"rate": 1})
    page.context.close()


def memory(browser: Browser, address: str, plan_ids: list[str], told: str) -> None:
    """Heap, nodes and canvases while plans are opened one after the other in one page."""
    page = opened(browser, f"{address}/plans/{plan_ids[0]}")
    session = page.context.new_cdp_session(page)
    has_globe = page.locator(".look-globe").count() > 0
    for number in range(1, PLANS + 1):
        plan_id = plan_ids[number % len(plan_ids)]
        page.evaluate(GO_TO, f"/plans/{plan_id}")
        # Not by wait_for_selector: the handle it returns would keep the chart.
        page.wait_for_function(ANEW)
        if has_globe:
            page.wait_for_function("document.querySelector('[data-state=there]') !== null")
        if number % 10 == 0 or number == 1:
            session.send("HeapProfiler.collectGarbage")
            heap = session.send("Runtime.getHeapUsage")["usedSize"] / 2**20
            counters = session.send("Memory.getDOMCounters")
            canvases = page.locator("canvas").count()
            print(
                f"{told}, after {number:3d} plans: {heap:.1f} MiB of heap, "
                f"{counters['nodes']} nodes, {counters['jsEventListeners']} listeners, "
                f"{canvases} canvases",
                flush=True,
            )
    page.context.close()


def weight(browser: Browser, address: str, plan_id: str) -> None:
    """What crosses the wire until a plan's charts are there, apart from the globe and data."""
    page = browser.new_context(viewport=LAPTOP).new_page()
    session = page.context.new_cdp_session(page)
    session.send("Network.enable")
    names: dict[str, str] = {}
    sizes: dict[str, float] = {}
    session.on(
        "Network.responseReceived", lambda e: names.update({e["requestId"]: e["response"]["url"]})
    )
    session.on(
        "Network.loadingFinished", lambda e: sizes.update({e["requestId"]: e["encodedDataLength"]})
    )
    page.goto(f"{address}/plans/{plan_id}")
    page.wait_for_selector(".chart canvas")
    page.wait_for_timeout(8000)
    own = {names[key]: size for key, size in sizes.items() if "/v1/" not in names.get(key, "/v1/")}
    globe = {url for url in own if "engine-" in url or "/cesium/" in url or "countries-" in url}
    before = sum(size for url, size in own.items() if url not in globe)
    print(f"page {before / 1e3:.0f} kB; globe {sum(own[url] for url in globe) / 1e3:.0f} kB")
    page.context.close()


def main(asked: list[str]) -> None:
    """Only what is asked for; all when nothing is."""
    chromium = os.environ["SLEWTRACK_TEST_CHROMIUM"]
    wanted = asked or ["frames", "weight", "map", "globe"]
    folder = Path(tempfile.mkdtemp())
    with live_service(folder) as service, sync_playwright() as playwright:
        long_id = post(service.address, long_table())
        plan_ids = [post(service.address, las_vegas(name=f"plan {n}")) for n in range(3)]
        with_gl, without = (
            playwright.chromium.launch(executable_path=chromium, args=FLAGS + more)
            for more in (SOFTWARE_GL, NO_GL)
        )
        if "frames" in wanted:
            frames(without, service.address, long_id)
        if "weight" in wanted:
            weight(with_gl, service.address, plan_ids[0])
        if "map" in wanted:
            memory(without, service.address, plan_ids, "flat map")
        if "globe" in wanted:
            memory(with_gl, service.address, plan_ids, "globe")


if __name__ == "__main__":
    main(sys.argv[1:])
