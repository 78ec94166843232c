"""In which units people read noise: a term's name, symbol, unit, and its factor from deg/h, ug or outputs."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from procedures.units import DEG_H_PER_DEG_S, STANDARD_GRAVITY, UG_PER_G

Terms = Mapping[str, tuple[str, str, str, float]]


@dataclass(frozen=True, slots=True)
class NoiseUnits:
    """``unit`` of deviations, ``factor`` from g, deg/s or outputs to it, and the terms by name."""

    unit: str
    factor: float
    terms: Terms


GYROSCOPE: Terms = MappingProxyType({  # from deg/h; a deg/h for a second is an arcsec
    "quantisation": ("quantisation", "Q", "arcsec", 1.0),
    "random_walk": ("angle random walk", "N", "deg/sqrt(h)", 1 / 60),
    "bias_instability": ("bias instability", "B", "deg/h", 1.0),
    "rate_random_walk": ("rate random walk", "K", "deg/h/sqrt(h)", 60.0),
    "rate_ramp": ("rate ramp", "R", "deg/h/h", 3600.0),
})  # fmt: skip
ACCELEROMETER: Terms = MappingProxyType({  # from ug
    "quantisation": ("quantisation", "Q", "um/s", STANDARD_GRAVITY),
    "random_walk": ("velocity random walk", "N", "ug/sqrt(Hz)", 1.0),
    "bias_instability": ("bias instability", "B", "ug", 1.0),
    "rate_random_walk": ("random walk of bias", "K", "ug/sqrt(h)", 60.0),
    "rate_ramp": ("ramp", "R", "ug/h", 3600.0),
})  # fmt: skip
OUTPUT: Terms = MappingProxyType({
    "quantisation": ("quantisation", "Q", "output s", 1.0),
    "random_walk": ("random walk", "N", "output sqrt(s)", 1.0),
    "bias_instability": ("bias instability", "B", "output", 1.0),
    "rate_random_walk": ("rate random walk", "K", "output/sqrt(s)", 1.0),
    "rate_ramp": ("rate ramp", "R", "output/s", 1.0),
})  # fmt: skip


def units_of(triad: str, is_scaled: bool) -> NoiseUnits:
    """Return the units of a triad's noise; ``output`` where its own is not known."""
    if not is_scaled:
        return NoiseUnits("output", 1.0, OUTPUT)
    if triad == "gyroscope":
        return NoiseUnits("deg/h", DEG_H_PER_DEG_S, GYROSCOPE)
    return NoiseUnits("ug", UG_PER_G, ACCELEROMETER)
