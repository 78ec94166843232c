"""Whether a spectrum is one that the five noise terms make; where it is not, up to which frequency it is.

Sampled noise has the density ``a w^2 + b + c / w + d / w^2 + e / w^4``, ``w = 2 sin(pi f T)``, of quantisation,
white noise, flicker, random walk and drift, none of them negative: in logarithms a convex curve. A low-pass
filter bends it the other way, a vibration or a resonance is a hill on it. The averaged periodogram of a band
has a gamma distribution; the terms are fitted to it by likelihood (Whittle, 1953).
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import rfft
from scipy.optimize import nnls

from procedures.arrays import FloatArray
from procedures.statistics.noise_conditions import ALL, MAX_LOG_P, Condition
from procedures.statistics.significance import log_chi2_sf
from procedures.statistics.spectrum import hann, without_straight_line

PER_OCTAVE = 4  # bands
MIN_IN_BAND, FIRST_BIN = 6, 8  # frequencies of the periodogram
HANN_CORRELATION = 1.94  # neighbouring frequencies hang together: variance of a band's mean, in those of one
MATERIAL = 1.3  # ratio of a band's power to the fit, from which on it matters: 15 % of a deviation
MIN_BANDS = 8
ITERATIONS = 12
PERIODS_AVERAGED = 8.0  # of the highest frequency that is noise: above it 2 % of the white noise are missing
TOP_OF_THE_BAND = 0.35  # cycles a sample: what rises above it only is no vibration but rows in turn
FLOOR = 1e-9  # of the largest density, below which a band is rounding


@dataclass(frozen=True, slots=True, eq=False)
class Bands:
    """The mean periodogram ``power`` (m,) [R^2] of bands, degrees of freedom, their basis (m, 5) and upper ends.

    ``top`` (m,) are in cycles a sample, between 0 and 1/2.
    """

    power: FloatArray
    dof: FloatArray
    basis: FloatArray
    top: FloatArray


def bands_of(rate: FloatArray) -> Bands:
    """Return the bands of a record ``rate`` (n,) [R] without its lines."""
    n = len(rate)
    window = hann(n)
    power = np.abs(rfft(without_straight_line(rate) * window)) ** 2 / float(window @ window)
    last = len(power) - 2
    edges = [FIRST_BIN]
    while edges[-1] < last:
        edges.append(max(round(edges[-1] * 2 ** (1 / PER_OCTAVE)), edges[-1] + MIN_IN_BAND))
    edges = [*edges[:-2], last] if len(edges) > 2 else [FIRST_BIN, last]
    w = 2 * np.sin(np.pi * np.arange(len(power)) / n)
    w[0] = 1.0
    basis = np.stack([w**2, np.ones_like(w), 1 / w, 1 / w**2, 1 / w**4], axis=1)[:last]
    count = np.diff(edges)
    at = edges[:-1]
    mean = np.add.reduceat(power[:last], at) / count
    return Bands(
        mean, 2 * count / HANN_CORRELATION, np.add.reduceat(basis, at, axis=0) / count[:, None],
        np.array(edges[1:]) / n,
    )  # fmt: skip


def fitted(bands: Bands, used: slice) -> tuple[FloatArray, float]:
    """Return the power (m,) [R^2] that terms fitted to the bands ``used`` make, and ln p of what they leave."""
    P, dof, X = bands.power[used], bands.dof[used], bands.basis[used]
    S = np.maximum(P, FLOOR * P.max())
    scale = X.max(axis=0)
    for _ in range(ITERATIONS):
        weight = np.sqrt(dof / 2) / S
        c, _ = nnls(weight[:, None] * X / scale, weight * P)
        S = np.maximum(X @ (c / scale), FLOOR * P.max())
    ratio = np.maximum(P / S, 1e-12)
    deviance = float(np.sum(dof * (ratio - 1 - np.log(ratio))))
    free = max(len(P) - int(np.sum(c > 0)), 1)
    whole: FloatArray = np.maximum(bands.basis @ (c / scale), FLOOR * P.max())
    return whole, log_chi2_sf(deviance, free)


def _is_material(bands: Bands, S: FloatArray, used: slice) -> bool:
    """Say whether a band is off the fit by more than `MATERIAL`, and by more than its own scatter."""
    off = np.abs(np.log(bands.power[used] / S[used]))
    return bool(np.any(off > np.log(MATERIAL) + 2 * np.sqrt(2 / bands.dof[used])))


def spectral_condition(rate: FloatArray, period: float) -> tuple[Condition, float] | None:
    """Return what the spectrum of ``rate`` (n,), any unit, ``period`` [s] apart, has beyond noise, if anything.

    With it the least averaging time [s] at which the Allan deviation is that of the noise terms.
    """
    bands = bands_of(rate)
    m = len(bands.power)
    if not bands.power.max() > 0 or m < MIN_BANDS:
        return None
    S, log_p = fitted(bands, slice(0, m))
    if log_p > MAX_LOG_P or not _is_material(bands, S, slice(0, m)):
        return None
    last = m - 1
    while last >= MIN_BANDS:
        S, log_p = fitted(bands, slice(0, last))
        if log_p > MAX_LOG_P / 2 or not _is_material(bands, S, slice(0, last)):
            break
        last -= 1
    top = float(bands.top[last - 1])
    tau = PERIODS_AVERAGED * period / top if last >= MIN_BANDS else len(rate) * period
    above = bands.power[last:] / S[last:]
    hertz = top / period
    at = last + int(np.argmax(above))
    lost: tuple[str, ...] = ("quantisation",)
    values = {"above_hz": hertz}
    if above.max() <= 1 / above.min():
        name, what = "filtered", "falls off, as behind a low-pass filter or of interpolated samples"
    elif at == m - 1 and top > TOP_OF_THE_BAND:
        lost, name = ALL, "rows_alternate"
        what = "rises to half of the sample rate, as where two devices write rows in turn"
    else:
        peak = float(bands.top[at]) / period
        name, what = "vibration", f"has a hill near {peak:.3g} Hz, as of vibration or a resonance"
        values["peak_hz"] = peak
    text = f"Above {hertz:.3g} Hz the spectrum {what}."
    if lost != ALL:
        text += f" The terms are those of averaging times over {tau:.3g} s."
    return Condition(name, text, lost, values, is_of_recording=lost == ALL), tau
