"""Element sets and states are checked as published, taken in every frame, and refused if wrong."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from planner.base.errors import OutsideCoverage
from planner.world.frames.time_scales import Instants
from planner.world.orbits import StateVectorOrbit, TleOrbit

# ISS on 2015-02-27, as distributed by NORAD
LINE1 = "1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991"
LINE2 = "2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964"
EPOCH = datetime(2015, 2, 27, 11, 33, 31, tzinfo=UTC)  # day 58.48161588
MINUTE = timedelta(minutes=1)


def checksummed(line):
    """The line with the checksum its other characters call for."""
    total = sum(int(c) if c.isdigit() else c == "-" for c in line[:68])
    return line[:68] + str(total % 10)


def test_epoch():
    epoch_utc = TleOrbit(line1=LINE1, line2=LINE2).epoch_utc
    # 1e-8 of a day
    assert abs((epoch_utc - EPOCH).total_seconds() - 0.612) < 1e-3


@pytest.mark.parametrize(
    ("line1", "line2", "reason"),
    [
        (LINE1[:-1] + "2", LINE2, "line1 ends in checksum '2', its digits give 1"),
        (LINE1, LINE2[:-1] + "5", "line2 ends in checksum '5', its digits give 4"),
        (LINE1, LINE2[:-2], "line2 has 67 characters"),
        (LINE2, LINE1, "are the lines swapped"),
        (LINE1, checksummed(LINE2.replace("25544", "25545")), "line1 is of satellite 25544"),
        (LINE1, checksummed(LINE2.replace("271.9610", "271,9610")), "doesn't belong"),
        (LINE1, checksummed(LINE2.replace("271.9610", "xxx.9610")), "doesn't belong"),
        (LINE1, checksummed(LINE2.replace("15.54887163", "00.00000000")),
         "gives 0 as its mean motion, outside"),
        (LINE1, checksummed(LINE2.replace("15.54887163", "16.94887163")), "below 80 km"),
        (LINE1, checksummed(LINE2.replace(" 51.6478", "251.6478")),
         "gives 251.6 as its inclination, outside"),
        (LINE1, checksummed(LINE2.replace("271.9610", "371.9610")),
         "gives 372 as its right ascension"),
        (LINE1, checksummed(LINE2.replace("0008043", "9008043")), "are no orbit|below 80 km"),
        (checksummed(LINE1.replace("15058.", "15000.")), LINE2,
         "gives 0.4816 as its day of the year, outside"),
        (checksummed(LINE1.replace("15058.", "15400.")), LINE2,
         "400.5 as its day of the year, outside 1..366"),
        (checksummed(LINE1.replace("15058.", "64058.")), LINE2, "1964-02-27.* lies outside 1973"),
        (checksummed(LINE1.replace("-3 0  999", "-3 4  999")), LINE2, "type 4, not for SGP4"),
        (LINE1.replace(" ", "\u2003", 1), LINE2, "plain ASCII"),
    ],
)  # fmt: skip
def test_faulty_sets_are_refused(line1, line2, reason):
    with pytest.raises(ValueError, match=reason):
        TleOrbit(line1=line1, line2=line2)


@pytest.mark.parametrize("sign", [1, -1])
def test_age_is_warned_of_from_3_days_and_refused_from_30(sign):
    orbit = TleOrbit(line1=LINE1, line2=LINE2)

    def ephemeris(days):
        start_utc = orbit.epoch_utc + sign * timedelta(days=days)
        return orbit.ephemeris(start_utc, start_utc + MINUTE)

    assert ephemeris(2.99).warnings == ()
    (warning,) = ephemeris(3.01).warnings
    assert "3.01 days from the farthest instant asked for" in warning
    with pytest.raises(OutsideCoverage, match="take newer ones") as refusal:
        ephemeris(30.01)
    assert refusal.value.field == "orbit.line1"


def test_sgp4s_own_errors_are_refusals():
    # so much drag that the mean motion loses its root within days
    heavy = checksummed(LINE1.replace("35618-3", "99999-0"))
    low = checksummed(LINE2.replace("15.54887163", "16.48887163"))
    orbit = TleOrbit(line1=heavy, line2=low)
    start_utc = orbit.epoch_utc + timedelta(days=2)
    ephemeris = orbit.ephemeris(start_utc, start_utc + MINUTE)
    with pytest.raises(OutsideCoverage, match="SGP4 gives up at"):
        ephemeris.states(Instants(start_utc, np.zeros(1)))


# Vallado, Fundamentals of Astrodynamics, 4th ed., example 3-14, the same state in two frames
STATE_EPOCH = datetime(2004, 4, 6, 7, 51, 28, 386009, tzinfo=UTC)
ITRF = {
    "frame": "ITRF",
    "position_km": (-1033.4793830, 7901.2952754, 6380.3565958),
    "velocity_km_s": (-3.225636520, -2.872451450, 5.531924446),
}
GCRF = {
    "frame": "GCRF",
    "position_km": (5102.508959, 6123.011403, 6378.136925),
    "velocity_km_s": (-4.743220157, 0.790536497, 5.533755727),
}
ISS = {
    "frame": "GCRF",
    "position_km": (545.284, 4217.417, 5288.810),
    "velocity_km_s": (-7.636397, 0.168828, 0.656343),
}


@pytest.mark.parametrize("force_model", ["full", "j2j4"])
def test_itrf_and_gcrf_states_start_at_the_same_place(force_model):
    starts = [
        StateVectorOrbit(epoch=STATE_EPOCH, force_model=force_model, **state)
        .ephemeris(STATE_EPOCH, STATE_EPOCH)
        .states(Instants(STATE_EPOCH, np.zeros(1)))
        for state in (ITRF, GCRF)
    ]
    # his UT1 is that of 0 h: 0.5 ms of the Earth's turning, 0.3 m (see test_frames_and_times)
    np.testing.assert_allclose(starts[0].r_sat_eci_m, starts[1].r_sat_eci_m, rtol=0, atol=0.35)
    np.testing.assert_allclose(starts[0].v_sat_eci_m_s, starts[1].v_sat_eci_m_s, rtol=0, atol=3e-4)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"position_km": (545284.0, 4217417.0, 5288810.0)}, "leaves the Earth"),
        ({"position_km": (0.545, 4.217, 5.289)}, "too low to orbit; is it in km"),
        ({"velocity_km_s": (-7636.4, 168.8, 656.3)}, "leaves the Earth"),
        ({"velocity_km_s": (-0.0076, 0.0002, 0.0007)}, "perigee is .* below 100 km"),
        ({"frame": "ITRF", "velocity_km_s": (0.0, 0.0, 0.0)}, "perigee is"),
    ],
)
def test_impossible_states_are_refused(change, reason):
    with pytest.raises(ValueError, match=reason):
        StateVectorOrbit(**{"epoch": STATE_EPOCH, **ISS, **change})


@pytest.mark.parametrize(("force_model", "warned_from_s"), [("full", 21600.0), ("j2j4", 900.0)])
def test_old_states_are_warned_of_and_refused(force_model, warned_from_s):
    orbit = StateVectorOrbit(epoch=STATE_EPOCH, force_model=force_model, **ISS)

    def warnings(after_s):
        stop_utc = STATE_EPOCH + timedelta(seconds=after_s)
        return orbit.ephemeris(STATE_EPOCH, stop_utc).warnings

    assert warnings(warned_from_s) == ()
    (warning,) = warnings(warned_from_s + 60.0)
    assert "expect an error of some" in warning
    with pytest.raises(OutsideCoverage, match="send a newer state") as refusal:
        warnings(3.01 * 86400.0)
    assert refusal.value.field == "orbit.epoch"
