"""What a live channel of a triad that is not solved shows by itself: noise, drift, temperature.

The longest recording at rest is taken. Noise is that of `procedures.samples.channel_noise`; drift and
temperature coefficient are lines through means of blocks, with a sigma for errors that hang together
(`procedures.statistics.line_fits`). Each is fitted alone: where the temperature goes with the time, one may be
the other, and `is_confounded` says so. A gyroscope's scale factor along its own axis comes from its turns,
``total = s angle + b T``: the Earth's rate and the bias go with the time, and in s is the cosine of its
misalignment, 1e-6 at 1 mrad. Its sigma holds the closures and by how much the rests before the turns differ.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, RestRecord, SoakRecord
from procedures.campaign.dead_channels import constant_end, stopped_in_turn
from procedures.campaign.observations import channel, turn_totals
from procedures.counts.sample_records import CountSeries, Series
from procedures.frames import AXES, TRIADS
from procedures.positions import face_normal, face_of
from procedures.samples.channel_noise import noise_of
from procedures.samples.held_samples import held_channels
from procedures.statistics.allan_deviation import NoiseTerm
from procedures.statistics.line_fits import CorrelatedLine, fit_correlated_line
from procedures.statistics.spectrum import MIN_SAMPLES
from procedures.twelve_positions.manual_rotations import END_REST_S, nominal_angle
from procedures.units import S_PER_H

LINE_BLOCKS = 24
MIN_RECORDING_SAMPLES = 2 * LINE_BLOCKS  # two in each block's mean
MIN_WARMING_K = 1.0  # K, from which on a temperature coefficient is looked for
MIN_AXIS_COSINE = 0.9  # of a turn's axis along the sensor
MAX_INFLATION = 10.0  # of a slope's variance by the other one: beyond, regressors count as collinear

Held = DwellRecord | RestRecord | SoakRecord


@dataclass(frozen=True, slots=True)
class SingleChannel:
    """A channel in its longest recording at rest, its outputs [output/s, or output of rates] as they come.

    ``noise`` is its random walk [output/s sqrt(s)], ``instability`` its bias instability [output/s]; ``drift`` a
    line over time [/h]; ``warming`` one over temperature [/K] that moved by ``kelvin``, None where it hardly did.
    ``correlation`` is that of temperature with time, 0 where there is no ``warming``.
    ``scale`` [output/s per deg/s], with its 1 sigma, is a gyroscope's along its own axis, None where no pair of
    turns tells it.
    """

    triad: str
    axis: str
    recording: str
    seconds: float
    mean: float
    noise: NoiseTerm
    instability: NoiseTerm
    drift: CorrelatedLine | None
    warming: CorrelatedLine | None
    kelvin: float
    scale: tuple[float, float] | None
    is_count: bool
    correlation: float = 0.0

    @property
    def is_confounded(self) -> bool:
        """Say whether drift and temperature cannot be separated: each is nearly a multiple of the other."""
        return 1 - self.correlation**2 < 1 / MAX_INFLATION


def single_channels(campaigns: Sequence[Campaign], solved: Sequence[str]) -> list[SingleChannel]:
    """Return the live channels of those triads that are not ``solved``."""
    return [
        each for campaign in campaigns for triad in TRIADS if triad not in solved for each in _of(campaign, triad)
    ]


def _of(campaign: Campaign, triad: str) -> Iterator[SingleChannel]:
    held: list[Held] = [*campaign.soaks, *campaign.dwells, *campaign.rests]
    records = [record for record in held if _samples(record.series, triad) is not None]
    if not records:
        return
    live = [[r for r in records if not _is_constant(r.series, triad, axis)] for axis in range(3)]
    for axis, found in enumerate(live):
        record = max(found, key=lambda r: len(r.series) * r.series.period, default=None)
        if record is not None and len(record.series) >= MIN_RECORDING_SAMPLES:
            yield _seen(campaign, triad, axis, record)


def _samples(series: Series, triad: str) -> FloatArray | None:
    samples = channel(series, triad)
    return None if samples is None else np.asarray(samples, dtype=np.float64)


def _is_constant(series: Series, triad: str, axis: int) -> bool:
    samples = _samples(series, triad)
    end = constant_end(samples[:, axis]) if samples is not None else None
    return end is not None and end.begin == 0


def _seen(
    campaign: Campaign, triad: str, axis: int, record: DwellRecord | RestRecord | SoakRecord
) -> SingleChannel:
    series, samples = record.series, _samples(record.series, triad)
    assert samples is not None
    is_count = isinstance(series, CountSeries)
    rate = samples[:, axis] / (series.period if is_count else 1.0)
    quantum = 1.0 if is_count else 0.0
    t, T, mean, least = _blocks(series, rate, quantum)
    known = np.isfinite(T)
    kelvin = float(np.ptp(T[known])) if known.any() else 0.0
    warming, correlation = None, 0.0
    if kelvin >= MIN_WARMING_K:
        correlation = float(np.corrcoef(t[known], T[known])[0, 1])
        warming = fit_correlated_line(T[known], mean[known], np.zeros(known.sum(), dtype=np.int64), least)
    drift = fit_correlated_line(t / S_PER_H, mean, np.zeros(len(t), dtype=np.int64), least)
    scale = _scale(campaign, axis) if triad == "gyroscope" else None
    return SingleChannel(
        triad, AXES[axis], record.name, len(series) * series.period, float(rate.mean()),
        *_noise(record, triad, axis), drift, warming, kelvin, scale, is_count, correlation,
    )  # fmt: skip


def _blocks(series: Series, rate: FloatArray, quantum: float) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Return times [s], temperatures and means of blocks, and the 1 sigma that counting leaves to a mean."""
    parts = np.array_split(np.arange(len(rate)), LINE_BLOCKS)
    t, mean = (np.array([values[part].mean() for part in parts]) for values in (series.t, rate))
    warm = [series.temperature[part] for part in parts]
    T = np.array([w[np.isfinite(w)].mean() if np.isfinite(w).any() else np.nan for w in warm])
    return t, T, mean, quantum / np.sqrt(6) / (len(parts[-1]) * series.period)


