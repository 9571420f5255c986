"""Which values can a place on the ground take?"""

GEODETIC_RANGES = (
    ("latitude_deg", -90.0, 90.0),
    ("longitude_deg", -180.0, 360.0),
    ("height_m", -1000.0, 100e3),
)
