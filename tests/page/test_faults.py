"""Faults of a service, for real: stated in plain words, nothing lost, and it goes on."""

import json
import re
import sqlite3
import zlib
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import httpx2 as httpx
import pytest
from browsing import PHONE, violations
from databases import damage
from hardships import dying_workers, full_disk, idle_workers, small_disk, spend_all, spent_rate
from live_service import Service, live_service
from playwright.sync_api import expect
from waiting import eventually

from app.requests.examples import LAS_VEGAS
from app.store.database import FILE

PLACE = "36.17, -115.14, 620"


@dataclass(frozen=True)
class Hard:
    """A service with little patience, and the disk its data are on."""

    service: Service
    folder: Path
    is_disk: bool


@pytest.fixture(scope="module")
def hard(browser, tmp_path_factory) -> Iterator[Hard]:
    """One worker, one job that may wait, one attempt at each."""
    folder = tmp_path_factory.mktemp("disk")
    with (
        small_disk(folder) as is_disk,
        live_service(
            tmp_path_factory.mktemp("hard"),
            SLEWTRACK_DATA_DIR=str(folder),
            SLEWTRACK_DATABASE_URL="",
            SLEWTRACK_WORKERS="1",
            SLEWTRACK_QUEUE_MAX="1",
            SLEWTRACK_JOB_ATTEMPTS="1",
        ) as service,
    ):
        yield Hard(service, folder, is_disk)


@pytest.fixture
def form(open_page):
    """Opens the form of a service, with a target typed into it."""

    def form(service, **settings):
        page = open_page("/", at=service, **settings)
        field = page.get_by_label("Place or coordinates")
        field.fill(PLACE)
        with page.expect_response(lambda answer: "36.17" in (answer.request.post_data or "")):
            page.get_by_role("button", name="Find").click()
        expect(page.get_by_role("list", name="Windows, the first first")).to_be_visible()
        expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
        return page

    return form


def plan(page):
    page.get_by_role("button", name="Plan", exact=True).click()


def keeps_what_was_typed(page):
    expect(page.get_by_label("Place or coordinates")).to_have_value(PLACE)
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()


def is_planned(page):
    """The plan is made, of the target that was typed; and once."""
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    path = f"/v1/plans/{page.url.rsplit('/', 1)[1]}/request"
    # Where the rate is spent, it is answered a little later.
    sessions = eventually(lambda: page.request.get(path).json().get("sessions"))
    target = sessions[0]["target"]
    assert (target["latitude_deg"], target["longitude_deg"]) == (36.17, -115.14)


def plan_and_be_told(page, text):
    """Plans, and waits for what is said of it, however short it stands there."""
    page.evaluate(
        """text => {
          const look = () => { window.told ||= document.body.textContent.includes(text); };
          const changes = { subtree: true, childList: true, characterData: true };
          window.told = false;
          new MutationObserver(look).observe(document.body, changes);
        }""",
        text,
    )
    plan(page)
    page.wait_for_function("() => window.told")


def says(page, text):
    """One alert or more says it: each part of the page that has to fetch then has its own."""
    expect(page.get_by_role("alert").filter(has_text=text).first).to_be_visible()


def told_in_russian_too(page, *texts):
    """What is told, told again when the language is changed, and back."""
    page.get_by_label("Language").select_option("ru")
    for text in texts:
        says(page, text)
    page.get_by_label("Язык").select_option("en")


