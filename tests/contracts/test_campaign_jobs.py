"""A campaign ends with its last pass, once, whatever becomes of the passes."""

import json
import zlib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from child_work import Notes, die, die_once, find_looks_once, hang, made, refuse_by
from job_cases import ended_with, new_job
from waiting import alive, eventually

from app.jobs.kinds import CAMPAIGN, JOB_KINDS, PLAN
from app.jobs.shares import Places, Sharing
from app.jobs.worker_process import ChildDied, Stop, Stopped, Task, run_here
from app.requests.examples import CAMPAIGN_EXAMPLES
from app.store import events, jobs, results
from app.store.packed import unzip
from app.work.campaign import campaign_json, choose, split_by_carrier, without_refused
from app.work.plan import plan_and_pack
from planner.base.errors import InvalidInput, Unreachable
from planner.planning.campaigns import fleet
from planner.planning.campaigns.apart import find_looks

BODY = json.dumps(CAMPAIGN_EXAMPLES["cities"][1]).encode()


@pytest.fixture(scope="module")
def chosen():
    return choose(BODY)


@pytest.fixture
def campaign_id(database, chosen):
    """A campaign whose passes wait to be planned."""
    new = new_job("campaign", name="Cities", request=BODY)
    with database.writing() as connection:
        token = jobs.accept(connection, new, 60.0)
    ended_with(database, CAMPAIGN, token, chosen)
    return new.id


FLEET = (Path(__file__).parents[2] / "examples" / "campaign_fleet.json").read_bytes()


@pytest.fixture(scope="module")
def chosen_at_once():
    return choose(FLEET)


@pytest.mark.parametrize("beside", [0, 2])
def test_looks_found_apart_make_the_same_choice_though_a_child_dies(
    chosen_at_once, monkeypatch, tmp_path, beside
):
    assert not split_by_carrier(FLEET)  # too few targets to be worth it
    monkeypatch.setattr(fleet, "BOUNDS", replace(fleet.BOUNDS, large_target_days=0.0))
    assert not split_by_carrier(BODY)
    notes, told = Notes(tmp_path / "notes"), []
    given = [b"%s\n%s" % (bytes(notes.file), one) for one in split_by_carrier(FLEET)]
    shares = replace(CAMPAIGN.shares, work=partial(find_looks_once, die_once))
    places = Places(take=lambda: True, leave=lambda: None, most=beside)
    sharing = Sharing(run_task=run_here, places=places, attempts=2)
    task = Task(job_id="fleet", bounds=CAMPAIGN.bounds, work=choose, arguments=())
    found = sharing.make(shares, given, task, Stop(), told.append)
    assert [(one.done, one.of) for one in told] == [(done, 3) for done in range(4)]
    assert len(notes.pids()) > 3  # one died at least
    assert choose(FLEET, None, found) == chosen_at_once


def test_a_fleet_that_sees_its_targets_often_keeps_some_looks_and_bounds_all(
    chosen_at_once, monkeypatch
):
    often = replace(fleet.BOUNDS, large_target_days=0.0, kept_looks=1)
    monkeypatch.setattr(fleet, "BOUNDS", often)
    rounds, made = 0, ()
    while given := split_by_carrier(FLEET, None, made):
        rounds, made = rounds + 1, [find_looks(one) for one in given]
    assert rounds == 2
    chosen = choose(FLEET, None, made)
    assert chosen == choose(FLEET)
    some, all_looks = (json.loads(unzip(one.document)) for one in (chosen, chosen_at_once))
    assert some["value"] < all_looks["value"] <= some["bound"]
    assert [one["target"] for one in some["unseen"]] == ["Reykjavik"]


def test_shares_end_with_the_work_and_by_their_own_refusal(tmp_path):
    notes = Notes(tmp_path / "notes")
    places = Places(take=lambda: True, leave=lambda: None, most=1)
    sharing = Sharing(run_task=run_here, places=places, attempts=2)
    task = Task(job_id="fleet", bounds=CAMPAIGN.bounds, work=choose, arguments=())
    stop, given = Stop(), [bytes(notes.file)] * 3
    with ThreadPoolExecutor(1) as thread:
        hanging = replace(CAMPAIGN.shares, work=hang)
        ending = thread.submit(sharing.make, hanging, given, task, stop)
        eventually(lambda: len(notes.pids()) == 2)
        stop.request()
        with pytest.raises(Stopped):
            ending.result()
    eventually(lambda: not any(map(alive, notes.pids())))
    refusing = partial(refuse_by, InvalidInput("is none", field="carriers.1.orbit"))
    with pytest.raises(InvalidInput):
        sharing.make(replace(CAMPAIGN.shares, work=refusing), given, task, Stop())
    with pytest.raises(ChildDied):
        sharing.make(replace(CAMPAIGN.shares, work=die), given[:1], task, Stop())


def claimed(database):
    with database.writing() as connection:
        return jobs.claim(connection, tuple(JOB_KINDS), 60.0)


def told(database, campaign_id):
    with database.reading() as connection:
        job = jobs.get(connection, campaign_id)
        parts = jobs.parts_of(connection, campaign_id)
        return json.loads(campaign_json(job, results.document(connection, campaign_id), parts))


