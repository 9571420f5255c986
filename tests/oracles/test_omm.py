"""OMM and OPM lead to the orbits that other readers and the plain elements give."""

import io
import json
from datetime import timedelta

import numpy as np
import pytest
from sgp4 import omm as sgp4_omm
from sgp4.api import Satrec

from planner.base.errors import OutsideCoverage
from planner.world.frames.time_scales import Instants, utc_from_text
from planner.world.orbits import OmmOrbit, OpmOrbit, StateVectorOrbit, TleOrbit

# The element set of 2022-02-07 from Space-Track, as a TLE and as CelesTrak's JSON writes it.
TLE = TleOrbit(
    line1="1 25544U 98067A   22038.37836806  .00007168  00000+0  13432-3 0  9993",
    line2="2 25544  51.6416 259.4336 0006553 105.8037 251.0375 15.49806680325044",
)
FIELDS = {
    "OBJECT_NAME": "ISS (ZARYA)",
    "OBJECT_ID": "1998-067A",
    "EPOCH": "2022-02-07T09:04:51.000384",
    "MEAN_MOTION": 15.4980668,
    "ECCENTRICITY": 0.0006553,
    "INCLINATION": 51.6416,
    "RA_OF_ASC_NODE": 259.4336,
    "ARG_OF_PERICENTER": 105.8037,
    "MEAN_ANOMALY": 251.0375,
    "EPHEMERIS_TYPE": 0,
    "CLASSIFICATION_TYPE": "U",
    "NORAD_CAT_ID": 25544,
    "ELEMENT_SET_NO": 999,
    "REV_AT_EPOCH": 32504,
    "BSTAR": 0.00013432,
    "MEAN_MOTION_DOT": 7.168e-05,
    "MEAN_MOTION_DDOT": 0,
}
START = utc_from_text("2022-02-08T12:00:00Z")
NOON = Instants(START, np.zeros(1))
INSTANTS = Instants(START, np.linspace(0.0, 6000.0, 61))
HEADER = {"MEAN_ELEMENT_THEORY": "SGP4", "REF_FRAME": "TEME", "TIME_SYSTEM": "UTC"}


def as_json(**changes):
    return json.dumps([{**FIELDS, **changes}])


def as_kvn(**changes):
    units = {"MEAN_MOTION": " [rev/day]", "INCLINATION": " [deg]", "BSTAR": " [1/ER]"}
    fields = {"CENTER_NAME": "EARTH", **HEADER, **FIELDS, **changes}
    lines = [f"{key} = {value}{units.get(key, '')}" for key, value in fields.items()]
    return "\n".join(["CCSDS_OMM_VERS = 2.0", "COMMENT GP data", *lines])


def as_xml():
    def tags(names):
        return "".join(f"<{name}>{({**HEADER, **FIELDS})[name]}</{name}>" for name in names)

    elements = ("EPOCH", "MEAN_MOTION", "ECCENTRICITY", "INCLINATION", "RA_OF_ASC_NODE")
    elements += ("ARG_OF_PERICENTER", "MEAN_ANOMALY")
    tle = ("EPHEMERIS_TYPE", "CLASSIFICATION_TYPE", "NORAD_CAT_ID", "ELEMENT_SET_NO")
    tle += ("REV_AT_EPOCH", "BSTAR", "MEAN_MOTION_DOT", "MEAN_MOTION_DDOT")
    return (
        '<?xml version="1.0" encoding="UTF-8"?><ndm><omm id="CCSDS_OMM_VERS" version="2.0">'
        "<header><CREATION_DATE/><ORIGINATOR/></header><body><segment><metadata>"
        f"{tags(('OBJECT_NAME', 'OBJECT_ID'))}<CENTER_NAME>EARTH</CENTER_NAME>{tags(HEADER)}"
        f"</metadata><data><meanElements>{tags(elements)}</meanElements>"
        f"<tleParameters>{tags(tle)}</tleParameters></data></segment></body></omm></ndm>"
    )


