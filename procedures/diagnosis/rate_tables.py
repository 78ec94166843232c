"""Turntables in the diagnosis: the base model is linear, ``N = k (E omega + D)``, and effects are added to it.

A change of scale acts on the rate turned, about the output at rest: of an analogue sensor that is a voltage.

Of what a table says nothing of (gravity along the axes, field, time where it has none) nothing is known, and
effects that need it do not stand for election. The Earth's rate along the table's axis is in D. Every block of the
file is a step, so that blocks are left out in turn.

Soaks that determine no calibration are diagnosed by what moves within them: the base model is a constant for each
recording and sensor. Scale factors are those of the units that were stated, misalignment is none; where no unit
was stated the output is its own unit. A long dwell or rest is a soak as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from procedures.anomalies.saturated_rates import without_saturated
from procedures.anomalies.wrong_rates import without_wrong_rows
from procedures.arrays import BoolArray, FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.solution_values import FitQuality, Solution
from procedures.campaign.campaign import Campaign, DwellRecord, RestRecord, SoakRecord
from procedures.effects.excitation import Excitation, ExcitationStep
from procedures.evidence.candidates import Candidate, raising_does_not_fit
from procedures.evidence.excitation import NodeBuilder
from procedures.evidence.linear_model import LinearFit
from procedures.evidence.rate_points import RatePoints, noise_of, read_points
from procedures.evidence.refit import Refit, added_at_nodes, iterate
from procedures.evidence.residual_rows import KINDS, Evidence, evidence_of
from procedures.evidence.row_sums import NodeWeights
from procedures.evidence.thermal_soaks import BLOCK_S, MIN_BLOCKS, soaks_seen
from procedures.frames import AXES, TRIADS
from procedures.inference.result import Finding, TableSensor
from procedures.statistics.significance import log_chi2_sf
from procedures.units import DEG_H_PER_DEG_S

GYROSCOPE = TRIADS.index("gyroscope")
OFFSET_SHARE = 0.1  # of the fastest rate: no gyroscope's bias is a tenth of the rates that it is made for


def usable_points(campaigns: Sequence[Campaign]) -> tuple[tuple[Campaign, ...], tuple[Finding, ...]]:
    """Return campaigns whose rate tables lack what says nothing of the sensor: beyond its range, wrong rows."""
    within, saturated = without_saturated(campaigns)
    right, wrong = without_wrong_rows(within)
    return right, (*saturated, *wrong)


@dataclass(frozen=True, slots=True, eq=False)
class RateTables:
    """Tables with the linear model fitted to them: parameters ``x`` (p,) [output/(deg/s), output], ``noise`` (r,).

    ``added`` (n, 3) [deg/s] is what effects add to E omega + D at the points; ``inside`` what of it belongs to the
    output that a change of scale multiplies.
    """

    campaigns: tuple[Campaign, ...]
    points: RatePoints
    noise: FloatArray
    noise_dof: float
    x: FloatArray
    added: FloatArray
    inside: FloatArray

    @classmethod
    def of(cls, campaigns: Sequence[Campaign]) -> Self | None:
        """Return the tables of one unit's campaigns; None if no sensor's own axis was turned about."""
        points = read_points(campaigns)
        if points is None:
            return None
        design = points.design()
        root = np.sqrt(points.count)
        fitted = np.linalg.lstsq(design * root[:, None], points.output * root, rcond=None)[0]
        x = np.asarray(fitted, dtype=np.float64)
        nothing = np.zeros_like(points.omega)
        return cls(tuple(campaigns), points, *noise_of(points, points.output - design @ x), x, nothing, nothing)

    def evidence(self) -> Evidence:
        """Return a row an output, less what effects added."""
        p = self.points
        k, design, r = p.scale(self.x)[p.sensor], p.design(), len(p.output)
        residual = (p.output - design @ self.x) / k - self.added[p.at, p.sensor]
        weights = tuple(
            NodeWeights(slice(at, at + 1), np.ones(1), slice(i, i + 1), GYROSCOPE, np.eye(3)[sensor][None])
            for i, (at, sensor) in enumerate(zip(p.at.tolist(), p.sensor.tolist(), strict=True))
        )
        columns = (np.zeros(0, dtype=np.int64), np.arange(len(self.x)))
        whole = np.ones(r, dtype=np.int64)
        return Evidence(
            residual, self.noise / abs(k), -design / k[:, None], GYROSCOPE * whole, KINDS.index("rate") * whole,
            p.block[p.at], p.sensor, np.zeros(r, dtype=bool), self.x, columns, weights, self._seen(),
            self.noise_dof,
        )  # fmt: skip

    def _seen(self) -> Excitation:
        p, n = self.points, len(self.points.omega)
        output = p.omega + self.inside
        about_offset = np.where(_is_offset(p, self.x), 0.0, self.x)
        base = p.design() @ about_offset / p.scale(self.x)[p.sensor]
        output[p.at, p.sensor] = base + self.inside[p.at, p.sensor]
        unknown, none = np.full((n, 3), np.nan), np.full(n, np.nan)
        steps = tuple(
            ExcitationStep(f"{name} block {i}", "rate", number, 0, "", clock=clock)
            for (name, i, number), clock in zip(p.blocks, p.clocks, strict=True)
        )
        C_sb = np.stack([self.campaigns[p.blocks[i][2]].fixture.C_sb for i in p.block])
        return Excitation(
            f=unknown, omega=p.omega, magnetic=unknown, accel_output=unknown, gyro_output=output, change=unknown,
            t=p.t, rest_s=none, temperature=p.temperature, temperature_rate=p.warming, auxiliary={}, step=p.block,
            C_sb=C_sb, E_accel=np.tile(np.eye(3), (n, 1, 1)), E_gyro=np.tile(np.eye(3), (n, 1, 1)), steps=steps,
        )  # fmt: skip

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Fit line and effects together; what an effect adds beyond its columns is subtracted.

        Raises
        ------
        DoesNotFit
            If the line with the effects in it cannot be fitted.
        """
        with raising_does_not_fit(bool(added)):
            fits = CampaignFits(self.campaigns, None, None, None, None)
            return iterate(self, type(self).evidence, type(self).without, lambda *_: fits, added)

    def without(self, evidence: Evidence, added: Sequence[Candidate], values: Sequence[FloatArray]) -> Self:
        """Fit the linear model to the outputs less what effects add, with ``values`` (k,) each, in their units."""
        total, inside = np.zeros_like(self.added), np.zeros_like(self.added)
        for candidate, c in zip(added, values, strict=True):
            _, part, _ = added_at_nodes(candidate, evidence, c)
            if part is not None:
                total = total + part
                inside = inside if candidate.effect.multiplies_output else inside + part
        p, scale = self.points, self.points.scale(self.x)
        less = p.output - total[p.at, p.sensor] * scale[p.sensor]
        white = p.design() / self.noise[:, None]
        x = np.asarray(np.linalg.lstsq(white, less / self.noise, rcond=None)[0], dtype=np.float64)
        return replace(self, x=x, added=total, inside=inside)

    def report(self, found: Refit) -> Solution:
        """Return how well the model fits: one axis' scale factor and bias are no triad's calibration."""
        T = self.points.temperature
        mean = float(np.nanmean(T)) if np.isfinite(T).any() else None
        return Solution(None, None, None, None, _quality(found.linear), (), np.zeros((0, 0)), mean)

    def on_table(self, found: Refit) -> tuple[TableSensor, ...]:
        """Return scale factor and bias of every sensor, the effects in."""
        p, size = self.points, len(self.x)
        x, C = found.evidence.x + found.linear.theta[:size], found.linear.covariance[:size, :size]
        return tuple(_sensor(p, x, C, int(sensor)) for sensor in np.unique(p.sensor))


