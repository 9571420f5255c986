"""Readers that others wrote find in our files the attitude and orbit of the plan."""

import io
import json

import ccsds_ndm
import cftime
import erfa
import netCDF4
import numpy as np
import pytest
import stk_files
from czml3 import Document
from export_cases import (
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
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

from planner.output.export import EXPORTERS
from planner.world.frames.time_scales import Instants
from planner.world.platforms import ISS_HRC

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
