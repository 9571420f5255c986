"""A flight with latencies, play, counts and clocks; and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from flight_cases import ARCSEC, ROCKING, rough, rows_between, steady, swinging

from planner.inflight.simulation.flight import fly
from planner.world.platforms import IDEAL_DRIVE, ISS_HRC, AxisDrive

SECONDS = 20.0


def ideal(**changes):
    return (replace(IDEAL_DRIVE, **changes), IDEAL_DRIVE)


def test_a_late_drive_is_where_the_table_was():
    table = swinging(SECONDS)
    flown = fly(table, ISS_HRC, drives=ideal(command_latency_s=0.34))
    late = rows_between(table, np.maximum(flown.t_s - 0.34, 0.0))[:, 0]
    np.testing.assert_allclose(flown.angle_rad[:, 0], late, rtol=0, atol=0.2 * ARCSEC)


def test_a_clock_that_is_ahead_flies_early():
    table = swinging(SECONDS)
    flown = fly(table, ISS_HRC, drives=ideal(), clock_offset_s=0.5)
    before_last = flown.t_s <= SECONDS - 0.5
    early = rows_between(table, flown.t_s[before_last] + 0.5)
    np.testing.assert_allclose(flown.angle_rad[before_last], early, rtol=0, atol=0.2 * ARCSEC)


def test_the_shaft_lags_by_half_the_play_either_way():
    table = swinging(SECONDS)
    flown = fly(table, ISS_HRC, drives=ideal(backlash_arcsec=40.0))
    behind = (flown.measured_angle_rad - flown.angle_rad)[:, 0] / ARCSEC
    rate = np.gradient(flown.measured_angle_rad[:, 0], flown.t_s) / ARCSEC
    assert np.abs(behind).max() == pytest.approx(20.0, abs=1e-6)
    quick = np.abs(rate) > 2000.0
    np.testing.assert_allclose(behind[quick], 20.0 * np.sign(rate[quick]), rtol=0, atol=1e-6)
    crossing = np.abs(behind) < 19.9
    assert np.any(crossing)
    assert np.all(flown.rate_rad_s[crossing, 0] == 0.0)


def test_encoder_and_gyro_count():
    drive = replace(
        IDEAL_DRIVE, encoder_step_arcsec=7.0, gyro_step_arcsec_s=13.0, encoder_noise_arcsec=2.0
    )
    flown = fly(swinging(SECONDS), ISS_HRC, drives=(drive, drive), seed=3)
    for measured, step in ((flown.measured_angle_rad, 7.0), (flown.measured_rate_rad_s, 13.0)):
        counts = measured / (step * ARCSEC)
        np.testing.assert_allclose(counts, np.round(counts), rtol=0, atol=1e-6)
        assert len(np.unique(np.round(counts[:, 0]))) > 100


def test_sensors_are_as_noisy_as_told():
    drive = replace(
        IDEAL_DRIVE, encoder_noise_arcsec=3.0, gyro_noise_arcsec_s=5.0, gyro_bias_arcsec_s=40.0
    )
    flown = fly(swinging(200.0), ISS_HRC, drives=(drive, drive), seed=5)
    angle = (flown.measured_angle_rad - flown.angle_rad) / ARCSEC
    rate = (flown.measured_rate_rad_s - flown.rate_rad_s) / ARCSEC
    # 10^4 samples: 1-sigma 0.7 % of a deviation.
    np.testing.assert_allclose(angle.std(axis=0), 3.0, rtol=0.04)
    np.testing.assert_allclose(rate.std(axis=0), 5.0, rtol=0.04)
    bias = [
        (flown.measured_rate_rad_s - flown.rate_rad_s).mean(axis=0) / ARCSEC
        for flown in (fly(steady(0.0, 0.0, duration_s=20.0), ISS_HRC, drives=(drive, drive), seed=k)
                      for k in range(60))
    ]  # fmt: skip
    assert np.std(bias) == pytest.approx(40.0, rel=0.25)  # 120 draws: 1-sigma 6.5 %


def test_the_same_seed_flies_the_same_and_another_does_not():
    table = swinging(SECONDS)
    first, again, other = (fly(table, ISS_HRC, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(first.angle_rad, again.angle_rad)
    assert np.array_equal(first.measured_rate_rad_s, again.measured_rate_rad_s)
    assert not np.array_equal(first.angle_rad, other.angle_rad)


def test_a_weak_drive_saturates_and_stays_behind():
    limits = replace(ISS_HRC.outer_limits, acceleration_max_rad_s2=0.004)  # the table asks 0.0126
    platform = replace(ISS_HRC, outer_limits=limits)
    flown = fly(swinging(SECONDS), platform, drives=(rough(torque_reserve=1.0), rough()))
    strong = fly(swinging(SECONDS), ISS_HRC, drives=(rough(), rough()))
    told = rows_between(swinging(SECONDS), flown.t_s)
    behind = np.abs(flown.angle_rad - told)[:, 0].max()
    assert behind > 10.0 * np.abs(strong.angle_rad - told)[:, 0].max()
    acceleration = np.diff(flown.rate_rad_s[:, 0]) / 0.02
    coulomb = np.radians(rough().breakaway_deg_s2)
    assert np.abs(acceleration).max() < 0.004 + 2.0 * coulomb


def test_the_gyro_feels_the_structure_and_the_encoder_does_not():
    drives = (replace(IDEAL_DRIVE, inertia_kg_m2=90.0), IDEAL_DRIVE)
    flown = fly(swinging(SECONDS), ROCKING, drives=drives)
    assert np.abs(flown.structure_rad).max() > 100.0 * ARCSEC
    assert np.array_equal(flown.measured_angle_rad, flown.angle_rad)
    outer = ROCKING.axes_platform[0]
    felt = flown.measured_rate_rad_s[:, 0] - flown.rate_rad_s[:, 0]
    swing = np.gradient(flown.structure_rad @ outer, flown.t_s)
    # Differences over 0.04 s of a swing of 2 Hz are 4 % off.
    np.testing.assert_allclose(felt[1:-1], swing[1:-1], rtol=0, atol=0.05 * np.abs(swing).max())


def test_output_at_a_multiple_of_the_control_step():
    table = swinging(SECONDS)
    whole, tenth = fly(table, ISS_HRC), fly(table, ISS_HRC, output_step_s=0.2)
    assert np.array_equal(tenth.angle_rad, whole.angle_rad[::10])
    np.testing.assert_allclose(tenth.t_s, table.t_s)
    for wrong in (0.03, 0.0, 0.005):
        with pytest.raises(ValueError, match=r"whole multiple of 0\.02"):
            fly(table, ISS_HRC, output_step_s=wrong)


def test_a_drive_that_cannot_be_is_refused_by_name():
    with pytest.raises(ValueError, match=r"lag_s \(0\.5\) is too long for a loop of 2 Hz"):
        AxisDrive(bandwidth_hz=2.0, lag_s=0.5)
    with pytest.raises(ValueError, match="breakaway_deg_s2 must be at least coulomb_deg_s2"):
        AxisDrive(coulomb_deg_s2=0.3)
    with pytest.raises(ValueError, match="for no friction set both to 0"):
        AxisDrive(coulomb_deg_s2=0.0)


@pytest.mark.parametrize("bandwidth_hz", [0.1, 0.3, 1.0, 3.0])
def test_a_loop_is_refused_where_it_would_swing_up(bandwidth_hz):
    """A loop that is just accepted settles in flight from a step of its command."""

    def accepted(lag_s):
        try:
            return AxisDrive(bandwidth_hz=bandwidth_hz, lag_s=lag_s) is not None
        except ValueError:
            return False

    low, high = 0.0, 5.0
    for _ in range(20):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if accepted(middle) else (low, middle)
    table = steady(0.0, 0.0, duration_s=60.0 / bandwidth_hz)
    table.position[5:] += 0.1 * ARCSEC  # below what saturates
    drive = replace(IDEAL_DRIVE, bandwidth_hz=bandwidth_hz, lag_s=0.9 * low)
    error = np.abs(fly(table, ISS_HRC, drives=(drive, drive)).angle_rad - table.position[-1])
    assert error[-500:].max() < 0.2 * error[:500].max()
