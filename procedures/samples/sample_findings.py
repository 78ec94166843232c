"""Causes that act sample by sample, and what was found of them as findings.

A candidate has columns; what it does to each sensor becomes coefficients with their covariance, words, errors and
means by phase.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects import EFFECTS
from procedures.effects.effect import INSTRUMENT, Kind
from procedures.frames import AXES, TRIADS
from procedures.inference import odds
from procedures.inference.result import Finding, FoldedResidual, ResidualRms
from procedures.samples.sample_blocks import Columns, Fitted, SampleBlocks, detrended
from procedures.samples.sample_phases import Phase
from procedures.samples.sample_rectification import steady_channels
from procedures.statistics.spectrum import Line, has_line
from procedures.units import DEG_H_PER_DEG_S, UG_PER_G

TIME = "time"  # in the place of a channel: the phase of a line
HARMONICS = 8  # by which a phase is found; how many it has, `with_order` finds
MIN_LINE_SHARE = 0.02  # of a line in time, below which it is only reported with the noise


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """Something that may act: name of the effect, columns (m, k) in groups of ``group``, what it is about.

    ``tried`` is how many that are as likely were looked at. ``hertz_std`` [Hz] is 1 sigma of a line, if known.
    """

    effect: str
    about: str
    columns: Columns
    group: int
    tried: int
    sensor: int = -1
    phase: Phase | None = None
    lag: int = 0
    is_linear: bool = False
    hertz_std: float = 0.0

    @property
    def is_line(self) -> bool:
        """Say whether it is a line in time, not in the phase of a channel."""
        return self.phase is not None and self.phase.channel == TIME


@dataclass(frozen=True, slots=True, eq=False)
class SampleFinding:
    """A candidate with what it does to each sensor that it acts on, by the sensor's number."""

    candidate: Candidate
    fitted: dict[int, Fitted]

    @property
    def share(self) -> float:
        """What it explains of the sensor that it explains most of."""
        return max(fit.share for fit in self.fitted.values())

    def predicts(self, samples: int) -> float:
        """Return ln of how much likelier it makes ``samples`` of held-out blocks, its share of the prior counted.

        Of several that act, this says which: blocks are too few for their scatter to tell large gains apart.
        """
        left = [np.log1p(-min(fit.share, 1 - np.finfo(float).eps)) for fit in self.fitted.values()]
        return float(-0.5 * samples * np.sum(left) - np.log(self.candidate.tried))


def periodic(effect: str, phase: Phase) -> Candidate:
    """Return an effect that is periodic in a phase."""
    about = f"{phase.channel} mod {phase.period:.6g}"
    return Candidate(effect, about, harmonics(phase, HARMONICS), 2, phase.tried, phase.sensor, phase)


