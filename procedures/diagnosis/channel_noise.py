"""The noise of every channel in its longest recording at rest: Allan deviation, its terms, spectrum and lines."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from procedures.campaign.campaign import Campaign
from procedures.diagnosis.held_samples import HeldChannel, Scales, held_channels, records_at_rest
from procedures.frames import AXES, TRIADS
from procedures.statistics.allan_deviation import AllanDeviation, overlapping_deviation
from procedures.statistics.noise_terms import NoiseFit, fit_noise
from procedures.statistics.spectrum import MIN_SAMPLES, Line, Spectrum, lines_of, spectrum_of, without_lines


@dataclass(frozen=True, slots=True, eq=False)
class ChannelNoise:
    """A channel's noise in ``seconds`` of a recording, in g, deg/s, or outputs where ``is_scaled`` is False.

    ``curve`` is that of the record as it is, ``fit`` the terms of what it is without its ``lines``.
    """

    triad: str
    axis: str
    recording: str
    seconds: float
    hertz: float
    mean: float
    is_scaled: bool
    curve: AllanDeviation
    fit: NoiseFit
    spectrum: Spectrum
    lines: tuple[Line, ...]


def channel_noise(campaigns: Sequence[Campaign], scales: Scales) -> list[ChannelNoise]:
    """Return the noise of the channels that change, each in the longest gap-free part that it has."""
    records = sorted(records_at_rest(campaigns), key=lambda record: -len(record.series) * record.series.period)
    found = dict[tuple[str, int], ChannelNoise]()
    for record in records:
        if len(found) == len(TRIADS) * len(AXES):
            break
        for each in held_channels(record, scales):
            part = each.longest
            if (each.triad, each.axis) not in found and part.stop - part.start >= MIN_SAMPLES:
                found[each.triad, each.axis] = noise_of(each, each.triad in scales)
    return [found[key] for key in sorted(found)]


def noise_of(channel: HeldChannel, is_scaled: bool) -> ChannelNoise:
    """Return the noise of a channel's longest gap-free part."""
    return replace(noise_as_is(channel), is_scaled=is_scaled)


@lru_cache(maxsize=len(TRIADS) * len(AXES))  # single channels ask for it, and the noise beside a diagnosis
def noise_as_is(channel: HeldChannel) -> ChannelNoise:
    """Return the same, whether its unit is known or not."""
    rate, period = channel.rate[channel.longest], channel.period
    curve = overlapping_deviation(rate, period)
    lines = [line for line in lines_of(rate, period) if line.amplitude * period > channel.quantum]
    bare = overlapping_deviation(without_lines(rate, period, lines), period) if lines else curve
    return ChannelNoise(
        channel.triad, AXES[channel.axis], channel.recording, len(rate) * period, 1 / period, float(rate.mean()),
        False, curve, fit_noise(bare, channel.quantum), spectrum_of(rate, period), tuple(lines),
    )  # fmt: skip
