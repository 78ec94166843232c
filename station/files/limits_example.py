"""A sample ``limits.toml``: what the simulated units are held to, in the units of the screens.

The simulated units (`drivers.simulated.truth.Truth.example`) are random; every limit stands six of their standard
deviations away, so that all pass and a broken one does not.
"""

MODEL = "SIM-FOG3"
TEMPLATE = """# Limits of an IMU model: edit the numbers, then
#   station fixtures limits MODEL --import limits.toml
# Units as the screens show them: ug, arcsec, deg/h, count/(g s), count/deg; or ppm of a nominal scale factor.
# A value is accepted where it is inside by guard_band times its own 1 sigma.
model = "MODEL"

[[limit]]
parameter = "accelerometer.scale_factor"   # all three axes; accelerometer.scale_factor.x is one
nominal = 1000.0                           # count/(g s)
low = -180000.0
high = 180000.0
unit = "ppm"
guard_band = 2.0

[[limit]]
parameter = "accelerometer.misalignment"
low = -2500.0
high = 2500.0
unit = "arcsec"
guard_band = 2.0

[[limit]]
parameter = "accelerometer.bias"
low = -12000.0
high = 12000.0
unit = "ug"
guard_band = 2.0

[[limit]]
parameter = "gyroscope.scale_factor"
low = 33000.0
high = 39000.0
unit = "count/deg"
guard_band = 2.0

[[limit]]
parameter = "gyroscope.misalignment"
low = -900.0
high = 900.0
unit = "arcsec"
guard_band = 2.0

[[limit]]
parameter = "gyroscope.bias"
low = -4.5
high = 4.5
unit = "deg/h"
guard_band = 2.0
"""


def example_limits(model: str = MODEL) -> str:
    """Return the sample for a model."""
    return TEMPLATE.replace('"MODEL"', f'"{model}"').replace("limits MODEL", f"limits {model}")
