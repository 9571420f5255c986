"""Files of a body's table say where the body and its camera point, against SciPy."""

import dataclasses
import re
from datetime import UTC, datetime

import numpy as np
import pytest
from judged_bodies import BODY, body_scenario, body_table
from judged_tables import CircularOrbit
from scipy.spatial.transform import Rotation

from planner.output.export import EXPORTERS
from planner.world.frames.time_scales import shifted_utc
from planner.world.orbits import CarrierName
from planner.world.plan import FlightPlan, Segment
from planner.world.platforms.body import FrameCamera

CREATED_UTC = datetime(2026, 6, 1, tzinfo=UTC)
# Looks along body -Y; the frame's first side is body Z.
CAMERA = FrameCamera(
    boresight_body=(0.0, -2.0, 0.0), side_body=(0.0, 0.0, 1.0), field_of_view_deg=(2.0, 1.5)
)
CAMERA_BODY = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # +X, +Y, +Z


class NamedOrbit(CircularOrbit):
    carrier_name = CarrierName("SMALLSAT", "2026-001A")


@pytest.fixture(scope="module")
def plan():
    scenario = body_scenario(dataclasses.replace(BODY, camera=CAMERA), orbit=NamedOrbit())
    table = body_table()
    start, stop = (shifted_utc(table.epoch_utc, row / 5.0) for row in (300, 500))
    segments = (Segment(kind="track", session=0, start_utc=start, stop_utc=stop),)
    return FlightPlan(scenario=scenario, segments=segments, table=table)


def written(plan, format_name):
    return EXPORTERS[format_name].write(plan, CREATED_UTC).decode()


def numbers(lines):
    return np.array([[float(number) for number in line.split()[1:]] for line in lines])


def off_rad(q_eci_from_frame_xyzw, axes_eci):
    """Of a frame's axes, turned as the file says, from where they are; axes_eci: (n, 3, 3)."""
    turns = Rotation.from_quat(q_eci_from_frame_xyzw)
    found = np.stack([turns.apply(axis) for axis in np.eye(3)], axis=1)
    return np.linalg.norm(found - axes_eci, axis=2).max()


def test_aem_has_the_body_and_its_camera(plan):
    text = written(plan, "aem")
    frames = re.findall(r"^REF_FRAME_B = (\S+)$", text, re.MULTILINE)
    assert frames == ["SC_BODY_1", "INSTRUMENT_1"]
    body, camera = (
        numbers(part.strip().splitlines())
        for part in re.findall(r"DATA_START\n(.*?)DATA_STOP", text, re.DOTALL)
    )
    q = Rotation.from_quat(plan.table.position)
    axes = np.stack([q.apply(axis) for axis in np.eye(3)], axis=1)
    # CCSDS: the quaternion turns frame A's axes into frame B's, so vectors of B into A
    assert off_rad(body[:, :4], axes) < 1e-12
    assert off_rad(camera[:, :4], np.stack([q.apply(axis) for axis in CAMERA_BODY], 1)) < 1e-12
    omega_deg_s = np.degrees(plan.table.rate_rad_s)
    assert body[:, 4:] == pytest.approx(omega_deg_s, abs=1e-9)
    assert camera[:, 4:] == pytest.approx(omega_deg_s @ CAMERA_BODY.T, abs=1e-9)


def test_stk_has_the_body_and_a_constant_mount(plan):
    def rows(format_name):
        lines = written(plan, format_name).splitlines()
        return numbers(lines[lines.index("AttitudeTimeQuaternions") + 1 : -1])

    q = Rotation.from_quat(plan.table.position)
    axes = np.stack([q.apply(axis) for axis in np.eye(3)], axis=1)
    assert off_rad(rows("stk-attitude"), axes) < 1e-12
    assert off_rad(rows("stk"), np.tile(CAMERA_BODY, (len(axes), 1, 1))) < 1e-12


def test_csv_has_every_channel(plan):
    lines = written(plan, "csv").splitlines()
    table = [line.split(",") for line in lines if not line.startswith("#")]
    assert table[0][2:] == [channel.name for channel in plan.table.channels]
    values = np.array(table[1:])[:, 2:].astype(float)
    assert values[:, :4] == pytest.approx(plan.table.position, abs=1e-13)
    assert np.deg2rad(values[:, 7:]) == pytest.approx(plan.table.acceleration_rad_s2, abs=1e-10)
