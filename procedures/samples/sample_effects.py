"""What acts sample by sample: periodic errors, lines, channels that act at once or lagged, rectified vibration.

They have no columns at the nodes of a step, since they vanish in its mean. The likeliest is subtracted, and the
rest looked at again, until nothing is likelier than not. Every candidate, lag and sensor has its share of the
prior.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.frames import AXES
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
from procedures.samples.sample_blocks import Columns, SampleBlocks, detrended, fit_scores, sample_blocks, scores_of
from procedures.samples.sample_findings import (
    MIN_LINE_SHARE,
    Candidate,
    SampleFinding,
    findings_of_samples,
    folded_by_phase,
    harmonics,
    line_in_time,
    periodic,
    recordings,
    sample_errors,
    without_finding,
)
from procedures.samples.sample_lines import coherent_line, repeated_lines, without_slow_lines
from procedures.samples.sample_phases import (
    Phase,
    channel_phases,
    count_phases,
    is_rounded,
    left_by_phase,
    with_linear,
    with_order,
)
from procedures.samples.sample_rectification import by_variance, rectified
from procedures.samples.sample_turns import periodic_in_turns
from procedures.statistics.spectrum import lines_of

SIDEBAND = 0.005  # of a line's frequency
ROUNDS = 5
MAX_LAG = 64  # samples, either way


@dataclass(frozen=True, slots=True, eq=False)
class SampleEffects:
    """What was found, and the samples' rms by triad [g, deg/s]: before, after, after on blocks left out."""

    findings: tuple[Finding, ...]
    errors: tuple[ResidualRms, ...]
    folded: tuple[FoldedResidual, ...] = ()
    left: tuple[Reason, ...] = ()


def with_sample_effects(found: Diagnosis, campaigns: Sequence[Campaign], scales: Scales) -> Diagnosis:
    """Return a diagnosis with what acts sample by sample among its findings."""
    seen = sample_effects(campaigns, scales, found.findings)
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
        other_reasons=(*found.other_reasons, *seen.left),
    )


def _is_same(one: Finding, other: Finding) -> bool:
    return one.effect == other.effect and one.where.get("channel") == other.where.get("channel")


def sample_effects(campaigns: Sequence[Campaign], scales: Scales, named: Sequence[Finding] = ()) -> SampleEffects:
    """Return what acts sample by sample in recordings at rest; slow lines may be ``named`` already."""
    blocks = sample_blocks(records_at_rest(campaigns), scales)
    if blocks is None:
        return SampleEffects((), ())
    is_usable = [not is_rounded(blocks, sensor) for sensor in range(len(blocks.sensors))]
    whole, found, before = blocks, list[SampleFinding](), list[SampleBlocks]()
    slow, of_slow = list[SampleFinding](), list[FoldedResidual]()
    is_searched = False  # for slow lines, before lines of blocks and after what goes with a channel
    while len(found) < ROUNDS:
        best = _best(blocks, is_usable, [one.candidate for one in found])
        if not is_searched and (best is None or best.candidate.is_line):
            blocks, slow, of_slow = without_slow_lines(blocks, is_usable, named, found)
            is_searched = True
            continue
        if best is None:
            break
        best = _with_order(blocks, best)
        found.append(best)
        before.append(blocks)
        blocks = without_finding(blocks, best)
    has_phase = any(one.candidate.phase is not None for one in found)
    if not has_phase and (line := coherent_line(blocks, is_usable)) is not None:
        about, has_phase = f"{line.hertz:.6g} Hz", True
        candidate = replace(periodic("disturbance.line", line.phase), about=about, tried=line.tried)
        found.append(SampleFinding(candidate, line.fitted))
        before.append(blocks)
        blocks = without_finding(blocks, found[-1])
    for one in slow:
        whole = without_finding(whole, one)
    findings = [each for one in (*slow, *found) for each in findings_of_samples(whole, one)]
    of_vibration = list(rectified(whole, is_usable, recordings(whole)))
    findings += of_vibration
    if not has_phase:  # else it may be the same, by its power
        findings += repeated_lines(whole, is_usable, recordings(whole))
    folded = [
        *of_slow,
        *(each for one, old in zip(found, before, strict=True) for each in folded_by_phase(one, old, blocks)),
    ]
    folded += [each for one in of_vibration for each in by_variance(whole, is_usable, one)]
    left = tuple(_left(blocks, is_usable, [one.candidate.phase for one in found]))
    return SampleEffects(tuple(findings), tuple(sample_errors(whole, blocks, found, slow)), tuple(folded), left)


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
    columns = with_linear(phase, order) if is_linear else harmonics(phase, order)
    return SampleFinding(replace(candidate, columns=columns, is_linear=is_linear), better)


def _left(blocks: SampleBlocks, is_usable: Sequence[bool], known: Sequence[Phase | None]) -> Iterator[Reason]:
    """Yield what a table by each phase of a channel, or of a finding, would explain of what is left."""
    by_phase = {(each.channel, each.period): each for each in channel_phases(blocks) if each.wraps}
    own = [each for each in known if each is not None and each.channel != "time"]
    by_phase |= {(each.channel, each.period): each for each in own}
    for phase, sensor, share in left_by_phase(blocks, list(by_phase.values()), is_usable):
        channel = blocks.sensors[sensor]
        yield Reason(Because.STRUCTURE, f"{phase.channel}, {channel.triad} {AXES[channel.axis]}", share)


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
    """Say whether a candidate is known, or a line next to a known one: a line that comes and goes has such."""
    if one.phase is None or known.phase is None or not (one.is_line and known.is_line):
        return one.about == known.about
    return abs(one.phase.period / known.phase.period - 1) < SIDEBAND


def _candidates(blocks: SampleBlocks) -> Iterator[Candidate]:
    for phase in channel_phases(blocks):
        yield periodic("auxiliary.periodic", phase)
    for phase in count_phases(blocks):
        triad = blocks.sensors[phase.sensor].triad
        yield periodic(f"{triad}.count_periodic", phase)
    for name, values in blocks.auxiliary.items():
        lag = _lag(blocks, values)
        yield Candidate("auxiliary.channel", f"{name} itself", _lagged(values, lag), 1, 2 * MAX_LAG + 1, lag=lag)
    yield from _lines(blocks)


def _lines(blocks: SampleBlocks) -> Iterator[Candidate]:
    """Yield the strongest line in time of each sensor, in a recording that stands alone."""
    if len(blocks.channels) > 1 or len(blocks.sensors[0].parts) > 1:
        return
    for sensor in range(len(blocks.sensors)):
        lines = lines_of(blocks.rates[:, :, sensor].ravel(), blocks.period)
        if lines and lines[0].share > MIN_LINE_SHARE:
            yield line_in_time(lines[0], blocks.period, len(blocks.sensors[0].rate))


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