def test_a_service_that_stops_comes_back_and_forgets(form, tmp_path):
    """What was typed is kept and planned; what the page holds of a plan whose time is over is still
    shown, what it must fetch isn't there."""
    with live_service(tmp_path) as service:
        waiting, shown = form(service), form(service)
        waiting.get_by_label("Language").select_option("ru")
        waiting.get_by_label("Язык").select_option("en")
        plan(shown)
        is_planned(shown)
        gone = shown.url.removeprefix(service.address)
        shown.wait_for_load_state("networkidle")
    plan_and_be_told(waiting, "The service doesn't answer; the next try is in")
    alert = waiting.get_by_role("alert")
    expect(alert).to_contain_text("The service doesn't answer")
    expect(alert).to_contain_text("Nothing you entered is lost")
    told_in_russian_too(waiting, "Служба не отвечает", "Введённое не потеряно")
    assert violations(waiting) == []
    keeps_what_was_typed(waiting)
    port = str(service.port)
    with live_service(tmp_path, "--port", port):
        alert.get_by_role("button", name="Try again").click()
        is_planned(waiting)
        waiting.close()
    with live_service(tmp_path, "--port", port, SLEWTRACK_RETENTION_DAYS="0.000001"):
        shown.get_by_role("button", name="Download CSV").click()
        says(shown, "It isn't there any more")
        told_in_russian_too(shown, "Этого больше нет")
        shown.goto(gone)
        expect(shown.get_by_text("There is no such plan")).to_be_visible()
        assert violations(shown) == []
        expect(shown.get_by_role("link", name="Plans kept")).to_be_visible()
        shown.get_by_role("link", name="Plan anew").click()
        expect(shown.get_by_role("slider", name="Session", exact=True)).to_be_visible()
        shown.close()


def test_a_service_that_starts_anew_while_it_works(form, tmp_path):
    """The work goes on where it was left, and the page follows it: one plan is made."""
    with ExitStack() as until_it_stopped, live_service(tmp_path) as service:
        page = form(service)
        until_it_stopped.enter_context(idle_workers(service))
        plan(page)
        expect(page.get_by_role("progressbar", name="at work")).to_be_visible()
    with live_service(tmp_path, "--port", str(service.port)) as service:
        is_planned(page)
        assert len(httpx.get(f"{service.address}/v1/plans").json()["plans"]) == 1
        page.close()


def test_too_many_requests_are_waited_for(form, tmp_path):
    with live_service(tmp_path, SLEWTRACK_RATE_PER_MINUTE="120") as service:
        page = form(service)
        refusal = spend_all(service)
        assert (refusal.status_code, refusal.headers["retry-after"]) == (429, "1")
        with spent_rate(service):
            plan_and_be_told(page, "The service is busy; the next try is in 1 s.")
        is_planned(page)
        page.close()


def test_a_full_queue_is_waited_for(form, hard):
    page = form(hard.service)
    with idle_workers(hard.service), httpx.Client(base_url=hard.service.address) as client:
        for number in range(2):
            order = LAS_VEGAS | {"name": f"before others {number}"}
            answer = client.post("/v1/plans", json=order, headers={"Prefer": "respond-async"})
            assert answer.status_code == 202, answer.text
        plan_and_be_told(page, "The service is busy; the next try is in 5 s.")
        for one in client.get("/v1/plans", params={"name": "before others"}).json()["plans"]:
            client.delete(f"/v1/plans/{one['id']}")
    is_planned(page)


def test_work_whose_process_dies_is_told_and_tried_again(form, hard):
    page = form(hard.service)
    with dying_workers(hard.service):
        plan(page)
        alert = page.get_by_role("alert")
        expect(alert).to_contain_text("The work broke off")
    expect(alert).to_contain_text("Try again; if it ends so again, ask for less")
    told_in_russian_too(page, "Работа прервалась", "Процесс, который над этим работал")
    assert violations(page) == []
    keeps_what_was_typed(page)
    # As it is told where the plan would be, too, from which it can be planned once more.
    [broken] = page.request.get("/v1/plans?state=failed").json()["plans"]
    alert.get_by_role("button", name="Try again").click()
    is_planned(page)
    page.goto(f"/plans/{broken['id']}")
    expect(alert).to_contain_text("The work broke off")
    expect(page.get_by_role("link", name="Change the request")).to_be_visible()
    alert.get_by_role("button", name="Try again").click()
    is_planned(page)


def test_work_that_takes_too_long_is_told(form, tmp_path):
    """Nothing can be planned in the hundredth of a second that is allowed."""
    with live_service(tmp_path, SLEWTRACK_JOB_DEADLINE_S="0.01") as service:
        page = form(service)
        plan(page)
        alert = page.get_by_role("alert")
        expect(alert).to_contain_text("It takes more than the service allows")
        expect(alert).to_contain_text("this took more than the 0.01 s of a processor")
        told_in_russian_too(page, "Это больше, чем служба позволяет", "Просите меньше за раз")
        keeps_what_was_typed(page)
        page.close()


