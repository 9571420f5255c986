"""States are taken in every frame, and impossible ones refused."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from planner.base.errors import OutsideCoverage
from planner.world.frames.time_scales import Instants
from planner.world.orbits import StateVectorOrbit

# Vallado, Fundamentals of Astrodynamics, 4th ed., example 3-14, the same state in two frames
EPOCH = datetime(2004, 4, 6, 7, 51, 28, 386009, tzinfo=UTC)
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
        StateVectorOrbit(epoch=EPOCH, force_model=force_model, **state)
        .ephemeris(EPOCH, EPOCH)
        .states(Instants(EPOCH, np.zeros(1)))
        for state in (ITRF, GCRF)
    ]
    # his UT1 is that of 0 h: 0.5 ms of the Earth's turning, 0.3 m (see test_earth_frames)
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
        StateVectorOrbit(**{"epoch": EPOCH, **ISS, **change})


@pytest.mark.parametrize(("force_model", "warned_from_s"), [("full", 21600.0), ("j2j4", 900.0)])
def test_old_states_are_warned_of_and_refused(force_model, warned_from_s):
    orbit = StateVectorOrbit(epoch=EPOCH, force_model=force_model, **ISS)

    def warnings(after_s):
        stop_utc = EPOCH + timedelta(seconds=after_s)
        return orbit.ephemeris(EPOCH, stop_utc).warnings

    assert warnings(warned_from_s) == ()
    (warning,) = warnings(warned_from_s + 60.0)
    assert "expect an error of some" in warning
    with pytest.raises(OutsideCoverage, match="send a newer state") as refusal:
        warnings(3.01 * 86400.0)
    assert refusal.value.field == "orbit.epoch"
