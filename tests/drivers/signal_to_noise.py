"""How far a kind of error of the literature stands out of the recorded counts.

A campaign is simulated twice with the same noise, with the kind and without it. A row is a channel's mean over a
step, or its slope within a rest, in units of the noise. Nothing here is the diagnosis's: what a calibration and
the bench absorb is projected off by columns in plain numpy, which are written again here.
"""

from dataclasses import dataclass

import numpy as np

from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, FreePosition, Step, Turn
from procedures.counts.sample_records import CountSeries
from tests.benchmarks.undeclared_kinds.campaigns import DESIGNS, Made, campaigns_of, truth_of
from tests.benchmarks.undeclared_kinds.literature import Kind

DPH = 1 / 3600.0  # deg/s of a deg/h
FREE = 1e3  # prior of what a calibration is free to take, far beyond any


@dataclass(frozen=True, slots=True)
class Shown:
    """Signal to noise of a kind in one campaign: in its best row, in all rows, and next to what is absorbed."""

    kind: str
    seed: int
    best: float
    row: str
    every: float
    left: float


def shown(kind: Kind, seed: int) -> Shown:
    """Simulate a kind's campaign with it and without it."""
    truth = truth_of(kind.design, seed)
    made, none = (campaigns_of(truth, kind.design, seed, kind.planted(seed, truth, scale)) for scale in (1.0, 0.0))
    added = np.concatenate([
        _rows(step, series, truth) - _rows(step, bare, truth)
        for (step, series), (_, bare) in zip(made.steps, none.steps, strict=True)
    ])  # fmt: skip
    best = int(np.argmax(np.abs(added)))
    A = _absorbed(none, truth, DESIGNS[kind.design].is_certified)
    left = added - A @ np.linalg.solve(A.T @ A + np.eye(A.shape[1]), A.T @ added)
    name = none.steps[best // 12][0].name
    row = f"{name} {'mean' if best % 12 < 6 else 'slope'} {'ax ay az gx gy gz'.split()[best % 6]}"
    # of a parameter with a prior, what it takes costs: (y - A b)'y is the chi-square of both
    return Shown(
        kind.name, seed, float(abs(added[best])), row, float(np.linalg.norm(added)), float(left @ added) ** 0.5
    )


def _noise(step: Step, n: int, truth: Truth) -> tuple[np.ndarray, np.ndarray]:
    """Return 1 sigma (6,) of a mean and of a change over a step of n samples [g, deg/s].

    White noise, the bias instability, and the floors of the counts; of the windows in `_rows`, by integrals.
    """
    seconds = n * truth.sample_period_s
    white = (
        np.repeat([truth.accel_noise_g * truth.sample_period_s**0.5, truth.gyro_arw_deg_rt_s], 3) ** 2 / seconds
    )
    slow = np.repeat([truth.accel_instability_g, truth.gyro_instability_dph * DPH], 3) ** 2
    floor = 1 / np.concatenate((truth.accel_k, truth.gyro_k)) ** 2 / seconds**2
    if isinstance(step, Turn):
        mean = np.sqrt(white + slow + floor / 6)
        mean[:3] = np.inf  # shaken by the hand
        return mean, np.full(6, np.inf)
    return np.sqrt(1.2 * white + slow + floor / n), np.sqrt(17.15 * white + 2 * slow + 60 * floor / n)


def _rows(step: Step, series: CountSeries, truth: Truth) -> np.ndarray:
    """Return the means and the changes over a step (12,), in sigmas.

    Those of a rest by windows that vanish at both ends, as of a line and a parabola through summed counts.
    """
    rates = np.concatenate((series.accel / truth.accel_k, series.gyro / truth.gyro_k), 1) / truth.sample_period_s
    mean, change = _noise(step, n := len(rates), truth)
    x = (np.arange(n) + 0.5) / n - 0.5
    level = np.ones(n) if isinstance(step, Turn) else 1.5 * (1 - 4 * x**2)
    return np.concatenate((level @ rates / n / mean, 30 * x * (1 - 4 * x**2) @ rates / n / change))


def _absorbed(made: Made, truth: Truth, is_certified: bool) -> np.ndarray:
    """Return what a calibration and the bench absorb (12 steps, columns), in sigmas, times their prior sigma.

    Scale factors, misalignments and biases; both tilts of each face and of the plate; a heading of each position,
    a closure of each turn, all three angles of each free rest.
    """
    count = len(made.steps)
    whole = np.zeros((count, 12, 24 + 12 + 2 + 3 * count))
    for i, (step, series) in enumerate(made.steps):
        seconds = len(series) * truth.sample_period_s
        mean, _ = _noise(step, len(series), truth)
        f = np.linalg.solve(truth.accel_e, series.accel.mean(axis=0) / truth.accel_k / truth.sample_period_s)
        w = np.linalg.solve(truth.gyro_e, series.gyro.mean(axis=0) / truth.gyro_k / truth.sample_period_s)
        to = whole[i, :6]
        for channel in range(6):
            to[channel, 4 * channel : 4 * channel + 4] = FREE * np.append(f if channel < 3 else w, 1.0)
        turned = np.array([np.concatenate((np.cross(f, r), np.cross(w, r))) for r in np.eye(3)]).T
        along = int(np.argmax(np.abs(f)))
        up, own = f / np.linalg.norm(f), 38 + 3 * i
        if isinstance(step, FreePosition):
            to[:, own : own + 3] = turned
        elif isinstance(step, Turn):
            to[3:, own] = truth.closure_std_deg * w / np.linalg.norm(w) / seconds
        else:
            to[:, own] = np.radians(truth.heading_std_deg) * turned @ up
        if not isinstance(step, FreePosition):
            face = 24 + 4 * along + 2 * (f[along] > 0)
            to[:, face : face + 2] = (5e-6 if is_certified else FREE) * turned[
                :, [j for j in range(3) if j != along]
            ]
        if isinstance(step, Dwell):
            north = np.cross(np.cross(up, w), up)
            north /= np.linalg.norm(north)
            to[:, 36:38] = FREE * turned @ np.stack((np.cross(north, up), north), axis=1)
        to /= mean[:, None]
    return whole.reshape(12 * count, -1)
