"""The noise of channels as `noise/1` (docs/reference/file-formats.md), the same in `diagnosis/2`; its units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, log
from types import MappingProxyType
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.samples.channel_noise import ChannelNoise, channel_noise
from procedures.samples.held_samples import constant_channels, known_scales, records_at_rest
from procedures.statistics.noise_conditions import Condition
from procedures.statistics.spectrum import Line
from procedures.units import DEG_H_PER_DEG_S, STANDARD_GRAVITY, UG_PER_G
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.solution_json import provenance

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


FORMAT = "noise/1"
SPECTRUM_POINTS = 240  # to which a spectrum is averaged, even in the logarithm


def noise_document(campaigns: Sequence[LoadedCampaign], solution: Any = None) -> dict[str, Any]:
    """Return the noise of a unit's recordings at rest; ``solution`` gives the scale factors where there is one."""
    bare = [one.campaign for one in campaigns]
    found = channel_noise(bare, known_scales(bare, solution))
    return {
        "format": FORMAT,
        "channels": [channel_document(each) for each in found],
        "left_out": [f"{name}: never changes" for name in constant_channels(records_at_rest(bare))],
        "warnings": list(dict.fromkeys(w for loaded in campaigns for w in loaded.warnings)),
        "provenance": provenance(campaigns),
    }


def channel_document(found: ChannelNoise) -> dict[str, Any]:
    """Return a channel's noise."""
    units, curve = units_of(found.triad, found.is_scaled), found.curve
    seen = curve.deviation > 0
    allan = {"tau_s": curve.tau[seen].tolist(), "unit": units.unit, "edf": curve.edf[seen].tolist()}
    for name in ("deviation", "low", "high"):
        allan[name] = (getattr(curve, name)[seen] * units.factor).tolist()
    hertz, density = averaged(found.spectrum.hertz, found.spectrum.density * units.factor**2)
    return {
        "channel": f"{found.triad} {found.axis}",
        "recording": found.recording,
        "seconds": found.seconds,
        "rate_hz": found.hertz,
        "mean": {"value": found.mean * units.factor, "unit": units.unit},
        "terms": {name: _term(found, name, units) for name in units.terms},
        "log10_p": found.fit.log_p / log(10),
        "conditions": [_condition(each) for each in found.conditions],
        "allan": allan,
        "spectrum": {"hertz": hertz.tolist(), "density": density.tolist(), "unit": f"({units.unit})^2/Hz"},
        "lines": [_line(line, units) for line in found.lines],
    }


def _term(found: ChannelNoise, name: str, units: NoiseUnits) -> Mapping[str, Any]:
    said, symbol, unit, factor = units.terms[name]
    term, factor = found.fit.terms[name], factor * units.factor
    known = {"name": said, "symbol": symbol, "unit": unit}
    if term.value is None and not isfinite(term.high):
        return known | {"value": None}
    if term.value is None:
        return known | {"below": term.high * factor}
    return known | {"value": term.value * factor, "low": term.low * factor, "high": term.high * factor}


def _condition(found: Condition) -> dict[str, Any]:
    return {
        "name": found.name, "text": found.text, "undetermined": list(found.undetermined),
        "values": dict(found.values),
    }  # fmt: skip


def _line(line: Line, units: NoiseUnits) -> dict[str, Any]:
    return {
        "hertz": line.hertz, "hertz_std": line.hertz_std, "amplitude": line.amplitude * units.factor,
        "amplitude_std": line.amplitude_std * units.factor, "unit": units.unit, "share": line.share,
        "log10_p": line.log_p / log(10),
    }  # fmt: skip


def averaged(hertz: FloatArray, density: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return ``hertz`` (n,) and ``density`` (n,), any unit, averaged to at most `SPECTRUM_POINTS`."""
    edges = np.unique(np.searchsorted(hertz, np.geomspace(hertz[0], hertz[-1], SPECTRUM_POINTS + 1)))
    edges = edges[edges < len(hertz)]
    count = np.diff(np.append(edges, len(hertz)))
    return np.add.reduceat(hertz, edges) / count, np.add.reduceat(density, edges) / count
