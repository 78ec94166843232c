"""Vibration rectification: ``K s^2``, the mean follows the variance of the vibration from step to step.

An accelerometer's own along its axis; a gyroscope's that of all accelerometers together, since a coil or a proof
mass may be shaken along any axis. The variance is that of the samples in each dwell and rest: where a sample is a
mean it is less than that of the motion, the faster that is the less. Within a recording, stretch by stretch:
`procedures.samples.sample_rectification`. Plausible: 3 mg/g^2 and 20 deg/h/g^2, as of consumer devices.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Effect, Excitation, of_accelerometers, of_gyroscopes
from procedures.units import DEG_H_PER_DEG_S


def _variance(seen: Excitation) -> FloatArray:
    return np.full(seen.f.shape, np.nan) if seen.vibration is None else seen.vibration


ACCELEROMETER = Effect(
    name="accelerometer.vibration_rectification",
    unit="g/g^2",
    physics="K s^2, s^2 the variance of the vibration in a step",
    source="IEEE Std 1293 and 836, vibration rectification coefficient",
    plausible=3e-3,
    columns=of_accelerometers(_variance),
    separate_by="the same position with a shaker, or the noisy neighbour, switched on and off",
)
GYROSCOPE = Effect(
    name="gyroscope.vibration_rectification",
    unit="deg/h/g^2",
    physics="K s^2, s^2 the variance of the vibration in a step, of all accelerometers together",
    source="IEEE Std 952, sensitivity to vibration",
    plausible=20.0,
    columns=of_gyroscopes(lambda seen: np.sum(_variance(seen), axis=1) / DEG_H_PER_DEG_S),
    separate_by=ACCELEROMETER.separate_by,
)
