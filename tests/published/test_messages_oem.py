"""Ephemeris messages are read as CCSDS 502.0-B and 505.0-B define them, and others refused."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import InvalidMessage
from planner.world.frames.time_scales import utc_from_text, utc_text
from planner.world.messages.oem import read_oem
from planner.world.messages.segments import MAX_CHARACTERS

DATA = Path(__file__).parents[1] / "data"

# Laid out like CCSDS 502.0-B-3, figures G-1 and G-2: every optional part the standard has
KVN = """CCSDS_OEM_VERS = 3.0
COMMENT
COMMENT a comment with = in it
CREATION_DATE = 2022-01-17T20:44:45
ORIGINATOR = NASA/JSC
META_START
OBJECT_NAME          = ISS
OBJECT_ID            = 1998-067-A
CENTER_NAME          = Earth
REF_FRAME            = EME2000
TIME_SYSTEM          = UTC
START_TIME           = 2022-01-17T12:00:00.000
USEABLE_START_TIME   = 2022-01-17T12:04:00.000
USEABLE_STOP_TIME    = 2022-01-17T12:08:00.000
STOP_TIME            = 2022-01-17T12:12:00.000
INTERPOLATION        = Hermite
INTERPOLATION_DEGREE = 7
META_STOP
COMMENT the states
2022-01-17T12:00:00.000  545.284  4217.417  5288.810 -7.636397  0.168828  0.656343
2022-017T12:04:00Z -1285.010  4103.999  5251.388 -7.522871 -1.108449 -0.964000 0.001 0.002 0.003
2022-01-17T12:08:00 -2.9e3 3.7e3 4.8e3 -6.8 -2.3 -2.5
2022-01-17T12:12:00.123456789 -4.4e3 3.0e3 4.0e3 -5.6 -3.3 -3.9
COVARIANCE_START
EPOCH = 2022-01-17T12:00:00.000
3.3e-04
4.6e-04 6.7e-04
COVARIANCE_STOP
"""
XML_STATE = (
    "<stateVector><EPOCH>{epoch}</EPOCH><X units='km'>545.284</X><Y>4217.417</Y><Z>5288.810</Z>"
    "<X_DOT units='km/s'>-7.636397</X_DOT><Y_DOT>0.168828</Y_DOT><Z_DOT>0.656343</Z_DOT>"
    "</stateVector>\n"
)
XML = (
    "<?xml version='1.0' encoding='UTF-8'?>\n"
    "<oem xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' version='2.0'>\n"
    "<header><COMMENT/><CREATION_DATE>2022-01-17T20:44:45</CREATION_DATE></header>\n"
    "<body><segment>\n<metadata><REF_FRAME>GCRF</REF_FRAME><TIME_SYSTEM>UTC</TIME_SYSTEM>"
    "</metadata>\n<data>\n"
    + XML_STATE.format(epoch="2022-01-17T12:00:00")
    + XML_STATE.format(epoch="2022-01-17T12:04:00")
    + "</data></segment></body></oem>\n"
)


def test_kvn_with_everything_in_it():
    message = read_oem(KVN)
    assert message.creation_utc == datetime(2022, 1, 17, 20, 44, 45, tzinfo=UTC)
    (segment,) = message.segments
    assert segment.object_name == "ISS"
    assert segment.frame == "EME2000"
    assert segment.epoch_utc == datetime(2022, 1, 17, 12, tzinfo=UTC)
    np.testing.assert_allclose(segment.t_s, [0.0, 240.0, 480.0, 720.123456789], rtol=0, atol=1e-9)
    np.testing.assert_allclose(segment.r_m[0], [545284.0, 4217417.0, 5288810.0])
    np.testing.assert_allclose(segment.v_m_s[1], [-7522.871, -1108.449, -964.0])
    assert segment.useable_s == (240.0, 480.0)


def test_what_lies_deeper_in_a_state_is_no_part_of_it():
    nested = XML.replace("</stateVector>", "<other><X>99999</X></other></stateVector>")
    (plain,), (segment,) = read_oem(XML).segments, read_oem(nested).segments
    np.testing.assert_array_equal(segment.r_m, plain.r_m)


def test_xml_without_ndm_and_with_namespaces():
    (segment,) = read_oem(XML).segments
    assert segment.frame == "GCRF"
    np.testing.assert_allclose(segment.v_m_s[1], [-7636.397, 168.828, 656.343])
    prefixed = XML.replace("<oem ", "<n:oem xmlns:n='urn:ccsds:schema:ndmxml' ").replace(
        "</oem>", "</n:oem>"
    )
    assert len(read_oem(prefixed).segments) == 1


def test_nasas_own_file():
    message = read_oem((DATA / "iss_oem_2022-038_excerpt.xml").read_text())
    assert message.creation_utc is not None
    assert utc_text(message.creation_utc) == "2022-02-07T21:54:55.800Z"
    assert len(message.segments) == 4
    burn = message.segments[2]
    # the last of its 2 s steps is cut off by the end of the burn at 039T07:58:22.262
    assert burn.t_s[np.argmin(np.diff(burn.t_s)) + 1] == pytest.approx(
        (datetime(2022, 2, 8, 7, 58, 22, 262000, tzinfo=UTC) - burn.epoch_utc).total_seconds(),
        abs=1e-9,
    )


@pytest.mark.parametrize(
    ("time_system", "first_utc"),
    [
        # 2022: TAI - UTC = 37 s (Bulletin C 62), TT - TAI = 32.184 s, TAI - GPS = 19 s
        ("TAI", "2022-01-17T11:59:23.000Z"),
        ("TT", "2022-01-17T11:58:50.816Z"),
        ("GPS", "2022-01-17T11:59:42.000Z"),
    ],
)
def test_time_systems(time_system, first_utc):
    (segment,) = read_oem(KVN.replace("= UTC", f"= {time_system}")).segments
    assert segment.epoch_utc == utc_from_text(first_utc)


def test_ut1_is_read():
    (segment,) = read_oem(KVN.replace("= UTC", "= UT1")).segments
    first_utc = utc_from_text("2022-01-17T12:00:00Z")
    # IERS Bulletin A of that week: UT1 - UTC = -0.1105 s
    assert (segment.epoch_utc - first_utc).total_seconds() == pytest.approx(0.1105, abs=1e-3)


def test_epochs_in_a_leap_second():
    head = KVN[: KVN.index("START_TIME")] + "META_STOP\n"
    epochs = (
        "2016-12-31T23:59:59",
        "2016-366T23:59:60.5",
        "2017-001T00:00:00",
        "2017-01-01T00:00:01",
    )
    rows = "".join(f"{epoch} 545.284 4217.417 5288.810 -7.6 0.2 0.7\n" for epoch in epochs)
    (segment,) = read_oem(head + rows).segments
    np.testing.assert_allclose(segment.t_s, [0.0, 1.5, 2.0, 3.0], rtol=0, atol=1e-9)
    with pytest.raises(InvalidMessage, match="is no time of that day"):
        read_oem(head + rows.replace("2016-366", "2016-365").replace("2016-12-31", "2016-12-30"))


@pytest.mark.parametrize(
    ("stated", "frame"),
    [
        ("J2000", "EME2000"), ("ICRF", "GCRF"), ("GCRF", "GCRF"), ("ITRF", "ITRF"),
        ("ITRF-97", "ITRF"), ("ITRF2014", "ITRF"), ("ITRF2000", "ITRF"), ("TEME", "TEME"),
        ("eme2000", "EME2000"),
    ],
)  # fmt: skip
def test_reference_frames(stated, frame):
    assert read_oem(KVN.replace("= EME2000", f"= {stated}")).segments[0].frame == frame


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("CCSDS_OEM_VERS = 3.0\n", "", r"line 5: no CCSDS_OEM_VERS"),
        ("VERS = 3.0", "VERS = 4.0", r"line 1: CCSDS_OEM_VERS '4.0' is not supported"),
        ("= EME2000", "= TOD", r"line 6: REF_FRAME 'TOD' is not supported"),
        ("= UTC", "= TDB", r"line 6: TIME_SYSTEM 'TDB' is not supported"),
        ("= Earth", "= MOON", r"line 6: CENTER_NAME is 'MOON'"),
        ("TIME_SYSTEM          = UTC\n", "", r"line 6: the segment's metadata lack TIME_SYSTEM"),
        ("12:04:00Z", "12:64:00Z", r"line 21: '2022-017T12:64:00Z' is no time"),
        ("2022-017T12", "2022-417T12", r"line 21: '2022-417' is no date"),
        ("2022-017T12:04", "2022-017T11:04", r"line 21: epoch .* is not after the one before"),
        ("-2.9e3", "nan", r"line 22: .* are no 6 finite numbers"),
        ("-2.9e3", "x", r"line 22: .* are no 6 finite numbers"),
        ("-2.9e3 3.7e3", "3.7e3", r"line 22: .* not 6 columns"),
        ("-2.9e3 3.7e3 4.8e3", "-2.9e6 3.7e6 4.8e6", r"line 22: a position .* must be in km"),
        ("-2.9e3 3.7e3 4.8e3", "-2.9 3.7 4.8", r"line 22: a position .* must be in km"),
        ("META_STOP", "", r"line 20: .* is no 'KEYWORD = value'"),
        ("COVARIANCE_STOP\n", "", r"the message ends inside its covariance"),
        ("COVARIANCE_STOP\n", "META_STOP\n", r"line 28: META_STOP can't follow"),
        ("12:12:00.1", "24:12:00.1", r"line 23: .* is no time of that day"),
        ("units='km'", "units='m'", r"line 7: X is in 'm'; it must be in km"),
        ("<Y>4217.417</Y>", "", r"line 7: the state vector lacks Y"),
        ("</data>", "", r"line 9: the XML is broken"),
        ("version='2.0'", "version='9'", r"line 2: OEM version '9' is not supported"),
        ("<oem", "<aem", r"the XML is broken"),
        ("5288.810<", "inf<", r"line 7: .* are no 6 finite numbers"),
    ],
)
def test_a_faulty_message_is_refused_naming_the_line(old, new, reason):
    [text] = [text for text in (KVN, XML) if old in text]
    with pytest.raises(InvalidMessage, match=reason):
        read_oem(text.replace(old, new, 1))


@pytest.mark.parametrize(
    "declaration",
    [
        # the billion laughs, an external file, an external document type
        "<!DOCTYPE oem [<!ENTITY a 'ha'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;'>]>",
        "<!DOCTYPE oem [<!ENTITY a SYSTEM 'file:///etc/hostname'>]>",
        "<!DOCTYPE oem SYSTEM 'http://localhost/oem.dtd'>",
    ],
)
def test_hostile_xml_is_refused_unparsed(declaration):
    with pytest.raises(InvalidMessage, match="line 2: a document type declaration"):
        read_oem(XML.replace("<oem ", declaration + "<oem ", 1))


@pytest.mark.parametrize(
    "content",
    [
        "",
        "   \n",
        "<",
        "<ndm/>",
        "<a>" * 5000,
        "\x00",
        "CCSDS_OEM_VERS = 2.0\n",
        "\ud800<",
        "<\ud800/>",
    ],
)
def test_rubbish_is_refused(content):
    with pytest.raises(InvalidMessage):
        read_oem(content)


def test_a_huge_message_is_refused_unread():
    with pytest.raises(InvalidMessage, match="only the days around the session"):
        read_oem(" " * (MAX_CHARACTERS + 1))
