"""Readers that others wrote, or SciPy, find in our files the attitude and orbit of the plan.

Orekit needs Java, so its reading is kept: see exports_by_orekit.py, run by `make oracles`.
"""

import dataclasses
import io
import json
import re
from pathlib import Path

import ccsds_ndm
import cftime
import erfa
import netCDF4
import numpy as np
import pytest
import stk_files
from czml3 import Document
from export_cases import (
    ARCSEC_RAD,
    CREATED_UTC,
    EPOCH_UTC,
    READ_BACK_RAD,
    SKEW,
    apart_rad,
    c_body_from_eci,
    c_payload_from_body,
    case,
    orbit_states,
    turned_axes_quaternions,
)
from judged_bodies import BODY, body_scenario, body_table
from judged_tables import CircularOrbit
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

from planner.output.export import EXPORTERS
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import CarrierName
from planner.world.plan import FlightPlan, Segment
from planner.world.platforms import ISS_HRC
from planner.world.platforms.body import FrameCamera

MICROSECOND_NS = 1000
CONJUGATE = np.array([-1.0, -1.0, -1.0, 1.0])


@pytest.fixture(scope="module", params=[SKEW, ISS_HRC], ids=lambda platform: platform.name)
def plan(request):
    return case(platform=request.param)


@pytest.fixture(scope="module")
def states(plan):
    return orbit_states(plan.scenario.orbit, Instants(EPOCH_UTC, plan.table.t_s))


@pytest.fixture(scope="module")
def c_body(states):
    return c_body_from_eci(states)


@pytest.fixture(scope="module")
def c_payload(plan, c_body):
    return c_payload_from_body(plan.scenario.platform, plan.table.position) @ c_body


def written(name, plan):
    return EXPORTERS[name].write(plan, CREATED_UTC)


def row_times(plan):
    return np.datetime64("2015-02-27T17:36:00", "ns") + np.round(plan.table.t_s * 1e9).astype(
        "timedelta64[ns]"
    )


def test_aem_by_ccsds_ndm(plan, c_payload):
    (segment,) = ccsds_ndm.Aem.from_str(written("aem", plan).decode()).segments
    metadata, data = segment.metadata, segment.data
    assert (metadata.ref_frame_a, metadata.ref_frame_b) == ("GCRF", "INSTRUMENT_1")
    assert metadata.attitude_type == "QUATERNION/ANGVEL"
    assert metadata.object_id == "1998-067A"
    assert metadata.angvel_frame == metadata.ref_frame_b
    times = np.array(data.attitude_states_epochs, dtype="datetime64[ns]")
    assert np.abs(times - row_times(plan)).max().astype(int) < MICROSECOND_NS
    q_xyzw = data.attitude_states_numpy[:, :4]
    assert apart_rad(q_xyzw, turned_axes_quaternions(c_payload)) < READ_BACK_RAD


def test_aem_rates_give_back_what_is_flown_between_rows(plan):
    """A cubic Hermite of quaternions and rates, half-way, against the cubic of the angles."""
    (segment,) = ccsds_ndm.Aem.from_str(written("aem", plan).decode()).segments
    data = segment.data.attitude_states_numpy
    p, omega_rad_s = Rotation.from_quat(data[:, :4]), np.deg2rad(data[:, 4:])
    half_turn = np.column_stack([0.5 * omega_rad_s, np.zeros(len(data))])
    t_s = plan.table.t_s
    q_dot = quaternion_product(p.as_quat(), half_turn)
    sign = np.sign(np.sum(p.as_quat() * data[:, :4], axis=1))[:, None]
    middle_s = t_s[:-1] + 0.1
    met = CubicHermiteSpline(t_s, data[:, :4], sign * q_dot)(middle_s)
    met /= np.linalg.norm(met, axis=1, keepdims=True)
    angle_rad = CubicHermiteSpline(t_s, plan.table.position, plan.table.rate_rad_s)(middle_s)
    c_body = c_body_from_eci(orbit_states(plan.scenario.orbit, Instants(EPOCH_UTC, middle_s)))
    c_flown = c_payload_from_body(plan.scenario.platform, angle_rad) @ c_body
    # 0.1 arcsec, what the table promises; h^4/384 of the fourth derivative is 1e-3 arcsec here
    assert apart_rad(met, turned_axes_quaternions(c_flown)) < 10.0 * READ_BACK_RAD


def quaternion_product(p, q):
    """Hamilton's, scalar last."""
    vector = p[:, 3:] * q[:, :3] + q[:, 3:] * p[:, :3] + np.cross(p[:, :3], q[:, :3])
    scalar = p[:, 3:] * q[:, 3:] - np.sum(p[:, :3] * q[:, :3], axis=1, keepdims=True)
    return np.hstack([vector, scalar])


