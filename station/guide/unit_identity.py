"""Is this the unit that the campaign began with? Where the wire says no serial number, its counts must tell.

On one face the accelerometers' count rates hold scale factor and bias whichever way the cube points, and the
upright gyro's its bias and the Earth rate's vertical part. A unit switched on again repeats them to
`MAX_ACCELEROMETER_CHANGE` and `MAX_GYROSCOPE_CHANGE`; another one of its model seldom comes as near in all.
"""

from typing import Literal, NamedTuple

import numpy as np

from procedures.frames import AXES
from station.files.campaign_folder.plan_file import UnitRecord
from station.stream.live.stillness import MIN_VARIANCE, TICKS_PER_BLOCK

MAX_ACCELEROMETER_CHANGE = 1e-3  # of g: turn-on repeatability of bias and scale factor together
MAX_GYROSCOPE_CHANGE = 0.3  # of the greatest gyro rate at rest
MAX_NOISE_RATIO = 2.0  # ratio of sigmas
MAX_PERIOD_DIFFERENCE = (
    2e-2  # relative: where a device sends no time it was measured for 3 s, by a busy machine to 1 %
)


class Sameness(NamedTuple):
    """Whether it is the same unit, and why, in words."""

    answer: Literal["yes", "no", "unsure"]
    text: str


def same_unit(before: UnitRecord, now: UnitRecord) -> Sameness:
    """Say whether the unit connected ``now`` is the one of ``before``.

    The wire's serial number decides where both have one. Else it is ``yes`` if rates and noise agree on the same
    face: evidence, no proof, so that the operator should be asked still.
    """
    if before.serial_from_wire and now.serial_from_wire:
        if (before.model, before.serial) == (now.model, now.serial):
            return Sameness("yes", f"it sends serial number {now.serial}, as at the start of the campaign")
        text = f"it sends {now.model} {now.serial}, the campaign started with {before.model} {before.serial}"
        return Sameness("no", text)
    if abs(now.period / before.period - 1) > MAX_PERIOD_DIFFERENCE:
        text = f"it sends every {now.period:.6g} s, the campaign's unit every {before.period:.6g} s"
        return Sameness("no", text)
    if before.rate is None or before.noise is None or now.rate is None or now.noise is None:
        return Sameness("unsure", "it sends no serial number, and no dwell is recorded yet to compare with")
    rate, other = np.array(now.rate), np.array(before.rate)
    if (here := _face(rate)) != (there := _face(other)):
        text = f"it rests with {here}; put it down with {there}, as in the campaign's first dwell, to compare"
        return Sameness("unsure", text)
    noise, other_noise = (np.maximum(np.array(each), MIN_VARIANCE) for each in (now.noise, before.noise))
    if unlike := _differences(rate, other, noise, other_noise):
        return Sameness("unsure", f"different from the campaign's first dwell: {', '.join(unlike)}")
    return Sameness("yes", "it sends no serial number, but its rates and noise match the first dwell")


def _face(rate: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    upright = int(np.argmax(np.abs(rate[3:])))
    return f"IMU {AXES[upright]} {'up' if rate[3 + upright] > 0 else 'down'}"


def _differences(*arrays: np.ndarray[tuple[int], np.dtype[np.float64]]) -> list[str]:
    """Say what differs more than switching off and on explains; arrays (6,): rates now, then, noise now, then."""
    rate, other, noise, other_noise = arrays
    upright = int(np.argmax(np.abs(other[3:])))
    shift = (rate - other)[3:] / abs(other[3 + upright])
    said = [
        f"accelerometer {AXES[i]} by {shift[i] * 1e3:+.1f} mg"
        for i in range(3)
        if abs(shift[i]) > MAX_ACCELEROMETER_CHANGE
    ]
    turn_on = MAX_GYROSCOPE_CHANGE * np.abs(other[:3]).max() + 5 * np.sqrt(
        TICKS_PER_BLOCK * (noise + other_noise)[upright]
    )
    if abs(rate[upright] - other[upright]) > turn_on:
        said.append(f"gyro {AXES[upright]} {rate[upright]:.4g} instead of {other[upright]:.4g} counts/s")
    ratio = np.sqrt(noise / other_noise)
    for i in np.flatnonzero((ratio > MAX_NOISE_RATIO) | (ratio < 1 / MAX_NOISE_RATIO)).tolist():
        triad = "gyro" if i < 3 else "accelerometer"
        said.append(f"noise of {triad} {AXES[i % 3]} {ratio[i]:.2g} times as large")
    return said
