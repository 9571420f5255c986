"""The judge finds what is wrong with a table as a whole."""

import dataclasses
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from judged_tables import ARCSEC_RAD, EPOCH_UTC, changed, only

from planner.base.commands import axis_channels
from planner.verification import verify
from planner.verification.structure import session_rows


def test_a_wrong_epoch_is_found(scenario, table):
    late = dataclasses.replace(table, epoch_utc=EPOCH_UTC + timedelta(seconds=0.2))
    report = verify(late, scenario)
    assert "+0.2 s" in only(report, "table").detail
    assert report.sessions[0].max_rad > 60 * ARCSEC_RAD  # 1 deg/s for 0.2 s


def test_an_epoch_off_the_grid_is_found(scenario, table):
    off = dataclasses.replace(table, epoch_utc=EPOCH_UTC + timedelta(seconds=0.1))
    details = [finding.detail for finding in verify(off, scenario).findings]
    assert any("no multiple of 0.2 s" in detail for detail in details)


def test_a_beginning_that_is_not_the_platforms_state_is_found(scenario, table):
    for change in ({"angle_rad": 0.1 * ARCSEC_RAD}, {"rate_rad_s": 0.1 * ARCSEC_RAD}):
        finding = only(verify(changed(table, 1, 0, **change), scenario), "initial_state")
        assert (finding.axis, finding.t_s) == ("beta", 0.0)


def test_a_table_that_ends_too_early_or_begins_too_late_is_found(scenario, table):
    short = dataclasses.replace(
        table, position=table.position[:-1], rate_rad_s=table.rate_rad_s[:-1]
    )
    late = dataclasses.replace(table, epoch_utc=EPOCH_UTC + timedelta(seconds=80))
    for other, rows in ((short, "300..500"), (late, "-100..100")):
        report = verify(other, scenario)
        assert rows in only(report, "coverage").detail
        assert report.sessions == ()


def test_two_rows_are_a_table(scenario, table):
    two = dataclasses.replace(table, position=table.position[:2], rate_rad_s=table.rate_rad_s[:2])
    report = verify(two, scenario)
    only(report, "coverage")
    assert report.limits != ()  # one cell is judged


def test_what_cannot_be_flown_is_said_and_not_judged_further(scenario, table):
    unflyable = {
        "no finite number": changed(table, 0, 77, angle_rad=np.nan),
        "beta, alpha": dataclasses.replace(table, channels=axis_channels(("beta", "alpha"))),
        "no table of 2 axes": dataclasses.replace(table, rate_rad_s=table.rate_rad_s[1:]),
        "at least 2 rows": dataclasses.replace(
            table, position=table.position[:1], rate_rad_s=table.rate_rad_s[:1]
        ),
        "no UTC offset": dataclasses.replace(table, epoch_utc=EPOCH_UTC.replace(tzinfo=None)),
    }
    for expected, bad in unflyable.items():
        report = verify(bad, scenario)
        assert expected in only(report, "table").detail
        assert report.sessions == ()
        assert report.limits == ()
    broken_row = verify(unflyable["no finite number"], scenario).findings[0]
    assert (broken_row.axis, broken_row.t_s) == ("alpha", pytest.approx(15.4))
    assert broken_row.at_utc == datetime(2015, 2, 27, 17, 36, 15, 400000, tzinfo=UTC)


@pytest.mark.parametrize(
    ("start_us", "stop_us", "first", "last"),
    [
        (60_000_000, 100_000_000, 300, 500),
        (60_000_002, 99_999_998, 300, 500),
        (59_999_999, 100_000_001, 300, 500),  # a microsecond is rounding, two are meant
        (59_999_998, 100_000_002, 299, 501),
        (60_199_998, 99_800_002, 300, 500),
        (60_199_999, 99_800_001, 301, 499),
    ],
)
def test_sessions_are_widened_to_the_grid(scenario, start_us, stop_us, first, last):
    session = dataclasses.replace(
        scenario.sessions[0],
        start=EPOCH_UTC + timedelta(microseconds=start_us),
        stop=EPOCH_UTC + timedelta(microseconds=stop_us),
    )
    assert session_rows(session, EPOCH_UTC) == range(first, last + 1)
