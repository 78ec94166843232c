"""Allan deviation of the longest dwell, all six channels, in natural units."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.calibration.solution_values import Solution, TriadCalibration
from procedures.campaign.campaign import Campaign, DwellRecord
from procedures.counts.sample_records import CountSeries
from procedures.statistics.allan_deviation import (
    MIN_SAMPLES,
    AllanDeviation,
    NoiseTerm,
    noise_terms,
    overlapping_deviation,
)
from procedures.units import DEG_H_PER_DEG_S, STANDARD_GRAVITY, UG_PER_G
from station.text.rounding import significant

_GYROSCOPE = {  # from deg/h: name, symbol, unit, factor
    "quantisation": ("Quantisation", "Q", "arcsec", 1.0),
    "random_walk": ("Angle random walk", "N", "deg/\u221ah", 1 / 60),
    "bias_instability": ("Bias instability", "B", "deg/h", 1.0),
    "rate_random_walk": ("Rate random walk", "K", "deg/h/\u221ah", 60.0),
}
_ACCELEROMETER = {  # from ug
    "quantisation": ("Quantisation", "Q", "\u00b5m/s", STANDARD_GRAVITY),
    "random_walk": ("Velocity random walk", "N", "\u00b5g/\u221aHz", 1.0),
    "bias_instability": ("Bias instability", "B", "\u00b5g", 1.0),
    "rate_random_walk": ("Random walk of the bias", "K", "\u00b5g/\u221ah", 60.0),
}


@dataclass(frozen=True, slots=True, eq=False)
class TriadNoise:
    """A triad's three curves in ``unit`` and what is read off them.

    ``rows`` has name, symbol and unit of each noise term, and its value and interval per axis, or a bound.
    """

    triad: str
    unit: str
    curves: tuple[AllanDeviation, ...]
    rows: list[tuple[str, str, str, list[str]]]


@dataclass(frozen=True, slots=True)
class DwellNoise:
    """Which dwell was used, how long its longest gap-free part is [s], and the triads' noise."""

    dwell: str
    seconds: float
    triads: tuple[TriadNoise, ...]


def longest_dwell_noise(campaigns: Sequence[Campaign], solution: Solution) -> DwellNoise | None:
    """Return the noise of the dwell with the longest gap-free part, None if there is no dwell long enough."""
    dwells = [(_longest_part(dwell), dwell) for campaign in campaigns for dwell in campaign.dwells]
    if not dwells:
        return None
    part, dwell = max(dwells, key=lambda pair: (pair[0].stop - pair[0].start) * pair[1].series.period)
    if part.stop - part.start < MIN_SAMPLES:
        return None
    triads = [
        _triad(name, dwell, part, calibration)
        for name, calibration in (("gyroscope", solution.gyroscope), ("accelerometer", solution.accelerometer))
    ]
    seconds = (part.stop - part.start) * dwell.series.period
    return DwellNoise(dwell.name, seconds, tuple(triad for triad in triads if triad is not None))


def _longest_part(dwell: DwellRecord) -> slice:
    edges = np.append(dwell.series.starts, len(dwell.series))
    longest = int(np.argmax(np.diff(edges)))
    return slice(int(edges[longest]), int(edges[longest + 1]))


def _triad(name: str, dwell: DwellRecord, part: slice, calibration: TriadCalibration | None) -> TriadNoise | None:
    series = dwell.series
    output = series.gyro if name == "gyroscope" else series.accel
    if output is None:
        return None
    counts = isinstance(series, CountSeries)
    if calibration is None:
        factor, unit, units = np.ones(3), "count/s" if counts else "output", {}
    elif name == "gyroscope":
        factor, unit, units = DEG_H_PER_DEG_S / calibration.scale_factor.value, "deg/h", _GYROSCOPE
    else:
        factor, unit, units = UG_PER_G / calibration.scale_factor.value, "\u00b5g", _ACCELEROMETER
    if counts:
        factor = factor / series.period
    curves = tuple(
        overlapping_deviation(output[part, i] * abs(np.float64(factor[i])), series.period) for i in range(3)
    )
    quantum = abs(factor) * series.period if counts else np.zeros(3)
    terms = [noise_terms(curve, float(one)) for curve, one in zip(curves, quantum, strict=True)]
    rows = [
        (title, symbol, shown, [_cell(term[key], scale) for term in terms])
        for key, (title, symbol, shown, scale) in units.items()
    ]
    return TriadNoise(name, unit, curves, rows)


def _cell(term: NoiseTerm, scale: float) -> str:
    if term.value is None:
        return f"< {significant(term.high * scale)}"
    low, high = significant(term.low * scale), significant(term.high * scale)
    return f"{significant(term.value * scale)} [{low}, {high}]"
