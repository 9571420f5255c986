"""The command table: plain data, made by one part and judged by another."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal, NamedTuple

import numpy as np

from planner.base.arrays import Array

ROWS_PER_S = 5  # Sumarokov 2016: the platform is fed every 0.2 s
COMMAND_STEP_S = 1.0 / ROWS_PER_S
DEGREES_DECIMALS = 9  # 1e-9 deg is 4 microarcsec, 1/25,000 of what the table promises
QUATERNION_DECIMALS = 13  # likewise


class Channel(NamedTuple):
    """One column of a table, as people read it.

    name: E.g. `"alpha_rate_deg_s"`.  dof: whose motion it tells, an axis or a part of the body's.
    of: which of the table's arrays holds it, in their order of columns.  unit: as UDUNITS writes
    it; the arrays hold radians where it says degree.
    """

    name: str
    dof: str
    of: Literal["position", "rate", "acceleration"]
    unit: str
    decimals: int = DEGREES_DECIMALS


def axis_channels(axis_names: tuple[str, ...]) -> tuple[Channel, ...]:
    """Angle and rate of each axis."""
    return (
        *(Channel(f"{name}_deg", name, "position", "degree") for name in axis_names),
        *(Channel(f"{name}_rate_deg_s", name, "rate", "degree s-1") for name in axis_names),
    )


BODY_CHANNELS = (
    *(
        Channel(f"q_eci_from_body_{part}", part, "position", "1", QUATERNION_DECIMALS)
        for part in "xyzw"
    ),
    *(Channel(f"omega_body_deg_s_{part}", part, "rate", "degree s-1") for part in "xyz"),
    *(Channel(f"alpha_body_deg_s2_{part}", part, "acceleration", "degree s-2") for part in "xyz"),
)


@dataclass(frozen=True, eq=False)
class Motion:
    """How a platform moves at n instants.

    position: of axes their angles, rad, (n, m); of a body `q_eci_from_body_xyzw`, unit, scalar
    last, turning body vectors into GCRF, neighbours of like sign, (n, 4).
    rate_rad_s, acceleration_rad_s2: of axes (n, m); of a body against GCRF in body axes, (n, 3).
    """

    position: Array
    rate_rad_s: Array
    acceleration_rad_s2: Array


@dataclass(frozen=True, kw_only=True)
class CommandTable:
    """Position and rate every `COMMAND_STEP_S`, counted from `epoch_utc`, in named channels.

    epoch_utc: a whole multiple of 0.2 s after its UTC second.
    position, rate_rad_s, acceleration_rad_s2: as in `Motion`, row k at epoch_utc + 0.2 k s (SI
    seconds).  Between rows axes, whose table has no acceleration, fly the cubic Hermite of the
    two rows, and a body the quintic in Rodrigues parameters that meets both.
    """

    epoch_utc: datetime
    channels: tuple[Channel, ...]
    position: Array
    rate_rad_s: Array
    acceleration_rad_s2: Array | None = None

    @property
    def dof_names(self) -> tuple[str, ...]:
        """What `rate_rad_s` has a column for: the axes, or those of the body."""
        return tuple(channel.dof for channel in self.channels if channel.of == "rate")

    @property
    def t_s(self) -> Array:
        """Seconds since the epoch of each row; k/5 is the closest double to 0.2 k, 0.2*k is not."""
        return np.arange(len(self.position)) / ROWS_PER_S
