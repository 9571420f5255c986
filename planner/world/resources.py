"""Battery, memory and wheels of a platform: what fills them, draws on them, and their limits."""

import math
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import LENGTH_MIN, VectorPart, Within, spec
from planner.world.frames.geodesy import HeightM, LatitudeDeg, LongitudeDeg

PowerW = Annotated[float, Within(0.0, 1e6)]
EnergyWh = Annotated[float, Within(0.0, 1e6)]
Gbit = Annotated[float, Within(0.0, 1e6)]
GbitS = Annotated[float, Within(0.0, 1e3)]
_WheelNMS = Annotated[float, Within(1e-6, 1e5)]
StartNMS = Annotated[float, Within(-1e5, 1e5)]
_TorqueNM = Annotated[float, Within(-1e3, 1e3)]

ResourceName = Literal["battery", "memory", "momentum_x", "momentum_y", "momentum_z"]
MOMENTA: tuple[ResourceName, ...] = ("momentum_x", "momentum_y", "momentum_z")


def resource_told(name: ResourceName) -> str:
    """In words: momentum about x."""
    return name.replace("_", " about ")


@spec
class Panel:
    """A flat array of solar cells, fixed to the body or, of two axes, to their carrier.

    normal_body: direction that it faces, in body axes; of two axes in those of their carrier. E.g.
    `[0.0, 0.0, -1.0]`.
    power_w: charge with the Sun square to it; by the cosine of the angle otherwise. E.g. `150.0`.
    """

    normal_body: tuple[VectorPart, VectorPart, VectorPart]
    power_w: PowerW

    def __post_init__(self) -> None:
        if not math.hypot(*self.normal_body) >= LENGTH_MIN:
            raise ValueError(
                f"normal_body must be at least {LENGTH_MIN:g} long, not "
                f"{math.hypot(*self.normal_body):g}"
            )

    @property
    def normal(self) -> Array:
        """As a unit vector, (3,)."""
        return np.asarray(self.normal_body) / math.hypot(*self.normal_body)


@spec
class Battery:
    """Charged in sunlight up to its capacity, drawn on by the platform, never below its least.

    Sunlight: the Sun's centre stands above the limb of the ellipsoid, without air. Neglects
    losses, the Sun's distance, and shadows that parts cast on panels.

    capacity_wh: charge when full; more is lost. E.g. `180.0`.
    start_wh: charge at row 0; unless given it is full, or what the plan of `after` leaves. E.g.
    `160.0`.
    least_wh: charge that it must keep. E.g. `110.0`.
    idle_w: drawn at all times. E.g. `38.0`.
    slew_w: drawn on top while the platform moves, or waits on a target, and doesn't image.
    imaging_w: drawn on top during sessions that image: not at a station, nor in test motions.
    downlink_w: drawn on top during sessions at a station, and while one of memory's stations takes
    data, whether or not there is any. E.g. `60.0`.
    panels: up to 16 arrays that charge it, by the angle of the Sun.
    sunlight_w: in place of panels, charge in sunlight whatever the attitude. E.g. `120.0`.
    """

    capacity_wh: Annotated[float, Within(1e-3, 1e6)]
    start_wh: EnergyWh | None = None
    least_wh: EnergyWh = 0.0
    idle_w: PowerW
    slew_w: PowerW = 0.0
    imaging_w: PowerW = 0.0
    downlink_w: PowerW = 0.0
    panels: tuple[Panel, ...] = ()
    sunlight_w: PowerW | None = None

    def __post_init__(self) -> None:
        if not self.least_wh <= self.capacity_wh:
            raise ValueError(
                f"least_wh must be capacity_wh, {self.capacity_wh:g}, or less, not "
                f"{self.least_wh:g}"
            )
        if not self.least_wh <= self.begins_wh <= self.capacity_wh:
            raise ValueError(
                f"start_wh must lie between least_wh and capacity_wh, {self.least_wh:g} to "
                f"{self.capacity_wh:g}, not {self.begins_wh:g}"
            )
        if len(self.panels) > 16:
            raise ValueError(f"panels must hold at most 16 panels, not {len(self.panels)}")
        if self.panels and self.sunlight_w is not None:
            raise ValueError("sunlight_w must be left out with panels: they say what charges it")

    @property
    def begins_wh(self) -> float:
        """Charge at row 0."""
        return self.capacity_wh if self.start_wh is None else self.start_wh


@spec
class Station:
    """A place on the ground that takes data while the platform stands high enough in its sky.

    id: its name, unlike the others'. E.g. `"svalbard"`.
    latitude_deg: of its antenna. E.g. `78.23`.
    longitude_deg: of its antenna. E.g. `15.4`.
    min_elevation_deg: elevation from which on it takes data, geometric, without refraction.
    """

    id: str
    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: HeightM = 0.0
    min_elevation_deg: Annotated[float, Within(0.0, 90.0)] = 5.0


