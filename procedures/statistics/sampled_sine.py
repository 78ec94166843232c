"""Sines at evenly spaced samples, and sums over them, without a sine of every sample.

Sample k is a multiple of m and a rest, so twice the root of n are exponentials, the others products of two.
"""

import numpy as np
import numpy.typing as npt

from procedures.arrays import FloatArray

Complex = npt.NDArray[np.complex128]


def sine(n: int, turns: float, amplitude: complex) -> FloatArray:
    """Return the real part (n,) of amplitude exp(2 pi i turns k), in its unit, ``turns`` [turns per sample]."""
    coarse, fine = _factors(n, turns)
    coarse = amplitude * coarse
    product = np.stack((coarse.real, -coarse.imag), axis=1) @ np.stack((fine.real, fine.imag))
    found: FloatArray = product.ravel()[:n]
    return found


def sine_sum(values: FloatArray, turns: float) -> complex:
    """Return the sum over k of values (n,) times exp(-2 pi i turns k), in their unit."""
    n = len(values)
    coarse, fine = _factors(n, -turns)
    whole = n // len(fine)
    parts = values[: whole * len(fine)].reshape(whole, -1) @ np.stack((fine.real, fine.imag), axis=1)
    rest = values[whole * len(fine) :]
    total = coarse[:whole] @ (parts[:, 0] + 1j * parts[:, 1])
    return complex(total + (coarse[whole] * (rest @ fine[: len(rest)]) if len(rest) else 0.0))


def slowed(values: FloatArray, turns: float, least: int) -> tuple[FloatArray, Complex]:
    """Return the middles of ``least`` or more parts, and sums over them of values (n,) times exp(-2 pi i turns k).

    The middles [samples] and sums (m,) determine the frequencies near: of one d turns per sample away what
    ``sums @ exp(-2 pi i d middles)`` gives is off by 2 d n / m of what noise does to it, 1 sigma: the samples of a
    part turn alike.
    """
    n = len(values)
    size = max(n // least, 1)
    edges = np.arange(0, n, size)
    sums: Complex = np.add.reduceat(values * sine(n, turns, 1.0), edges) - 1j * np.add.reduceat(
        values * sine(n, turns, -1j), edges
    )
    middles: FloatArray = (edges + np.append(edges[1:], n) - 1) / 2
    return middles, sums


def _factors(n: int, turns: float) -> tuple[Complex, Complex]:
    """Return exp(2 pi i turns k) of the multiples of m below n, and of the rests."""
    m = int(np.ceil(np.sqrt(n)))
    coarse, fine = (np.exp(2j * np.pi * (turns * k % 1.0)) for k in (np.arange(0, n, m), np.arange(m)))
    return coarse, fine
