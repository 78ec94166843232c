"""A reference angle with a turning gyroscope, an encoder's or a motor's, as points of a rate table.

Over a block of time the angle grew by so much, and the gyroscope put out so much on average: both means are exact
whatever the rate did between. At the edges of blocks angle, time and integrals are averaged over the same rows, so
that an encoder's noise is, too. An angle that is read late is found by the blocks in which the rate changes.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray

LEAST_BLOCKS, MOST_BLOCKS = 40, 100  # long ones: what an encoder cannot resolve is a small part of their turn
ROWS = 8  # of a block, at the least
LEAST_ROWS = 2 * LEAST_BLOCKS
EDGE_PART = 3  # of a block, one of so many, over which its edges are averaged
FARTHEST_S = 1.0  # that an angle is looked for before or after its row
ROUNDS = 8  # of Gauss and Newton
SURE = 5.0  # sigmas from which on a delay is taken out


@dataclass(frozen=True, slots=True, eq=False)
class MeanRates:
    """Means over m blocks: ``t`` (m,) [s], ``reference`` (m,) [deg/s], ``values`` (m, k) as they are put in."""

    t: FloatArray
    reference: FloatArray
    values: FloatArray


def unwrapped(angle: FloatArray) -> FloatArray:
    """Return an angle (n,) [deg] that may begin again at each turn as one that goes on."""
    return np.unwrap(angle, period=360.0)


def slope_and_correlation(reference: FloatArray, output: FloatArray) -> tuple[float, float]:
    """Return the slope of ``output`` (n,) over ``reference`` (n,), in their units, and their correlation.

    Both are 0 where one of the two never changes.
    """
    u, y = reference - np.mean(reference), output - np.mean(output)
    if not (uu := float(u @ u)) > 0 or not (yy := float(y @ y)) > 0:
        return 0.0, 0.0
    return float(u @ y) / uu, float(u @ y) / float(np.sqrt(uu * yy))


def mean_rates(
    t: FloatArray, angle: FloatArray, values: FloatArray, late_s: float = 0.0, margin_s: float | None = None
) -> MeanRates:
    """Return means over blocks of rows.

    Parameters
    ----------
    t, angle : (n,) float64, s and deg
        Rows, and the angle that goes on; n is at least `LEAST_ROWS`.
    values : (n, k) float64
        What is averaged by trapezes: outputs, a temperature. What is not known (nan) goes straight between its
        neighbours; a block that ends before the first known one, or begins after the last, is nan.
    late_s : s
        How much older than its row an angle is.
    margin_s : s
        What is left out at both ends, where the angle of that time was not recorded; ``late_s`` unless given.
    """
    margin = abs(late_s) if margin_s is None else margin_s
    values, known = _bridged(t, values)
    inside = (t >= t[0] + margin) & (t <= t[-1] - margin)
    angle, t, values = np.interp(t[inside] + late_s, t, angle), t[inside], values[inside]
    blocks = int(np.clip(len(t) // ROWS, LEAST_BLOCKS, MOST_BLOCKS))
    steps = np.diff(t)[:, None] * (values[1:] + values[:-1]) / 2
    total = np.concatenate((np.zeros((1, values.shape[1])), np.cumsum(steps, axis=0)))
    every = np.column_stack((t, angle, total))
    near = _averaged(every - every[0], max(len(t) // blocks // EDGE_PART, 1))
    grown = np.diff(near[np.linspace(0, len(near) - 1, blocks + 1).round().astype(int)], axis=0)
    end = t[0] + near[0, 0] + np.cumsum(grown[:, 0])
    unknown = (end[:, None] < known[0]) | ((end - grown[:, 0])[:, None] > known[1])
    means = np.where(unknown, np.nan, grown[:, 2:] / grown[:, :1])
    return MeanRates(end - grown[:, 0] / 2, grown[:, 1] / grown[:, 0], means)


def _bridged(t: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return values (n, k) without nan, and between which times (2, k) [s] each column is known."""
    filled, known = np.zeros(values.shape), np.tile([[np.inf], [-np.inf]], values.shape[1])
    for i, column in enumerate(values.T):
        rows = np.flatnonzero(np.isfinite(column))
        if len(rows):
            filled[:, i] = np.interp(t, t[rows], column[rows])
            known[:, i] = t[rows[[0, -1]]]
    return filled, known


def _averaged(values: FloatArray, rows: int) -> FloatArray:
    """Return means (n - rows + 1, k) of so many neighbouring rows of values (n, k)."""
    total = np.concatenate((np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)))
    return (total[rows:] - total[:-rows]) / rows


def lateness(t: FloatArray, angle: FloatArray, output: FloatArray) -> tuple[float, float]:
    """Return how much older than its row an angle is, and 1 sigma [s]; infinite where nothing determines it.

    So it is where fewer than `LEAST_ROWS` are left between the ends. Of ``output = k d(angle)/dt + b`` with the
    angle shifted: a search first, then least squares.

    Parameters
    ----------
    t, angle, output : (n,) float64, s, deg, and outputs as they come
        Rows in order, the angle that goes on.
    """
    longest = min(FARTHEST_S, float(t[-1] - t[0]) / 20)
    grid = np.linspace(-longest, longest, 41)
    h = max(float(np.median(np.diff(t))), 1e-6)
    margin, std = longest + h, float("inf")
    if np.sum((t >= t[0] + margin) & (t <= t[-1] - margin)) < LEAST_ROWS:
        return 0.0, std
    late = float(grid[int(np.argmin([_line(t, angle, output, at, margin)[1] for at in grid]))])
    for _ in range(ROUNDS):
        rates = mean_rates(t, angle, output[:, None], late, margin)
        less, more = (mean_rates(t, angle, output[:, None], late + step, margin).reference for step in (-h, h))
        (k, _), _ = _line(t, angle, output, late, margin)
        A = np.column_stack((rates.reference, np.ones(len(rates.t)), k * (more - less) / (2 * h)))
        x, squares, rank, _ = np.linalg.lstsq(A, rates.values[:, 0], rcond=None)
        if rank < A.shape[1] or not len(squares):
            return 0.0, float("inf")
        std = float(np.sqrt(squares[0] / (len(A) - 3) * np.linalg.inv(A.T @ A)[2, 2]))
        late = float(np.clip(late + x[2], -longest, longest))
        if abs(x[2]) < 0.01 * std:
            break
    return late, std


def _line(
    t: FloatArray, angle: FloatArray, output: FloatArray, late: float, margin: float
) -> tuple[tuple[float, float], float]:
    """Return scale factor and bias of a line of the output over the rate, and the mean square that it leaves."""
    rates = mean_rates(t, angle, output[:, None], late, margin)
    A = np.column_stack((rates.reference, np.ones(len(rates.t))))
    k, b = np.linalg.lstsq(A, rates.values[:, 0], rcond=None)[0]
    return (float(k), float(b)), float(np.mean((rates.values[:, 0] - A @ (k, b)) ** 2))
