"""A cause that acts sample by sample, and what it does to each sensor."""

from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.samples.sample_blocks import Columns, Fitted, SampleBlocks, detrended
from procedures.samples.sample_phases import Phase
from procedures.statistics.spectrum import Line

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
