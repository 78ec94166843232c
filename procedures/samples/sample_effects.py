"""What acts sample by sample: periodic errors, lines, channels that act at once or lagged, rectified vibration.

They have no columns at the nodes of a step, since they vanish in its mean. The likeliest is taken off, and the
rest looked at again, until nothing is likelier than not. Every candidate, lag and sensor has its share of the
prior.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.effects.effect import INSTRUMENT, Kind
from procedures.frames import AXES, TRIADS
from procedures.inference import odds
from procedures.inference.result import (
    Because,
    Diagnosis,
    Finding,
    FoldedResidual,
    Reason,
    ResidualRms,
    verdict_of,
)
from procedures.samples.held_samples import Scales, records_at_rest
from procedures.samples.sample_blocks import (
    Columns,
    Fitted,
    SampleBlocks,
    detrended,
    fit_scores,
    sample_blocks,
    scores_of,
)
from procedures.samples.sample_lines import coherent_line, repeated_lines
from procedures.samples.sample_phases import (
    Phase,
    channel_phases,
    count_phases,
    is_rounded,
    left_by_phase,
    with_linear,
    with_order,
)
from procedures.samples.sample_rectification import by_variance, rectified, steady_channels
from procedures.samples.sample_turns import periodic_in_turns
from procedures.statistics.spectrum import lines_of
from procedures.units import DEG_H_PER_DEG_S, UG_PER_G

BESIDE_A_LINE = 0.005  # of its frequency
TIME = "time"  # in the place of a channel: the phase of a line
MIN_LINE_SHARE = 0.02  # of a line in time, below which it is only reported with the noise
ROUNDS = 5
HARMONICS = 8  # by which a phase is found; how many it has, `with_order` finds
MAX_LAG = 64  # samples, either way
MAX_NAMED = 3  # recordings
FOLDS = 32  # parts of a turn, in which samples are shown
SEPARATE = "the channel changed on purpose, at another speed, while the unit rests"


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """Something that may act: name of the effect, columns (m, k) in groups of ``group``, what it is about.

    ``tried`` is how many that are as likely were looked at.
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


@dataclass(frozen=True, slots=True, eq=False)
class SampleEffects:
    """What was found, and the samples' rms by triad [g, deg/s]: before, after, after on blocks left out."""

    findings: tuple[Finding, ...]
    errors: tuple[ResidualRms, ...]
    folded: tuple[FoldedResidual, ...] = ()
    left: tuple[Reason, ...] = ()


def with_sample_effects(found: Diagnosis, campaigns: Sequence[Campaign], scales: Scales) -> Diagnosis:
    """Return a diagnosis with what acts sample by sample among its findings."""
    seen = sample_effects(campaigns, scales)
    turning, errors = periodic_in_turns(campaigns, scales)
    seen = replace(seen, findings=seen.findings + turning, errors=seen.errors + errors)
    new = tuple(each for each in seen.findings if not any(_is_same(each, one) for one in found.findings))
    if not new and not seen.left:
        return found
    findings, is_left = (*found.findings, *new), found.verdict in {"partly", "unexplained"} or bool(seen.left)
    return replace(
        found,
        verdict=verdict_of(findings, is_left=is_left),
        findings=findings,
        errors=(*found.errors, *seen.errors),
        folded=seen.folded,
        beside=(*found.beside, *seen.left),
    )


def _is_same(one: Finding, other: Finding) -> bool:
    return one.effect == other.effect and one.where.get("channel") == other.where.get("channel")


def sample_effects(campaigns: Sequence[Campaign], scales: Scales) -> SampleEffects:
    """Return what acts sample by sample in recordings at rest."""
    blocks = sample_blocks(records_at_rest(campaigns), scales)
    if blocks is None:
        return SampleEffects((), ())
    whole, found, before = blocks, list[SampleFinding](), list[SampleBlocks]()
    is_usable = [not is_rounded(blocks, sensor) for sensor in range(len(blocks.sensors))]
    for _ in range(ROUNDS):
        best = _best(blocks, is_usable, [one.candidate for one in found])
        if best is None:
            break
        best = _with_order(blocks, best)
        found.append(best)
        before.append(blocks)
        blocks = _without(blocks, best)
    has_phase = any(one.candidate.phase is not None for one in found)
    if not has_phase and (line := coherent_line(blocks, is_usable)) is not None:
        about, has_phase = f"{line.hertz:.6g} Hz", True
        candidate = replace(_periodic("disturbance.line", line.phase), about=about, tried=line.tried)
        found.append(SampleFinding(candidate, line.fitted))
        before.append(blocks)
        blocks = _without(blocks, found[-1])
    findings = [each for one in found for each in _findings(whole, one)]
    of_vibration = list(rectified(whole, is_usable, recordings(whole)))
    findings += of_vibration
    if not has_phase:  # else it may be the same, by its power
        findings += repeated_lines(whole, is_usable, recordings(whole))
    folded = [each for one, old in zip(found, before, strict=True) for each in _folded(one, old, blocks)]
    folded += [each for one in of_vibration for each in by_variance(whole, is_usable, one)]
    left = tuple(_left(blocks, is_usable, [one.candidate.phase for one in found]))
    return SampleEffects(tuple(findings), tuple(_errors(whole, blocks, found)), tuple(folded), left)


