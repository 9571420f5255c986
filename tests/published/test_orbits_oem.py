"""The interpolated ephemeris agrees with what NASA publishes beside the states."""

import re
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import erfa
import numpy as np
import pytest
from scipy.optimize import brentq

from planner.base.errors import OutsideCoverage
from planner.world.frames.time_scales import Instants, shifted_utc, utc_from_text
from planner.world.orbits import OemOrbit, StateVectorOrbit
from planner.world.orbits.accuracy import oem_sigma
from planner.world.orbits.burns import burns_between
from planner.world.orbits.cell_defects import cell_defects, odd_nodes, smooth_arcs, strongest_push
from planner.world.orbits.collocation import node_times_s, propagate_segment
from planner.world.orbits.forces import forces_at

DATA = Path(__file__).parents[1] / "data"
FILES = sorted(DATA.glob("iss_oem_*_excerpt.xml"))
REBOOST = DATA / "iss_oem_2022-038_excerpt.xml"
CALM = DATA / "iss_oem_2022-017_excerpt.xml"
EARTH_RADIUS_M = 6378137.0
ISS = 2.0 * 1500.0 / 450e3  # m2/kg


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_first_ascending_node_is_nasas(path):
    """NASA gives the node's time to 1 ms and its longitude to 1e-5 deg, with UT1 = UTC."""
    text = path.read_text()
    stated = re.search(r"first asc. node: EPOCH = (\S+) .* LAN\(DEG\) = (\S+)<", text)
    epoch_utc, longitude_deg = utc_from_text(stated[1] + "Z"), float(stated[2])
    ephemeris = OemOrbit(content=text).ephemeris(
        epoch_utc - timedelta(seconds=10), epoch_utc + timedelta(seconds=10)
    )

    def r_earth_m(t_s):
        instants = Instants(epoch_utc, np.array([t_s]))
        r_eci_m = ephemeris.states(instants).r_sat_eci_m[0]
        x, y, s = erfa.xys06a(*instants.tt_jd())
        r_cirs_m = erfa.c2ixys(x, y, s)[0] @ r_eci_m
        return erfa.rz(erfa.era00(*instants.utc_jd())[0], np.eye(3)) @ r_cirs_m

    node_s = brentq(lambda t_s: r_earth_m(t_s)[2], -5.0, 5.0, xtol=1e-9)
    assert abs(node_s) < 1e-3
    x, y, _ = r_earth_m(node_s)
    off_deg = (np.rad2deg(np.arctan2(y, x)) - longitude_deg + 180.0) % 360.0 - 180.0
    # 0.5 ms of 4.4 km/s eastward on the ground and half the last digit of the longitude: 2.8 m
    assert abs(np.deg2rad(off_deg)) * EARTH_RADIUS_M < 2.8


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_between_the_nodes_lies_the_propagated_orbit(path):
    """Half-way between nodes, against the mean of propagating from either side."""
    segment = OemOrbit(content=path.read_text()).message.segments[1]
    ephemeris = OemOrbit(content=path.read_text()).ephemeris(
        *(shifted_utc(segment.epoch_utc, float(t)) for t in segment.t_s[[0, -1]])
    )
    errors_m = []
    for k in range(2, len(segment.t_s) - 4, 3):
        nodes = Instants(segment.epoch_utc, segment.t_s[k : k + 2])
        if nodes.t_s[1] - nodes.t_s[0] != 240.0:
            continue
        states = ephemeris.states(nodes)
        middle_s = float(np.mean(nodes.t_s))
        from_either_side = []
        for side in (0, 1):
            start_s = float(nodes.t_s[side])
            at = Instants(segment.epoch_utc, node_times_s(start_s, middle_s))
            motion = propagate_segment(
                states.r_sat_eci_m[side],
                states.v_sat_eci_m_s[side],
                start_s,
                middle_s,
                forces_at(at, ISS).acceleration_eci_m_s2,
            )
            from_either_side.append(motion.at(np.array([middle_s]))[0][0])
        middle = ephemeris.states(Instants(segment.epoch_utc, np.array([middle_s])))
        errors_m.append(np.linalg.norm(middle.r_sat_eci_m[0] - np.mean(from_either_side, axis=0)))
    assert len(errors_m) >= 4
    # the field's short waves that six nodes 240 s apart can't follow
    assert np.sqrt(np.mean(np.square(errors_m))) < 0.05


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_nasas_own_nodes_agree_with_each_other(path):
    """Also across the reboost.  Of the file of 2025 some epochs are 1 ms off their 30.6 s."""
    stamped_m = 7.7 if "2025" in path.stem else 0.05  # 7.66 km/s for 1 ms; the field's waves
    for segment in OemOrbit(content=path.read_text()).message.segments:
        nodes = Instants(segment.epoch_utc, segment.t_s)
        defects = cell_defects(nodes, segment.r_m, segment.v_m_s)
        assert odd_nodes(defects).off_m < stamped_m
        assert strongest_push(defects) is None


