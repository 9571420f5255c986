"""Our STK quaternion is the one of STK's own example."""

from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import numpy as np

from planner.base.commands import CommandTable, axis_channels
from planner.output.export import EXPORTERS
from planner.world.attitude.inertial import InertialAttitude
from planner.world.orbits import StateVectorOrbit
from planner.world.platforms import ISS_HRC
from planner.world.scenario import InitialState, Scenario, Session
from planner.world.targets import StarTarget

EPOCH_UTC = datetime(2002, 6, 1, 12, tzinfo=UTC)
STOP_UTC = EPOCH_UTC + timedelta(seconds=40)
# STK help, "AttitudeTimeQuatAngVels Format (*.a) Example": t, q1..q4, rates 0 0 6 deg/s in body
PUBLISHED = {
    0.0: (0.0, 0.0, 0.0, 1.0),
    10.0: (0.0, 0.0, 5.000000000000e-001, 8.660254037844e-001),
    20.0: (0.0, 0.0, 8.660254037844e-001, 5.000000000000e-001),
    30.0: (0.0, 0.0, 1.0, 0.0),
    40.0: (0.0, 0.0, 8.660254037844e-001, -5.000000000000e-001),
}


def test_spinning_body_gives_the_published_rows():
    t_s = np.arange(0.0, 40.01, 0.2)
    plan = SimpleNamespace(
        scenario=Scenario(
            orbit=StateVectorOrbit(
                frame="GCRF",
                epoch=EPOCH_UTC,
                position_km=(6778.0, 0.0, 0.0),
                velocity_km_s=(0.0, 4.8, 5.9),
                force_model="j2j4",
            ),
            attitude=InertialAttitude(
                epoch=EPOCH_UTC,
                q_body_from_eci_xyzw=(0.0, 0.0, 0.0, 1.0),
                omega_body_deg_s=(0.0, 0.0, 6.0),
            ),
            platform=ISS_HRC,
            initial_state=InitialState(epoch=EPOCH_UTC, angles_deg={"alpha": 0.0, "beta": 0.0}),
            sessions=(
                Session(target=StarTarget(ra_deg=0.0, dec_deg=0.0), start=EPOCH_UTC, stop=STOP_UTC),
            ),
        ),
        segments=(),
        table=CommandTable(
            epoch_utc=EPOCH_UTC,
            channels=axis_channels(("alpha", "beta")),
            position=np.zeros((len(t_s), 2)),
            rate_rad_s=np.zeros((len(t_s), 2)),
        ),
    )
    lines = EXPORTERS["stk-attitude"].write(plan, EPOCH_UTC).decode().splitlines()
    data = lines[lines.index("AttitudeTimeQuaternions") + 1 : -1]
    for t, expected in PUBLISHED.items():
        moment, *q = data[round(5 * t)].split()
        assert moment == f"2002-06-01T12:00:{t:06.3f}"
        # half the last printed digit; the sign of a quaternion is free
        likeness = np.sign(np.dot(np.array(q, dtype=float), expected))
        np.testing.assert_allclose(likeness * np.array(q, float), expected, rtol=0, atol=6e-13)