def test_oem_by_ccsds_ndm(plan, states):
    (segment,) = ccsds_ndm.Oem.from_str(written("oem", plan).decode()).segments
    assert segment.metadata.ref_frame == "GCRF"
    rows = np.unique([*range(0, len(plan.table.t_s), 5), len(plan.table.t_s) - 1])
    times = np.array(segment.data.state_vector_epochs, dtype="datetime64[ns]")
    assert np.abs(times - row_times(plan)[rows]).max().astype(int) < MICROSECOND_NS
    read = segment.data.state_vector_numpy
    # printed to 1 um and 1 nm/s
    np.testing.assert_allclose(1e3 * read[:, :3], states.r_sat_eci_m[rows], rtol=0, atol=6e-7)
    np.testing.assert_allclose(1e3 * read[:, 3:], states.v_sat_eci_m_s[rows], rtol=0, atol=6e-10)


def test_sensor_pointing_and_attitude_by_stk_files(plan, c_body, c_payload):
    """The .sp on the .a is the payload's attitude, as STK would turn the sensor."""
    config, times, q_sensor = stk_files.read_sensor(io.StringIO(written("stk", plan).decode()))
    assert (config.format, config.coordinate_axes) == ("Quaternions", None)
    np.testing.assert_array_equal(times.astype("datetime64[ns]"), row_times(plan))
    expected = turned_axes_quaternions(c_payload @ np.swapaxes(c_body, 1, 2))
    assert apart_rad(q_sensor, expected) < READ_BACK_RAD

    carrier = io.StringIO(written("stk-attitude", plan).decode())
    config, times, q_carrier = stk_files.read_attitude(carrier)
    assert (config.format, config.coordinate_axes, config.central_body) == (
        "Quaternions",
        "ICRF",
        "Earth",
    )
    np.testing.assert_array_equal(times.astype("datetime64[ns]"), row_times(plan))
    assert apart_rad(q_carrier, turned_axes_quaternions(c_body)) < READ_BACK_RAD
    both = quaternion_product(q_carrier, q_sensor)  # axes turned twice: the later on the right
    assert apart_rad(both, turned_axes_quaternions(c_payload)) < READ_BACK_RAD


def test_czml_by_czml3(plan, states, c_payload):
    text = written("czml", plan)
    document = Document(packets=json.loads(text))
    assert json.loads(document.to_json()) == json.loads(text)
    packets = {packet.id: packet for packet in document.packets}
    t_s = plan.table.t_s
    c_itrf = c_itrf_from_eci_by_erfa(t_s)

    samples = np.reshape(packets["carrier"].position.cartesian.values, (-1, 4))
    np.testing.assert_array_equal(samples[:, 0], t_s)
    expected_m = np.einsum("nij,nj->ni", c_itrf, states.r_sat_eci_m)
    # c2t06a leaves out dX, dY: 0.3 mas, 1 cm at the Earth's radius
    np.testing.assert_allclose(samples[:, 1:], expected_m, rtol=0, atol=0.02)

    samples = np.reshape(packets["payload"].orientation.unitQuaternion.values, (-1, 5))
    c_itrf_from_payload = c_itrf @ np.swapaxes(c_payload, 1, 2)
    expected = Rotation.from_matrix(c_itrf_from_payload).as_quat()
    assert apart_rad(samples[:, 1:], expected) < READ_BACK_RAD
    assert packets["target-0"].availability is not None


def c_itrf_from_eci_by_erfa(t_s):
    """Full IAU 2006/2000A series; IERS finals2000A, Bulletin A, 27 and 28 Feb 2015 0h UTC."""
    utc = erfa.dtf2d("UTC", 2015, 2, 27, 17, 36, 0.0)
    tai1, tai2 = erfa.utctai(*utc)
    tai2 = tai2 + t_s / 86400.0
    day = (utc[1] + t_s / 86400.0)[:, None]
    at, after = (
        np.array([0.003247, 0.353179, -0.5259277]),
        np.array([0.003160, 0.354817, -0.5268002]),
    )
    x, y, ut1_utc = (at + day * (after - at)).T
    tt, ut1 = erfa.taitt(tai1, tai2), erfa.taiut1(tai1, tai2, ut1_utc - 35.0)
    return erfa.c2t06a(*tt, *ut1, x * erfa.DAS2R, y * erfa.DAS2R)