def test_passes_that_were_chosen_can_be_flown_as_they_are(chosen):
    for part in chosen.parts:
        plan = plan_and_pack(part.request)
        assert plan.state == "done"
        answer = json.loads(zlib.decompress(plan.document))
        assert not [told for told in answer["warnings"] if "than asked" in told]  # none cut short
    looks = [look["target"] for part in chosen.parts for look in part.facts["looks"]]
    assert len(looks) == len(set(looks)) == 4


def test_campaign_ends_with_its_last_pass(database, campaign_id, chosen):
    seen = []
    while (part := claimed(database)) is not None:
        assert told(database, campaign_id)["state"] == "running"
        ended_with(database, PLAN, part.token, made())
        seen.append(part.job.id)
    answer = told(database, campaign_id)
    assert answer["state"] == "done"
    assert answer["planned"]["done"] == len(seen) == len(chosen.parts) > 1
    assert answer["planned"]["value"] == pytest.approx(answer["choice"]["value"])
    with database.reading() as connection:
        states = [e.data for e in events.after(connection, campaign_id, 0) if e.kind == "state"]
    assert [state["state"] for state in states] == ["queued", "running", "running", "done"]


@pytest.mark.usefixtures("patient_store")
def test_passes_that_end_together_end_the_campaign_once(database, campaign_id, chosen):
    parts = [claimed(database) for _ in chosen.parts]
    with ThreadPoolExecutor(len(parts)) as threads:
        list(threads.map(lambda part: ended_with(database, PLAN, part.token, made()), parts))
    assert told(database, campaign_id)["state"] == "done"


def test_refused_pass_is_planned_again_without_the_look_at_fault(database, campaign_id):
    refusal = Unreachable("alpha's stop", field="sessions.1.start")
    replaced = 0
    while (part := claimed(database)) is not None:
        looks = part.job.options["campaign"]["looks"]
        if len(looks) > 2:
            assert ended_with(database, PLAN, part.token, refusal) == "refused"
            lost, replaced = looks[1]["target"], replaced + 1
        else:
            ended_with(database, PLAN, part.token, made())
    answer = told(database, campaign_id)
    assert (answer["state"], replaced) == ("done", 1)
    left_out = [one for part in answer["passes"] for one in part["left_out"]]
    assert left_out == [{"target": lost, "because": "alpha's stop"}]
    assert lost not in {look["target"] for part in answer["passes"] for look in part["looks"]}


def test_least_worth_goes_when_no_look_is_named(chosen):
    part = max(chosen.parts, key=lambda one: len(one.facts["looks"]))
    least = min(part.facts["looks"], key=lambda look: look["value"])
    rest = len(part.facts["looks"])
    for field in (None, f"sessions.{rest}.start"):
        repaired = without_refused(part, field, "why")
        assert repaired.facts["left_out"] == [{"target": least["target"], "because": "why"}]
        assert len(json.loads(repaired.request)["sessions"]) == rest  # and the one at rest


def test_single_look_that_is_refused_stays_so(database, campaign_id):
    while (part := claimed(database)) is not None:
        ended_with(database, PLAN, part.token, Unreachable("never"))
    answer = told(database, campaign_id)
    assert answer["state"] == "done"
    assert answer["planned"]["refused"] == len(answer["passes"])
    assert answer["planned"]["value"] == 0.0


def test_cancelled_campaign_takes_its_passes_along(database, campaign_id):
    running = claimed(database)
    with database.writing() as connection:
        jobs.cancel(connection, campaign_id)
        assert jobs.leases_to_end(connection, [running.token]) == {running.token}
    ended_with(database, PLAN, running.token, made())  # it was done before it could be stopped
    while (part := claimed(database)) is not None:
        assert part.job.cancel_requested
        with database.writing() as connection:
            jobs.finish(connection, jobs.job_of_lease(connection, part.token), "cancelled")
    answer = told(database, campaign_id)
    assert answer["state"] == "cancelled"
    assert answer["planned"]["done"] == 1
    assert answer["planned"]["open"] == 0


def test_campaign_cancelled_while_choosing_plans_nothing(database, chosen):
    new = new_job("campaign", request=BODY)
    with database.writing() as connection:
        token = jobs.accept(connection, new, 60.0)
        jobs.cancel(connection, new.id)
    assert ended_with(database, CAMPAIGN, token, chosen) == "cancelled"
    assert claimed(database) is None


def test_best_view_is_told_though_its_quotient_rounds_up(database):
    """Three rows of 0.1 each are worth more than 0.3, to a computer."""
    request = {**CAMPAIGN_EXAMPLES["cities"][1], "view": {"ground_sample": 0.0}}
    looks = {"priority": 0.1, "session_s": 6.0, "min_session_s": 6.0}
    request["targets"] = [target | looks for target in request["targets"]]
    body = json.dumps(request).encode()
    new = new_job("campaign", request=body)
    with database.writing() as connection:
        token = jobs.accept(connection, new, 60.0)
    ended_with(database, CAMPAIGN, token, choose(body))
    looks = [look for one in told(database, new.id)["passes"] for look in one["looks"]]
    assert {look["quality"] for look in looks} == {1.0}
