"""Attitude messages are read as CCSDS 504.0-B defines them, and others refused."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from planner.base.errors import InvalidMessage
from planner.world.frames.time_scales import utc_from_text
from planner.world.messages.aem import read_aem

# Rows of CCSDS 504.0-B-1, figure 4-1 (a quaternion, scalar last), about the Earth.
KVN = """CCSDS_AEM_VERS = {version}
CREATION_DATE = 2002-11-04T17:22:31
ORIGINATOR = NASA/JPL
META_START
COMMENT  It is to be used for attitude reconstruction only.
OBJECT_NAME          = MARS GLOBAL SURVEYOR
OBJECT_ID            = 1996-062A
{metadata}
META_STOP
COMMENT
DATA_START
{rows}
DATA_STOP
"""
METADATA = {
    "CENTER_NAME": "EARTH",
    "REF_FRAME_A": "EME2000",
    "REF_FRAME_B": "SC_BODY_1",
    "ATTITUDE_DIR": "A2B",
    "TIME_SYSTEM": "UTC",
    "ATTITUDE_TYPE": "QUATERNION",
    "QUATERNION_TYPE": "LAST",
    "USEABLE_START_TIME": "1996-11-28T22:08:03.000",
}
EPOCHS = ("1996-11-28T22:08:02.5555", "1996-333T22:08:03.5555Z", "1996-11-28T22:08:04.5555")
QUATERNIONS = np.array(
    [
        [0.56748, 0.03146, 0.45689, 0.68427],
        [0.42319, -0.45697, 0.23784, 0.74533],
        [-0.84532, 0.26974, -0.06532, 0.45652],
    ]
)


def kvn(rows, version="1.0", **metadata):
    lines = {**METADATA, **metadata}
    return KVN.format(
        version=version,
        metadata="\n".join(f"{key} = {value}" for key, value in lines.items() if value),
        rows="\n".join(
            f"{epoch} " + " ".join(f"{value:.10g}" for value in row)
            for epoch, row in zip(EPOCHS, rows, strict=False)
        ),
    )


def attitude(content):
    return Rotation.from_quat(read_aem(content)[0].q_body_from_frame_xyzw)


def reference_matrices():
    """Annex A of 504.0-B-1: M = (qc^2 - q.q) E + 2 q q^T - 2 qc [q x]; v_B = M v_A."""
    matrices = []
    for quaternion in QUATERNIONS:
        *q, qc = quaternion / np.linalg.norm(quaternion)
        cross = np.cross(q, np.eye(3)).T
        matrices.append((qc**2 - np.dot(q, q)) * np.eye(3) + 2 * np.outer(q, q) - 2 * qc * cross)
    return np.array(matrices)


def test_the_blue_books_quaternion_turns_vectors_of_a_into_vectors_of_b():
    segment = read_aem(kvn(QUATERNIONS))[0]
    assert segment.frame == "EME2000"
    assert segment.epoch_utc == utc_from_text("1996-11-28T22:08:02.5555Z")
    np.testing.assert_allclose(segment.t_s, [0.0, 1.0, 2.0], atol=1e-9)
    assert segment.useable_s == (pytest.approx(0.4445), 2.0)
    # rounding of double precision only
    np.testing.assert_allclose(
        Rotation.from_quat(segment.q_body_from_frame_xyzw).as_matrix(),
        reference_matrices(),
        atol=1e-14,
    )


@pytest.mark.parametrize(
    ("rows", "metadata"),
    [
        (np.roll(QUATERNIONS, 1, axis=1), {"QUATERNION_TYPE": "FIRST"}),
        (QUATERNIONS * [-1, -1, -1, 1], {"ATTITUDE_DIR": "B2A"}),
        (-QUATERNIONS, {}),
        (QUATERNIONS * [-1, -1, -1, 1], {"REF_FRAME_A": "SC_BODY_1", "REF_FRAME_B": "J2000"}),
        (
            QUATERNIONS,
            {"REF_FRAME_A": "SC_BODY_1", "REF_FRAME_B": "EME2000", "ATTITUDE_DIR": "B2A"},
        ),
        (QUATERNIONS, {"version": "2.0", "ATTITUDE_DIR": "", "QUATERNION_TYPE": ""}),
        (np.hstack([QUATERNIONS, np.ones((3, 3))]), {"ATTITUDE_TYPE": "QUATERNION/RATE"}),
    ],
    ids=["scalar first", "B2A", "other sign", "body is A", "body is A, B2A", "version 2", "rates"],
)
def test_every_way_to_write_an_attitude_means_the_same(rows, metadata):
    turn = attitude(kvn(rows, **metadata)) * attitude(kvn(QUATERNIONS)).inv()
    assert turn.magnitude().max() < 1e-9  # ten printed digits


@pytest.mark.parametrize("sequence", ["321", "ZYX", "zyx"])
def test_euler_angles_turn_the_axes_in_sequence(sequence):
    """504.0-B-1, annex A: M = R1(a3) R2(a2) R3(a1) of frame rotations."""
    angles_deg = np.array([[30.0, -20.0, 10.0], [31.0, -20.0, 10.0], [32.0, -20.0, 10.0]])
    content = kvn(
        angles_deg, ATTITUDE_TYPE="EULER_ANGLE", EULER_ROT_SEQ=sequence, QUATERNION_TYPE=""
    )
    yaw, pitch, roll = np.deg2rad(angles_deg[0])
    r3 = np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    r2 = np.array(
        [[np.cos(pitch), 0, -np.sin(pitch)], [0, 1, 0], [np.sin(pitch), 0, np.cos(pitch)]]
    )
    r1 = np.array([[1, 0, 0], [0, np.cos(roll), np.sin(roll)], [0, -np.sin(roll), np.cos(roll)]])
    np.testing.assert_allclose(attitude(content)[0].as_matrix(), r1 @ r2 @ r3, atol=1e-12)


XML = """<?xml version="1.0" encoding="UTF-8"?>
<ndm><aem id="CCSDS_AEM_VERS" version="{version}">
<header><COMMENT/><CREATION_DATE>2008-071T17:09:49</CREATION_DATE></header>
<body><segment><metadata>{metadata}</metadata><data>{rows}</data></segment></body>
</aem></ndm>
"""


def xml(states, version="1.0", **metadata):
    entries = {**METADATA, **metadata}
    return XML.format(
        version=version,
        metadata="".join(f"<{k}>{v}</{k}>" for k, v in entries.items() if v),
        rows="".join(f"<attitudeState>{state}</attitudeState>" for state in states),
    )


def test_xml_says_the_same_as_kvn():
    states = [
        f"<quaternionState><EPOCH>{epoch}</EPOCH><quaternion><QC>{qc}</QC><Q1>{q1}</Q1>"
        f"<Q2>{q2}</Q2><Q3>{q3}</Q3></quaternion></quaternionState>"
        for epoch, (q1, q2, q3, qc) in zip(EPOCHS, QUATERNIONS, strict=True)
    ]
    turn = attitude(xml(states, QUATERNION_TYPE="FIRST")) * attitude(kvn(QUATERNIONS)).inv()
    assert turn.magnitude().max() < 1e-9


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_euler_angles_in_xml_of_both_versions(version):
    angles_deg = np.array([[45.0, 0.9, 15.0], [46.0, 1.9, 14.0]])
    if version == "1.0":
        form = (
            '<rotationAngles><rotation1 angle="X_ANGLE" units="deg">{}</rotation1>'
            '<rotation2 angle="Y_ANGLE">{}</rotation2><rotation3>{}</rotation3></rotationAngles>'
        )
    else:
        form = "<ANGLE_1>{}</ANGLE_1><ANGLE_2>{}</ANGLE_2><ANGLE_3>{}</ANGLE_3>"
    states = [
        f"<eulerAngle><EPOCH>{epoch}</EPOCH>{form.format(*row)}</eulerAngle>"
        for epoch, row in zip(EPOCHS, angles_deg, strict=False)
    ]
    euler = {"ATTITUDE_TYPE": "EULER_ANGLE", "EULER_ROT_SEQ": "123", "QUATERNION_TYPE": ""}
    turn = attitude(xml(states, version, **euler)) * attitude(kvn(angles_deg, **euler)).inv()
    assert turn.magnitude().max() < 1e-9


def spinning(rate_deg_s, seconds, frame):
    """Rows of a body that spins about its own Z, tilted: quaternion and angular velocity."""
    axis_a = np.array([0.6, 0.0, 0.8])
    tilt = Rotation.align_vectors([[0.0, 0.0, 1.0]], [axis_a])[0]
    rows = []
    for t_s in seconds:
        q_b_from_a = Rotation.from_rotvec([0, 0, -np.deg2rad(rate_deg_s * t_s)]) * tilt
        omega = np.array([0.0, 0.0, rate_deg_s]) if frame == "SC_BODY_1" else rate_deg_s * axis_a
        rows.append(np.concatenate([q_b_from_a.inv().as_quat(), omega]))
    return np.array(rows)


@pytest.mark.parametrize("frame", ["SC_BODY_1", "REF_FRAME_A"])
def test_angular_velocity_is_the_attitudes_derivative(frame):
    content = kvn(
        spinning(2.0, (0.0, 1.0, 2.0), frame),
        version="2.0",
        ATTITUDE_TYPE="QUATERNION/ANGVEL",
        ANGVEL_FRAME=frame,
        ATTITUDE_DIR="",
        QUATERNION_TYPE="",
    )
    segment = read_aem(content)[0]
    step_s = 1e-4
    turn = Rotation.from_quat(segment.q_body_from_frame_xyzw + step_s * segment.q_dot_s)
    turn = turn * Rotation.from_quat(segment.q_body_from_frame_xyzw).inv()
    # frame rotation about +Z turns vectors the other way
    expected = np.tile([0.0, 0.0, -np.deg2rad(2.0)], (3, 1))
    np.testing.assert_allclose(turn.as_rotvec() / step_s, expected, atol=1e-6)


def test_rates_that_contradict_the_attitudes_are_refused():
    rows = spinning(2.0, (0.0, 1.0, 2.0), "SC_BODY_1") * [1, 1, 1, 1, 1, 1, -1]
    content = kvn(rows, version="2.0", ATTITUDE_TYPE="QUATERNION/ANGVEL", ANGVEL_FRAME="SC_BODY_1")
    with pytest.raises(InvalidMessage, match="rates miss the next row"):
        read_aem(content)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (kvn(QUATERNIONS, ATTITUDE_TYPE="SPIN"), "line 4: .*spinning.*convert to QUATERNION"),
        (kvn(QUATERNIONS, ATTITUDE_TYPE="EULER_ANGLE"), "line 19: a row .* has 3 numbers"),
        (kvn(QUATERNIONS, ATTITUDE_TYPE="DCM"), "ATTITUDE_TYPE 'DCM' is not known"),
        (kvn(QUATERNIONS, REF_FRAME_A="MARS_FIXED"), "'MARS_FIXED' is not supported"),
        (kvn(QUATERNIONS, REF_FRAME_B="IMU_FRAME_1"), "exactly one must be the spacecraft"),
        (kvn(QUATERNIONS, REF_FRAME_A="LVLH", CENTER_NAME="MARS"), "must be about EARTH"),
        (kvn(QUATERNIONS, ATTITUDE_DIR="A2C"), "must be A2B or B2A"),
        (kvn(QUATERNIONS, TIME_SYSTEM="MET"), "TIME_SYSTEM 'MET' is not supported"),
        (kvn(QUATERNIONS, TIME_SYSTEM=""), "lack TIME_SYSTEM"),
        (kvn(QUATERNIONS, version="3.0"), "versions 1 to 2 are"),
        (kvn(QUATERNIONS * 1.1), "line 19: the quaternion's length is 1.1"),
        (kvn(QUATERNIONS * np.nan), "line 19: .* no 4 finite numbers"),
        (kvn(QUATERNIONS[:1]), "has 1 states; at least 2"),
        (kvn(QUATERNIONS).replace("04.5555", "03.5555"), "line 21: .*not after the one before"),
        (kvn(QUATERNIONS).replace("META_START\n", ""), "META_STOP can't follow"),
        (kvn(QUATERNIONS).replace("CCSDS_AEM", "CCSDS_OEM"), "is this an AEM"),
        ("CCSDS_AEM_VERS = 1.0\n", "no segment"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><aem/>', "document type declaration"),
        (xml(["<spin><EPOCH>2006-090T05:00:00</EPOCH></spin>"], ATTITUDE_TYPE="SPIN"), "spinning"),
        (xml(["<quaternionState/>"]), "lacks EPOCH"),
        ("<aem version='1.0'><body>", "the XML is broken"),
    ],
)
def test_what_cannot_be_pointed_by_is_refused_by_line(content, said):
    with pytest.raises(InvalidMessage, match=said):
        read_aem(content)
