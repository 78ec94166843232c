"""Which of its face's two positions every dwell was in, read from the gyroscopes' own Earth rate.

A gyro at rest puts out, for up and North as unit vectors u, n in IMU axes,

    r = b + d t + G u + H n + noise

with bias b, its drift d, and in G its g-sensitivity and the Earth rate's vertical part; ``H = K w cos(latitude)``
plus what follows the heading alike, as a magnetic field does. All have broad normal priors about what the turns
say of K. Between the two positions of a face n changes sign, so labellings are compared by the likelihood of all
gyros' dwells together (a normal one, the coefficients integrated out), improved one dwell or two at a time. That
the biases jumped in one dwell instead is the same with more scatter in that dwell, of any size.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import channel
from procedures.counts.sample_records import CountSeries
from procedures.geodesy import earth_rate_n
from procedures.inference import priors
from procedures.inference.marginal import log_mean
from procedures.positions import ATTITUDES, face_normal, face_of, nominal_C_lb
from procedures.units import DEG_H_PER_DEG_S, S_PER_H

MIN_DWELLS = 5  # dwells
# 1 sigma, deg/s; deg/s per g, next to which the vertical Earth rate is small
BIAS_STD, G_SENSITIVITY_STD = 1.0, 0.01
DRIFT_STD = 10.0 / DEG_H_PER_DEG_S  # 1 sigma, deg/s per hour
NORTH_STD = 0.5  # 1 sigma of H about K w cos(latitude), of that: magnetic sensitivity, and K guessed from dwells
BIAS_SCATTER_STDS = np.array([0.1, 0.4, 1.5, 6.0, 25.0, 100.0]) / DEG_H_PER_DEG_S  # deg/s, 1 sigma, dwell to dwell
JUMP_STDS = priors.grid(BIAS_SCATTER_STDS[0], BIAS_SCATTER_STDS[-1])  # deg/s, 1 sigma, of one dwell

_NOMINAL_C_BL = [nominal_C_lb(position).T for position in range(1, len(ATTITUDES) + 1)]


@dataclass(frozen=True, slots=True, eq=False)
class HeadingLikelihood:
    """Judges labellings by the gyros of dwells ``rows``: rates (n, 3) and variances, over the largest of K.

    ``H`` (3, 3) is what North is expected to give, ``C_sb`` takes the cube's axes to the IMU's.
    """

    C_sb: FloatArray
    rows: IntArray
    rate: FloatArray
    variance: FloatArray
    hours: FloatArray
    H: FloatArray

    @classmethod
    def of(
        cls, campaign: Campaign, rate: FloatArray, std: FloatArray, start: Sequence[int]
    ) -> "HeadingLikelihood | None":
        """Judge dwells by their gyros; None if they do not tell.

        ``rate`` (n, 3) and its 1 sigma ``std`` (n, 3) are in outputs per second, nan where there are none.

        K is roughly what the turns say, or else the dwells themselves.
        """
        rows = np.flatnonzero(np.all(np.isfinite(rate), axis=1))
        north = float(np.degrees(earth_rate_n(campaign.site.latitude)[1]))
        if len(rows) < MIN_DWELLS:
            return None
        C_sb, rate, std = campaign.fixture.C_sb, rate[rows], std[rows]
        hours = np.array([campaign.dwells[i].series.t.mean() / S_PER_H for i in rows.tolist()])
        K = scale_factors_from_turns(campaign)
        if K is None:
            K = _from_dwells(_design(C_sb, np.array([[start[i] for i in rows.tolist()]]))[0], rate, north)
        size = float(np.abs(K).max())
        if not size > 0:
            return None
        return cls(C_sb, rows, rate / size, (std / size) ** 2, hours - hours.mean(), K / size * north)

    def costs(self, labellings: IntArray, jump: FloatArray | float = 0.0) -> FloatArray:
        """Return minus the log likelihood (m,) of labellings (m, dwells), up to a constant.

        The scatter of the biases from dwell to dwell is whatever makes a labelling likeliest; ``jump`` (n,) is
        that of single dwells next to it [deg/s].
        """
        A = _design(self.C_sb, labellings[:, self.rows])
        A = np.concatenate((A, np.broadcast_to(self.hours[:, None], (*A.shape[:2], 1))), axis=2)
        total = np.zeros((len(labellings), len(BIAS_SCATTER_STDS)))
        for q in range(3):
            north = NORTH_STD * np.linalg.norm(self.H[q])
            prior = np.array([BIAS_STD, *[G_SENSITIVITY_STD] * 3, *[north] * 3, DRIFT_STD])
            own = self.variance[:, q] + BIAS_SCATTER_STDS[:, None] ** 2 + np.square(jump)
            covariance = ((A * prior**2) @ A.swapaxes(1, 2))[:, None] + own[:, :, None] * np.eye(len(self.rows))
            left = (self.rate[:, q] - A[:, :, 4:7] @ self.H[q])[:, None, :, None]
            root = np.linalg.cholesky(covariance)
            white = np.linalg.solve(root, np.broadcast_to(left, (*covariance.shape[:3], 1)))
            total += 0.5 * np.sum(white[..., 0] ** 2, axis=2)
            total += np.log(np.diagonal(root, axis1=2, axis2=3)).sum(axis=2)
        least: FloatArray = total.min(axis=1)
        return least

    def best(self, start: Sequence[int]) -> tuple[list[int], FloatArray]:
        """Return the best labelling, one or two dwells changed at a time.

        With it comes what changing each dwell alone costs (n,) [ln likelihood].
        """
        changes = np.zeros((0, len(start)), dtype=bool)
        for which in (*((i,) for i in self.rows), *combinations(self.rows, 2)):
            changes = np.vstack((changes, np.isin(np.arange(len(start)), which)))
        positions = np.array(start)
        while True:
            costs = self.costs(np.vstack((positions, np.where(changes, _other(positions), positions))))
            least = int(np.argmin(costs))
            if least == 0:
                break
            positions = np.where(changes[least - 1], _other(positions), positions)
        margins = np.zeros(len(start))
        margins[self.rows] = costs[1 : 1 + len(self.rows)] - costs[0]
        return positions.tolist(), margins

    def gain_of_jump(self, named: Sequence[int], positions: Sequence[int], i: int) -> float:
        """Return the gain of a jump in dwell ``i``, ``named`` right, the others in ``positions``, over no jump."""
        labels = np.array(positions)
        labels[i] = named[i]
        stds = np.outer(JUMP_STDS, self.rows == i)
        freed = np.array([-self.costs(labels[None], std)[0] for std in stds])
        return float(log_mean(freed) + self.costs(labels[None])[0])


def _other(position: IntArray) -> IntArray:
    """Return the other position of the same face."""
    return np.where(position % 2 == 1, position + 1, position - 1)


def _design(C_sb: FloatArray, labellings: IntArray) -> FloatArray:
    """Return (m, n, 7): one, up (3) and North (3) in IMU axes for labellings (m, n)."""
    nominal = np.stack([np.hstack((1.0, C_sb @ C_bl[:, 2], C_sb @ C_bl[:, 1])) for C_bl in _NOMINAL_C_BL])
    return nominal[labellings - 1]


def _from_dwells(A: FloatArray, rate: FloatArray, north: float) -> FloatArray:
    """Return K (3, 3) [output/deg] from the Earth's rate in dwells (n): the signs by gyro, one size for all."""
    H = np.linalg.lstsq(A, rate, rcond=None)[0][4:].T
    own: FloatArray = np.diag(H) / north
    return np.diag(np.sign(own) * np.median(np.abs(own)))


def scale_factors_from_turns(campaign: Campaign) -> FloatArray | None:
    """Return K (3, 3) [output/deg] of the gyros, roughly, from the turns; None if they do not tell."""
    angle, total = list[FloatArray](), list[FloatArray]()
    for turn in campaign.turns:
        samples = channel(turn.series, "gyroscope")
        if samples is not None:
            per = 1.0 if isinstance(turn.series, CountSeries) else turn.series.period
            up = campaign.fixture.C_sb @ face_normal(face_of(turn.start_position))
            sign = 1 if (turn.direction == "+") == face_of(turn.start_position).endswith("up") else -1
            angle.append(sign * 360.0 * turn.revolutions * up)
            total.append(samples.sum(axis=0) * per)
    if not angle or np.linalg.matrix_rank(np.array(angle), tol=1.0) < 3:
        return None
    K, *_ = np.linalg.lstsq(np.array(angle), np.array(total), rcond=None)
    return K.T
