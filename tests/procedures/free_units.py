"""Units at rest and on the move in attitudes that nobody set, made without `procedures`' solvers: for tests."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import RestRecord, SequenceRecord
from procedures.campaign.observations import TriadRests
from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.frames import rotation

NO_SERIES = CountSeries(np.zeros(0), None, None, np.zeros(0), 0.02)
EARTH_DEG_S = 15.041067 / 3600
LATITUDE = 0.55  # rad
PERIOD = 0.01


@dataclass(frozen=True, eq=False)
class Unit:
    """k (3,), E (3, 3), D (3,) of one triad, K2 (3,) [g/g^2]."""

    k: FloatArray
    E: FloatArray
    D: FloatArray
    K2: FloatArray

    def output(self, u: FloatArray) -> FloatArray:
        """Output (n, 3) at inputs (n, 3)."""
        seen: FloatArray = self.k * (u @ self.E.T + self.D + self.K2 * u**2)
        return seen


def unit(rng: np.random.Generator, k: float, bias: float, *, lower: bool = False, quadratic: float = 0.0) -> Unit:
    """A unit drawn at random; ``lower``: E lower triangular."""
    E = np.eye(3) + 3e-3 * rng.standard_normal((3, 3)) * ~np.eye(3, dtype=bool)
    E = np.tril(E) if lower else E
    E /= np.linalg.norm(E, axis=1)[:, None]
    scale = k * (1 + 0.02 * rng.standard_normal(3))
    return Unit(scale, E, bias * rng.standard_normal(3), quadratic * rng.standard_normal(3))


def ups(rng: np.random.Generator, n: int) -> FloatArray:
    """Up vectors (n, 3) spread evenly over the sphere, turned at random."""
    i = np.arange(n) + 0.5
    z, angle = 1 - 2 * i / n, np.pi * (1 + 5**0.5) * i
    r = np.sqrt(1 - z**2)
    spread: FloatArray = np.stack((r * np.cos(angle), r * np.sin(angle), z), axis=1)
    return spread @ rotation(rng.standard_normal(3)).T


def at_rest(rate: FloatArray, std: float, up: str | None = None) -> TriadRests:
    """Rates (n, 3) as `rest_rates` would have returned them."""
    records = tuple((0, RestRecord(f"rest {i}", up, NO_SERIES)) for i in range(len(rate)))
    return TriadRests(records, rate, np.full(rate.shape, std), np.full(3, std))


def sequence(
    rng: np.random.Generator, accel: Unit, gyro: Unit, *, rests: int = 20, accel_noise: float, gyro_noise: float
) -> SequenceRecord:  # fmt: skip
    """Rests of 4 s and moves of 2 s about random axes, on a turning Earth; noise per sample [g], [deg/s]."""
    C = rotation(rng.standard_normal(3))  # level to body
    level_earth = EARTH_DEG_S * np.array([0.0, np.cos(LATITUDE), np.sin(LATITUDE)])
    still = round(4 / PERIOD)
    profile = 1 - np.cos(2 * np.pi * (np.arange(round(2 / PERIOD)) + 0.5) * PERIOD / 2)
    turned, rate = list[FloatArray](), list[FloatArray]()
    for i in range(rests):
        turned.append(np.broadcast_to(C, (still, 3, 3)))
        rate.append(np.zeros((still, 3)))
        if i == rests - 1:
            break
        axis = rng.standard_normal(3)
        axis *= rng.uniform(60, 170) / np.linalg.norm(axis) / profile.sum()  # deg a sample
        part = np.cumsum(profile)
        turned.append(rotation(-np.radians(np.outer(part - profile / 2, axis))) @ C)
        rate.append(np.outer(profile, axis) / PERIOD)
        C = rotation(-np.radians(part[-1] * axis)) @ C
    C_bn, w = np.concatenate(turned), np.concatenate(rate)
    f = C_bn[:, :, 2] + accel_noise * rng.standard_normal((len(w), 3))
    seen = w + C_bn @ level_earth + gyro_noise * rng.standard_normal((len(w), 3))
    t = PERIOD * np.arange(1, len(w) + 1)
    return SequenceRecord(
        "sequence.csv", RateSeries(t, gyro.output(seen), accel.output(f), np.full(len(t), np.nan), PERIOD)
    )
