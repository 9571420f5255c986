"""Requests a planner might send are planned, by another's geometry too, or refused as documented.

`bench/plausible.py` looks at thousands.
"""

import copy

import pytest
from plan_oracle import ARCSEC, faults
from plausible_requests import demanding_request, plausible_request, with_time_to_spare
from plausible_trials import answer, as_advised, outcome

COUNT = 30
SPARE_COUNT = 6
LONG = 10  # every tenth may have six sessions, which take 2 s, the others one


@pytest.mark.parametrize("seed", range(COUNT))
def test_a_plausible_request_is_planned_or_refused_as_documented(seed):
    assert_planned_or_refused(plausible_request(seed, sessions_max=6 if seed % LONG == 0 else 1))


@pytest.mark.parametrize("seed", range(SPARE_COUNT))
def test_so_is_one_with_time_to_spare_and_a_final_state(seed):
    request = plausible_request(seed, sessions_max=6 if seed % LONG == 0 else 1)
    assert_planned_or_refused(with_time_to_spare(request, seed))


# 30 June 2012, which ends with a leap second; a slew of one row, with modes to suppress.
@pytest.mark.parametrize("seed", [940354, 942548])
def test_so_is_a_demanding_one(seed):
    assert_planned_or_refused(demanding_request(seed))


def assert_planned_or_refused(request):
    found = outcome(request)
    assert found.faults == []
    if found.advises:
        advised = outcome(as_advised(request, found.problem))
        assert (advised.kind, advised.faults) in [("planned", []), ("baseline", [])], (
            found.problem,
            advised.problem,
        )


def test_requests_are_the_same_for_the_same_seed():
    assert plausible_request(7) == plausible_request(7)
    assert plausible_request(7) != plausible_request(8)


@pytest.fixture(scope="module")
def held():
    """A request with a session on the ground, one cone, and its good answer."""
    seed = next(seed for seed in range(COUNT, 3000) if _shows_all(plausible_request(seed)))
    request = plausible_request(seed)
    return request, answer(request)


def _shows_all(request):
    looked_at = {session["target"]["mode"] for session in request["sessions"]}
    is_plain = looked_at == {"ground"} and request["slew"]["method"] == "ocp"
    return is_plain and "keep_out" in request["slew"] and outcome(request).kind == "planned"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda request, table: table["alpha_deg"].__setitem__(0, 1.0), "alpha begins at 1"),
        (lambda request, table: _shift(table, 0.5 * ARCSEC), "arcsec off"),
        (lambda request, table: table.update(epoch="2001-01-01T00:00:00Z"), "row 0 is at"),
        (lambda request, table: table["t_s"].__setitem__(3, 0.7), "not 0.2 s apart"),
        (lambda request, table: _bump(table), "acceleration limit"),
        (lambda request, table: _widen(request), "cone 0 is entered"),
    ],
)
def test_the_oracle_sees_a_table_that_is_wrong(held, change, says):
    request, good = copy.deepcopy(held)
    assert faults(request, good) == []
    change(request, good["table"])
    assert any(says in fault for fault in faults(request, good))


def _shift(table, angle_rad):
    """By a little, but for the first rows, so that nothing but the pointing is wrong."""
    for name in ("alpha", "beta"):
        angle = table[f"{name}_deg"]
        rise = [min(max(row - 20, 0) / 60.0, 1.0) for row in range(len(angle))]
        table[f"{name}_deg"] = [
            a + angle_rad * 57.29578 * s * s * (3.0 - 2.0 * s)
            for a, s in zip(angle, rise, strict=True)
        ]


def _bump(table):
    table["beta_deg"][20] += 1.0


def _widen(request):
    request["slew"]["keep_out"][0]["half_angle_deg"] = 179.0