def test_netcdf_by_the_reference_library(plan, states, c_payload):
    data = netCDF4.Dataset("plan.nc", memory=written("netcdf", plan))
    data.set_auto_mask(False)
    assert data.data_model == "NETCDF3_64BIT_OFFSET"
    assert data.Conventions == "CF-1.12"
    time = data["time"]
    moments = cftime.num2pydate(time[:], time.units, time.calendar)
    times = np.array(moments, dtype="datetime64[us]").astype("datetime64[ns]")
    assert np.abs(times - row_times(plan)).max().astype(int) <= MICROSECOND_NS
    assert b"".join(data["utc"][1]) == b"2015-02-27T17:36:00.2Z"

    q_xyzw = data["q_payload_from_gcrf_xyzw"][:]
    assert apart_rad(CONJUGATE * q_xyzw, turned_axes_quaternions(c_payload)) < READ_BACK_RAD
    np.testing.assert_array_equal(data["r_sat_gcrf_m"][:], states.r_sat_eci_m)
    for column, axis in enumerate(plan.scenario.platform.axis_names):
        read_rad = np.deg2rad(data[f"{axis}_deg"][:])
        # rounded to 1e-9 deg
        np.testing.assert_allclose(read_rad, plan.table.position[:, column], rtol=0, atol=1e-11)
        assert data[f"{axis}_rate_deg_s"].units == "degree s-1"
    meanings = data["activity"].flag_meanings.split()
    activity = [meanings[flag] for flag in data["activity"][[2, 50, 200]]]
    assert activity == ["wait", "slew", "track"]


@pytest.mark.parametrize("name", ["csv", "json"])
def test_tables_by_numpy_and_json(plan, name):
    content = written(name, plan)
    if name == "csv":
        read = np.genfromtxt(
            io.BytesIO(content),
            delimiter=",",
            skip_header=content.count(b"#"),
            names=True,
            dtype=None,
        )
        assert read["utc"][0] == "2015-02-27T17:36:00.0Z"
    else:
        read = json.loads(content)
        assert read["epoch"] == "2015-02-27T17:36:00.0Z"
    np.testing.assert_array_equal(read["t_s"], plan.table.t_s)
    for column, axis in enumerate(plan.table.dof_names):
        for key, values in (("deg", plan.table.position), ("rate_deg_s", plan.table.rate_rad_s)):
            # rounded to 1e-9 deg
            np.testing.assert_allclose(
                np.deg2rad(read[f"{axis}_{key}"]), values[:, column], rtol=0, atol=1e-11
            )


READ = json.loads((Path(__file__).parents[1] / "data" / "exports_by_orekit.json").read_text())
SAMPLES = READ["samples"]
PLAN = case()


def flown_at(t_s):
    """Payload axes in GCRF as rows, states; angles by the cubic Hermite the platform flies."""
    table = PLAN.table
    angle_rad = CubicHermiteSpline(table.t_s, table.position, table.rate_rad_s)(t_s)
    states = orbit_states(PLAN.scenario.orbit, Instants(EPOCH_UTC, np.append(t_s, 60.0)))
    c_body = c_body_from_eci(states)[:-1]
    return c_payload_from_body(SKEW, angle_rad) @ c_body, states


def test_orekit_knows_what_the_messages_are_about():
    assert (READ["attitude_from"], READ["attitude_to"]) == ("GCRF", "INSTRUMENT_1")
    assert READ["attitude_type"] == "QUATERNION/ANGVEL"
    assert READ["object_id"] == "1998-067A"
    assert READ["start"] == "2015-02-27T17:36:00.000Z"
    assert READ["orbit_stop"] == "2015-02-27T17:37:00.000Z"


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: f"{sample['t_s']} s")
def test_orekit_finds_the_attitude(sample):
    c_payload, _ = flown_at(np.array([sample["t_s"]]))
    on_row = abs(5.0 * sample["t_s"] - round(5.0 * sample["t_s"])) < 1e-9
    # on rows 0.01 arcsec; between them what the table promises, 0.1 arcsec
    tolerance_rad = READ_BACK_RAD if on_row else 0.1 * ARCSEC_RAD
    for axis, name in ((0, "x_payload_gcrf"), (2, "z_payload_gcrf")):
        assert np.linalg.norm(c_payload[0, axis] - sample[name]) < tolerance_rad


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: f"{sample['t_s']} s")
def test_orekit_finds_the_angular_velocity(sample):
    step_s = 1e-3
    inside_s = np.clip(sample["t_s"], step_s, 60.0 - step_s)
    (before, here, after), _ = flown_at(inside_s + step_s * np.arange(-1.0, 2.0))
    cross = here @ (after - before).T / (2.0 * step_s)  # of omega, in payload axes
    omega_rad_s = np.array([cross[2, 1], cross[0, 2], cross[1, 0]])
    # at the table's ends the difference is taken 1 ms inside, at up to 0.06 rad/s2; elsewhere
    # Hermite's rate error h^3/96 of the fourth derivative, 2e-8 rad/s
    atol = 1e-4 if inside_s != sample["t_s"] else 1e-6
    np.testing.assert_allclose(sample["spin_payload_rad_s"], omega_rad_s, rtol=0, atol=atol)


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: f"{sample['t_s']} s")
def test_orekit_finds_the_orbit(sample):
    _, states = flown_at(np.array([sample["t_s"]]))
    # SGP4's velocity strays from its position's derivative by 16 mm/s (central differences of
    # either), of which Hermite interpolation of 1 s nodes makes 2 mm and 40 mm/s between them
    on_node = sample["t_s"] == round(sample["t_s"])
    for found, planned, atol in (
        (sample["r_sat_gcrf_m"], states.r_sat_eci_m[0], 1e-6 if on_node else 2e-3),
        (sample["v_sat_gcrf_m_s"], states.v_sat_eci_m_s[0], 1e-8 if on_node else 0.05),
    ):
        np.testing.assert_allclose(found, planned, rtol=0, atol=atol)


