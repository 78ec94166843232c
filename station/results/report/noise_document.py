"""The noise of channels as `noise/1` (docs/reference/file-formats.md), the same in `diagnosis/2`; and as text."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, log
from types import MappingProxyType
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.samples.channel_noise import ChannelNoise, channel_noise
from procedures.samples.held_samples import constant_channels, known_scales, records_at_rest
from procedures.statistics.allan_deviation import NoiseTerm
from procedures.statistics.spectrum import Line
from procedures.units import DEG_H_PER_DEG_S, STANDARD_GRAVITY, UG_PER_G
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.diagnosis.finding_wording import p_text
from station.results.diagnosis.uncalibrated import output_unit
from station.results.result_formats import IS_NULLABLE
from station.results.solution_json import Provenance, provenance
from station.results.solution_text import measured
from station.text import plural, significant, unit_in_words

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
DIGITS = 2  # of a term in a table, whose interval is some percent
MAX_LINES_IN_WORDS = 6
NO_FIT_LOG10_P = -2.0


@dataclass(frozen=True, slots=True)
class Term:
    """A noise term in its ``unit`` with its 95 % interval; ``value`` is None where it is not determined."""

    name: str
    symbol: str
    unit: str
    value: float | None = field(metadata=IS_NULLABLE)
    low: float | None = None
    high: float | None = None

    @property
    def text(self) -> str:
        """The term with its interval."""
        if self.value is None:
            return "not determined"
        return f"{self.value:.3g} {self.unit}, {self.low:.3g} to {self.high:.3g}"

    @property
    def cells(self) -> tuple[str, str]:
        """Its value, or what stands in its place, and its interval."""
        if self.value is None or self.low is None or self.high is None:
            return "not determined", ""
        value, low, high = (significant(each, DIGITS) for each in (self.value, self.low, self.high))
        return value, f"[{low}, {high}]"


@dataclass(frozen=True, slots=True)
class TermBelow:
    """A noise term that the curve does not show, and its bound."""

    name: str
    symbol: str
    unit: str
    below: float

    @property
    def text(self) -> str:
        """The bound in words."""
        return f"not detected, below {self.below:.3g} {self.unit}"

    @property
    def cells(self) -> tuple[str, str]:
        """The bound, and no interval."""
        return f"< {significant(self.below, DIGITS)}", ""


@dataclass(frozen=True, slots=True)
class NoiseCondition:
    """A condition of the recording, by its stable name, and the terms that it leaves undetermined."""

    name: str
    text: str
    undetermined: Sequence[str]
    values: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class MeanOutput:
    """The mean of a channel."""

    value: float
    unit: str


@dataclass(frozen=True, slots=True)
class AllanCurve:
    """Deviations with 95 % limits in ``unit`` by averaging time [s], and their equivalent degrees of freedom."""

    tau_s: Sequence[float]
    unit: str
    edf: Sequence[float]
    deviation: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]


@dataclass(frozen=True, slots=True)
class SpectrumCurve:
    """A one-sided density in ``unit`` by frequency [Hz]."""

    hertz: Sequence[float]
    density: Sequence[float]
    unit: str


@dataclass(frozen=True, slots=True)
class NoiseLine:
    """A line of a spectrum: frequency [Hz] and amplitude with u, share of the variance, chance in noise."""

    hertz: float
    hertz_std: float
    amplitude: float
    amplitude_std: float
    unit: str
    share: float
    log10_p: float

    @property
    def text(self) -> str:
        """The line in words."""
        size = measured(self.amplitude, self.amplitude_std, self.unit)
        return f"{self.hertz:.6g} Hz, {size}, {100 * self.share:.2g} % of the variance, {p_text(self.log10_p)}"


@dataclass(frozen=True, slots=True)
class NoiseChannel:
    """The noise of a channel (``gyroscope x``) in one recording at rest."""

    channel: str
    recording: str
    seconds: float
    rate_hz: float
    mean: MeanOutput
    terms: Mapping[str, Term | TermBelow]
    log10_p: float
    conditions: Sequence[NoiseCondition]
    allan: AllanCurve
    spectrum: SpectrumCurve
    lines: Sequence[NoiseLine]

    @property
    def triad(self) -> str:
        """Its triad."""
        return self.channel.split()[0]

    @property
    def axis(self) -> str:
        """Its axis."""
        return self.channel.split()[1]

    @property
    def source(self) -> str:
        """How long of which recording it is."""
        return f"{self.seconds:.4g} s of {self.recording}"

    @property
    def condition_texts(self) -> list[str]:
        """Its conditions, a text each with its stable name before it."""
        return [f"{each.name.replace('_', ' ')}: {each.text}" for each in self.conditions]

    @property
    def line_texts(self) -> list[str]:
        """Its strongest lines in words."""
        return [each.text for each in self.lines[:MAX_LINES_IN_WORDS]]


@dataclass(frozen=True, slots=True)
class NoiseDocument:
    """The noise of a unit's recordings; the fields of this and of what it holds are the keys of `noise/1`."""

    format: str
    channels: Sequence[NoiseChannel]
    left_out: Sequence[str]
    warnings: Sequence[str]
    provenance: Provenance


def noise_document(campaigns: Sequence[LoadedCampaign], solution: Any = None) -> NoiseDocument:
    """Return the noise of a unit's recordings at rest; ``solution`` gives the scale factors where there is one."""
    bare = [one.campaign for one in campaigns]
    found = channel_noise(bare, known_scales(bare, solution))
    return NoiseDocument(
        FORMAT,
        [noise_channel(each, output_unit(campaigns, each.triad)) for each in found],
        [f"{name}: never changes" for name in constant_channels(records_at_rest(bare))],
        list(dict.fromkeys(w for loaded in campaigns for w in loaded.warnings)),
        provenance(campaigns),
    )


