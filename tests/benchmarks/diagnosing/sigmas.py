"""One sigma of every coefficient of an effect in its design, of a campaign without it: the measure of sizes.

The only place where the diagnosis's own columns are used, and for no more than how large a size is drawn.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from procedures.calibration.joint_calibration import fit
from procedures.effects import EFFECTS
from procedures.evidence.candidates import Candidates
from procedures.evidence.residual_rows import evidence_of
from tests.benchmarks.diagnosing.designs import DESIGNS, clock_sigma, unit

CLOCKS = 5  # campaigns that the sigma of a clock's rate is the median of


@dataclass(frozen=True, slots=True)
class Sigmas:
    """1 sigma by position (0: any), time constant (0: none) and coefficient; ``given`` where there is none."""

    found: Mapping[tuple[int, float, str], float]
    given: float = 0.0

    def of(self, key: str, position: int = 0, tau: float = 30.0) -> float:
        """Return 1 sigma of a coefficient, planted with a time constant nearest to ``tau`` [s]."""
        if self.given:
            return self.given
        one = catalogued(key) if set(key) <= set("xyz") else key
        of_key = {at: std for at, std in self.found.items() if at[0] == position and at[2] in {key, one}}
        if not of_key:
            return float(np.median(list(self.found.values())))
        taus = {abs(np.log(of / tau)): std for (_, of, _), std in of_key.items() if of}
        return taus[min(taus)] if taus else next(iter(of_key.values()))


def catalogued(key: str) -> str:
    """Return the catalogue's key of a planted cross product: sensor and two axes."""
    return key[0] + ("".join(sorted(key)) if len(key) == 2 else key[1:])


def sigmas_of(effect: str, design: str, seed: int = 1) -> Sigmas:
    """Return the sigmas of an effect in its design."""
    made = DESIGNS[design]
    if effect == "clock.rate":  # known by the scatter of delays, which differs by a factor of 3 between campaigns
        several = [made.make(unit(i, **made.truth), i)[0] for i in range(seed, seed + CLOCKS)]
        return Sigmas({}, float(np.median([clock_sigma(each) for each in several])))
    campaigns = made.make(unit(seed, **made.truth), seed)
    fits = fit(campaigns)
    evidence = evidence_of(fits)
    found: dict[tuple[int, float, str], float] = {}
    for way in Candidates(evidence, fits, EFFECTS).get(effect, ()):
        if way.columns.tau_s and way.columns.shape:  # in proportion to f or its change: not what is planted
            continue
        _, C = way.fit(evidence, (), np.ones(len(evidence.residual))).coefficients()
        linear = way.columns.coefficients[: len(C)]
        for key, one in zip(linear, np.sqrt(np.diag(C)), strict=True):
            at = (int(str(way.columns.where.get("position", 0))), way.columns.tau_s, key)
            found.setdefault(at, float(one))
    return Sigmas(found)
