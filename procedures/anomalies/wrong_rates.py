"""Rows of a rate table that contradict the others: a sign or a digit typed wrong, two rows exchanged, a shock.

A row's output is held against the prediction by the others (`procedures.anomalies.held_out_rows`). They predict it
by a Gaussian process: a line for each direction of the rate; and, with variances that the table leaves open, a
smooth function of the rate (a cubic smoothing spline), a value of its own at each rate that is repeated, and a
walk with time or a smooth function of temperature, of the bias or of the scale factor. Every combination of
variances is a case. Noise is what the case leaves, Student's t at its degrees of freedom.

What an error term does to several rows at once is another explanation, as likely as a wrong row, and competes
with it: one rate at which all repeats are off, a jump or a settling of bias or scale factor, a zone about zero, an
end of the range. Where a rate at the end of the range was taken once, the others do not predict it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.linalg import solve_triangular

from procedures.anomalies.held_out_rows import HeldOut, WrongRow, find_wrong_rows, log_odds
from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign, RateTable
from procedures.evidence.rate_points import EXACT, LEAST_POINTS, ROWS_BY_HAND, same_rates
from procedures.frames import AXES
from procedures.inference.priors import PRESENT
from procedures.inference.result import Finding

EFFECT = "procedure.wrong_row"
# Standard deviations [noise] of the curves: from noise to the largest that a table shows, a case every 1.5 decades
OF_CURVE = (0.0, 3e1, 1e3, 3e4, 1e6)  # of the second derivative over the range of rates
OF_RATES = (0.0, 1e1, 3e2)
OF_DRIVEN = (3.0, 1e2, 3e3)  # over the whole table
OFFSET_SHARE = 0.1  # of the range of outputs: no error term but a curve of the rate adds as much to several rows
SETTLING_ROWS = (2.0, 5.0, 15.0)  # time constants of what settles after the start
LEAST_DOF = 3  # to judge the noise by
SEEN = 1e-8  # of the largest singular value, or of a column's squares: less is rounding


@dataclass(frozen=True, slots=True, eq=False)
class _Points:
    """Outputs ``y`` (n,) at ``rows`` (n,) of a table, and the columns H (n, m) that compete: first each row alone.

    ``free`` (n, p) are columns that act freely, ``covariances`` (c, n, n) those of the curves in each case
    [noise^2].
    """

    rows: IntArray
    y: FloatArray
    free: FloatArray
    H: FloatArray
    covariances: FloatArray

    def held_out(self, without: Sequence[int]) -> dict[int, HeldOut]:
        """Let each column act in turn where those ``without`` act freely."""
        # what is free is projected out first: an output a million sigmas off would cost all digits later
        U, extent, _ = np.linalg.svd(np.column_stack((self.free, self.H[:, list(without)])))
        N = U[:, int(np.sum(extent > SEEN * extent[0])) :]
        n, dof = N.shape
        if dof <= LEAST_DOF:
            return {}
        least = n * (EXACT * np.max(np.abs(self.y))) ** 2
        cases = [_whitened(N.T @ K @ N + np.eye(dof), N.T @ self.y, N.T @ self.H) for K in self.covariances]
        log_det, whole, size, along, rest = (np.stack(each) for each in zip(*cases, strict=True))
        weight = -0.5 * log_det - dof / 2 * np.log(whole + least)
        acts = size > SEEN * np.sum(self.H**2, axis=0)
        size, along = np.where(acts, size, 1.0), np.where(acts, along, 0.0)
        squares = (dof - 1) * along**2 / size / (rest + least)
        case = np.argmax(weight[:, None] + dof / 2 * np.log1p(squares / (dof - 1)), axis=0)
        most, largest = OFFSET_SHARE * np.ptp(self.y), np.max(np.abs(self.H), axis=0)
        found = dict[int, HeldOut]()
        for each in np.setdiff1d(np.flatnonzero(np.any(acts, axis=0)), list(without)).tolist():
            at, is_row = case[each], each < n
            off = along[at, each] / size[at, each]
            if is_row or abs(off) * largest[each] < most:
                one = log_odds(weight, squares[:, each], n if is_row else self.H.shape[1] - n, dof - 1)
                found[each] = HeldOut(float(off), float(np.sqrt(squares[at, each])), one)
        return found


def without_wrong_rows(campaigns: Sequence[Campaign]) -> tuple[tuple[Campaign, ...], tuple[Finding, ...]]:
    """Return campaigns whose rate tables lack outputs that contradict the others; a finding for each."""
    findings, kept = list[Finding](), list[Campaign]()
    for campaign in campaigns:
        tables = list[RateTable]()
        for table in campaign.rate_tables:
            output = table.output.copy()
            for sensor in np.flatnonzero(campaign.fixture.C_sb[:, AXES.index(table.axis)]).tolist():
                for wrong in find_wrong_rates(table, sensor):
                    findings.append(_finding(table, sensor, wrong))
                    if wrong.probability >= PRESENT:
                        output[wrong.row, sensor] = np.nan
            tables.append(replace(table, output=output))
        kept.append(replace(campaign, rate_tables=tuple(tables)))
    return tuple(kept), tuple(findings)


def find_wrong_rates(table: RateTable, sensor: int) -> tuple[WrongRow, ...]:
    """Find the rows of a table, written row by row, whose output of a sensor contradicts the others [output]."""
    points = _points(table, sensor)
    if points is None:
        return ()
    found = find_wrong_rows(points.held_out, len(points.y))
    rows = points.rows.tolist()
    return tuple(
        replace(each, row=rows[each.row], alternatives=tuple((rows[i], share) for i, share in each.alternatives))
        for each in found
    )


def _points(table: RateTable, sensor: int) -> _Points | None:
    rows = np.flatnonzero(np.isfinite(table.output[:, sensor]) & np.isfinite(table.reference))
    if not LEAST_POINTS <= len(rows) <= ROWS_BY_HAND or np.ptp(table.reference[rows]) == 0:
        return None
    if np.ptp(table.output[rows, sensor]) == 0:
        return None
    u, y = table.reference[rows] / np.max(np.abs(table.reference[rows])), table.output[rows, sensor]
    rates, rate, times = np.unique(same_rates(u), return_inverse=True, return_counts=True)
    at_end = (rate == 0) | (rate == len(rates) - 1)
    alone = np.flatnonzero(at_end & (times[rate] == 1))
    free = np.column_stack((np.ones(len(u)), u, np.abs(u), np.eye(len(u))[:, alone]))
    covariances = np.stack(list(_covariances(table, rows, u, rate)))
    H = np.column_stack((np.eye(len(u)), *_shared(u, rate)))
    return _Points(rows, y, free, H, covariances)


def _covariances(table: RateTable, rows: IntArray, u: FloatArray, rate: IntArray) -> Iterator[FloatArray]:
    """Yield the covariance (n, n) of the curves in each case [noise^2]."""
    spline, own = _spline(_unit(u)), np.equal.outer(rate, rate).astype(np.float64)
    time: FloatArray = rows.astype(np.float64) if table.t is None else table.t[rows]
    T = table.temperature[rows]
    drives: list[FloatArray] = [np.zeros_like(own)]
    if np.isfinite(time).all() and np.ptp(time) > 0:
        walk = np.minimum.outer(_unit(time), _unit(time))
        drives += [size**2 * by * walk for by in (1.0, np.outer(u, u)) for size in OF_DRIVEN]
    if np.isfinite(T).all() and np.ptp(T) > 0:
        smooth = np.outer(_unit(T), _unit(T)) + _spline(_unit(T))
        drives += [size**2 * by * smooth for by in (1.0, np.outer(u, u)) for size in OF_DRIVEN]
    has_repeats = len(np.unique(rate)) < len(rate)
    for curve, values, driven in product(OF_CURVE, OF_RATES if has_repeats else OF_RATES[:1], drives):
        yield curve**2 * spline + values**2 * own + driven


def _unit(x: FloatArray) -> FloatArray:
    found: FloatArray = (x - x.min()) / np.ptp(x)
    return found


def _spline(x: FloatArray) -> FloatArray:
    """Return the covariance (n, n) of a cubic smoothing spline of x (n,) in [0, 1], but for its line."""
    least, most = np.minimum.outer(x, x), np.maximum.outer(x, x)
    found: FloatArray = least**2 * (3 * most - least) / 6
    return found


def _shared(u: FloatArray, rate: IntArray) -> Iterator[FloatArray]:
    """Yield what an error term does to several rows (n,)."""
    for number in np.flatnonzero(np.bincount(rate) > 1).tolist():
        yield 1.0 * (rate == number)
    order = np.arange(len(u), dtype=np.float64)
    for first in range(2, len(u) - 1):
        after = (order >= first).astype(np.float64)
        yield after
        yield u * after
    for rows in SETTLING_ROWS:
        fading: FloatArray = np.exp(-order / rows)
        yield fading
        yield u * fading
    for edge in np.unique(np.abs(u)).tolist():
        if (np.abs(u) <= edge).sum() > 1:
            yield 1.0 * (np.abs(u) <= edge)
            yield u * (np.abs(u) <= edge)
        for side in (u, -u):
            if (side > edge).sum() > 1:
                yield np.asarray(np.maximum(side - edge, 0.0), np.float64)


def _whitened(C: FloatArray, y: FloatArray, H: FloatArray) -> tuple[np.ndarray, ...]:
    """Return ln det C (n, n); of y (n,), H (n, m) that C whitens, y'y, h'h, h'y and what each h leaves of y'y."""
    L = np.linalg.cholesky(C)
    white = solve_triangular(L, np.column_stack((y, H)), lower=True)
    y, H = white[:, 0], white[:, 1:]
    size, along = np.sum(H**2, axis=0), y @ H
    rest = np.sum((y[:, None] - H * (along / np.maximum(size, np.finfo(float).tiny))) ** 2, axis=0)
    return 2 * np.sum(np.log(np.diag(L))), y @ y, size, along, rest


def _finding(table: RateTable, sensor: int, wrong: WrongRow) -> Finding:
    number, counted = (
        ("line", table.lines) if table.lines is not None else ("point", range(1, len(table.output) + 1))
    )
    where: dict[str, object] = {"file": table.name, number: counted[wrong.row]}
    if wrong.alternatives:
        where |= {f"or_{number}": [counted[row] for row, _ in wrong.alternatives]}
    off = wrong.off / _scale(table.reference, table.output[:, sensor])
    return Finding(
        EFFECT, "procedure", (AXES[sensor],), np.array([off]), np.array([abs(off) / wrong.sigmas]), "deg/s",
        where | {"rate_deg_s": float(table.reference[wrong.row])}, wrong.probability,
        f"check the {number} in the file, or measure this rate again",
        "not used" if wrong.probability >= PRESENT else "used: another row may be the wrong one",
    )  # fmt: skip


def _scale(reference: FloatArray, output: FloatArray) -> float:
    """Return the scale factor [output/(deg/s)] of outputs (n,) at rates (n,); few wrong rows do not move it."""
    moves = np.flatnonzero(np.diff(reference))
    slope = float(np.nanmedian(np.diff(output)[moves] / np.diff(reference)[moves]))
    if slope:
        return slope
    known = np.isfinite(output)  # outputs in coarse steps
    return float(np.polyfit(reference[known], output[known], 1)[0])