def noise_channel(found: ChannelNoise, output: str = "output") -> NoiseChannel:
    """Return a channel's noise, in units of its ``output`` where its scale factor is not known."""
    units, curve = units_of(found.triad, found.is_scaled, output), found.curve
    seen = curve.deviation > 0
    ends = ((each[seen] * units.factor).tolist() for each in (curve.deviation, curve.low, curve.high))
    hertz, density = averaged(found.spectrum.hertz, found.spectrum.density * units.factor**2)
    return NoiseChannel(
        channel=f"{found.triad} {found.axis}",
        recording=found.recording,
        seconds=found.seconds,
        rate_hz=found.hertz,
        mean=MeanOutput(found.mean * units.factor, units.unit),
        terms={name: _term(found.fit.terms[name], units, name) for name in units.terms},
        log10_p=found.fit.log_p / log(10),
        conditions=[NoiseCondition(one.name, one.text, one.undetermined, one.values) for one in found.conditions],
        allan=AllanCurve(curve.tau[seen].tolist(), units.unit, curve.edf[seen].tolist(), *ends),
        spectrum=SpectrumCurve(hertz.tolist(), density.tolist(), f"({units.unit})^2/Hz"),
        lines=[_line(one, units) for one in found.lines],
    )


def read_channel(stated: Mapping[str, Any]) -> NoiseChannel:
    """Return a channel of a `noise/1` or `diagnosis/2`."""
    parts = {
        "mean": MeanOutput(**stated["mean"]),
        "terms": {n: TermBelow(**t) if "below" in t else Term(**t) for n, t in stated["terms"].items()},
        "conditions": [NoiseCondition(**one) for one in stated["conditions"]],
        "allan": AllanCurve(**stated["allan"]),
        "spectrum": SpectrumCurve(**stated["spectrum"]),
        "lines": [NoiseLine(**one) for one in stated["lines"]],
    }
    return NoiseChannel(**{**stated, **parts})


def _term(term: NoiseTerm, units: NoiseUnits, key: str) -> Term | TermBelow:
    name, symbol, unit, factor = units.terms[key]
    factor *= units.factor
    if term.value is not None:
        return Term(name, symbol, unit, term.value * factor, term.low * factor, term.high * factor)
    if isfinite(term.high):
        return TermBelow(name, symbol, unit, term.high * factor)
    return Term(name, symbol, unit, None)


def _line(line: Line, units: NoiseUnits) -> NoiseLine:
    size, std = line.amplitude * units.factor, line.amplitude_std * units.factor
    return NoiseLine(line.hertz, line.hertz_std, size, std, units.unit, line.share, line.log_p / log(10))


def averaged(hertz: FloatArray, density: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return ``hertz`` (n,) and ``density`` (n,), any unit, averaged to at most `SPECTRUM_POINTS`."""
    edges = np.unique(np.searchsorted(hertz, np.geomspace(hertz[0], hertz[-1], SPECTRUM_POINTS + 1)))
    edges = edges[edges < len(hertz)]
    count = np.diff(np.append(edges, len(hertz)))
    return np.add.reduceat(hertz, edges) / count, np.add.reduceat(density, edges) / count


def noise_text(document: NoiseDocument) -> str:
    """Return the summary that ``station noise`` prints: every term with its 95 % interval, or its bound."""
    origin = document.provenance
    who, files = unit_in_words(origin.model, origin.serial), plural(len(origin.files), "file")
    lines = [f"{who}: {files}, 95 % intervals", *(line for each in document.channels for line in _lines(each))]
    lines += [f"left out: {text}" for text in document.left_out]
    return "\n".join([*lines, *(f"warning: {text}" for text in document.warnings)])


def _lines(one: NoiseChannel) -> Iterator[str]:
    """Yield what is reported of a channel."""
    yield f"{one.channel}, {one.source} at {_rates_text(one)}"
    yield from (f"   {term.name + ' ' + term.symbol:<24}{term.text}" for term in one.terms.values())
    yield from (f"   {text}" for text in one.condition_texts)
    rest = [term for name, term in one.terms.items() if name != "quantisation"]
    if all(isinstance(term, TermBelow) for term in rest) and not one.conditions:
        yield "   count size or rounding hides the other terms"
    elif one.log10_p < NO_FIT_LOG10_P:
        yield "   the five terms do not fit this curve: their intervals are widened by the misfit"
    yield from (f"   {'line':<24}{text}" for text in one.line_texts)
    if more := one.lines[MAX_LINES_IN_WORDS:]:
        yield f"   and {plural(len(more), 'weaker line')}"


def _rates_text(channel: NoiseChannel) -> str:
    """Return the rate of the rows, and that of the sensor where a condition says it is another."""
    own = [each.values["sensor_hz"] for each in channel.conditions if "sensor_hz" in each.values]
    return f"{channel.rate_hz:.5g} Hz" + (f" (sensor {own[-1]:.5g} Hz)" if own else "")


def noise_summary(channels: Sequence[NoiseChannel]) -> Iterator[str]:
    """Yield a line for every channel: the terms that its curve shows, and how many lines its spectrum has."""
    for each in channels:
        terms = [one for one in each.terms.values() if isinstance(one, Term) and one.value is not None]
        seen = [f"{one.symbol} {one.value:.3g} {one.unit}" for one in terms]
        lines = [plural(len(each.lines), "line")] if each.lines else []
        named = [one.name.replace("_", " ") for one in each.conditions]
        yield f"{each.channel:<16}{', '.join([*seen, *lines, *named])}"
