"""Noise of a bias in recordings at rest: bias instability and random walk, as IEEE Std 952 and 1293 name them.

Both are draws of one variance. A recording's blocks share their covariance C, whose root L (N, r) gives columns:
``bias = L c``, each c of the noise coefficient's size.

Random walk, of coefficient K: ``C = K^2 min(t, t')``. Bias instability, of coefficient B: noise of the power
``B^2 / (pi f)`` (one-sided; two-sided ``B^2 / (2 pi f)``, IEEE Std 952 annex C). Gauss-Markov processes, an octave
of time constants each, of the variance q have the power ``q / (ln 2 f)`` together, so that ``q = B^2 ln 2 / pi``.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Effect
from procedures.effects.excitation import Columns, Excitation, per_axis
from procedures.effects.jump import soak_of
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S, S_PER_H

MIN_BLOCKS = 10  # of a soak: fewer show a variance, but not of what
MOST_DRAWS = 40  # of a random walk in a recording, of each sensor: the others hold 2 % of its variance
OCTAVES = 5  # of time constants beyond the recording and below a block: what is beyond adds 3 % of an octave
Covariance = Callable[[FloatArray, float], FloatArray]


def _walk(t: FloatArray, block: float) -> FloatArray:
    """Return the covariance (N, N) per unit of K^2 of means over a ``block`` [h] about times t (N,) [h]."""
    found: FloatArray = np.minimum(t[:, None], t) - block / 6 * np.eye(len(t))
    return found


def _flicker(t: FloatArray, block: float) -> FloatArray:
    """Return the covariance (N, N) per unit of B^2 of means over a ``block`` [h] about times t (N,) [h].

    That of a Gauss-Markov process's values is ``q exp(-|t - t'| / tau)``; its means are the integrals over both.
    """
    apart, span = np.abs(t[:, None] - t), float(np.ptp(t))
    octaves = np.arange(-int(np.ceil(np.log2(span / block))) - OCTAVES, OCTAVES + 1)
    total = np.zeros_like(apart)
    for x in (block / (span * 2.0**octaves)).tolist():
        between = np.exp(-np.maximum(apart / block - 1, 0.0) * x) * ((1 - np.exp(-x)) / x) ** 2
        total += np.where(apart > 0, between, 2 / x - 2 / x**2 * (1 - np.exp(-x)))
    found: FloatArray = np.log(2) / np.pi * total
    return found


def _soaks(seen: Excitation) -> Iterator[list[int]]:
    """Yield the steps of each soak that has enough blocks, in their order."""
    found = dict[tuple[int, str], list[int]]()
    for number, step in enumerate(seen.steps):
        if step.kind == "soak":
            found.setdefault((step.campaign, soak_of(step)), []).append(number)
    yield from (steps for steps in found.values() if len(steps) >= MIN_BLOCKS)


def _roots(seen: Excitation, covariance: Covariance, most: int | None) -> FloatArray:
    """Return a root (n, r) of the covariance at the nodes; each soak has ``most`` draws of its own.

    Flicker noise has all: of 200 blocks those beyond the 40th look like white noise as large as the block's.
    """
    found = [np.zeros((len(seen.t), 0))]
    for steps in _soaks(seen):
        t = np.array([float(np.mean(seen.t[seen.step == step])) for step in steps]) / S_PER_H
        block = float(np.median(np.diff(t)))
        variances, V = np.linalg.eigh(covariance(t - t[0] + block / 2, block))
        last = slice(None if most is None else -most, None)
        of_soak = V[:, last] * np.sqrt(np.maximum(variances[last], 0.0))
        at_nodes = np.zeros((len(seen.t), of_soak.shape[1]))
        for step, row in zip(steps, of_soak, strict=True):
            at_nodes[seen.step == step] = row
        found.append(at_nodes)
    return np.hstack(found)


def _columns(triad: str, covariance: Covariance, most: int | None = None) -> Callable[[Excitation], list[Columns]]:
    per = 1.0 if triad == "accelerometer" else DEG_H_PER_DEG_S

    def columns(seen: Excitation) -> list[Columns]:
        """Return columns of all three sensors together, and of each alone."""
        roots = _roots(seen, covariance, most) / per
        if not roots.shape[1]:
            return []
        of_sensors = np.stack([per_axis(root) for root in roots.T], axis=3)  # (n, 3, sensor, r)
        parts: list[tuple[FloatArray, dict[str, object]]] = [(of_sensors.reshape(len(roots), 3, -1), {})]
        parts += [(of_sensors[:, :, i], {"channel": f"{triad[0]}{axis}"}) for i, axis in enumerate(AXES)]
        found = [(Columns(tuple(map(str, range(at.shape[2]))), where=where), at) for at, where in parts]
        return [replace(way, accel=at) if triad == "accelerometer" else replace(way, gyro=at) for way, at in found]

    return columns


_ABOUT = (
    "Every inertial sensor has some: a property of its noise, no error that a calibration could correct. It shows "
    "in recordings at rest of ten blocks or more. Plausible: as of a navigation grade unit; of noisier ones more."
)
_SEPARATE = "a recording at rest several times as long, at one temperature"
ACCELEROMETER_INSTABILITY = Effect(
    name="accelerometer.bias_instability",
    meaning="Bias instability, noise of 1 / frequency",
    about=_ABOUT,
    unit="g",
    physics="bias with the power spectral density value^2 / (pi f)",
    source="IEEE Std 1293, bias instability (flicker noise)",
    plausible=1e-5,
    columns=_columns("accelerometer", _flicker),
    next_measurement="longer",
    separate_by=_SEPARATE,
    is_scatter=True,
    driver="time",
)
GYROSCOPE_INSTABILITY = replace(
    ACCELEROMETER_INSTABILITY,
    name="gyroscope.bias_instability",
    unit="deg/h",
    source="IEEE Std 952, annex C: bias instability B",
    plausible=0.1,
    columns=_columns("gyroscope", _flicker),
)
ACCELEROMETER_WALK = replace(
    ACCELEROMETER_INSTABILITY,
    name="accelerometer.acceleration_random_walk",
    meaning="Acceleration random walk of the bias",
    unit="g/sqrt(h)",
    physics="bias with the variance value^2 t",
    source="IEEE Std 1293, acceleration random walk",
    columns=_columns("accelerometer", _walk, MOST_DRAWS),
)
GYROSCOPE_WALK = replace(
    GYROSCOPE_INSTABILITY,
    name="gyroscope.rate_random_walk",
    meaning="Rate random walk of the bias",
    unit="deg/h/sqrt(h)",
    physics="bias with the variance value^2 t",
    source="IEEE Std 952, annex C: rate random walk K",
    columns=_columns("gyroscope", _walk, MOST_DRAWS),
)
