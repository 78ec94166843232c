"""Which sigmas are wanted of a campaign, and how far a design is from them."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.planning.design_sigmas import NAMES

SHARE_OF_MEAN = 0.1  # of the score beside the worst ratio: what is met already is not let go for nothing
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
    """Return what is asked, and of all the rest `TIMES_USUAL` of the usual campaign's sigmas (30,).

    Without that the shortest campaign for a bias would leave scale factors open altogether. The accelerometers'
    scale factors follow the site's gravity, and a row of E is of unit length, whatever is done.
    """
    return WantedSigmas(np.minimum(asked.sigma, np.where(MEASURED, TIMES_USUAL * usual, np.inf)))


def as_good_as(usual: FloatArray) -> WantedSigmas:
    """Return the sigmas ``usual`` (30,) of a campaign, in the units of `NAMES`, as wanted."""
    return WantedSigmas(np.where(MEASURED, usual, np.inf))