def _is_offset(points: RatePoints, x: FloatArray) -> BoolArray:
    """Say of every parameter (p,) whether it is an analogue output's zero point, which no rate gives."""
    sensor, is_bias = points.parameters[:, 0], points.parameters[:, 1] < 0
    fastest = np.array([np.max(np.abs(points.omega[points.at[points.sensor == i]])) for i in sensor.tolist()])
    found: BoolArray = is_bias & (np.abs(x) > OFFSET_SHARE * fastest * np.abs(points.scale(x)[sensor]))
    return found


def _sensor(points: RatePoints, x: FloatArray, C: FloatArray, sensor: int) -> TableSensor:
    k = float(points.scale(x)[sensor])
    own = points.parameters[:, 0] == sensor
    rate, bias = own & (points.parameters[:, 1] >= 0), own & (points.parameters[:, 1] < 0)
    D = float(x[bias][0]) / k
    of_k = np.where(rate, x / k, 0.0)
    of_D = (bias - D * of_k) / k
    std = [float(np.sqrt(g @ C @ g)) for g in (of_k, of_D)]
    return TableSensor(
        AXES[sensor], k, std[0], DEG_H_PER_DEG_S * D, DEG_H_PER_DEG_S * std[1], float(x[bias][0]),
        float(np.sqrt(C[bias][:, bias][0, 0])), bool(_is_offset(points, x)[bias][0]),
    )  # fmt: skip


