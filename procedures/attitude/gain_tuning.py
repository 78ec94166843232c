"""Gains of the complementary filter by cross-validation: over a grid, on held-out stretches of the log."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_estimate import estimate
from procedures.attitude.attitude_log import AttitudeLog, inclination
from procedures.attitude.complementary_gains import ComplementaryGains
from procedures.errors import NotObservable
from procedures.units import STANDARD_GRAVITY

TAUS = tuple(float(tau) for tau in np.geomspace(0.5, 200.0, 25))
FOLDS = 5  # stretches of equal numbers of rows: neighbours in time are not independent


@dataclass(frozen=True, slots=True, eq=False)
class GainTuning:
    """Errors over a grid of gains.

    ``rms`` (m,) [rad] is the inclination error of each of ``candidates`` over all rows, ``by_fold`` (m, FOLDS) in
    each stretch. ``best`` is the index of the least. ``picked`` are the candidates that the other stretches chose
    for each, ``held_out`` [rad] is the rms of those choices on the stretches that had no say.
    """

    candidates: tuple[ComplementaryGains, ...]
    rms: FloatArray
    by_fold: FloatArray
    best: int
    picked: tuple[int, ...]
    held_out: float
    rows: int

    @property
    def at_edge(self) -> bool:
        """Whether the best stands at an end of the grid, so that better ones may lie beyond."""
        grids = ([getattr(each, name) for each in self.candidates] for name in ("k1", "k2"))
        return any(len(set(grid)) > 1 and grid[self.best] in (min(grid), max(grid)) for grid in grids)


def grid_of_taus(taus: Sequence[float] = TAUS) -> tuple[ComplementaryGains, ...]:
    """Return critically damped gains (You and Lee eq. 15) over time constants [s]."""
    return tuple(ComplementaryGains.of_time_constant(tau) for tau in taus)


def grid_of_gains() -> tuple[ComplementaryGains, ...]:
    """Return K1 (0.005 to 2 1/s) and K2 (0.0005 to 0.5 1/s) on a grid, both in equal ratios."""
    return tuple(
        ComplementaryGains(float(k1), float(k2))
        for k1 in np.geomspace(0.005, 2, 9)
        for k2 in np.geomspace(5e-4, 0.5, 7)
    )


def tune(
    log: AttitudeLog, aid: str, candidates: Sequence[ComplementaryGains], gravity: float = STANDARD_GRAVITY
) -> GainTuning:
    """Run the filter with each of ``candidates`` and compare with the log's truth.

    Raises
    ------
    NotObservable
        If there is no truth, or too little of it to leave stretches out.
    """
    truth = log.true_down
    rows = np.zeros(len(log.t), bool) if truth is None else np.isfinite(truth).all(axis=1)
    if log.scored is not None:
        rows &= log.scored
    if truth is None:
        raise NotObservable("gains", ["roll_rad and pitch_rad to compare with"])
    if rows.sum() < 10 * FOLDS:
        which = f"{10 * FOLDS} {'scored rows' if log.scored is not None else 'rows'}"
        raise NotObservable("gains", [f"{which} with roll_rad and pitch_rad, of which it has {rows.sum()}"])
    fold = np.arange(rows.sum()) * FOLDS // rows.sum()
    down = [estimate(log, aid, gains, gravity).down[rows] for gains in candidates]
    square = np.array([inclination(each, truth[rows]) ** 2 for each in down])
    in_fold = np.stack([square[:, fold == i].mean(axis=1) for i in range(FOLDS)], axis=1)
    weight = np.bincount(fold, minlength=FOLDS) / rows.sum()
    picked = tuple(int(np.argmin(np.delete(in_fold, i, 1) @ np.delete(weight, i))) for i in range(FOLDS))
    held_out = np.sqrt(sum(weight[i] * in_fold[best, i] for i, best in enumerate(picked)))
    rms = np.sqrt(square.mean(axis=1))
    return GainTuning(
        tuple(candidates), rms, np.sqrt(in_fold), int(np.argmin(rms)), picked, float(held_out), int(rows.sum())
    )
