"""A sample ``limits.toml``: what the simulated units are held to, in the units of the screens.

The simulated units (`drivers.simulated.truth.Truth.example`) are random; every limit stands six of their standard
deviations away, so that all pass and a broken one does not.
"""

MODEL = "SIM-FOG3"
HEAD = """# Limits of an IMU model: edit the numbers, then
#   station fixtures limits MODEL --import limits.toml
# Units as the screens show them: ug, arcsec, deg/h, count/(g s), count/deg; or ppm of a nominal scale factor.
# A value is accepted if it is inside the limits by guard_band times its own standard uncertainty u.
model = "MODEL"
"""
LIMIT = """
[[limit]]
parameter = "{}"{}
low = {}
high = {}
unit = "{}"
guard_band = 2.0
"""
FIRST = """   # all three axes; accelerometer.scale_factor.x is one
nominal = 1000.0                           # count/(g s)"""
ROWS = (
    ("accelerometer.scale_factor", FIRST, -180000.0, 180000.0, "ppm"),
    ("accelerometer.misalignment", "", -2500.0, 2500.0, "arcsec"),
    ("accelerometer.bias", "", -12000.0, 12000.0, "ug"),
    ("gyroscope.scale_factor", "", 33000.0, 39000.0, "count/deg"),
    ("gyroscope.misalignment", "", -900.0, 900.0, "arcsec"),
    ("gyroscope.bias", "", -4.5, 4.5, "deg/h"),
)


def example_limits(model: str = MODEL) -> str:
    """Return the sample for a model."""
    head = HEAD.replace('"MODEL"', f'"{model}"').replace("limits MODEL", f"limits {model}")
    return head + "".join(LIMIT.format(*row) for row in ROWS)
