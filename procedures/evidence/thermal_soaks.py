"""Soaks as evidence: long rests while temperature or an auxiliary channel moves, in blocks as long as dwells.

Each soak has a constant of its own a sensor: attitude, bench and bias are in it, and only what moves within it
speaks. Temperature and its rate are those of the whole soak, of block means, so that a slow or coarse thermometer
will do. Each of its means stands at the mean time of its readings: read in every tenth row, the first one of each,
they are early, and a slope over temperature would show as an effect of its rate.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.campaign.campaign import Campaign, RestRecord, SoakRecord
from procedures.campaign.dead_channels import dead_in_soak
from procedures.campaign.observations import channel, rest_rates
from procedures.counts.count_rate import MIN_DWELL_SAMPLES
from procedures.counts.dwell_means import MIN_DWELL_BLOCKS
from procedures.counts.sample_records import CountSeries, Series, series_rows
from procedures.effects.excitation import ExcitationStep
from procedures.effects.jump import UNCALIBRATED
from procedures.effects.settling import most_cycles
from procedures.evidence.excitation import NodeBuilder, StepNodes, attitude, on_face
from procedures.frames import AXES, TRIADS
from procedures.geodesy import EARTH_RATE
from procedures.statistics.spectrum import has_line, lines_of, sine_at
from procedures.twelve_positions.accelerometer_fit import TriadFit
from procedures.units import S_PER_MIN

BLOCK_S = 100.0
LEAST_BLOCKS = 10  # of a short soak, as long as each has `SHORT_BLOCK_S`; of one below 200 s `SAMPLES_PER_BLOCK`
SHORT_BLOCK_S = 30.0
SAMPLES_PER_BLOCK = MIN_DWELL_BLOCKS  # of which a mean's sigma is known to 6 %
BLOCK_NODES = 8  # the mean of a cycle of two blocks is 0.6 % off by them
MIN_BLOCKS = 3
MAX_BLOCKS = 200  # of a soak: its effects are tried at each of them, and the time this takes goes with the square


@dataclass(frozen=True, slots=True, eq=False)
class SoakBlock:
    """A block's nodes, and its mean output less that of the whole soak (3,) with 1 sigma (3,) [g, deg/s].

    ``level`` (3,) is the whole soak's mean in the same units. ``alive`` are the sensors that the soak shows; of
    others nothing is stated.
    """

    part: StepNodes
    residual: FloatArray
    sigma: FloatArray
    alive: IntArray
    level: FloatArray


def soaks_seen(fits: CampaignFits, places: NodeBuilder) -> list[tuple[str, list[SoakBlock]]]:
    """Return the blocks of every soak, by the triad that saw it."""
    soaks = [(number, soak) for number, campaign in enumerate(fits.campaigns) for soak in campaign.soaks]
    found = [
        (triad, list(_blocks(fits, places, number, soak, triad)))
        for number, soak in soaks
        for triad in ("accelerometer", "gyroscope")
    ]
    return [each for each in found if each[1]]


def _blocks(
    fits: CampaignFits, places: NodeBuilder, number: int, soak: SoakRecord, triad: str
) -> Iterator[SoakBlock]:
    """Yield a soak's blocks as one triad saw them; none where it is absent or not solved."""
    k = _scale(fits, number, triad)
    found = None if k is None else block_rates(soak, triad)
    if k is None or found is None:
        return
    series, rate, std = found
    alive = np.flatnonzero([end is None for end in dead_in_soak(soak, triad)])
    if not len(alive):
        return
    level = np.average(rate, axis=0) / k
    residual = rate / k - level
    for part, left, sigma in zip(_parts(fits, places, number, soak, series), residual, std / k, strict=True):
        yield SoakBlock(part, left, sigma, alive, level)


def _scale(fits: CampaignFits, number: int, triad: str) -> FloatArray | None:
    """Return a triad's scale factors (3,) [output/s per g or deg/s]: as solved, else as its unit says.

    Where nothing at all is solved, the outputs are their own unit; None where a triad has neither.
    """
    if (joint := _joint(fits, triad)) is not None:
        return joint.k
    is_alone = fits.accelerometer is None and _joint(fits, "gyroscope") is None
    nominal = fits.campaigns[number].nominal_scale.get(triad, 1.0 if is_alone else None)
    return None if nominal is None else np.full(3, nominal)


def _joint(fits: CampaignFits, triad: str) -> TriadFit | None:
    if triad == "accelerometer":
        return fits.accelerometer
    return fits.gyroscope.joint if fits.gyroscope is not None else None


