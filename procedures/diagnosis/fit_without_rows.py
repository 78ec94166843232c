"""A linear fit without some of its rows, from what the whole fit holds."""

from dataclasses import replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.diagnosis.linear_model import LinearFit


def without_rows(fit: LinearFit, rows: IntArray) -> LinearFit:
    """Return a fit without some rows, their numbers (r,), dimensionless: its normal equations less theirs."""
    keep = np.ones(len(fit.Q), dtype=bool)
    keep[rows] = False
    design = fit.Q[keep]
    Q, R = np.linalg.qr(design)
    step = np.linalg.solve(R @ fit.R, Q.T @ fit.whole[keep])
    return replace(fit, Q=_spread(Q, keep), R=R @ fit.R, theta=fit.theta - step)


def _spread(Q: FloatArray, keep: BoolArray) -> FloatArray:
    wide = np.zeros((len(keep), Q.shape[1]))
    wide[keep] = Q
    return wide