def test_the_reboost_is_found_where_nasa_says():
    """The file's event summary: ignition 039:07:56:00.000, 0.3 m/s."""
    segment = OemOrbit(content=REBOOST.read_text()).message.segments[2]
    r_m, v_m_s = segment.r_m, segment.v_m_s  # the frame bias is no matter here
    arcs = smooth_arcs(cell_defects(Instants(segment.epoch_utc, segment.t_s), r_m, v_m_s))
    assert [arc.thrust_m_s2 > 0.0 for arc in arcs] == [False, True, False]
    burn_s = segment.t_s[[arcs[1].first, arcs[1].last]]
    ignition_utc = shifted_utc(segment.epoch_utc, float(burn_s[0]))
    assert ignition_utc == utc_from_text("2022-02-08T07:56:00Z")
    velocity_gain_m_s = arcs[1].thrust_m_s2 * (burn_s[1] - burn_s[0])
    assert velocity_gain_m_s == pytest.approx(0.3, abs=0.05)  # half its last digit


def test_no_polynomial_crosses_the_reboost():
    """Just before ignition and after cut-off the velocity turns smoothly, as gravity bends it."""
    orbit = OemOrbit(content=REBOOST.read_text())
    ignition_utc = utc_from_text("2022-02-08T07:56:00Z")
    ephemeris = orbit.ephemeris(
        ignition_utc - timedelta(seconds=700), ignition_utc + timedelta(seconds=900)
    )
    [planned] = ephemeris.warnings
    assert "a burn it plans: 0.26 m/s at 2022-02-08T07:56:00Z" in planned
    for first_s, last_s in ((-240.0, -1.0), (1.0, 141.0), (143.0, 382.0)):
        t_s = np.arange(first_s, last_s, 1.0)
        at = Instants(ignition_utc, t_s)
        states = ephemeris.states(at)
        second = (
            ephemeris.states(Instants(ignition_utc, t_s + 0.5)).v_sat_eci_m_s
            - ephemeris.states(Instants(ignition_utc, t_s - 0.5)).v_sat_eci_m_s
        )
        gravity = forces_at(at, ISS).acceleration_eci_m_s2(states.r_sat_eci_m, states.v_sat_eci_m_s)
        thrust_m_s2 = np.linalg.norm(second - gravity, axis=1)
        burning = first_s == 1.0
        # 0.26 m/s in 142 s; while coasting what four and six nodes leave of the field, 1e-4
        expected = 0.26 / 142.0 if burning else 0.0
        np.testing.assert_allclose(thrust_m_s2, expected, rtol=0, atol=2e-4)


def test_segments_are_joined_but_gaps_refused():
    orbit = OemOrbit(content=REBOOST.read_text())
    first, second = orbit.message.segments[:2]
    start_utc = shifted_utc(first.epoch_utc, 600.0)
    with pytest.raises(OutsideCoverage, match=r"says nothing between 2022-02-07T13:28:00\.000Z"):
        orbit.ephemeris(start_utc, shifted_utc(second.epoch_utc, 600.0))
    with pytest.raises(OutsideCoverage) as before:
        orbit.ephemeris(start_utc - timedelta(days=1), start_utc)
    assert before.value.field == "orbit.content"
    assert "it covers 2022-02-07T12:00:00.000Z to 2022-02-07T13:28:00.000Z" in before.value.detail


