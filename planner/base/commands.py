"""The command table: plain data, made by one part and judged by another."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from planner.base.arrays import Array

ROWS_PER_S = 5  # Sumarokov 2016: the platform is fed every 0.2 s
COMMAND_STEP_S = 1.0 / ROWS_PER_S


class Channel(NamedTuple):
    """One column of a table, as people read it.

    name: E.g. `"alpha_rate_deg_s"`.  dof: whose motion it tells, an axis or a part of the body's.
    of: which of the table's arrays holds it, in their order of columns.  unit: as UDUNITS writes
    it; the arrays hold radians where it says degree.
    """

    name: str
    dof: str
    of: Literal["position", "rate", "acceleration", "extra"]
    unit: str
    decimals: int = 9  # 1e-9 deg is 4 microarcsec, 1/25,000 of what the table promises

    def told(self, value: Array) -> Array:
        """In the channel's unit, rounded to its decimals."""
        in_unit = np.degrees(value) if self.unit.startswith("degree") else value
        return np.asarray(np.round(in_unit, self.decimals) + 0.0)  # no -0.0

    def read(self, cells: ArrayLike) -> Array:
        """As the table's array holds what was told."""
        values = np.array(cells, dtype=float)
        return np.radians(values) if self.unit.startswith("degree") else values


def axis_channels(names: tuple[str, ...]) -> tuple[Channel, ...]:
    """Angle and rate of each axis."""
    return (
        *(Channel(f"{name}_deg", name, "position", "degree") for name in names),
        *(Channel(f"{name}_rate_deg_s", name, "rate", "degree s-1") for name in names),
    )


BODY_CHANNELS = (
    *(
        Channel(f"q_eci_from_body_{part}", part, "position", "1", decimals=13)  # likewise
        for part in "xyzw"
    ),
    *(Channel(f"omega_body_deg_s_{part}", part, "rate", "degree s-1") for part in "xyz"),
    *(Channel(f"alpha_body_deg_s2_{part}", part, "acceleration", "degree s-2") for part in "xyz"),
)
GIMBAL_CHANNELS = (
    *(Channel(f"gimbal_deg_{number}", str(number), "extra", "degree") for number in range(1, 5)),
    *(
        Channel(f"gimbal_rate_deg_s_{number}", str(number), "extra", "degree s-1")
        for number in range(1, 5)
    ),
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
    extra_rad: what other channels tell, (n, k): of gyros the gimbals' angles and the rates, rad/s,
    that they hold until the next row.
    """

    epoch_utc: datetime
    channels: tuple[Channel, ...]
    position: Array
    rate_rad_s: Array
    acceleration_rad_s2: Array | None = None
    extra_rad: Array | None = None

    @property
    def dof_names(self) -> tuple[str, ...]:
        """What `rate_rad_s` has a column for: the axes, or those of the body."""
        return tuple(channel.dof for channel in self.channels if channel.of == "rate")

    @property
    def columns(self) -> tuple[tuple[Channel, Array], ...]:
        """The channels, and what each tells in its unit, (n,)."""
        arrays = {
            "position": self.position,
            "rate": self.rate_rad_s,
            "acceleration": self.acceleration_rad_s2,
            "extra": self.extra_rad,
        }
        columns = {of: iter(array.T) for of, array in arrays.items() if array is not None}
        return tuple((one, one.told(next(columns[one.of]))) for one in self.channels)

    @property
    def t_s(self) -> Array:
        """Seconds since the epoch of each row; k/5 is the closest double to 0.2 k, 0.2*k is not."""
        return np.arange(len(self.position)) / ROWS_PER_S


def table_of(
    epoch_utc: datetime, channels: tuple[Channel, ...], columns: Mapping[str, ArrayLike]
) -> CommandTable:
    """The table whose columns are told by the channels' names; raises KeyError, ValueError."""
    read: dict[str, list[Array]] = {"position": [], "rate": [], "acceleration": [], "extra": []}
    for channel in channels:
        read[channel.of].append(channel.read(columns[channel.name]))
    return CommandTable(
        epoch_utc=epoch_utc,
        channels=channels,
        position=np.stack(read["position"], axis=1),
        rate_rad_s=np.stack(read["rate"], axis=1),
        acceleration_rad_s2=(
            np.stack(read["acceleration"], axis=1) if read["acceleration"] else None
        ),
        extra_rad=np.stack(read["extra"], axis=1) if read["extra"] else None,
    )