def _with_order(blocks: SampleBlocks, found: SampleFinding) -> SampleFinding:
    """Return a periodic error with as many harmonics as it has, and the linear term where it is likelier."""
    candidate, phase = found.candidate, found.candidate.phase
    if phase is None or candidate.is_line:
        return found
    is_linear, fits = with_order(blocks, phase, list(found.fitted))
    better = {i: fit for i, fit in fits.items() if fit.share >= found.fitted[i].share}
    if len(better) < len(found.fitted):
        return found
    order = max(fit.order for fit in better.values())
    columns = with_linear(phase, order) if is_linear else _harmonics(phase, order)
    return SampleFinding(replace(candidate, columns=columns, is_linear=is_linear), better)


def _left(blocks: SampleBlocks, is_usable: Sequence[bool], known: Sequence[Phase | None]) -> Iterator[Reason]:
    """Yield what a table by each phase of a channel, or of a finding, would explain of what is left."""
    by_phase = {(each.channel, each.period): each for each in channel_phases(blocks) if each.wraps}
    own = [each for each in known if each is not None and each.channel != "time"]
    by_phase |= {(each.channel, each.period): each for each in own}
    for phase, sensor, share in left_by_phase(blocks, list(by_phase.values()), is_usable):
        channel = blocks.sensors[sensor]
        yield Reason(Because.STRUCTURE, f"{phase.channel}, {channel.triad} {AXES[channel.axis]}", share)


def _folded(found: SampleFinding, before: SampleBlocks, after: SampleBlocks) -> Iterator[FoldedResidual]:
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


def _best(blocks: SampleBlocks, is_usable: Sequence[bool], known: Sequence[Candidate]) -> SampleFinding | None:
    """Return the best of the candidates that act, likelier than not, on some sensors."""
    found = list[SampleFinding]()
    candidates = [each for each in _candidates(blocks) if not any(_is_stated(each, one) for one in known)]
    alike = Counter(each.effect for each in candidates)
    for candidate in candidates:
        sensors = sum(is_usable) if candidate.sensor < 0 else 1
        candidate = replace(candidate, tried=candidate.tried * alike[candidate.effect] * sensors)
        scores = scores_of(blocks, candidate.columns)
        of_sensors = range(len(blocks.sensors)) if candidate.sensor < 0 else (candidate.sensor,)
        fits = {
            sensor: fit
            for sensor in of_sensors
            if is_usable[sensor]
            and (fit := fit_scores(scores, sensor, candidate.group)) is not None
            and odds.log_odds(fit.gain, candidate.tried) > 0
            and fit.share > (MIN_LINE_SHARE if candidate.is_line else 0.0)
        }
        if fits:
            found.append(SampleFinding(candidate, fits))
    return max(found, key=lambda each: each.predicts(blocks.rates[:, :, 0].size), default=None)


def _is_stated(one: Candidate, known: Candidate) -> bool:
    """Say whether a candidate is known, or a line beside a known one: a line that comes and goes has such."""
    if one.phase is None or known.phase is None or not (one.is_line and known.is_line):
        return one.about == known.about
    return abs(one.phase.period / known.phase.period - 1) < BESIDE_A_LINE


def _candidates(blocks: SampleBlocks) -> Iterator[Candidate]:
    for phase in channel_phases(blocks):
        yield _periodic("auxiliary.periodic", phase)
    for phase in count_phases(blocks):
        triad = blocks.sensors[phase.sensor].triad
        yield _periodic(f"{triad}.count_periodic", phase)
    for name, values in blocks.auxiliary.items():
        lag = _lag(blocks, values)
        yield Candidate("auxiliary.channel", f"{name} itself", _lagged(values, lag), 1, 2 * MAX_LAG + 1, lag=lag)
    yield from _lines(blocks)


def _periodic(effect: str, phase: Phase) -> Candidate:
    about = f"{phase.channel} mod {phase.period:.6g}"
    return Candidate(effect, about, _harmonics(phase, HARMONICS), 2, phase.tried, phase.sensor, phase)


def _harmonics(phase: Phase, order: int) -> Columns:
    return lambda number, part: phase.columns(number, part, order)


