"""Turntables in the diagnosis: the base model is linear, ``N = k (E omega + D)``, and effects are added to it.

A sensor is taken in where a table turns about its own axis: elsewhere its scale factor is unknown. Of the inputs a
table says nothing of (gravity along the axes, field, time) nothing is known, and effects that need them do not
stand for election. The Earth's rate along the axis is in D. The file is cut into nine blocks, each left out in turn.

Noise of a point: second differences of three neighbouring sweeps' points of equal rate, in which what goes evenly
with time cancels, by their median; of a table without such points, of three neighbours' residual.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.calibration import Fits
from procedures.campaign import Campaign, RateTable
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.evidence import KINDS, TRIADS, Evidence, Weights
from procedures.diagnosis.model import fit_linear
from procedures.diagnosis.refit import ROUNDS, SMALL, Refit, beyond_linear, part_of, terms_at
from procedures.diagnosis.unexplained import chi2_of
from procedures.effects.effect import Seen, SeenStep
from procedures.frames import AXES
from procedures.solution import FitQuality, Solution

BLOCKS = 9
LEAST_POINTS = 4 * BLOCKS  # of a table worth cutting into blocks
LEAST_TRIPLES = 8  # second differences that a median is taken of
SAME_RATE = 1e-4  # of the largest, within which two points have the same
MAD = 1.482602  # of a normal distribution: 1 sigma over the median of the absolute deviations
GYROSCOPE = TRIADS.index("gyroscope")
OF_OUTPUT = ("gyroscope.scale_temperature", "clock.rate")  # multiply the whole output, other effects included


@dataclass(frozen=True, slots=True, eq=False)
class _Points:
    """All tables' points: ``omega`` (n, 3) [deg/s] IMU axes, ``output`` (n, s) of the sensors, the block of each."""

    omega: FloatArray
    output: FloatArray
    temperature: FloatArray
    block: IntArray
    noise: FloatArray  # (s,) [output]
    sensors: IntArray
    turned: IntArray  # the axes some table turns about
    names: tuple[tuple[str, int], ...]  # of each block: the table's and its campaign