def test_instants_outside_the_prepared_span_are_refused():
    orbit = OemOrbit(content=REBOOST.read_text())
    start_utc = shifted_utc(orbit.message.segments[0].epoch_utc, 600.0)
    ephemeris = orbit.ephemeris(start_utc, start_utc + timedelta(seconds=60))
    with pytest.raises(OutsideCoverage, match="prepared only from"):
        ephemeris.states(Instants(start_utc, np.array([61.0])))


MOVED = DATA / "iss_oem_2022-031_excerpt.oem"  # its reboost of 037/09:30 was flown on 039


def test_a_planned_burn_before_the_session_is_named_and_widens_the_error():
    """NASA's next ephemeris has the station 77 km from there: told to a factor of three, no less.

    Without the burn's part 20 km were told.
    """
    start_utc, stop_utc = (utc_from_text(f"2022-02-07T{t}:00Z") for t in ("12:00", "13:20"))
    at = Instants(start_utc, np.arange(0.0, 4800.0, 60.0))
    planned = OemOrbit(content=MOVED.read_text()).ephemeris(start_utc, stop_utc)
    truth = OemOrbit(content=REBOOST.read_text()).ephemeris(start_utc, stop_utc)
    off_m = planned.states(at).r_sat_eci_m - truth.states(at).r_sat_eci_m
    seen_m = float(np.sqrt(np.mean(np.sum(off_m**2, axis=1))))
    told = planned.sigma(at)
    assert 70e3 < seen_m < 3.0 * told.along_m.mean() < 6.0 * seen_m
    [warning] = planned.warnings
    assert "0.20 m/s at 2022-02-06T09:30:00Z" in warning
    assert truth.warnings == ()  # its own burn comes later


def test_before_its_planned_burn_an_ephemeris_is_as_good_as_without():
    before_utc = [utc_from_text(f"2022-02-06T09:{minute}:00Z") for minute in (20, 25)]
    ephemeris = OemOrbit(content=MOVED.read_text()).ephemeris(*before_utc)
    assert ephemeris.warnings == ()
    told = ephemeris.sigma(Instants(before_utc[0], np.zeros(1)))
    assert (
        told.along_m
        == oem_sigma(
            ephemeris.age_s(Instants(before_utc[0], np.zeros(1))), ephemeris.drag_in_a_day_m
        ).along_m
    )


@pytest.mark.parametrize("gain_m_s", [0.3, -0.05])
def test_a_jump_of_velocity_from_one_segment_to_the_next_is_a_burn(gain_m_s):
    """As of a message that splits where an engine burns for an instant."""
    segment = OemOrbit(content=CALM.read_text()).message.segments[0]
    epoch_utc, middle = segment.epoch_utc, len(segment.t_s) // 2
    kick = segment.v_m_s[middle] / np.linalg.norm(segment.v_m_s[middle]) * gain_m_s
    after = StateVectorOrbit(
        frame="EME2000",
        epoch=shifted_utc(epoch_utc, float(segment.t_s[middle])),
        position_km=tuple(segment.r_m[middle] / 1e3),
        velocity_km_s=tuple((segment.v_m_s[middle] + kick) / 1e3),
    )
    seconds = segment.t_s[middle:] - segment.t_s[middle]
    stop_utc = shifted_utc(after.epoch, float(seconds[-1]))
    states = after.ephemeris(after.epoch, stop_utc).states(Instants(after.epoch, seconds))
    parts = [
        replace(segment, t_s=segment.t_s[: middle + 1], r_m=segment.r_m[: middle + 1],
                v_m_s=segment.v_m_s[: middle + 1]),
        replace(segment, t_s=segment.t_s[middle:], r_m=states.r_sat_eci_m,
                v_m_s=states.v_sat_eci_m_s),
    ]  # fmt: skip
    [burn] = burns_between(parts, epoch_utc, stop_utc)
    assert burn.ignition_utc == after.epoch
    assert burn.along_m_s == pytest.approx(gain_m_s, abs=5e-3)  # the cell bends between both
    assert burns_between([segment], epoch_utc, stop_utc) == ()