def _quality(linear: LinearFit) -> FitQuality:
    chi2 = float(np.sum((linear.white * linear.factor) ** 2))
    dof = round(float(np.sum(1 - linear.leverage)))
    return FitQuality(chi2, dof, float(np.exp(log_chi2_sf(chi2, dof))))


LONG_REST_S = 2 * MIN_BLOCKS * BLOCK_S  # of a dwell that is a soak too


@dataclass(frozen=True, slots=True, eq=False)
class SoaksAlone:
    """Campaigns of which only the soaks are looked at; nothing of them is solved."""

    fits: CampaignFits

    @classmethod
    def of(cls, campaigns: Sequence[Campaign]) -> "SoaksAlone | None":
        """Return the soaks of one unit's campaigns, long rests among them; None if none has blocks enough."""
        found = cls(CampaignFits(tuple(_with_long_rests(each) for each in campaigns), None, None, None, None))
        if not any(campaign.soaks for campaign in found.fits.campaigns):
            return None
        return found if soaks_seen(found.fits, NodeBuilder(found.fits)) else None

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Fit constants and effects together.

        Raises
        ------
        DoesNotFit
            If they cannot be fitted with the effects in.
        """
        with raising_does_not_fit(bool(added)):
            return iterate(self.fits, evidence_of, lambda fits, *_: fits, lambda fits, *_: fits, added)

    def report(self, found: Refit) -> Solution:
        """Return how well the model fits: there is no calibration."""
        linear = found.linear
        chi2 = float(np.sum((linear.white * linear.factor) ** 2))
        dof = round(float(np.sum(1 - linear.leverage)))
        # draws of a bias's noise may take up every block
        quality = FitQuality(chi2, dof, float(np.exp(log_chi2_sf(chi2, dof))) if dof else 1.0)
        return Solution(None, None, None, None, quality, (), np.zeros((0, 0)), None)

    def on_table(self, found: Refit) -> tuple[TableSensor, ...]:
        """Return none: a rest is no table."""
        return ()


def _with_long_rests(campaign: Campaign) -> Campaign:
    held: list[DwellRecord | RestRecord] = [*campaign.dwells, *campaign.rests]
    more = tuple(_as_soak(each) for each in held if len(each.series) * each.series.period >= LONG_REST_S)
    return replace(campaign, soaks=(*campaign.soaks, *more))


def _as_soak(rest: DwellRecord | RestRecord) -> SoakRecord:
    if isinstance(rest, DwellRecord):
        return SoakRecord(rest.name, rest.position, None, rest.series)
    return SoakRecord(rest.name, 0, rest.up, rest.series)