@dataclass(frozen=True, slots=True, eq=False)
class RateTables:
    """Tables with the linear model fitted to them: ``K`` (s, p) [output/(deg/s)] and ``b`` (s,) [output].

    ``added`` (n, 3) [deg/s] is what effects add to E omega + D at the points, ``inside`` what of it is in the output
    that a change of scale multiplies.
    """

    campaigns: tuple[Campaign, ...]
    points: _Points
    K: FloatArray
    b: FloatArray
    added: FloatArray
    inside: FloatArray

    @property
    def k(self) -> FloatArray:
        """Scale factor (s,) [output/(deg/s)]."""
        own = np.searchsorted(self.points.turned, self.points.sensors)
        k = self.K[np.arange(len(own)), own]
        return np.asarray(np.sign(k) * np.linalg.norm(self.K, axis=1))

    def fitted(self, added: FloatArray, inside: FloatArray) -> "RateTables":
        """Return the linear model fitted to the output less what effects ``added`` (n, 3)."""
        p, k = self.points, self.k
        less = p.output - added[:, p.sensors] * k
        K, b = _line(p, less)
        return replace(self, K=K, b=b, added=added, inside=inside)

    def evidence(self) -> Evidence:
        """Return a row a point and sensor, block by block."""
        p, k = self.points, self.k
        n, s = p.output.shape
        base = p.omega[:, p.turned] @ self.K.T + self.b
        residual = (p.output - base) / k - self.added[:, p.sensors]
        design = np.column_stack((p.omega[:, p.turned], np.ones(n)))
        A = np.einsum("np,st->nstp", -design, np.eye(s)).reshape(n * s, -1)
        pick = np.eye(3)[p.sensors]
        weights = tuple(
            Weights(slice(i, i + 1), np.ones(1), slice(i * s, i * s + s), GYROSCOPE, pick) for i in range(n)
        )
        x = (np.column_stack((self.K, self.b)) / k[:, None]).ravel()
        columns = (np.zeros(0, dtype=np.int64), np.arange(len(x)))
        same = np.ones(n * s, dtype=np.int64)
        return Evidence(
            residual.ravel(), np.tile(p.noise / abs(k), n), A, GYROSCOPE * same, KINDS.index("rate") * same,
            np.repeat(p.block, s), np.tile(p.sensors, n), np.zeros(n * s, dtype=bool), x, columns, weights,
            self._seen(base / k),
        )  # fmt: skip

    def _seen(self, base: FloatArray) -> Seen:
        p, n = self.points, len(self.points.omega)
        output = p.omega + self.inside
        output[:, p.sensors] = base + self.inside[:, p.sensors]
        unknown, none = np.full((n, 3), np.nan), np.full(n, np.nan)
        steps = tuple(SeenStep(f"{name} block {i + 1}", "rate", c, 0, "") for i, (name, c) in enumerate(p.names))
        C_ib = np.stack([self.campaigns[steps[i].campaign].fixture.C_ib for i in p.block])
        return Seen(
            unknown, p.omega, unknown, unknown, output, unknown, none, none, p.temperature, none, {}, p.block, C_ib,
            steps,
        )  # fmt: skip

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Fit line and effects together, effects as exactly as they are known."""
        values = [np.zeros(len(each.columns.coefficients)) for each in added]
        at = self
        for _ in range(ROUNDS):
            evidence = at.evidence()
            terms, offsets = terms_at(evidence, added, values)
            evidence = beyond_linear(evidence, terms, values, offsets)
            linear = fit_linear(evidence, terms)
            found = [linear.coefficients(i) for i in range(len(terms))]
            moved = [np.max(abs(c - o) / np.sqrt(np.diag(C))) for (c, C), o in zip(found, values, strict=True)]
            values = [c for c, _ in found]
            if max(moved, default=0.0) < SMALL:
                break
            parts = [part_of(each, evidence, c)[1] for each, c in zip(added, values, strict=True)]
            inner = [part for each, part in zip(added, parts, strict=True) if each.effect.name not in OF_OUTPUT]
            at = at.fitted(_sum(parts, at.added), _sum(inner, at.added))
        fits = Fits(self.campaigns, None, None, None, None)
        return Refit(fits, evidence, linear, tuple(values), tuple(C for _, C in found))

    def report(self, refit: Refit) -> Solution:
        """Return how well the model fits; the scale factor of one axis alone is no triad's calibration."""
        chi2, dof, p = chi2_of(refit.evidence, refit.linear)
        return Solution(
            None, None, None, None, FitQuality(chi2, dof, p), (), np.zeros((0, 0)),
            float(np.nanmean(self.points.temperature)) if np.isfinite(self.points.temperature).any() else None,
        )  # fmt: skip


def rate_tables(campaigns: Sequence[Campaign]) -> RateTables | None:
    """Return the tables of one unit's campaigns with the linear model; None if no sensor's own axis was turned."""
    tables = [(number, table) for number, each in enumerate(campaigns) for table in each.rate_tables]
    axes = [campaigns[number].fixture.C_ib[:, AXES.index(table.axis)] for number, table in tables]
    seen = [np.isfinite(table.output).sum(axis=0) >= LEAST_POINTS for _, table in tables]
    own = np.array([has & (abs(axis) > 0.5) for has, axis in zip(seen, axes, strict=True)]).reshape(-1, 3)
    sensors = np.flatnonzero(own.any(axis=0))
    if not len(sensors):
        return None
    parts = [_taken(n, table, axis, sensors) for (n, table), axis in zip(tables, axes, strict=True)]
    points = _joined([part for part in parts if len(part["omega"]) >= LEAST_POINTS], sensors)
    K, b = _line(points, points.output)
    nothing = np.zeros_like(points.omega)
    return RateTables(tuple(campaigns), replace(points, noise=_noise(points, K, b)), K, b, nothing, nothing)


def _taken(number: int, table: RateTable, axis: FloatArray, sensors: IntArray) -> Mapping[str, object]:
    """Return the points of a table at which every sensor taken in was read."""
    known = np.isfinite(table.output[:, sensors]).all(axis=1)
    return {
        "omega": table.reference[known, None] * axis, "output": table.output[known][:, sensors],
        "temperature": table.temperature[known], "name": (table.name, number),
    }  # fmt: skip