# Looks along body -Y; the frame's first side is body Z.
CAMERA = FrameCamera(
    boresight_body=(0.0, -2.0, 0.0), side_body=(0.0, 0.0, 1.0), field_of_view_deg=(2.0, 1.5)
)
CAMERA_BODY = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # +X, +Y, +Z


class NamedOrbit(CircularOrbit):
    carrier_name = CarrierName("SMALLSAT", "2026-001A")


@pytest.fixture(scope="module")
def plan_of_a_body():
    scenario = body_scenario(dataclasses.replace(BODY, camera=CAMERA), orbit=NamedOrbit())
    table = body_table()
    start, stop = (shifted_utc(table.epoch_utc, row / 5.0) for row in (300, 500))
    segments = (Segment(kind="track", session=0, start_utc=start, stop_utc=stop),)
    return FlightPlan(scenario=scenario, segments=segments, table=table)


def numbers(lines):
    return np.array([[float(number) for number in line.split()[1:]] for line in lines])


def off_rad(q_eci_from_frame_xyzw, axes_eci):
    """Of a frame's axes, turned as the file says, from where they are; axes_eci: (n, 3, 3)."""
    turns = Rotation.from_quat(q_eci_from_frame_xyzw)
    found = np.stack([turns.apply(axis) for axis in np.eye(3)], axis=1)
    return np.linalg.norm(found - axes_eci, axis=2).max()


def test_aem_has_the_body_and_its_camera(plan_of_a_body):
    text = written("aem", plan_of_a_body).decode()
    frames = re.findall(r"^REF_FRAME_B = (\S+)$", text, re.MULTILINE)
    assert frames == ["SC_BODY_1", "INSTRUMENT_1"]
    body, camera = (
        numbers(part.strip().splitlines())
        for part in re.findall(r"DATA_START\n(.*?)DATA_STOP", text, re.DOTALL)
    )
    q = Rotation.from_quat(plan_of_a_body.table.position)
    axes = np.stack([q.apply(axis) for axis in np.eye(3)], axis=1)
    # CCSDS: the quaternion turns frame A's axes into frame B's, so vectors of B into A
    assert off_rad(body[:, :4], axes) < 1e-12
    assert off_rad(camera[:, :4], np.stack([q.apply(axis) for axis in CAMERA_BODY], 1)) < 1e-12
    omega_deg_s = np.degrees(plan_of_a_body.table.rate_rad_s)
    assert body[:, 4:] == pytest.approx(omega_deg_s, abs=1e-9)
    assert camera[:, 4:] == pytest.approx(omega_deg_s @ CAMERA_BODY.T, abs=1e-9)


def test_stk_has_the_body_and_a_constant_mount(plan_of_a_body):
    def rows(format_name):
        lines = written(format_name, plan_of_a_body).decode().splitlines()
        return numbers(lines[lines.index("AttitudeTimeQuaternions") + 1 : -1])

    q = Rotation.from_quat(plan_of_a_body.table.position)
    axes = np.stack([q.apply(axis) for axis in np.eye(3)], axis=1)
    assert off_rad(rows("stk-attitude"), axes) < 1e-12
    assert off_rad(rows("stk"), np.tile(CAMERA_BODY, (len(axes), 1, 1))) < 1e-12


def test_csv_has_every_channel(plan_of_a_body):
    lines = written("csv", plan_of_a_body).decode().splitlines()
    table = [line.split(",") for line in lines if not line.startswith("#")]
    assert table[0][2:] == [channel.name for channel in plan_of_a_body.table.channels]
    values = np.array(table[1:])[:, 2:].astype(float)
    assert values[:, :4] == pytest.approx(plan_of_a_body.table.position, abs=1e-13)
    assert np.deg2rad(values[:, 7:]) == pytest.approx(
        plan_of_a_body.table.acceleration_rad_s2, abs=1e-10
    )
