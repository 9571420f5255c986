"""Which values can a field of a target take?"""


def require_within(target: object, *ranges: tuple[str, float, float]) -> None:
    """Refuse the first field outside its closed range; fields that hold None are not given."""
    for name, low, high in ranges:
        value = getattr(target, name)
        if value is not None and not low <= value <= high:
            raise ValueError(f"{name} must lie in {low:g}..{high:g}, not {value}")


GEODETIC_RANGES = (
    ("latitude_deg", -90.0, 90.0),
    ("longitude_deg", -180.0, 360.0),
    ("height_m", -1000.0, 100e3),
)