def test_work_is_cancelled_and_asked_for_again(form, hard):
    page = form(hard.service)
    with idle_workers(hard.service):
        plan(page)
        expect(page.get_by_role("progressbar", name="at work")).to_be_visible()
        page.get_by_role("button", name="Cancel").click()
        expect(page.get_by_role("progressbar")).to_be_hidden()
    keeps_what_was_typed(page)
    found = page.request.get("/v1/plans?state=cancelled").json()["plans"]
    cancelled = found[0]  # the latest
    plan(page)
    is_planned(page)
    page.goto(f"/plans/{cancelled['id']}")
    expect(page.get_by_text("Work on it was cancelled.")).to_be_visible()
    page.get_by_role("link", name="Change the request").click()
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    plan(page)
    is_planned(page)


def test_a_full_disk_is_told_and_recovered_from(form, hard):
    page = form(hard.service, viewport=PHONE)
    with full_disk(hard.service, hard.folder, is_disk=hard.is_disk):
        plan_and_be_told(page, "The service can't use its database now; the next try is in")
        alert = page.get_by_role("alert")
        expect(alert).to_contain_text("Its disk may be full")
        told_in_russian_too(page, "Возможно, диск полон")
        assert violations(page) == []
    keeps_what_was_typed(page)
    alert.get_by_role("button", name="Try again").click()
    is_planned(page)


def test_a_damaged_database_is_told_as_damaged(form, tmp_path):
    """By which nobody is made to try again."""
    own = {"SLEWTRACK_DATABASE_URL": ""}
    with live_service(tmp_path, **own) as service:
        page = form(service)
    damage(tmp_path / FILE)
    with live_service(tmp_path, "--port", str(service.port), **own):
        plan(page)
        alert = page.get_by_role("alert")
        expect(alert).to_contain_text("The service's database is damaged")
        expect(alert).to_contain_text("must restore a backup")
        expect(alert.get_by_role("button", name="Try again")).to_have_count(0)
        told_in_russian_too(page, "База данных службы повреждена", "восстановить резервную копию")
        keeps_what_was_typed(page)
        page.close()


def test_a_plan_asked_for_in_other_words_is_told(open_page, hard):
    request = zlib.compress(json.dumps(LAS_VEGAS | {"colour": "blue"}).encode())
    made = httpx.post(f"{hard.service.address}/v1/plans", json=LAS_VEGAS, timeout=None).json()
    with sqlite3.connect(hard.folder / FILE) as store:
        store.execute("UPDATE jobs SET request = ? WHERE id = ?", (request, made["id"]))
    store.close()
    page = open_page(f"/plans/{made['id']}", at=hard.service)
    alert = page.get_by_role("alert")
    expect(alert).to_contain_text("Its request is of another version")
    expect(alert).to_contain_text("Its table is still there as JSON")
    expect(alert.get_by_role("button", name="Try again")).to_have_count(0)
    told_in_russian_too(page, "Запрос составлен для другой версии", "Таблица остаётся")


def test_work_is_followed_where_no_stream_has_a_place(form, tmp_path):
    """The page asks how the work stands until one has.

    A browser asks for six files at once, which must not be refused while the page loads.
    """
    with live_service(tmp_path, SLEWTRACK_CONCURRENCY_PER_KEY="16") as service:
        page = form(service)
        with (
            ExitStack() as held,
            httpx.Client(base_url=service.address, timeout=None) as client,
            idle_workers(service),
        ):
            before = client.post(
                "/v1/plans", json=LAS_VEGAS, headers={"Prefer": "respond-async"}
            ).headers["location"]
            for _ in range(8):
                stream = held.enter_context(client.stream("GET", f"{before}/events"))
                assert stream.status_code == 200
            with page.expect_response(
                lambda answer: answer.status == 200 and re.search(r"/plans/[\w-]+$", answer.url)
            ):
                with page.expect_response(lambda answer: answer.status == 429):
                    plan(page)
                expect(page.get_by_role("progressbar")).to_be_visible()
        is_planned(page)
        page.close()
