"""Biases differ from one recording at rest to the next by draws of one variance: turn-on to turn-on repeatability.

A column for every soak and sensor. It shows in the means of soaks that determine no calibration
(`procedures.evidence.thermal_soaks`), of which two or more lie side by side. Plausible: 30 deg/h and 1 mg, of
which ten times as much is believed.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation
from procedures.effects.jump import soak_of
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S


def accelerometer_columns(excitation: Excitation) -> list[Columns]:
    """Return a bias of its own for each soak and sensor [g per g]."""
    names, own = _own(excitation)
    return [Columns(names, accel=own)] if names else []


def gyroscope_columns(excitation: Excitation) -> list[Columns]:
    """Return a bias of its own for each soak and sensor [deg/s per deg/h]."""
    names, own = _own(excitation)
    return [Columns(names, gyro=own / DEG_H_PER_DEG_S)] if names else []


def _own(excitation: Excitation) -> tuple[tuple[str, ...], FloatArray]:
    """Return the coefficients' names, and 1 at a soak's nodes in each of its columns (n, 3, k)."""
    of_step = [(step.campaign, soak_of(step)) if step.kind == "soak" else None for step in excitation.steps]
    soaks = [soak for soak in dict.fromkeys(of_step) if soak is not None]
    if len(soaks) < 2:
        return (), np.zeros((len(excitation.t), 3, 0))
    own = np.zeros((len(excitation.t), 3, 3 * len(soaks)))
    for i, soak in enumerate(soaks):
        here = np.array([each == soak for each in of_step])[excitation.step]
        own[here, :, 3 * i : 3 * i + 3] = np.eye(3)
    return tuple(f"{soak[0] + 1}.{soak[1]}.{axis}" for soak in soaks for axis in AXES), own


ACCELEROMETER = Effect(
    name="accelerometer.turn_on_bias",
    unit="g",
    physics="the bias of every recording is random, standard deviation = value",
    source="IEEE Std 1293, bias repeatability",
    plausible=1e-3,
    columns=accelerometer_columns,
    separate_by="the same recordings once more, some of them without switching off in between, at one temperature",
    is_scatter=True,
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.turn_on_bias",
    unit="deg/h",
    source="IEEE Std 952, bias repeatability",
    plausible=30.0,
    columns=gyroscope_columns,
)