def line_in_time(line: Line, period: float, samples: int) -> Candidate:
    """Return a line of a recording of so many ``samples``, ``period`` [s] apart."""
    turns: FloatArray = line.hertz * period * np.arange(samples).astype(np.float64)
    phase = Phase(TIME, 1 / line.hertz, (turns,), samples // 2)
    return replace(periodic("disturbance.line", phase), about=f"{line.hertz:.5g} Hz", hertz_std=line.hertz_std)


def harmonics(phase: Phase, order: int) -> Columns:
    """Return the columns (m, 2 k) of a phase's first harmonics, as many as its order."""
    return lambda number, part: phase.columns(number, part, order)


def without_finding(blocks: SampleBlocks, found: SampleFinding) -> SampleBlocks:
    """Return the samples less what a finding does."""
    rates = blocks.rates.copy()
    for i, (number, part) in enumerate(blocks.blocks):
        H = detrended(found.candidate.columns(number, part))
        for sensor, fit in found.fitted.items():
            rates[i, :, sensor] -= H[:, : len(fit.value)] @ fit.value
    return replace(blocks, rates=rates)


MAX_NAMED = 3  # recordings
FOLDS = 32  # parts of a turn, in which samples are shown
SEPARATE = "the channel changed on purpose, at another speed, while the unit rests"
SEPARATE_LINE = "the recording again at another sample rate, and with machines nearby switched off"


def findings_of_samples(blocks: SampleBlocks, found: SampleFinding) -> Iterator[Finding]:
    """Yield a finding of what acts, of each triad by itself where units differ."""
    candidate = found.candidate
    for triad in TRIADS:
        fits = {s: fit for s, fit in found.fitted.items() if blocks.sensors[s].triad == triad}
        if fits:
            yield _finding(blocks, candidate, triad, fits)


def _finding(blocks: SampleBlocks, candidate: Candidate, triad: str, fits: dict[int, Fitted]) -> Finding:
    factor, unit = (DEG_H_PER_DEG_S, "deg/h") if triad == "gyroscope" else (1.0, "g")
    names, value, std = list[str](), list[FloatArray](), list[FloatArray]()
    for sensor, fit in fits.items():
        axis = AXES[blocks.sensors[sensor].axis]
        prefix = ("g" if triad == "gyroscope" else "a") + axis
        if candidate.phase is None:
            names.append(prefix)
        else:
            names += [f"{prefix}.linear"] if candidate.is_linear else []
            names += [f"{prefix}.{part}{1 + i // 2}" for i, part in enumerate(("cos", "sin") * fit.order)]
        value.append(fit.value * factor)
        std.append(_std(blocks, candidate, fit) * factor)
    probability = odds.probability(odds.log_odds(max(fit.gain for fit in fits.values()), candidate.tried))
    effect = candidate.effect
    owner = effect.split(".")[0]
    kind: Kind = "instrument" if owner in INSTRUMENT else "procedure"
    where: dict[str, object] = {"file": recordings(blocks)}
    if candidate.phase is None:
        unit, where["channel"] = f"{unit}/unit", candidate.about.removesuffix(" itself")
    elif not candidate.is_line:
        where["channel"] = candidate.phase.channel
    aliases: tuple[str, ...] = ()
    separate = SEPARATE_LINE if candidate.is_line else SEPARATE
    if candidate.is_line and candidate.phase is not None:
        hertz = candidate.phase.step / blocks.period
        if turning := steady_channels(blocks, hertz):
            aliases = ("auxiliary.periodic",)
            separate = f"{', '.join(turning)} at another speed"
        if any(
            has_line(each[0].series.temperature, blocks.period, hertz / blocks.period) for each in blocks.channels
        ):
            aliases += tuple(
                each.name for each in EFFECTS if each.driver == "temperature" and each.name.startswith(triad)
            )[:1]
    one = Finding(
        effect, kind, tuple(names), np.concatenate(value), np.concatenate(std), unit, where, probability,
        separate, _shape(blocks, candidate, fits), max(f.share for f in fits.values()),
    )  # fmt: skip
    return one.or_else(*aliases) if aliases else one


def _std(blocks: SampleBlocks, candidate: Candidate, fit: Fitted) -> FloatArray:
    """Return 1 sigma (k,) of coefficients; those of a line are of its beginning, by a frequency with its own."""
    variance = np.diag(fit.covariance)
    if candidate.hertz_std:
        seconds = len(blocks.sensors[0].rate) * blocks.period
        cosine, sine = fit.value.reshape(-1, 2).T
        turned = (
            np.pi * candidate.hertz_std * seconds * np.arange(1, len(cosine) + 1)
        )  # rad, from the middle to it
        variance = variance + np.stack((turned * sine, turned * cosine), axis=1).ravel() ** 2
    return np.sqrt(variance)


def recordings(blocks: SampleBlocks) -> list[str]:
    """Return the recordings' names, of many the first and how many more."""
    names = sorted({found[0].recording for found in blocks.channels})
    return names if len(names) <= MAX_NAMED else [names[0], f"{len(names) - 1} more"]


def with_std(value: float, std: float) -> str:
    """Return a frequency with two digits of its 1 sigma, and to the same place; six digits where none is known."""
    if not std > 0:
        return f"{value:.6g}"
    places = max(1 - math.floor(math.log10(std)), 0)
    return f"{value:.{places}f} +- {std:.{places}f}"


def _shape(blocks: SampleBlocks, candidate: Candidate, fits: dict[int, Fitted]) -> str:
    """Return period, harmonics or lag in words, and what the sample rate may have folded."""
    if candidate.phase is None:
        return f"{candidate.lag * blocks.period:.4g} s after the channel"
    order = max(fit.order for fit in fits.values())
    harmonics = "1 harmonic" if order == 1 else f"{order} harmonics"
    if candidate.is_line:
        folded = f"it may be any multiple of {1 / blocks.period:.5g} Hz away"
        return f"{with_std(1 / candidate.phase.period, candidate.hertz_std)} Hz, {harmonics}; {folded}"
    folded = ", folded by the sample rate" if order * candidate.phase.step > 0.5 else ""
    harmonics += " and a linear term by the turn" if candidate.is_linear else ""
    return f"period {candidate.phase.period:.6g} of {candidate.phase.channel}, {harmonics}{folded}"


def sample_errors(
    whole: SampleBlocks, left: SampleBlocks, found: Sequence[SampleFinding], slow: Sequence[SampleFinding]
) -> Iterator[ResidualRms]:
    """Yield the samples' rms of each triad whose sensors something acts on, less each block's own line.

    The blocks have no ``slow`` lines, whose power is added to what was before.
    """
    power = np.zeros(len(whole.sensors))
    for one in slow:
        for sensor, fit in one.fitted.items():
            power[sensor] += fit.value @ fit.value / 2
    every = (*slow, *found)
    for triad in TRIADS:
        touched = sorted({s for one in every for s in one.fitted if whole.sensors[s].triad == triad})
        if not touched:
            continue
        factor, unit = (DEG_H_PER_DEG_S, "deg/h") if triad == "gyroscope" else (UG_PER_G, "ug")
        before, after = (_mean_squares(whole) + power)[touched], _mean_squares(left)[touched]
        kept = [np.prod([1 - one.fitted[s].share for one in every if s in one.fitted]) for s in touched]
        rms = [factor * float(np.sqrt(np.mean(each))) for each in (before, after, before * np.array(kept))]
        yield ResidualRms(f"{triad} samples", unit, rms[0], rms[1], rms[0], rms[2])


def _mean_squares(blocks: SampleBlocks) -> FloatArray:
    """Return the variance (s,) of every sensor within blocks."""
    found: FloatArray = np.mean(blocks.rates**2, axis=(0, 1))
    return found


def folded_by_phase(found: SampleFinding, before: SampleBlocks, after: SampleBlocks) -> Iterator[FoldedResidual]:
    """Yield the samples of every sensor that a periodic finding is of, by its phase."""
    phase = found.candidate.phase
    if phase is None:
        return
    parts = [phase.turns[number][part] for number, part in before.blocks]
    at = (np.concatenate(parts) % 1.0 * FOLDS).astype(np.int64) % FOLDS
    count = np.maximum(np.bincount(at, minlength=FOLDS), 1)
    for sensor in found.fitted:
        channel = before.sensors[sensor]
        factor, unit = (DEG_H_PER_DEG_S, "deg/h") if channel.triad == "gyroscope" else (UG_PER_G, "ug")
        means = [
            factor * np.bincount(at, one.rates[:, :, sensor].ravel(), FOLDS) / count for one in (before, after)
        ]
        sigma: FloatArray = factor * np.std(after.rates[:, :, sensor]) / np.sqrt(count)
        yield FoldedResidual(
            found.candidate.effect, found.candidate.about, channel.triad, channel.axis, unit,
            (np.arange(FOLDS) + 0.5) / FOLDS, means[0], means[1], sigma,
        )  # fmt: skip
