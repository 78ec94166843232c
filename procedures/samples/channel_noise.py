"""The noise of every channel in its longest recording at rest: Allan deviation, its terms, spectrum and lines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.frames import AXES, TRIADS
from procedures.samples.held_samples import HeldChannel, Scales, held_channels, records_at_rest
from procedures.statistics.allan_deviation import AllanDeviation, NoiseFit, overlapping_deviation
from procedures.statistics.noise_conditions import (
    TAU_POWERS,
    Condition,
    changing_interval,
    fit_from,
    of_levels,
    stamps_in_turn,
    undetermined,
    wider,
    without_rounding,
    without_trend,
)
from procedures.statistics.recording_conditions import Examined, examine, measured_rows, on_the_grid
from procedures.statistics.spectral_shape import spectral_condition
from procedures.statistics.spectrum import MIN_SAMPLES, Line, Spectrum, lines_of, spectrum_of, without_lines


@dataclass(frozen=True, slots=True, eq=False)
class ChannelNoise:
    """A channel's noise in ``seconds`` of a recording, in g, deg/s, or outputs where ``is_scaled`` is False.

    ``curve`` is that of the samples that are analysed, ``fit`` the terms of what it is without its ``lines``;
    ``conditions`` are what the samples are in addition to a sensor's noise.
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
    conditions: tuple[Condition, ...] = ()


def channel_noise(campaigns: Sequence[Campaign], scales: Scales) -> list[ChannelNoise]:
    """Return the noise of the channels that change, each in the longest gap-free part that it has."""
    records = sorted(records_at_rest(campaigns), key=lambda record: -len(record.series) * record.series.period)
    found = dict[tuple[str, int], ChannelNoise]()
    for record in records:
        if len(found) == len(TRIADS) * len(AXES):
            break
        for each in held_channels(record, scales):
            part = each.longest
            if (each.triad, each.axis) not in found and each.is_measured[part].sum() >= MIN_SAMPLES:
                found[each.triad, each.axis] = noise_of(each, each.triad in scales)
    return with_shared_conditions([found[key] for key in sorted(found)])


def with_shared_conditions(channels: Sequence[ChannelNoise]) -> list[ChannelNoise]:
    """Return channels, each with the conditions of its recording that another channel of it shows."""
    shared = dict[tuple[str, str], tuple[str, Condition]]()
    for each in channels:
        for one in each.conditions:
            if one.is_of_recording:
                shared.setdefault((each.recording, one.name), (f"{each.triad} {each.axis}", one))
    return [_with_shared(each, shared) for each in channels]


def _with_shared(channel: ChannelNoise, shared: Mapping[tuple[str, str], tuple[str, Condition]]) -> ChannelNoise:
    if any(each.is_of_recording for each in channel.conditions):
        return channel
    added = tuple(
        replace(one, text=f"Seen in {shown_by}, and true of all channels of the recording: {one.text}")
        for (recording, _), (shown_by, one) in shared.items()
        if recording == channel.recording
    )
    conditions = (*channel.conditions, *added)
    return replace(channel, fit=undetermined(channel.fit, conditions), conditions=conditions) if added else channel


def noise_of(channel: HeldChannel, is_scaled: bool) -> ChannelNoise:
    """Return the noise of a channel's longest gap-free part."""
    return replace(noise_as_is(channel), is_scaled=is_scaled)


@lru_cache(maxsize=len(TRIADS) * len(AXES))  # single channels ask for it, and the noise with a diagnosis
def noise_as_is(channel: HeldChannel) -> ChannelNoise:
    """Return the same, whether its unit is known or not."""
    raw, part = channel.rate[channel.longest], channel.longest
    measured = channel.is_measured[part]
    own = measured_rows(measured)
    found = examine(raw[measured], channel.period * own.every, channel.quantum > 0, own)
    rate, period = found.rate, found.period
    curve = overlapping_deviation(rate, period)
    even, at = (rate, np.ones(len(rate), dtype=np.bool_)) if own.every > 1 else on_the_grid(rate, measured)
    lines = list[Line]()
    if found.is_usable and found.white is None:
        lines = [line for line in lines_of(even, period) if line.amplitude * period > channel.quantum]
    bare = without_lines(even, period, lines)[at] if lines else rate
    fit, conditions = _terms(
        found, bare, curve if not lines else overlapping_deviation(bare, period), channel.quantum
    )
    if (changes := changing_interval(channel.series.t[part])) is not None:
        condition, low, high = changes
        factors = [{name: ratio**power for name, power in TAU_POWERS.items()} for ratio in (low, high)]
        pairs = {name: sorted((factors[0][name], factors[1][name])) for name in TAU_POWERS}
        conditions = (*conditions, condition)
        fit = undetermined(
            wider(fit, {k: v[0] for k, v in pairs.items()}, {k: v[1] for k, v in pairs.items()}), conditions
        )
    if (turns := stamps_in_turn(channel.series.t[part])) is not None:
        conditions = (*conditions, turns)
        fit = undetermined(fit, conditions)
    return ChannelNoise(
        channel.triad, AXES[channel.axis], channel.recording, len(raw) * channel.period, 1 / channel.period,
        float(rate.mean()), False, curve, fit, spectrum_of(even, period), tuple(lines), conditions,
    )  # fmt: skip


def _terms(
    found: Examined, bare: FloatArray, curve: AllanDeviation, quantum: float
) -> tuple[NoiseFit, tuple[Condition, ...]]:
    """Return the terms of samples without their lines, ``bare`` (n,), and all conditions."""
    if found.white is not None:
        return of_levels(found.white, found.step, found.period), found.conditions
    if not found.is_usable:
        return undetermined(fit_from(curve, 0.0, quantum), found.conditions), found.conditions
    conditions, tau = found.conditions, 0.0
    if curve.deviation[0] > np.sqrt(2) * quantum / curve.tau[0]:  # else the counts hide the noise there
        shape = spectral_condition(bare, found.period)
        if shape is not None:
            conditions, tau = (*conditions, shape[0]), shape[1]
    fit, trend = without_trend(bare, found.period, fit_from(curve, tau, quantum), tau)
    conditions = (*conditions, *trend)
    share = dict.fromkeys(TAU_POWERS, found.replaced + found.missing)
    share["random_walk"] = found.replaced  # white noise does not change where rows close up over missing ones
    low, high = ({name: 1 + sign * each for name, each in share.items()} for sign in (-1, 1))
    fit = wider(fit, low, high)
    return undetermined(without_rounding(fit, found.rounding, found.period), conditions), conditions
