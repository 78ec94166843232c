"""Standard uncertainties that a solve of a planned campaign would state, compared with those wanted.

One normal matrix holds both triads, in the units of their parameters. Placements are a chain, each bound to the
next by a move; what belongs to one alone is eliminated as the chain goes on (Schur complement). The
accelerometers' own fit has no seats and is made apart, as in the solve.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import CORRELATED_DWELLS, triad_vector, vector_names
from procedures.campaign.observations import TriadDwells
from procedures.planning.campaign_design import CampaignDesign, Placement
from procedures.planning.placement_rows import BENCH, GYRO, OWN, SHARED, TRIAD
from procedures.planning.step_information import OWN_FIT, StepInformation
from procedures.statistics.least_squares import Fit
from procedures.twelve_positions.accelerometer_fit import TriadFit
from procedures.units import DEG_H_PER_DEG_S

RIDGE = 1e-12  # of a correlation: what is open has a sigma all the same, a million times that of the rest
OPEN_SIGMA = 1.0  # g, deg/h, rad or relative: nothing that is solved is as bad
NOTHING = 1e-12  # in the place of zero where it divides
BEYOND = 1e100  # above any variance in units of the scaled matrix: what stands there is not looked at
NAMES = vector_names("accelerometer") + vector_names("gyroscope")
OF_TRIAD = len(NAMES) // 2  # k (3), E (9), D (3)


@dataclass(frozen=True, eq=False)
class DesignSigmas:
    """The sigmas of any design, by what its ``steps`` add."""

    steps: StepInformation

    def of(self, design: CampaignDesign) -> FloatArray:
        """Return 1 sigma (30,) of k (relative), E, D [g], [deg/h] of both triads, as `NAMES`; inf where open."""
        dwells = [at for at in design.placements if at.turn is None]
        information = sum((self.steps.information(at) for at in dwells), np.zeros((len(OWN_FIT),) * 2))
        found = self.by_information(information, self.shared(design), len(dwells))
        return np.where(found > OPEN_SIGMA, np.inf, found)

    def by_information(self, information: FloatArray, shared: FloatArray, dwells: int) -> FloatArray:
        """Return 1 sigma (..., 30) of designs of so many dwells, by what they say; above `OPEN_SIGMA` where open.

        ``information`` (..., 27, 27) is what they add to the accelerometers, ``shared`` (..., 39, 39) to both.
        """
        return np.concatenate((self._accelerometer(information), self._gyroscope(shared, dwells)), axis=-1)

    def shared(self, design: CampaignDesign) -> FloatArray:
        """Return the normal matrix (39, 39) of what a design says of all that belongs to no single placement."""
        return without_first(self.chain(design))

    def chain(self, design: CampaignDesign) -> FloatArray:
        """Return the normal matrix (43, 43) of a design, its last placement's own parameters still in it."""
        chain = self.begun(design.placements[0])
        for before, after in pairwise(design.placements):
            chain = self.carried_on(chain, before, after)
        return chain

    def begun(self, at: Placement) -> FloatArray:
        """Return a chain (43, 43) that holds one placement and what is known of the bench."""
        chain = self.steps.placed(at).copy()
        chain[OWN:, OWN:] += self.known
        return chain

    def carried_on(self, chain: FloatArray, before: Placement, after: Placement) -> FloatArray:
        """Return the chain (43, 43) that ended with ``before``, and now with ``after``; the move is in it."""
        moved = self.steps.moved(before.position, after.position) * after.is_carried
        return joined(chain, moved) + self.steps.placed(after)

    def _accelerometer(self, information: FloatArray) -> FloatArray:
        return _stated(information + self._known_to_accelerometers, *self.accelerometer_vector)

    def _gyroscope(self, shared: FloatArray, dwells: int) -> FloatArray:
        """Neighbouring dwells share a bias instability, as in `triad_calibration.common_variance`."""
        found = _stated(shared, *self.gyroscope_vector)
        common = (min(CORRELATED_DWELLS, dwells) - 1) / dwells if dwells else 0.0
        bias = found[..., TRIAD:]
        bias[...] = np.hypot(bias, self.steps.noise.instability * DEG_H_PER_DEG_S * np.sqrt(common))
        return found

    @cached_property
    def known(self) -> FloatArray:
        """What is known of the bench (39, 39) before the first count."""
        return self.steps.known(skew_seen=True)

    @cached_property
    def _known_to_accelerometers(self) -> FloatArray:
        known: FloatArray = self.steps.known(skew_seen=False)[np.ix_(OWN_FIT, OWN_FIT)]
        return known

    @cached_property
    def accelerometer_vector(self) -> tuple[FloatArray, FloatArray]:
        """The Jacobian (15, 27) of the accelerometers' k, E, D by the columns `OWN_FIT`, and a variance (15,)."""
        return self._vector("accelerometer")

    @cached_property
    def gyroscope_vector(self) -> tuple[FloatArray, FloatArray]:
        """The Jacobian (15, 39) of the gyroscopes' k, E, D by what is shared, and a variance (15,)."""
        J, more = self._vector("gyroscope")
        whole = np.zeros((len(J), SHARED))
        whole[:, GYRO], whole[:, BENCH] = J[:, :TRIAD], J[:, TRIAD:]
        return whole, more

    def _vector(self, triad: str) -> tuple[FloatArray, FloatArray]:
        """Return the Jacobian (15, 27) of k, E, D by K, b and the bench, and their variance (15,) in addition."""
        bench = self.steps.bench(skew_seen=False)
        size = TRIAD + bench.size
        x = np.concatenate((np.eye(3).ravel(), np.zeros(size - 9)))
        none = TriadDwells((), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(3), ())
        fit = Fit(x, np.zeros((size, size)), np.zeros(0), np.zeros((0, size)))
        joint = TriadFit(fit, bench, none, np.zeros(3), np.zeros((0, 3)), np.zeros(0, dtype=bool))
        vector = triad_vector(joint, triad, joint)
        return vector.jacobian[:, : TRIAD + bench.shared], np.diag(vector.covariance)


