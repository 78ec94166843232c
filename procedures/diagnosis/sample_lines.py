"""Lines that come again in every recording, or whose frequency wanders, as that of a dither driven with noise.

Such a line has no phase to fit, but a power. So recordings are cut into pieces, first as long as a recording, then
ever shorter ones, in which a wandering line still stands; the periodograms of all pieces, each over its own
background, are summed, of one sensor or of a triad's together. Under noise of any colour and variance a sum of B
over its neighbours' is F distributed with 2 B degrees of freedom. A resonance that noise drives stands out as
well. But its power in a piece is exponentially distributed, that of a line, rho times the noise, by the noncentral
chi-square of 2 degrees of freedom. In shorter pieces the likelihood of this must be `MIN_ODDS` that of the other;
in whole recordings, which resolve most resonances, at least not as much less.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ive

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.result import Finding
from procedures.diagnosis.sample_blocks import SampleBlocks
from procedures.frames import AXES, TRIADS
from procedures.statistics.significance import log_f_sf
from procedures.statistics.spectrum import (
    MAX_LOG_P,
    MIN_PERIODS,
    WINDOW_BINS,
    background_of,
    without_straight_line,
)
from procedures.units import DEG_H_PER_DEG_S

EFFECT = "disturbance.line"
MIN_PIECE, SHORTER, MIN_PIECES = 512, 4, 6  # samples; times, from one length to the next; pieces
WHOLE = 0.98  # of a part, so that parts of nearly one length give a piece each
NEAR = 12  # neighbours on either side that tell what noise has
NEIGHBOURS_DOF = 10.0  # of their median, for each piece: 18 values that hang together under Hann's window
MIN_ODDS = 20.0
MIN_SHARE = 1e-3  # of a sensor's variance
ESTABLISHED_LOG_P = np.log(1e-5)
SEPARATE = "another sample rate, and another bench"


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """A sensor's pieces: ``power`` (b, m), what noise has there (b, m), and the variance within pieces."""

    power: FloatArray
    background: FloatArray
    variance: float

    def square(self, at: int) -> FloatArray:
        """Return the square of a line's amplitude at a bin, in each piece (b,)."""
        near, length = slice(at - 2, at + 3), 2 * (self.power.shape[1] - 1)
        found: FloatArray = 4 / length * np.sum(self.power[:, near] - self.background[:, near], axis=1)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """A line at a bin of pieces of ``length`` samples of some sensors, and ln p, all that was tried counted."""

    sensors: tuple[int, ...]
    length: int
    pieces: int
    at: int
    log_p: float


def repeated_lines(blocks: SampleBlocks, is_usable: Sequence[bool], names: list[str]) -> Iterator[Finding]:
    """Yield the strongest such line of each triad."""
    parts = np.array([part.stop - part.start for channels in blocks.channels for part in channels[0].parts])
    lengths = _lengths(parts)
    for triad in TRIADS:
        sensors = [i for i, each in enumerate(blocks.sensors) if each.triad == triad and is_usable[i]]
        groups = {(s,) for s in sensors} | {tuple(sensors)} if sensors else set[tuple[int, ...]]()
        found = list[tuple[_Line, dict[int, _Pieces]]]()
        for length in lengths:
            pieces = {s: _pieces(blocks, s, length) for s in sensors}
            least = -np.log(MIN_ODDS) if length > 0.9 * np.median(parts) else np.log(MIN_ODDS)
            lines = (_line(pieces, group, length, len(groups) * len(lengths), least) for group in sorted(groups))
            found += [(line, pieces) for line in lines if line is not None and line.log_p < MAX_LOG_P]
        if found:
            yield from _findings(blocks, triad, *min(found, key=lambda each: each[0].log_p), names)