def states(orbit, instants=INSTANTS):
    stop = instants.epoch_utc + timedelta(seconds=float(instants.t_s[-1]))
    return orbit.ephemeris(instants.epoch_utc, stop).states(instants)


@pytest.mark.parametrize("content", [as_json(), as_kvn(), as_xml()], ids=["JSON", "KVN", "XML"])
def test_every_notation_gives_the_tles_orbit(content):
    """The TLE's epoch has 1e-8 day, 0.4 ms or 3 m along the track less: here the digits agree."""
    apart_m = states(OmmOrbit(content=content)).r_sat_eci_m - states(TLE).r_sat_eci_m
    assert np.abs(apart_m).max() < 0.02  # 1 us along the track is 8 mm


def test_elements_are_initialised_as_sgp4s_own_reader_does():
    satrec = Satrec()
    sgp4_omm.initialize(satrec, next(sgp4_omm.parse_xml(io.StringIO(as_xml()))))
    ours = OmmOrbit(content=as_xml()).ephemeris(START, START + timedelta(hours=2)).satrec
    jd, fraction = 2459619.0, np.linspace(0.0, 1.0, 25)
    theirs = satrec.sgp4_array(np.full(25, jd), fraction)
    # 1e-6 km: the epoch is one number of days here, two there
    for a, b in zip(ours.sgp4_array(np.full(25, jd), fraction)[1:], theirs[1:], strict=True):
        np.testing.assert_allclose(a, b, atol=1e-6)


def test_elements_far_from_the_plan_are_refused_in_the_content():
    late = START + timedelta(days=40)
    with pytest.raises(OutsideCoverage) as refusal:
        OmmOrbit(content=as_json()).ephemeris(late, late + timedelta(seconds=60))
    assert refusal.value.field == "orbit.content"
    assert OmmOrbit(content=as_json()).ephemeris(START, START + timedelta(days=4)).warnings


def test_elements_made_after_a_reboost_are_read():
    """Drag terms as the ISS's of 13 November 2024, -0.11407, refused until now."""
    orbit = OmmOrbit(content=as_json(BSTAR=-0.11407))
    quiet = OmmOrbit(content=as_json())
    told_m = [o.ephemeris(START, START).sigma(NOON).along_m[0] for o in (orbit, quiet)]
    assert orbit.message.bstar == -0.11407
    assert told_m[0] > 100.0 * told_m[1]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("[]", "holds 0 entries"),
        (json.dumps([FIELDS, FIELDS]), "holds 2 entries"),
        ("[1]", "send one satellite"),
        ("[{", "JSON is broken"),
        ("[" * 100_000, "no orbit has|broken"),
        (as_json(MEAN_MOTION=float("nan")), "holds a value no orbit has"),
        (as_json(MEAN_MOTION="fast"), "MEAN_MOTION = 'fast' is no finite number"),
        (as_json(BSTAR=True), "BSTAR is missing"),
        (as_json(MEAN_MOTION=0.0), r"MEAN_MOTION must lie in 0\.1\.\.18, not 0$"),
        (as_json(MEAN_MOTION=16.9), "perigee .* below 80 km"),
        (as_json(MEAN_ELEMENT_THEORY="SGP"), "MEAN_ELEMENT_THEORY 'SGP' is not supported"),
        (as_json(ECCENTRICITY=1.5), r"ECCENTRICITY must lie in 0\.\.0\.999, not 1\.5"),
        (as_json(EPOCH="2022-13-01T00:00:00"), "is no date"),
        (as_json(EPOCH="2022-366T00:00:00"), "is no date"),
        (as_kvn().replace("[deg]", "[rad]"), "INCLINATION is in 'rad'; it must be in deg"),
        (as_kvn().replace("2.0", "9.0", 1), "'9.0' is not supported"),
        (as_kvn() + "\nnonsense", "no 'KEYWORD = value'"),
        ("EPOCH = 2022", "CCSDS_OMM_VERS is missing"),
        ("x" * 300_000, "more than the 200000"),
    ],
)
def test_what_is_no_mean_elements_message_is_refused(content, said):
    with pytest.raises(ValueError, match=said):
        OmmOrbit(content=content)


