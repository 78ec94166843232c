"""Counts lost at rate: ``-1e-6 p sign(u) max(0, |u| - w)``, p in ppm of what lies above w.

A counter or a loop that no longer follows loses a share of its pulses from a rate on; where it loses all of them,
p of 1e6, the range ends at w. The knee w is fitted. Turns at one speed put it into the scale factor, and where a
single speed lies above w its share and its knee are one. Plausible: 1000 ppm.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from procedures.effects.effect import KNEE, Columns, Effect, Excitation, per_axis
from procedures.effects.time_constant import with_nonlinear
from procedures.frames import AXES
from procedures.units import PPM_PER_ONE

PLAUSIBLE = 1000.0  # ppm
SLOWEST, FASTEST = 0.1, 0.95  # of the fastest rate, between which a search for the knee begins
RATIO = 1.4  # between neighbours, at most
MIN_FASTEST = 1.0  # deg/s: slower ones are no turning


def at(seen: Excitation, way: Columns) -> Columns:
    """Return what is lost per sensor above a way's knee [deg/s per ppm], and a column for the knee."""
    u = seen.omega
    lost = np.sign(u) * np.maximum(np.abs(u) - way.nonlinear[KNEE], 0.0) / -PPM_PER_ONE
    return with_nonlinear(replace(way, coefficients=AXES, gyro=per_axis(lost)), (PLAUSIBLE,) * 3)


def _knees(seen: Excitation) -> Iterator[float]:
    """Yield knees [deg/s] to begin with."""
    fastest = float(np.max(np.abs(seen.omega), initial=0.0))
    if fastest > MIN_FASTEST:
        count = 1 + int(np.ceil(np.log(FASTEST / SLOWEST) / np.log(RATIO)))
        yield from np.geomspace(SLOWEST * fastest, FASTEST * fastest, count).tolist()


EFFECT = Effect(
    name="gyroscope.counts_lost",
    unit="ppm",
    physics="-1e-6 p sign(u) max(0, abs(u) - w)",
    source="IEEE Std 952, maximum input rate; saturation of a counter or loop",
    plausible=PLAUSIBLE,
    columns=lambda seen: [at(seen, Columns((), nonlinear={KNEE: knee})) for knee in _knees(seen)],
    separate_by="turns at four speeds in each direction, or a rate table",
    at=at,
    is_loss=True,
    ranges={KNEE: (MIN_FASTEST, 1e4)},
    driver="input",
)
