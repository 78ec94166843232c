"""How many sigmas an effect does beside all that an innocent campaign may absorb, by plain least squares.

Nothing here is of the diagnosis. A unit without noise is run with the effect and without it; what differs, in
blocks of each rest and in the whole of each turn, is whitened by the noise of a count and of the sensor, and what
biases, scale factors, misalignments, faces, slab, headings and closures can take is taken off.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from drivers.simulated.effects import Planted
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, FreePosition, Step, Turn
from procedures.counts.sample_records import CountSeries
from tests.benchmarks.diagnosing.designs import unit
from tests.benchmarks.undeclared_kinds.campaigns import CERTIFICATE, DESIGNS, Made, campaigns_of, truth_of
from tests.benchmarks.undeclared_kinds.kind import Kind

FINER = 1e4  # counts, so that a floor is no noise
FACE, SLAB, ANY = 1e-3, 5e-3, 1e3  # rad: what is plausible of a face and a slab; of the unit's own parameters
LEAST, MOST, NEAR = 6.0, 20.0, 0.15
TRIES = 30
DEG_H = 3600.0


@dataclass(frozen=True, slots=True, eq=False)
class Bench:
    """A campaign of a seed without noise; ``columns`` (m, p): what is innocent, whitened, in prior sigmas."""

    truth: Truth
    design: str
    seed: int
    block_s: float
    rows_of: np.ndarray
    columns: np.ndarray

    def added(self, also: Planted) -> np.ndarray:
        """Return what an effect adds (m,), whitened."""
        made = campaigns_of(self.truth, self.design, self.seed, also)
        return _rows(made, self.truth, self.block_s) - self.rows_of

    def with_effect(self, name: str, sizes: Mapping[str, float]) -> np.ndarray:
        """Return what an effect of the simulator's own adds (m,), whitened; the files say nothing of it."""
        truth = replace(self.truth, effects={name: dict(sizes)})
        made = campaigns_of(truth, self.design, self.seed, stated=self.truth)
        return _rows(made, self.truth, self.block_s) - self.rows_of

    def products(self, added: np.ndarray) -> np.ndarray:
        """Return inner products (k, k) of what is left of effects (m, k) beside all that is innocent."""
        seen = self.columns.T @ added
        M = self.columns.T @ self.columns + np.eye(self.columns.shape[1])
        left: np.ndarray = added.T @ added - seen.T @ np.linalg.solve(M, seen)
        return left

    def sigmas(self, also: Planted) -> float:
        """Return how many sigmas an effect does."""
        return float(np.sqrt(max(self.products(self.added(also)[:, None])[0, 0], 0.0)))


def bench_of(kind: Kind, seed: int) -> Bench:
    """Return the bench of a kind's campaign of a seed, the kind in it at nought."""
    truth = quiet(truth_of(kind.design, seed))
    none = kind.planted(seed, truth, 0.0)
    made = campaigns_of(truth, kind.design, seed, none)
    columns = _columns(made, truth, DESIGNS[kind.design].is_certified, kind.block_s)
    return Bench(truth, kind.design, seed, kind.block_s, _rows(made, truth, kind.block_s), columns)


def quiet(truth: Truth) -> Truth:
    """Return a unit without noise, its counts finer than any; the hands' scatter stays as it is."""
    return replace(
        truth, accel_noise_g=0.0, gyro_arw_deg_rt_s=0.0, gyro_instability_dph=0.0, accel_instability_g=0.0,
        accel_k=truth.accel_k * FINER, gyro_k=truth.gyro_k * FINER,
    )  # fmt: skip


def sized(kind: Kind, seed: int) -> tuple[float, float, Bench]:
    """Return a size of 6 to 20 sigmas, drawn, and how many it is; bisection, since not every kind is linear."""
    bench = bench_of(kind, seed)
    asked = float(np.random.default_rng([seed, 43]).uniform(LEAST, MOST))
    low, high = np.log(kind.least), np.log(kind.most)
    for _ in range(TRIES):
        size = float(np.exp((low + high) / 2))
        got = bench.sigmas(kind.planted(seed, bench.truth, size))
        if abs(got / asked - 1) < NEAR:
            break
        low, high = (np.log(size), high) if got < asked else (low, np.log(size))
    return size, got, bench


def _rows(made: Made, truth: Truth, block_s: float) -> np.ndarray:
    return np.concatenate([_whitened(_seen(step, each, truth, block_s), step, truth, block_s).ravel()
                           for step, each in made.steps])  # fmt: skip