def _lengths(parts: IntArray) -> list[int]:
    """Return the even lengths [samples] of pieces: of parts (p,), the long ones and all, and shorter."""
    typical = {float(np.median(parts[parts >= parts.max() / 2])), float(np.median(parts))}
    found = sorted((int(WHOLE * n) for n in typical), reverse=True)
    while found[-1] // SHORTER >= MIN_PIECE:
        found.append(found[-1] // SHORTER)
    return [n // 2 * 2 for n in found if n >= MIN_PIECE and np.sum(parts // n) >= MIN_PIECES]


def _line(
    pieces: dict[int, _Pieces], sensors: tuple[int, ...], length: int, tries: int, least: float
) -> _Line | None:
    """Return the strongest line of some sensors together; None where a resonance may be it, by ``least`` odds."""
    ratio = np.concatenate([pieces[s].power / pieces[s].background for s in sensors])
    begin = int(MIN_PERIODS)
    total = ratio.sum(axis=0)
    over = total / _neighbours(total)
    over[:begin], over[-WINDOW_BINS:] = 0.0, 0.0
    at, count = int(np.argmax(over)), len(ratio)
    log_p = log_f_sf(float(over[at]), 2 * count, NEIGHBOURS_DOF * count) + np.log((len(over) - begin) * tries)
    noise = total[at] / over[at] / count
    odds = sum(_odds_of_line(pieces[s].power[:, at] / pieces[s].background[:, at] / noise) for s in sensors)
    if odds < least:
        return None
    return _Line(sensors, length, count // len(sensors), at, min(float(log_p), 0.0))


def _pieces(blocks: SampleBlocks, sensor: int, length: int) -> _Pieces:
    window = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(length) + 0.5) / length)
    parts = [(channels[sensor].rate, part) for channels in blocks.channels for part in channels[sensor].parts]
    level = without_straight_line(np.concatenate([_cut(rate[part], length) for rate, part in parts]))
    power = np.abs(np.fft.rfft(level * window)) ** 2 / float(window @ window)
    return _Pieces(power, background_of(power, int(MIN_PERIODS)), float(np.mean(level**2)))


def _cut(rate: FloatArray, length: int) -> FloatArray:
    """Return the pieces (b, length) of a part (n,), in its unit, but for what is left at its end."""
    return rate[: len(rate) // length * length].reshape(-1, length)


def _neighbours(total: FloatArray) -> FloatArray:
    """Return the median (m,) of what stands about each value (m,), but for those that its own line reaches."""
    padded = np.pad(total, NEAR, mode="reflect")
    steps: IntArray = np.array([k for k in range(-NEAR, NEAR + 1) if abs(k) > WINDOW_BINS])
    found: FloatArray = np.median(padded[NEAR + np.arange(len(total))[:, None] + steps], axis=1)
    return np.maximum(found, np.finfo(float).tiny)


def _odds_of_line(power: FloatArray) -> float:
    """Return ln odds of one amplitude over a resonance by powers (b,), of which noise has 1."""
    rho = float(power.mean()) - 1
    if rho <= 0:
        return 0.0
    of_line = -((np.sqrt(power) - np.sqrt(rho)) ** 2) + np.log(ive(0, 2 * np.sqrt(rho * power)))  # I0 e^-x
    of_resonance = -power / (1 + rho) - np.log(1 + rho)
    return float(np.sum(of_line - of_resonance))


def _findings(
    blocks: SampleBlocks, triad: str, line: _Line, pieces: dict[int, _Pieces], names: list[str]
) -> Iterator[Finding]:
    """Yield the finding of a line that is a large enough share of a sensor's variance."""
    squares = {s: pieces[s].square(line.at) for s in line.sensors}
    shares = {s: float(each.mean()) / 2 / pieces[s].variance for s, each in squares.items()}
    told = [s for s, share in shares.items() if share > MIN_SHARE]
    if not told:
        return
    factor, unit = (DEG_H_PER_DEG_S, "deg/h") if triad == "gyroscope" else (1.0, "g")
    amplitude = np.array([np.sqrt(squares[s].mean()) for s in told])
    std = np.array([squares[s].std() for s in told]) / np.sqrt(line.pieces) / (2 * amplitude)
    seconds = line.length * blocks.period
    stretches = f"{line.at / seconds:.4g} +- {0.5 / seconds:.2g} Hz in {line.pieces} stretches of {seconds:.4g} s"
    yield Finding(
        EFFECT, "procedure", tuple(triad[0] + AXES[blocks.sensors[s].axis] for s in told), factor * amplitude,
        factor * std, unit, {"file": names}, "established" if line.log_p < ESTABLISHED_LOG_P else "likely", (),
        SEPARATE, line.log_p, 0.0, f"{stretches}; it may be any multiple of {1 / blocks.period:.5g} Hz away",
        share=min(max(shares.values()), 1.0),
    )  # fmt: skip
