"""Lines slower than a block of samples: its own straight line takes them, so the whole recording shows them.

Frequency and sine are those of the whole recording's spectrum. A line that is a cycle of the bias, or of a
temperature that the bias follows, has its name already.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects import CATALOGUE
from procedures.effects.excitation import PERIOD
from procedures.inference import odds
from procedures.inference.result import Finding, FoldedResidual
from procedures.samples.sample_blocks import Fitted, SampleBlocks
from procedures.samples.sample_candidates import (
    MIN_LINE_SHARE,
    SampleFinding,
    line_in_time,
    without_finding,
)
from procedures.samples.sample_findings import folded_by_phase
from procedures.statistics.spectrum import (
    BACKGROUND_DOF,
    Line,
    has_line,
    lines_of,
    sine_at,
    without_straight_line,
)


def without_slow_lines(
    blocks: SampleBlocks, is_usable: Sequence[bool], named: Sequence[Finding]
) -> tuple[SampleBlocks, list[SampleFinding], list[FoldedResidual]]:
    """Return blocks less the lines that are slower than they are, and those that no finding in ``named`` is.

    The last are the means of the recording by the phase of each.
    """
    found, folded = list[SampleFinding](), list[FoldedResidual]()
    if len(blocks.channels) > 1 or len(blocks.sensors[0].parts) > 1:
        return blocks, found, folded
    level = np.stack([without_straight_line(each.rate) for each in blocks.sensors], axis=1)
    whole = replace(blocks, blocks=((0, slice(0, len(level))),), rates=level[None])
    for one in list(_slow_lines(blocks, whole, is_usable)):
        before, blocks, whole = whole, without_finding(blocks, one), without_finding(whole, one)
        if not all(_has_name(one, whole, sensor, named) for sensor in one.fitted):
            found.append(one)
            folded += folded_by_phase(one, before, whole)
    return blocks, found, folded


def _slow_lines(blocks: SampleBlocks, whole: SampleBlocks, is_usable: Sequence[bool]) -> Iterator[SampleFinding]:
    """Yield the lines of a ``whole`` recording that are slower than one of its blocks, the strongest first."""
    n, period = whole.rates.shape[1], whole.period
    tried, found = n // 2 * sum(is_usable), list[tuple[float, int, Line]]()
    for sensor in np.flatnonzero(is_usable).tolist():
        noise = float(np.mean(blocks.rates[:, :, sensor] ** 2))
        for line in lines_of(whole.rates[0, :, sensor], period):
            share = line.amplitude**2 / 2 / (line.amplitude**2 / 2 + noise)
            is_slow = line.hertz * period * blocks.rates.shape[1] < 1
            if is_slow and share > MIN_LINE_SHARE and odds.log_odds(_gain(line), tried) > 0:
                found.append((share, sensor, line))
    found.sort(key=lambda each: -each[0])
    while found:
        line = found[0][2]
        same = [each for each in found if abs(each[2].hertz - line.hertz) * n * period < 1]
        found = [each for each in found if each not in same]
        rates, turns = whole.rates[0], line.hertz * period
        fits = {sensor: _fitted(each, share, rates[:, sensor], turns) for share, sensor, each in same}
        yield SampleFinding(replace(line_in_time(line, period, n), tried=tried), fits)


def _gain(line: Line) -> float:
    return float(odds.gain_of_squares(np.array((line.amplitude / line.amplitude_std) ** 2), 2, BACKGROUND_DOF))


def _fitted(line: Line, share: float, rate: FloatArray, turns: float) -> Fitted:
    sine = sine_at(rate, turns)
    value: FloatArray = np.array([sine.real, -sine.imag])
    return Fitted(1, value, line.amplitude_std**2 * np.eye(2), _gain(line), share)


def _has_name(one: SampleFinding, whole: SampleBlocks, sensor: int, named: Sequence[Finding]) -> bool:
    """Say whether a finding of the sensor's triad is a cycle of the line's period, or what a temperature does."""
    channel, phase = whole.sensors[sensor], one.candidate.phase
    assert phase is not None
    seconds = len(channel.rate) * channel.period
    of_triad = [each for each in named if each.effect.partition(".")[0] == channel.triad]
    periods = [each.value[each.coefficients.index(PERIOD)] for each in of_triad if PERIOD in each.coefficients]
    if any(abs(1 / phase.period - 1 / period) * seconds < 1 for period in periods):
        return True
    drivers = {CATALOGUE[each.effect].driver for each in of_triad if each.effect in CATALOGUE}
    return "temperature" in drivers and has_line(channel.series.temperature, channel.period, 1 / phase.period)
