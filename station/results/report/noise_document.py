"""The noise of channels as `noise/1` (docs/reference/file-formats.md), the same in `diagnosis/2`; and as text."""

from collections.abc import Iterator, Mapping, Sequence
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
from station.results.diagnosis.finding_wording import p_text
from station.results.diagnosis.uncalibrated import output_unit
from station.results.solution_json import provenance
from station.results.solution_text import measured
from station.text import plural, unit_in_words

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
OUTPUT: Terms = MappingProxyType({  # each in what follows the unit of the output
    "quantisation": ("quantisation", "Q", " s", 1.0),
    "random_walk": ("random walk", "N", " sqrt(s)", 1.0),
    "bias_instability": ("bias instability", "B", "", 1.0),
    "rate_random_walk": ("rate random walk", "K", "/sqrt(s)", 1.0),
    "rate_ramp": ("rate ramp", "R", "/s", 1.0),
})  # fmt: skip


def units_of(triad: str, is_scaled: bool, output: str = "output") -> NoiseUnits:
    """Return the units of a triad's noise; those of its ``output`` where its scale factor is not known."""
    if not is_scaled:
        terms = {
            key: (name, sign, f"{output}{unit}", factor) for key, (name, sign, unit, factor) in OUTPUT.items()
        }
        return NoiseUnits(output, 1.0, terms)
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
        "channels": [channel_document(each, output_unit(campaigns, each.triad)) for each in found],
        "left_out": [f"{name}: never changes" for name in constant_channels(records_at_rest(bare))],
        "warnings": list(dict.fromkeys(w for loaded in campaigns for w in loaded.warnings)),
        "provenance": provenance(campaigns),
    }


def channel_document(found: ChannelNoise, output: str = "output") -> dict[str, Any]:
    """Return a channel's noise, in units of its ``output`` where its scale factor is not known."""
    units, curve = units_of(found.triad, found.is_scaled, output), found.curve
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
    text, symbol, unit, factor = units.terms[name]
    term, factor = found.fit.terms[name], factor * units.factor
    known = {"name": text, "symbol": symbol, "unit": unit}
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


MAX_LINES_IN_WORDS = 6
NO_FIT_LOG10_P = -2.0


def noise_text(document: Mapping[str, Any]) -> str:
    """Return the summary that ``station noise`` prints: every term with its 95 % interval, or its bound."""
    origin = document["provenance"]
    who, files = unit_in_words(origin["model"], origin["serial"]), plural(len(origin["files"]), "file")
    wording = [f"{who}: {files}, 95 % intervals"]
    wording += noise_lines(document["channels"])
    wording += [f"left out: {text}" for text in document["left_out"]]
    return "\n".join([*wording, *(f"warning: {text}" for text in document["warnings"])])


def noise_lines(channels: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield what is reported of every channel."""
    for each in channels:
        yield f"{each['channel']}, {each['seconds']:.4g} s of {each['recording']} at {_rates_text(each)}"
        for term in each["terms"].values():
            yield f"   {term['name'] + ' ' + term['symbol']:<24}{term_text(term)}"
        yield from (f"   {each_text}" for each_text in condition_texts(each))
        rest = [term for name, term in each["terms"].items() if name != "quantisation"]
        if all("below" in term for term in rest) and not each["conditions"]:
            yield "   count size or rounding hides the other terms"
        elif each["log10_p"] < NO_FIT_LOG10_P:
            yield "   the five terms do not fit this curve: their intervals are widened by the misfit"
        for line in each["lines"][:MAX_LINES_IN_WORDS]:
            yield f"   {'line':<24}{line_text(line)}"
        if more := each["lines"][MAX_LINES_IN_WORDS:]:
            yield f"   and {plural(len(more), 'weaker line')}"


def _rates_text(channel: Mapping[str, Any]) -> str:
    """Return the rate of the rows, and that of the sensor where a condition says it is another."""
    own = [each["values"]["sensor_hz"] for each in channel["conditions"] if "sensor_hz" in each["values"]]
    sensor = f" (sensor {own[-1]:.5g} Hz)" if own else ""
    return f"{channel['rate_hz']:.5g} Hz{sensor}"


def noise_summary(channels: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield a line for every channel: the terms that its curve shows, and how many lines its spectrum has."""
    for each in channels:
        seen = [
            f"{t['symbol']} {t['value']:.3g} {t['unit']}"
            for t in each["terms"].values()
            if t.get("value") is not None
        ]
        lines = [plural(len(each["lines"]), "line")] if each["lines"] else []
        named = [one["name"].replace("_", " ") for one in each["conditions"]]
        yield f"{each['channel']:<16}{', '.join([*seen, *lines, *named])}"


def term_text(term: Mapping[str, Any]) -> str:
    """Return a term with its interval, or the bound where the curve does not show it."""
    if is_undetermined(term):
        return "not determined"
    if "below" in term:
        return f"not detected, below {term['below']:.3g} {term['unit']}"
    return f"{term['value']:.3g} {term['unit']}, {term['low']:.3g} to {term['high']:.3g}"


def is_undetermined(term: Mapping[str, Any]) -> bool:
    """Say whether a term has neither value nor bound."""
    return term.get("value", 0.0) is None


def condition_texts(channel: Mapping[str, Any]) -> list[str]:
    """Return a channel's conditions, a text each with its stable name before it."""
    return [f"{each['name'].replace('_', ' ')}: {each['text']}" for each in channel["conditions"]]


def line_text(line: Mapping[str, Any]) -> str:
    """Return a line's frequency, amplitude, share of the variance and chance."""
    size = measured(line["amplitude"], line["amplitude_std"], line["unit"])
    share = f"{100 * line['share']:.2g} % of the variance"
    return f"{line['hertz']:.6g} Hz, {size}, {share}, {p_text(line['log10_p'])}"