@spec
class Memory:
    """Filled in sessions that image, emptied over stations, one at a time.

    capacity_gbit: most that it holds. E.g. `512.0`.
    start_gbit: data in it at row 0; unless given none, or what the plan of `after` leaves. E.g.
    `40.0`.
    imaging_gbit_s: written during sessions that image. E.g. `1.6`.
    downlink_gbit_s: sent while any of `stations` takes data, wherever the platform points. E.g.
    `0.4`.
    stations: up to 16 of them.
    pointed_gbit_s: sent during sessions whose target is a station, by an antenna that must be
    pointed at it; where one of `stations` takes data as well, the faster of both. E.g. `0.8`.
    """

    capacity_gbit: Annotated[float, Within(1e-3, 1e6)]
    start_gbit: Gbit = 0.0
    imaging_gbit_s: GbitS
    downlink_gbit_s: GbitS = 0.0
    stations: tuple[Station, ...] = ()
    pointed_gbit_s: GbitS = 0.0

    def __post_init__(self) -> None:
        if self.start_gbit > self.capacity_gbit:
            raise ValueError(
                f"start_gbit must be capacity_gbit, {self.capacity_gbit:g}, or less, not "
                f"{self.start_gbit:g}"
            )
        if len(self.stations) > 16:
            raise ValueError(f"stations must hold at most 16 stations, not {len(self.stations)}")
        names = [station.id for station in self.stations]
        for number, name in enumerate(names):
            if not name or name in names[:number]:
                raise ValueError(f"stations.{number}.id must be a name of its own, not {name!r}")


@spec
class Momentum:
    """Held by reaction wheels about the axes of a body with an inertia, which agility turns.

    The wheels take up what the gravity gradient and the given torque bring, and turn the body:
    what it turns with is taken from them. Neglects torques of air, light and the magnetic field
    but for the one given, and the Earth's flattening.

    capacity_n_m_s: most that the wheels hold about body x, y, z, either way. E.g.
    `[0.9, 0.9, 0.9]`.
    start_n_m_s: of the wheels at row 0, in body axes; unless given none, or what the plan of
    `after` leaves. E.g. `[0.1, -0.2, 0.0]`.
    torque_body_n_m: a constant torque from outside, in body axes. E.g. `[2e-6, 0.0, 1e-6]`.
    unload_n_m: torque about each body axis that takes momentum from the wheels, until they hold
    none, while the platform waits in its idle attitude; 0 for no unloading. E.g. `2e-5`.
    """

    capacity_n_m_s: tuple[_WheelNMS, _WheelNMS, _WheelNMS]
    start_n_m_s: tuple[StartNMS, StartNMS, StartNMS] = (0.0, 0.0, 0.0)
    torque_body_n_m: tuple[_TorqueNM, _TorqueNM, _TorqueNM] = (0.0, 0.0, 0.0)
    unload_n_m: Annotated[float, Within(0.0, 1e3)] = 0.0

    def __post_init__(self) -> None:
        ends = zip(self.start_n_m_s, self.capacity_n_m_s, strict=True)
        for axis, (start, capacity) in enumerate(ends):
            if abs(start) > capacity:
                raise ValueError(
                    f"start_n_m_s.{axis} must lie within capacity_n_m_s, {-capacity:g} to "
                    f"{capacity:g}, not {start:g}"
                )


@spec
class Resources:
    """Stores that may run out: a plan is refused that takes more than there is.

    battery: energy, in Wh.
    memory: images waiting to be sent, in Gbit.
    momentum: of a body's reaction wheels, in N m s.
    """

    battery: Battery | None = None
    memory: Memory | None = None
    momentum: Momentum | None = None

    def __post_init__(self) -> None:
        if self.battery is None and self.memory is None and self.momentum is None:
            raise ValueError("battery, memory or momentum is required: or leave resources out")


def eased(resources: Resources, name: str, share: float, decimals: int) -> Resources:
    """The same, begun so much nearer to a full battery, an empty memory or wheels at rest.

    decimals: of what it begins with, rounded to the better side.
    """
    one, scale = getattr(resources, name), 10.0**decimals
    begins: dict[str, object]
    if isinstance(one, Battery):
        start_wh = one.begins_wh + share * (one.capacity_wh - one.begins_wh)
        begins = {"start_wh": min(math.ceil(start_wh * scale) / scale, one.capacity_wh)}
    elif isinstance(one, Memory):
        begins = {"start_gbit": math.floor(one.start_gbit * (1.0 - share) * scale) / scale}
    else:
        held = (math.trunc(each * (1.0 - share) * scale) / scale for each in one.start_n_m_s)
        begins = {"start_n_m_s": tuple(held)}
    return replace(resources, **{name: replace(one, **begins)})


def started(resources: Resources, name: str) -> str:
    """In words, what one of them begins with, by the request's field."""
    one = getattr(resources, name)
    if isinstance(one, Battery):
        return f"battery.start_wh {one.begins_wh:.10g}"
    if isinstance(one, Memory):
        return f"memory.start_gbit {one.start_gbit:.10g}"
    return f"momentum.start_n_m_s {[float(f'{each:.10g}') for each in one.start_n_m_s]}"