def joined(chain: FloatArray, moved: FloatArray) -> FloatArray:
    """Return what ``chain`` (43, 43) and ``moved`` (..., 47, 47) at its end say of another (..., 43, 43)."""
    wide = moved.copy()
    wide[..., :OWN, :OWN] += chain[:OWN, :OWN]
    wide[..., :OWN, 2 * OWN :] += chain[:OWN, OWN:]
    wide[..., 2 * OWN :, :OWN] += chain[OWN:, :OWN]
    wide[..., 2 * OWN :, 2 * OWN :] += chain[OWN:, OWN:]
    return without_first(wide)


def without_first(N: FloatArray) -> FloatArray:
    """Return the normal matrix (..., n - 4, n - 4) with the first four parameters of N (..., n, n) eliminated."""
    own, across = N[..., :OWN, :OWN], N[..., :OWN, OWN:]
    left: FloatArray = N[..., OWN:, OWN:] - np.swapaxes(across, -1, -2) @ np.linalg.solve(own, across)
    return left


def _stated(N: FloatArray, J: FloatArray, more: FloatArray) -> FloatArray:
    """Return 1 sigma (..., 15) by normal matrices N (..., p, p), J (15, p), and a variance (15,) in addition.

    J below N in one matrix: of its Cholesky factor what stands there is J times the inverse of that of N.
    """
    n = N.shape[-1]
    scale = 1 / np.sqrt(np.maximum(np.diagonal(N, axis1=-2, axis2=-1), NOTHING))
    whole = np.zeros((*N.shape[:-2], n + len(J), n + len(J))) + np.diag(np.repeat((RIDGE, BEYOND), (n, len(J))))
    whole[..., :n, :n] += N * scale[..., :, None] * scale[..., None, :]
    whole[..., n:, :n] = J * scale[..., None, :]
    half = np.linalg.cholesky(whole)[..., n:, :n]
    found: FloatArray = np.sqrt(np.sum(half**2, axis=-1) + more)
    return found


SHARE_OF_MEAN = 0.1  # of the score, added to the worst ratio: what is met already is not let go for nothing
TIMES_USUAL = 10.0  # of the usual campaign's sigma: what nobody asks for is solved at least as well as that
IN_PLACE = [name.split(".")[-1] in {"xx", "yy", "zz"} for name in NAMES]
MEASURED = ~np.array(IN_PLACE) & [not name.startswith("accelerometer.scale") for name in NAMES]


@dataclass(frozen=True, slots=True, eq=False)
class WantedSigmas:
    """1 sigma (30,) that each of `NAMES` is to have, infinite where nothing is wanted; scale factors relative."""

    sigma: FloatArray

    def and_also(self, other: "WantedSigmas") -> "WantedSigmas":
        """Return what both want: the smaller of two."""
        return WantedSigmas(np.minimum(self.sigma, other.sigma))

    def ratios(self, found: FloatArray) -> FloatArray:
        """Return by what factor ``found`` (..., 30) is above what is wanted (..., 30): 1 is met, 0 open."""
        ratio = np.zeros(found.shape)
        asked = np.isfinite(self.sigma)
        ratio[..., asked] = found[..., asked] / self.sigma[asked]
        return ratio

    def worst(self, found: FloatArray) -> FloatArray:
        """Return the largest of the ratios (...) of ``found`` (..., 30)."""
        worst: FloatArray = self.ratios(found).max(axis=-1)
        return worst

    def score(self, found: FloatArray) -> FloatArray:
        """Return what designs of sigmas ``found`` (..., 30) are worth (...), the less the better."""
        ratio = self.ratios(found)
        mean = ratio.sum(axis=-1) / max(int(np.isfinite(self.sigma).sum()), 1)
        score: FloatArray = (ratio.max(axis=-1) + SHARE_OF_MEAN * mean) / (1 + SHARE_OF_MEAN)
        return score


def wanted(sigmas: dict[str, float]) -> WantedSigmas:
    """Return what is wanted by name; every name is one of `NAMES`."""
    found = np.full(len(NAMES), np.inf)
    for name, sigma in sigmas.items():
        found[NAMES.index(name)] = sigma
    return WantedSigmas(found)


def with_all_solved(asked: WantedSigmas, usual: FloatArray) -> WantedSigmas:
    """Return what is asked, and of all the rest `TIMES_USUAL` of the usual campaign's sigmas (30,)."""
    return WantedSigmas(np.minimum(asked.sigma, np.where(MEASURED, TIMES_USUAL * usual, np.inf)))


def as_good_as(usual: FloatArray) -> WantedSigmas:
    """Return the sigmas ``usual`` (30,) of a campaign, in the units of `NAMES`, as wanted."""
    return WantedSigmas(np.where(MEASURED, usual, np.inf))