@lru_cache(maxsize=32)  # a loop asks for the same soak after every refit, and to estimate takes long
def block_rates(soak: SoakRecord, triad: str) -> tuple[tuple[Series, ...], FloatArray, FloatArray] | None:
    """Return a soak's blocks, their rates (m, 3) [output/s, or output] and 1 sigma (m, 3); None of too few."""
    series = _cut(soak.series)
    if channel(soak.series, triad) is None or len(series) < MIN_BLOCKS:
        return None
    found = rest_rates([(0, RestRecord(soak.name, None, each)) for each in series], triad)
    return None if found is None else (series, found.rate - _of_lines(soak.series, triad, series), found.std)


def _of_lines(whole: Series, triad: str, blocks: tuple[Series, ...]) -> FloatArray:
    """Return what lines too fast for blocks to show add to their means (m, 3) [output/s, or output].

    The means would show a slow cycle, which nothing makes. A line that the temperature has as well stays: the
    means of both show the same.
    """
    added, samples = np.zeros((len(blocks), 3)), channel(whole, triad)
    if samples is None or len(whole.starts) > 1:
        return added
    sizes, quantum = np.array([len(each) for each in blocks]), 1.0 if isinstance(whole, CountSeries) else 0.0
    middles, fastest = np.cumsum(sizes) - (sizes + 1) / 2, most_cycles(len(blocks)) / (len(whole) * whole.period)
    for axis, rate in enumerate(samples.T / (whole.period if isinstance(whole, CountSeries) else 1.0)):
        for line in lines_of(rate, whole.period):
            if line.amplitude * whole.period < quantum or line.hertz < fastest:
                continue  # what rounding makes cancels from count to count
            if not has_line(whole.temperature, whole.period, line.hertz):
                turns = line.hertz * whole.period
                mean = np.sinc(turns * sizes) / np.sinc(turns) * np.exp(2j * np.pi * turns * middles)
                added[:, axis] += np.real(sine_at(rate, turns) * mean)
    return added