def _lines(blocks: SampleBlocks) -> Iterator[Candidate]:
    """Yield the strongest line in time of each sensor, in a recording that stands alone."""
    if len(blocks.channels) > 1 or len(blocks.sensors[0].parts) > 1:
        return
    for sensor in range(len(blocks.sensors)):
        lines = lines_of(blocks.rates[:, :, sensor].ravel(), blocks.period)
        if lines and lines[0].share > MIN_LINE_SHARE:
            samples = len(blocks.sensors[0].rate)
            turns: FloatArray = lines[0].hertz * blocks.period * np.arange(samples).astype(np.float64)
            phase = Phase(TIME, 1 / lines[0].hertz, (turns,), samples // 2)
            yield replace(_periodic("disturbance.line", phase), about=f"{lines[0].hertz:.5g} Hz")


def _lag(blocks: SampleBlocks, values: tuple[FloatArray, ...]) -> int:
    """Return the lag [samples] at which a channel goes with any sensor most."""
    most = min(MAX_LAG, (blocks.blocks[0][1].stop - blocks.blocks[0][1].start) // 4)
    lags = np.arange(-most, most + 1)
    total, size = np.zeros((len(lags), len(blocks.sensors))), np.zeros(len(blocks.sensors))
    for number, part, e in blocks.each():
        n = len(e)
        a = np.fft.rfft(detrended(values[number][part, None]), 2 * n, axis=0)
        together = np.fft.irfft(np.fft.rfft(e, 2 * n, axis=0) * np.conj(a), 2 * n, axis=0)
        total += together[lags]
        size += np.sum(e * e, axis=0)
    return int(lags[np.argmax(np.max(np.abs(total) / np.sqrt(np.maximum(size, 1e-300)), axis=1))])


def _lagged(values: tuple[FloatArray, ...], lag: int) -> Columns:
    def columns(number: int, part: slice) -> FloatArray:
        index = np.clip(np.arange(part.start, part.stop) - lag, 0, len(values[number]) - 1)
        found: FloatArray = values[number][index, None]
        return found

    return columns


def _without(blocks: SampleBlocks, found: SampleFinding) -> SampleBlocks:
    """Return the samples less what a finding does."""
    rates = blocks.rates.copy()
    for i, (number, part) in enumerate(blocks.blocks):
        H = detrended(found.candidate.columns(number, part))
        for sensor, fit in found.fitted.items():
            rates[i, :, sensor] -= H[:, : len(fit.value)] @ fit.value
    return replace(blocks, rates=rates)


def _findings(blocks: SampleBlocks, found: SampleFinding) -> Iterator[Finding]:
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
        std.append(np.sqrt(np.diag(fit.covariance)) * factor)
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
    separate = SEPARATE
    if candidate.is_line and candidate.phase is not None:
        hertz = candidate.phase.step / blocks.period
        if turning := steady_channels(blocks, hertz):
            aliases = ("auxiliary.periodic",)
            separate = f"{', '.join(turning)} at another speed"
    one = Finding(
        effect, kind, tuple(names), np.concatenate(value), np.concatenate(std), unit, where, probability,
        separate, _shape(blocks, candidate, fits), max(f.share for f in fits.values()),
    )  # fmt: skip
    return one.or_else(*aliases) if aliases else one


def recordings(blocks: SampleBlocks) -> list[str]:
    """Return the recordings' names, of many the first and how many more."""
    names = sorted({found[0].recording for found in blocks.channels})
    return names if len(names) <= MAX_NAMED else [names[0], f"{len(names) - 1} more"]


def _shape(blocks: SampleBlocks, candidate: Candidate, fits: dict[int, Fitted]) -> str:
    """Return period, harmonics or lag in words, and what the sample rate may have folded."""
    if candidate.phase is None:
        return f"{candidate.lag * blocks.period:.4g} s after the channel"
    order = max(fit.order for fit in fits.values())
    harmonics = "1 harmonic" if order == 1 else f"{order} harmonics"
    if candidate.is_line:
        folded = f"it may be any multiple of {1 / blocks.period:.5g} Hz away"
        return f"{1 / candidate.phase.period:.6g} Hz, {harmonics}; {folded}"
    folded = ", folded by the sample rate" if order * candidate.phase.step > 0.5 else ""
    harmonics += " and a linear term by the turn" if candidate.is_linear else ""
    return f"period {candidate.phase.period:.6g} of {candidate.phase.channel}, {harmonics}{folded}"


def _errors(whole: SampleBlocks, left: SampleBlocks, found: Sequence[SampleFinding]) -> Iterator[ResidualRms]:
    """Yield the samples' rms of each triad whose sensors something acts on, less each block's own line."""
    for triad in TRIADS:
        touched = sorted({s for one in found for s in one.fitted if whole.sensors[s].triad == triad})
        if not touched:
            continue
        factor, unit = (DEG_H_PER_DEG_S, "deg/h") if triad == "gyroscope" else (UG_PER_G, "ug")
        before, after = (_mean_squares(blocks)[touched] for blocks in (whole, left))
        kept = [np.prod([1 - one.fitted[s].share for one in found if s in one.fitted]) for s in touched]
        rms = [factor * float(np.sqrt(np.mean(each))) for each in (before, after, before * np.array(kept))]
        yield ResidualRms(f"{triad} samples", unit, rms[0], rms[1], rms[0], rms[2])


def _mean_squares(blocks: SampleBlocks) -> FloatArray:
    """Return the variance (s,) of every sensor within blocks."""
    found: FloatArray = np.mean(blocks.rates**2, axis=(0, 1))
    return found