def _noise(record: Held, triad: str, axis: int) -> tuple[NoiseTerm, NoiseTerm]:
    """Return random walk and bias instability as `procedures.samples.channel_noise` has them."""
    held = next(each for each in held_channels(record, {}) if (each.triad, each.axis) == (triad, axis))
    if held.longest.stop - held.longest.start < MIN_SAMPLES:
        return NoiseTerm(None, 0.0, float("inf")), NoiseTerm(None, 0.0, float("inf"))
    terms = noise_of(held, False).fit.terms
    return terms["random_walk"], terms["bias_instability"]


def _scale(campaign: Campaign, axis: int) -> tuple[float, float] | None:
    rows, rests = list[tuple[float, float, float]](), list[float]()
    for turn in turn_totals([campaign], np.zeros(3)):
        samples = _samples(turn.record.series, "gyroscope")
        assert samples is not None
        along = float(campaign.fixture.C_sb[axis] @ face_normal(face_of(turn.record.start_position)))
        end = constant_end(samples[:, axis])
        if abs(along) < MIN_AXIS_COSINE or (
            end and (not end.begin or stopped_in_turn(turn.record, samples[:, axis], end, True))
        ):
            continue
        rows.append((np.degrees(nominal_angle(turn)) * along, turn.seconds, float(turn.total[axis])))
        rest = samples[: max(round(END_REST_S / turn.record.series.period), 1), axis].mean()
        rests.append(float(rest) / (turn.record.series.period if turn.counts else 1.0))
    angle, seconds, total = np.array(rows).reshape(-1, 3).T
    if not len(rows) or angle.min() > 0 or angle.max() < 0:
        return None
    A = np.column_stack((angle, seconds))
    scale = float(np.linalg.lstsq(A, total, rcond=None)[0][0])
    gain = np.linalg.pinv(A)[0]
    each = np.hypot(scale * np.degrees(campaign.sigma.closure), np.ptp(rests) / 2 * seconds)
    return scale, float(np.linalg.norm(gain * each))