def _cut(series: Series) -> tuple[Series, ...]:
    """Return equal blocks of at most `BLOCK_S` seconds, longer ones where they would be more than `MAX_BLOCKS`.

    Of five blocks nothing separates a walk from a wider noise: a soak of some minutes has `LEAST_BLOCKS` shorter
    ones, one of seconds as many as its samples allow.
    """
    n = len(series)
    seconds = n * series.period
    is_short = seconds <= (MIN_BLOCKS - 1) * BLOCK_S
    least = min(LEAST_BLOCKS, n // SAMPLES_PER_BLOCK if is_short else int(seconds / SHORT_BLOCK_S))
    count = min(max(int(np.ceil(seconds / BLOCK_S)), least), n // MIN_DWELL_SAMPLES, MAX_BLOCKS)
    edges = np.linspace(0, n, max(count, 1) + 1).round().astype(np.int64)
    return tuple(_piece(series, int(a), int(b)) for a, b in itertools.pairwise(edges))


def _piece(series: Series, a: int, b: int) -> Series:
    starts = np.concatenate(([0], series.starts[(series.starts > a) & (series.starts < b)] - a))
    return series_rows(series, slice(a, b), starts)


def _parts(
    fits: CampaignFits, places: NodeBuilder, number: int, soak: SoakRecord, blocks: tuple[Series, ...]
) -> Iterator[StepNodes]:
    campaign = fits.campaigns[number]
    C_sn = attitude(campaign, soak.position) if soak.position else None
    f = on_face(campaign, soak.up) if soak.up else _force(fits, campaign, soak)
    t, T = block_temperatures(blocks)
    known = np.isfinite(T)
    warming = np.gradient(T[known], t[known] / S_PER_MIN) if known.sum() > 1 else np.array([])
    for i, series in enumerate(blocks):
        step = ExcitationStep(f"{soak.name} block {i + 1}", "soak", number, 0, "")
        part = places.rest(number, step, series, C_sn, f, BLOCK_NODES)
        if known.sum() > 1:
            smooth, rate = (np.interp(part.t, t[known], v) for v in (T[known], warming))
            # before the first block's middle and after the last one's it went on warming: a lag begins there
            smooth += rate * (part.t - np.clip(part.t, t[known][0], t[known][-1])) / S_PER_MIN
            if known[i]:  # a block's mean output is that at its mean temperature, at the middle of its rows
                late = (series.t.mean() - t[i]) / S_PER_MIN
                smooth += T[i] + late * warming[int(known[:i].sum())] - smooth.mean()
            part = replace(part, temperature=smooth, temperature_rate=rate)
        # what only adds a constant is in the soak's own: unknown field and heading say nothing, and hide nothing
        yield replace(part, magnetic=np.nan_to_num(part.magnetic))


@lru_cache(maxsize=32)
def block_temperatures(blocks: tuple[Series, ...]) -> tuple[FloatArray, FloatArray]:
    """Return the mean temperature [degC] of each block (m,), nan where unknown, and the mean time [s] of it."""
    read = [np.isfinite(each.temperature) for each in blocks]
    t = np.array([b.t[known].mean() if known.any() else b.t.mean() for b, known in zip(blocks, read, strict=True)])
    T = np.array(
        [np.nanmean(b.temperature) if known.any() else np.nan for b, known in zip(blocks, read, strict=True)]
    )
    return t, T


def _force(fits: CampaignFits, campaign: Campaign, soak: SoakRecord) -> FloatArray | None:
    """Return the specific force (3,) [g] as the accelerometers read it; None if one is dead or of no scale."""
    if any(end is not None for end in dead_in_soak(soak, "accelerometer")):
        return None
    if (found := block_rates(soak, "accelerometer")) is None:
        return None
    if fits.accelerometer is None:
        nominal = campaign.nominal_scale.get("accelerometer")
        return None if nominal is None else found[1].mean(axis=0) / nominal
    return np.linalg.solve(fits.accelerometer.K, found[1].mean(axis=0) - fits.accelerometer.b)


MIN_SOAKS = 2


@dataclass(frozen=True, slots=True, eq=False)
class SoakLevel:
    """A soak's mean less that of all (r,) with 1 sigma (r,) [g, deg/s]; ``mix`` (r, 3) makes it of the sensors.

    ``soak`` numbers the soak among those given; ``axis`` (r,) the sensors, -1 of a length.
    """

    triad: str
    soak: int
    axis: IntArray
    residual: FloatArray
    sigma: FloatArray
    mix: FloatArray


def levels(soaks: Sequence[tuple[str, Sequence[SoakBlock]]]) -> list[SoakLevel]:
    """Return the levels of each triad's soaks, in those sensors that all show; none of one soak.

    Of accelerometers all three must be there: one alone may be tilted as far as it will.
    """
    found = list[SoakLevel]()
    for triad in TRIADS:
        own = [(i, blocks) for i, (of, blocks) in enumerate(soaks) if of == triad]
        if len(own) < MIN_SOAKS:
            continue
        alive = [axis for axis in range(len(AXES)) if all(axis in blocks[0].alive for _, blocks in own)]
        if triad == "gyroscope" and alive:
            found += _of_gyroscopes(own, np.array(alive))
        elif triad == "accelerometer" and len(alive) == len(AXES):
            found += _of_accelerometers(own)
    return found


def _noise(blocks: Sequence[SoakBlock]) -> FloatArray:
    """Return 1 sigma (3,) of a soak's mean by the noise of its blocks."""
    noise: FloatArray = np.sqrt(np.sum([block.sigma**2 for block in blocks], axis=0)) / len(blocks)
    return noise


def _of_gyroscopes(soaks: Sequence[tuple[int, Sequence[SoakBlock]]], alive: IntArray) -> Iterator[SoakLevel]:
    rates = np.array([blocks[0].level for _, blocks in soaks])
    earth = np.degrees(EARTH_RATE) / np.sqrt(3)
    for (i, blocks), off in zip(soaks, rates - rates.mean(axis=0), strict=True):
        sigma = np.hypot(_noise(blocks), earth)
        yield SoakLevel("gyroscope", i, alive, off[alive], sigma[alive], np.eye(3)[alive])


def _of_accelerometers(soaks: Sequence[tuple[int, Sequence[SoakBlock]]]) -> Iterator[SoakLevel]:
    forces = np.array([blocks[0].level for _, blocks in soaks])
    length = np.linalg.norm(forces, axis=1)
    if not np.all(length > 0):
        return
    up = forces / length[:, None]
    mean = up.mean(axis=0)
    angle = np.linalg.norm(up - mean, axis=1)
    for (i, blocks), off, u, a in zip(soaks, length - length.mean(), up, angle, strict=True):
        sigma = np.hypot(np.linalg.norm(u * _noise(blocks)), UNCALIBRATED * a * length.mean())
        yield SoakLevel("accelerometer", i, np.array([-1]), np.array([off]), np.array([sigma]), u[None])
