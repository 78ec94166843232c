"""Effects of one's own as files, and the law that one of them is, planted."""

import numpy as np

from drivers.simulated.effects import PlantedEffect

DEAD_ZONE = """format = "effect/1"
name = "dead_zone"
triad = "gyroscope"
term = "-u * exp(-(u / w)**4)"
unit = "1"
plausible = 1.0
source = "Lefevre 10.3"
shape.w = {unit = "deg/h", low = 1, high = 100}
"""
WARMING = """format = "effect/1"
name = "warming_while_warm"
triad = "gyroscope"
term = "T * T_rate"
unit = "deg/h/K/(K/min)"
plausible = 1.0
source = "Lefevre 6.2, Shupe effect of a coil whose index goes with temperature"
"""
WARMING_SIZES = np.array([2.0, -3.0, 1.5])  # deg/h/K/(K/min)
WARMING_LAW = PlantedEffect(
    "a law", "", (),
    gyro=lambda seen, triad, sizes: WARMING_SIZES / 3600 * (seen.temperature - 25) * seen.temperature_rate,
)  # fmt: skip