# The state of CCSDS 502.0-B-3, figure G-1's layout, with an ISS state in it.
OPM = """CCSDS_OPM_VERS = 2.0
CREATION_DATE = 2022-02-07T00:00:00
ORIGINATOR = NASA
OBJECT_NAME = ISS
OBJECT_ID = 1998-067A
CENTER_NAME = EARTH
REF_FRAME = EME2000
TIME_SYSTEM = {time_system}
EPOCH = {epoch}
X = 545.284 [km]
Y = 4217.417 [km]
Z = 5288.810 [km]
X_DOT = -7.636397 [km/s]
Y_DOT = 0.168828 [km/s]
Z_DOT = 0.656343 [km/s]
MASS = 420000 [kg]
DRAG_AREA = 1600 [m**2]
DRAG_COEFF = 2.2
"""
EPOCH = utc_from_text("2022-01-17T12:00:00Z")
STATE = StateVectorOrbit(
    frame="EME2000",
    epoch=EPOCH,
    position_km=(545.284, 4217.417, 5288.810),
    velocity_km_s=(-7.636397, 0.168828, 0.656343),
    mass_kg=420e3,
    drag_area_m2=1600.0,
    drag_coefficient=2.2,
)
BURN = "MAN_EPOCH_IGNITION = 2022-01-17T12:10:00\nMAN_DURATION = 60 [s]\n"


def opm_xml():
    lines = [line.split(" = ") for line in OPM.splitlines()[5:]]
    tags = "".join(f"<{key}>{value.split(' [')[0]}</{key}>" for key, value in lines)
    tags = tags.format(time_system="UTC", epoch="2022-01-17T12:00:00")
    return f'<opm version="2.0"><header/><body><segment><data>{tags}</data></segment></body></opm>'


@pytest.mark.parametrize(
    "content",
    [
        OPM.format(time_system="UTC", epoch="2022-01-17T12:00:00"),
        OPM.format(time_system="TAI", epoch="2022-017T12:00:37"),
        opm_xml(),
    ],
    ids=["KVN", "TAI", "XML"],
)
def test_an_opm_is_a_state_vector(content):
    instants = Instants(EPOCH, np.linspace(0.0, 900.0, 10))
    np.testing.assert_array_equal(
        states(OpmOrbit(content=content), instants).r_sat_eci_m, states(STATE, instants).r_sat_eci_m
    )


def test_an_opm_is_not_carried_across_a_burn_it_announces():
    orbit = OpmOrbit(content=OPM.format(time_system="UTC", epoch="2022-01-17T12:00:00") + BURN)
    orbit.ephemeris(EPOCH, EPOCH + timedelta(seconds=599))
    with pytest.raises(OutsideCoverage, match="announces a burn at 2022-01-17T12:10:00"):
        orbit.ephemeris(EPOCH + timedelta(seconds=700), EPOCH + timedelta(seconds=800))


def test_an_opm_too_old_is_refused_in_the_content():
    orbit = OpmOrbit(content=OPM.format(time_system="UTC", epoch="2022-01-17T12:00:00"))
    with pytest.raises(OutsideCoverage) as refusal:
        orbit.ephemeris(EPOCH + timedelta(days=9), EPOCH + timedelta(days=9, seconds=60))
    assert refusal.value.field == "orbit.content"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("EME2000", "TOD"), "REF_FRAME 'TOD' is not supported"),
        (("X = 545.284 [km]", "X = 545284 [m]"), "X is in 'm'; it must be in km"),
        (("Y = 4217.417 [km]\n", ""), "Y is missing"),
        (("Z = 5288.810", "Z = inf"), "is no finite number"),
        (("-7.636397", "-17.636397"), "leaves the Earth"),
        (("= EARTH", "= MOON"), "only orbits about EARTH"),
    ],
)
def test_what_is_no_orbit_parameter_message_is_refused(change, said):
    content = OPM.format(time_system="UTC", epoch="2022-01-17T12:00:00").replace(*change)
    with pytest.raises(ValueError, match=said):
        OpmOrbit(content=content)
