"""What the means of several recordings at rest say beside each other, where nothing of them is solved.

Every soak has constants of its own, and what acts on all of it alike is in them. Side by side the constants say
something all the same: whatever their attitudes, gyroscopes see no more than the Earth's rate,

    b_s + w_s,   w_s a draw of 15.04 deg/h over sqrt(3) along each axis,

and accelerometers the length of gravity, so that of sensors with a bias across gravity a tilt by an angle a shows
as a part of it: |f_s| = b_s . u_s + 1 g, known to `BIAS_ACROSS` a.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.thermal_soaks import SoakBlock
from procedures.earth.geodesy import EARTH_RATE
from procedures.frames import AXES, TRIADS

MIN_SOAKS = 2
BIAS_ACROSS = 0.02  # of gravity, that biases and scale factors nobody calibrated may come to


@dataclass(frozen=True, slots=True, eq=False)
class SoakLevel:
    """A soak's mean less that of all (r,) with 1 sigma (r,) [g, deg/s]; ``mix`` (r, 3) makes it of the sensors.

    ``soak`` numbers the soak among those given; ``axis`` (r,) the sensors, -1 of a length.
    """

    triad: str
    soak: int
    axis: IntArray
    residual: FloatArray
    sigma: FloatArray
    mix: FloatArray


def levels(soaks: Sequence[tuple[str, Sequence[SoakBlock]]]) -> list[SoakLevel]:
    """Return the levels of each triad's soaks, in those sensors that all show; none of one soak.

    Of accelerometers all three must be there: one alone may be tilted as far as it will.
    """
    found = list[SoakLevel]()
    for triad in TRIADS:
        own = [(i, blocks) for i, (of, blocks) in enumerate(soaks) if of == triad]
        if len(own) < MIN_SOAKS:
            continue
        alive = [axis for axis in range(len(AXES)) if all(axis in blocks[0].alive for _, blocks in own)]
        if triad == "gyroscope" and alive:
            found += _of_gyroscopes(own, np.array(alive))
        elif triad == "accelerometer" and len(alive) == len(AXES):
            found += _of_accelerometers(own)
    return found


def _noise(blocks: Sequence[SoakBlock]) -> FloatArray:
    """Return 1 sigma (3,) of a soak's mean by the noise of its blocks."""
    noise: FloatArray = np.sqrt(np.sum([block.sigma**2 for block in blocks], axis=0)) / len(blocks)
    return noise


def _of_gyroscopes(soaks: Sequence[tuple[int, Sequence[SoakBlock]]], alive: IntArray) -> Iterator[SoakLevel]:
    rates = np.array([blocks[0].level for _, blocks in soaks])
    earth = np.degrees(EARTH_RATE) / np.sqrt(3)
    for (i, blocks), off in zip(soaks, rates - rates.mean(axis=0), strict=True):
        sigma = np.hypot(_noise(blocks), earth)
        yield SoakLevel("gyroscope", i, alive, off[alive], sigma[alive], np.eye(3)[alive])


def _of_accelerometers(soaks: Sequence[tuple[int, Sequence[SoakBlock]]]) -> Iterator[SoakLevel]:
    forces = np.array([blocks[0].level for _, blocks in soaks])
    length = np.linalg.norm(forces, axis=1)
    if not np.all(length > 0):
        return
    up = forces / length[:, None]
    mean = up.mean(axis=0)
    angle = np.linalg.norm(up - mean, axis=1)
    for (i, blocks), off, u, a in zip(soaks, length - length.mean(), up, angle, strict=True):
        sigma = np.hypot(np.linalg.norm(u * _noise(blocks)), BIAS_ACROSS * a * length.mean())
        yield SoakLevel("accelerometer", i, np.array([-1]), np.array([off]), np.array([sigma]), u[None])
