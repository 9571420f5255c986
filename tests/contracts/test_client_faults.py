"""The client asks again where it helps, and says plainly what failed where it doesn't."""

import httpx
import pytest

import slewtrack
from slewtrack.client.clients import Service

REQUEST = {"sessions": []}  # what it says doesn't matter: no service reads it


def scripted(*answers):
    """A client whose requests are answered so, and the requests."""
    left, asked = list(answers), []

    def answer(request):
        asked.append(request)
        one = left.pop(0)
        if isinstance(one, Exception):
            raise one
        return one

    return slewtrack.Client("http://service", transport=httpx.MockTransport(answer)), asked


def busy(after):
    problem = {"type": "urn:slewtrack:problem:queue-full", "status": 503, "detail": "full"}
    return httpx.Response(503, json=problem, headers={"Retry-After": after})


def accepted():
    return httpx.Response(202, json={"id": "1", "state": "queued", "name": ""})


@pytest.mark.parametrize("first", [busy("0"), httpx.ReadError("lost"), httpx.ConnectError("no")])
def test_asking_again_makes_no_second_plan(first):
    client, asked = scripted(first, accepted())
    assert client.submit(REQUEST).is_open
    one, other = (request.headers["Idempotency-Key"] for request in asked)
    assert one == other
    assert asked[0].content == asked[1].content


def test_waiting_has_an_end():
    still = {"id": "1", "state": "running", "name": ""}
    client, asked = scripted(
        accepted(),
        httpx.Response(200, json=still),
        httpx.ReadTimeout("silent"),
        httpx.Response(200, json=still),
        httpx.ReadTimeout("silent"),
        httpx.Response(200, json=still),
    )
    with pytest.raises(slewtrack.NotFinished) as late:
        client.plan(REQUEST, progress=lambda _: None, timeout_s=0.6)
    assert late.value.job_id == "1"
    assert [request.url.path for request in asked[1:3]] == ["/v1/plans/1", "/v1/plans/1/events"]


def test_what_is_cancelled_says_so():
    ended = {"id": "1", "state": "cancelled", "name": "", "problem": None}
    client, _ = scripted(accepted(), httpx.Response(200, json=ended))
    with pytest.raises(slewtrack.Cancelled):
        client.plan(REQUEST)


def test_patience_ends_with_the_reason():
    client, asked = scripted(busy("3600"))
    with pytest.raises(slewtrack.Refused, match="full") as refused:
        client.submit(REQUEST)
    assert refused.value.problem.status == 503
    assert len(asked) == 1


def test_a_service_that_is_not_there():
    with (
        slewtrack.Client("http://127.0.0.1:9", patience_s=0.0) as client,
        pytest.raises(slewtrack.NoAnswer, match="slewtrack serve"),
    ):
        client.plans()


@pytest.mark.parametrize("answer", [httpx.Response(200, text="<html>"), httpx.Response(200)])
def test_another_service_at_the_address(answer):
    client, _ = scripted(answer)
    with pytest.raises(slewtrack.BadAnswer, match="isn't answered as a slewtrack service"):
        client.plans()


def test_a_proxys_page_of_an_error_is_a_problem():
    client, _ = scripted(httpx.Response(502, text="<html>Bad gateway"))
    with pytest.raises(slewtrack.Refused, match="502"):
        client.plans()


@pytest.mark.parametrize("url", ["service", "ftp://service", "http://"])
def test_an_address_that_is_none(url):
    with pytest.raises(ValueError, match="http://HOST"):
        slewtrack.Client(url)


def test_address_and_key_of_the_environment(monkeypatch):
    monkeypatch.setenv("SLEWTRACK_URL", "https://plans.example/")
    monkeypatch.setenv("SLEWTRACK_KEY", "st_1")
    service = Service()
    assert service.url == "https://plans.example"
    assert service.options["headers"] == {"Authorization": "Bearer st_1"}
