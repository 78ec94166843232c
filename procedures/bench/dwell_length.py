"""How long must a dwell be for a wanted sigma of the accelerometers' bias, of white rate noise n [count/sqrt(s)].

    std^2 = (WHITE_NOISE_FACTOR n / (2 k))^2 / T + (REMAINDER_COUNTS / (k T))^2

The bias of an axis rests on four dwells of T seconds (docs/explanation/solving.md); both numbers are measured on
simulated campaigns (docs/explanation/guiding.md).
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray

WHITE_NOISE_FACTOR = 1.03
REMAINDER_COUNTS = 2e-3  # count
STEP_S, SHORTEST_S, LONGEST_S = 5.0, 10.0, 3600.0


@dataclass(frozen=True, slots=True)
class DwellLength:
    """Seconds per position, the 1 sigma [g] the worst axis's bias has then, and whether it is what was wanted."""

    seconds: float
    bias_std_g: float
    is_reached: bool


def dwell_seconds(noise_per_rt_s: FloatArray, k: FloatArray, bias_std_g: float) -> DwellLength:
    """Return the dwell time for a wanted 1 sigma of every axis's joint bias.

    Rounded up to `STEP_S`, between `SHORTEST_S` and `LONGEST_S`.

    Parameters
    ----------
    noise_per_rt_s : (3,) float64, count/sqrt(s)
        The accelerometers' white noise.
    k : (3,) float64, count/(g s)
        Their scale factors, roughly.
    bias_std_g : float, g
    """
    white, rest = _parts(noise_per_rt_s, k)
    square = bias_std_g**2
    needed = np.max((white + np.sqrt(white**2 + 4 * square * rest)) / (2 * square))
    seconds = float(np.clip(np.ceil(needed / STEP_S) * STEP_S, SHORTEST_S, LONGEST_S))
    reached = float(np.sqrt(np.max(white / seconds + rest / seconds**2)))
    return DwellLength(seconds, reached, bool(needed <= LONGEST_S))


def _parts(noise_per_rt_s: FloatArray, k: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the parts (3,) of the variance that fall with the time and with its square."""
    return (WHITE_NOISE_FACTOR * noise_per_rt_s / (2 * k)) ** 2, (REMAINDER_COUNTS / k) ** 2