def _seen(step: Step, series: CountSeries, truth: Truth, block_s: float) -> np.ndarray:
    """Return rates (n, 6) [g, deg/s] in blocks of a rest, totals (1, 6) [-, deg] of a turn."""
    period = truth.sample_period_s
    every = np.concatenate((series.accel / truth.accel_k, series.gyro / truth.gyro_k), axis=1)
    if isinstance(step, Turn):
        total: np.ndarray = every.sum(axis=0, keepdims=True)
        return total
    size = max(1, round(block_s / period))
    whole = every[: len(every) // size * size].reshape(-1, size, 6)
    rates: np.ndarray = whole.mean(axis=1) / period
    return rates


def _whitened(rows: np.ndarray, step: Step, truth: Truth, block_s: float) -> np.ndarray:
    """Return rows (n, ..) in sigmas: accelerometers of a turn count nothing."""
    if isinstance(step, Turn):
        seconds = 60.0
        std = np.sqrt((1e-4 * np.sqrt(seconds)) ** 2 + (0.01 / DEG_H * seconds) ** 2 + 1 / 6 / 180000.0**2)
        return np.asarray(rows * np.array([0, 0, 0, 1, 1, 1]).reshape(-1, *[1] * (rows.ndim - 2)) / std)
    whiten = [_whitening(len(rows), block_s, triad) for triad in ("accel", "gyro")]
    parts = [
        np.tensordot(W, rows[:, part], axes=1) for W, part in zip(whiten, (slice(3), slice(3, 6)), strict=True)
    ]
    return np.concatenate(parts, axis=1)


@cache
def _whitening(n: int, block_s: float, triad: str) -> np.ndarray:
    """Return W (n, n) that makes a unit's noise in blocks white: of samples, of counts' floors, of instability."""
    truth = unit(1)
    white = truth.accel_noise_g * np.sqrt(truth.sample_period_s) if triad == "accel" else truth.gyro_arw_deg_rt_s
    k = float(np.mean(truth.accel_k if triad == "accel" else truth.gyro_k))
    slow = 0.0 if triad == "accel" else truth.gyro_instability_dph / DEG_H
    C = (
        white**2 / block_s * np.eye(n)
        + (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)) / 12 / (k * block_s) ** 2
    )
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) * block_s
    C += slow**2 * np.exp(-apart / truth.instability_tau_s)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(C)))


def _columns(made: Made, truth: Truth, is_certified: bool, block_s: float) -> np.ndarray:
    """Return what is innocent, whitened, each column one prior sigma of its parameter: (m, p)."""
    face = CERTIFICATE if is_certified else FACE
    found = list[np.ndarray]()
    own = sum({Dwell: 1, Turn: 1, FreePosition: 3}.get(type(s), 1) for s, _ in made.steps)
    width, at = 24 + 12 + 2 + own, 38
    for step, series in made.steps:
        seen = _seen(step, series, truth, block_s)
        seconds = len(series) * truth.sample_period_s if isinstance(step, Turn) else 1.0
        mean = seen.mean(axis=0)
        f = np.linalg.solve(truth.accel_e, mean[:3] / seconds - truth.accel_d_g)
        omega = np.linalg.solve(truth.gyro_e, mean[3:] - truth.gyro_d_deg_s * seconds)
        up = np.round(f / np.linalg.norm(f))
        rows = np.zeros((6, width))
        for i in range(3):
            rows[i, 4 * i : 4 * i + 4] = ANY * np.append(f, 1.0)
            rows[3 + i, 12 + 4 * i : 16 + 4 * i] = ANY * np.append(omega, seconds)
        if not isinstance(step, FreePosition):
            along, sign = int(np.argmax(np.abs(f))), f[np.argmax(np.abs(f))] > 0
            for j, across in enumerate(i for i in range(3) if i != along):
                rows[:, 24 + 4 * along + 2 * int(sign) + j] = face * _turned(f, omega, np.eye(3)[across])
        if isinstance(step, Turn):
            rows[3:, at] = truth.closure_std_deg * omega / np.linalg.norm(omega)
            at += 1
        elif isinstance(step, FreePosition):
            rows[:, at : at + 3] = np.stack([_turned(f, omega, axis) for axis in np.eye(3)], axis=1)
            at += 3
        else:
            rows[:, at] = np.radians(truth.heading_std_deg) * _turned(f, omega, up)
            at += 1
            north = omega - (omega @ up) * up
            north /= np.linalg.norm(north)
            rows[:, 36] = SLAB * _turned(f, omega, np.cross(north, up))
            rows[:, 37] = SLAB * _turned(f, omega, north)
        every = np.broadcast_to(rows, (len(seen), 6, width))
        found.append(_whitened(every, step, truth, block_s).reshape(-1, width))
    return np.concatenate(found)


def _turned(f: np.ndarray, omega: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return what a rotation of 1 rad about an axis (3,) of the cube changes of both triads (6,)."""
    return np.concatenate((np.cross(f, axis), np.cross(omega, axis)))
